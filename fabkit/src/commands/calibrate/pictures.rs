//! Reading pictures and looking for pins in them.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use fabkit::calibration::image::GreyImage;
use fabkit::calibration::pins::{Detection, DetectionError, DetectionOptions, detect};
use rayon::prelude::*;

use crate::failure::{Exit, Failure};
use crate::reading::{self, Expected};

const PICTURE: Expected = Expected {
    what: "a picture",
    max_bytes: 256 << 20,
    hint: "pictures of tactile sensors are PNG files of a few megabytes at most",
};

/// Reads a PNG.
pub(super) fn read(path: &Path) -> Result<GreyImage, Failure> {
    let bytes = reading::bytes(path, PICTURE)?;
    GreyImage::from_png(&bytes)
        .map_err(|error| Failure::plain(Exit::BadInput, format!("{}: {error}", path.display())))
}

/// Looks for pins in each picture; every picture that cannot be used is named.
pub(super) fn detect_all(
    reference: &Path,
    pictures: &[PathBuf],
    options: &DetectionOptions,
) -> Result<Vec<Detection>, Failure> {
    let names: Vec<String> = pictures.iter().map(|path| path.display().to_string()).collect();
    detect_in(&read(reference)?, &names, &|i| Ok(Cow::Owned(read(&pictures[i])?)), options)
}

/// The same with pictures by their names, from wherever `read` has the i-th.
///
/// # Errors
/// Pictures that cannot be used, all of them.
pub fn detect_in<'a>(
    reference: &GreyImage,
    names: &[String],
    read: &(dyn Fn(usize) -> Result<Cow<'a, GreyImage>, Failure> + Sync),
    options: &DetectionOptions,
) -> Result<Vec<Detection>, Failure> {
    let one = |(i, name): (usize, &String)| -> Result<Detection, Failure> {
        detect(reference, &*read(i)?, options).map_err(|error| {
            let hint = match error {
                DetectionError::Size { .. } => "all pictures come from one camera at one size",
                DetectionError::Identical => "take the reference without contact",
                DetectionError::Exposure { .. } => {
                    "lower or raise the exposure until the surface is grey, not white or black"
                }
            };
            Failure::new(Exit::BadInput, format!("{name}: {error}"), hint)
        })
    };
    let results: Vec<Result<Detection, Failure>> = names.par_iter().enumerate().map(one).collect();
    let (found, mut wrong) = (Vec::with_capacity(results.len()), Vec::new());
    let found = results.into_iter().fold(found, |mut found, result| {
        match result {
            Ok(detection) => found.push(detection),
            Err(failure) => wrong.push(failure),
        }
        found
    });
    Failure::all(wrong).map_or(Ok(found), Err)
}
