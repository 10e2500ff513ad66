//! Reading of images, and detection of pins in them.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use fabkit_files::Error;
use fabkit_files::memory::{self, MemoryHint};
use fabkit_files::reading::{self, ExpectedFile};
use rayon::prelude::*;

use super::PinCaptureError;
use crate::image::{GreyImage, ImageError};
use crate::pin_detection::{Detection, DetectionError, DetectionOptions, detect};

/// Limits for image files of tactile sensors.
pub const IMAGE_FILE: ExpectedFile = ExpectedFile {
    what: "an image",
    max_bytes: 256 << 20,
    hint: "images of tactile sensors are files of a few megabytes at most",
};

/// Memory for decoding besides the image, bytes per pixel: the file, and all of the widest pixels.
const DECODING_BYTES: u64 = 16;
/// Memory for the detection of pins, including the image itself, bytes per pixel.
const PINS_BYTES: u64 = 32;

/// Reads an image as grey.
///
/// # Errors
/// Fails for a file that cannot be read, or is no image that can be used.
pub fn read_grey(path: &Path) -> Result<GreyImage, Error> {
    read_grey_if(path, |_| Ok(()))
}

/// Reads an image if its size passes `fits`, which is called before anything is decoded.
pub fn read_grey_if(
    path: &Path,
    fits: impl Fn([u32; 2]) -> Result<(), Error>,
) -> Result<GreyImage, Error> {
    let bytes = reading::read(path, IMAGE_FILE)?;
    let wrong = |source: ImageError| {
        Error::from(PinCaptureError::Image { file: path.display().to_string(), source })
    };
    fits(GreyImage::size_px(&bytes).map_err(wrong)?)?;
    GreyImage::read(&bytes).map_err(wrong)
}

/// Reads the size of an image, `[width, height]`, from its header.
///
/// # Errors
/// Fails for a file that cannot be read, or is no image that can be used.
pub fn read_size_px(path: &Path) -> Result<[u32; 2], Error> {
    let wrong = |source: ImageError| {
        Error::from(PinCaptureError::Image { file: path.display().to_string(), source })
    };
    GreyImage::size_px(&reading::read(path, IMAGE_FILE)?).map_err(wrong)
}

/// Runs `work` on images of this size with as many workers as memory allows. `each` is the memory of one worker and
/// `shared` that of all together, bytes per pixel.
pub fn run_on_workers<R: Send>(
    what: &str,
    size_px: [u32; 2],
    [shared, each]: [u64; 2],
    work: impl FnOnce() -> Result<R, Error> + Send,
) -> Result<R, Error> {
    let [width, height] = size_px.map(u64::from);
    let pixels = width * height;
    let what = format!("{what} an image of {width} x {height} px");
    let each = pixels * (each + DECODING_BYTES);
    memory::run_on_workers(&what, pixels * shared, each, MemoryHint::Images, work)
}

/// Detects pins in each image.
///
/// # Errors
/// Reports all images that cannot be read or used.
pub fn detect_all(
    reference: &Path,
    images: &[PathBuf],
    options: &DetectionOptions,
) -> Result<Vec<Detection>, Error> {
    let names: Vec<String> = images.iter().map(|path| path.display().to_string()).collect();
    let what = "looking for pins in";
    // Memory is reserved with the size from the header, before the reference is decoded.
    let fits = |size_px| run_on_workers(what, size_px, [4, PINS_BYTES], || Ok(()));
    let reference = read_grey_if(reference, fits)?;
    let reference_px = [reference.width_px(), reference.height_px()];
    let picture = |i: usize| {
        let same = |size_px: [u32; 2]| match size_px.map(|px| px as usize) {
            pressed if pressed == reference_px => Ok(()),
            pressed => {
                let error = DetectionError::Size { pressed, reference: reference_px };
                Err(undetected(&names[i], error))
            }
        };
        Ok(Cow::Owned(read_grey_if(&images[i], same)?))
    };
    // The cast is safe: the reference is no larger than an image may be.
    run_on_workers(what, reference_px.map(|px| px as u32), [4, PINS_BYTES], || {
        detect_in_images(&reference, &names, &picture, options)
    })
}

fn undetected(name: &str, source: DetectionError) -> Error {
    PinCaptureError::DetectionFailed { file: name.into(), source }.into()
}

/// Detects pins as [`detect_all`], in images that `read` supplies by their index in `names`.
///
/// # Errors
/// Reports all images that cannot be used.
///
/// ```
/// use std::borrow::Cow;
///
/// use fabkit_calibration::image::GreyImage;
/// use fabkit_calibration::pin_captures::images::detect_in_images;
/// use fabkit_calibration::pin_detection::DetectionOptions;
/// let grey = |value: f32| GreyImage::new(128, 96, vec![value; 128 * 96]).unwrap();
/// let reference = grey(0.5);
/// let names = ["01_05.png".to_owned(), "02_07.png".to_owned()];
/// // Each image that cannot be used is reported by its name.
/// let options = DetectionOptions::default();
/// let error = detect_in_images(&reference, &names, &|_| Ok(Cow::Borrowed(&reference)), &options);
/// let text = error.unwrap_err().to_string();
/// assert!(text.contains("01_05.png: the image is the reference itself"));
/// assert!(text.contains("02_07.png: the image is the reference itself"));
/// ```
pub fn detect_in_images<'a>(
    reference: &GreyImage,
    names: &[String],
    read: &(dyn Fn(usize) -> Result<Cow<'a, GreyImage>, Error> + Sync),
    options: &DetectionOptions,
) -> Result<Vec<Detection>, Error> {
    let one = |(i, name): (usize, &String)| -> Result<Detection, Error> {
        detect(reference, &*read(i)?, options).map_err(|error| undetected(name, error))
    };
    let results: Vec<Result<Detection, Error>> = names.par_iter().enumerate().map(one).collect();
    let (found, mut wrong) = (Vec::with_capacity(results.len()), Vec::new());
    let found = results.into_iter().fold(found, |mut found, result| {
        match result {
            Ok(detection) => found.push(detection),
            Err(error) => wrong.push(error),
        }
        found
    });
    Error::join(wrong).map_or(Ok(found), Err)
}
