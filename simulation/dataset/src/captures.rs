//! Existing images of half presses.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit_files::join_first_messages;
use fabkit_files::reading::{self, ExpectedFile};
use fabkit_image::{DecodedImage, EXTENSIONS, PixelValues};
use rayon::prelude::*;

/// Words for the sides, in file names and in CSV, in the order of the halves.
const SIDES: [&str; 2] = ["left", "right"];
const LIST: ExpectedFile = ExpectedFile {
    what: "a list of captures",
    max_bytes: 1 << 20,
    hint: "it has one row for each half",
};
const IMAGE: ExpectedFile = ExpectedFile {
    what: "a capture",
    max_bytes: 256 << 20,
    hint: "captures are files of a few megabytes at most",
};

/// Image for each half: left halves, then right ones.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfCaptures {
    /// Number of values per pixel: 1 or 3.
    channels: u32,
    /// Values of each image, row by row.
    images: Vec<Vec<u8>>,
}

/// All problems of a set of captures.
#[derive(Debug, thiserror::Error)]
#[error("{}", join_first_messages(.0))]
pub struct InvalidCaptures(pub Vec<String>);

impl HalfCaptures {
    /// Reads images from a folder with `PATTERN-left.png` and `PATTERN-right.png` for each pattern, or from a CSV file
    /// with the columns pattern, side (`left` or `right`) and file. Files are relative to the folder of the CSV file.
    ///
    /// # Errors
    /// Reports missing images, two for one half, and images that cannot be read or do not have the camera's size; all
    /// together.
    ///
    /// ```
    /// use std::path::Path;
    ///
    /// use fabkit_dataset::HalfCaptures;
    ///
    /// let folder = std::env::temp_dir();
    /// let missing = HalfCaptures::read(&folder, &["no-such-pattern".into()], [640, 480]).unwrap_err();
    /// // One message for each side.
    /// assert_eq!(missing.0.len(), 2);
    /// ```
    pub fn read(
        place: &Path,
        patterns: &[String],
        size_px: [u32; 2],
    ) -> Result<Self, InvalidCaptures> {
        let mut faults = Vec::new();
        let paths = if place.is_dir() {
            in_folder(place, patterns)
        } else {
            in_csv(place, patterns, &mut faults)
        };
        let mut files = Vec::new();
        for side in SIDES {
            for pattern in patterns {
                let found = paths.get(&(pattern.clone(), side)).map_or(&[][..], Vec::as_slice);
                match found {
                    [file] => files.push(file.clone()),
                    [] => faults.push(format!("no capture of {pattern} {side}")),
                    several => {
                        let names: Vec<String> =
                            several.iter().map(|file| file.display().to_string()).collect();
                        faults.push(format!(
                            "{} captures of {pattern} {side}: {}",
                            several.len(),
                            names.join(", ")
                        ));
                    }
                }
            }
        }
        let read: Vec<Result<(u32, Vec<u8>), String>> =
            files.par_iter().map(|file| read_image(file, size_px)).collect();
        let mut images = Vec::new();
        let mut channels = None;
        for (file, pixels) in files.iter().zip(read) {
            let shown = file.display();
            match pixels {
                Err(message) => faults.push(message),
                Ok((of_this, _)) if channels.is_some_and(|count| count != of_this) => {
                    faults.push(format!("{shown} has {of_this} channels; the first has not"));
                }
                Ok((of_this, values)) => {
                    channels = Some(of_this);
                    images.push(values);
                }
            }
        }
        match channels {
            Some(channels) if faults.is_empty() => Ok(Self { channels, images }),
            _ => Err(InvalidCaptures(faults)),
        }
    }

    /// Returns the number of values per pixel: 1 or 3.
    pub fn channels(&self) -> u32 {
        self.channels
    }

    /// Returns the values of a half's image, row by row.
    pub(super) fn image(&self, half: usize) -> &[u8] {
        &self.images[half]
    }

    /// Computes a BLAKE3 hash, in hex, over all images.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        for picture in &self.images {
            hasher.update(picture);
        }
        hasher.finalize().to_hex().to_string()
    }
}

type FilesByHalf = BTreeMap<(String, &'static str), Vec<PathBuf>>;

/// Finds the images of each half in a folder, by their names.
fn in_folder(folder: &Path, patterns: &[String]) -> FilesByHalf {
    let mut found = FilesByHalf::new();
    for side in SIDES {
        for pattern in patterns {
            // Names are compared exactly, so that upper-case extensions are tried too.
            let endings =
                EXTENSIONS.into_iter().flat_map(|end| [end.into(), end.to_ascii_uppercase()]);
            let files = endings.map(|end: String| folder.join(format!("{pattern}-{side}.{end}")));
            let files = files.filter(|file| file.is_file()).collect();
            found.insert((pattern.clone(), side), files);
        }
    }
    found
}

/// Reads the images of each half from a list.
fn in_csv(csv: &Path, patterns: &[String], faults: &mut Vec<String>) -> FilesByHalf {
    let mut found = FilesByHalf::new();
    let shown = csv.display();
    let text = match reading::read_text(csv, LIST) {
        Ok(text) => text,
        Err(error) => {
            faults.push(error.to_string());
            return found;
        }
    };
    let folder = csv.parent().unwrap_or(Path::new(""));
    for (number, line) in (1..).zip(text.lines()) {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        match *cells {
            [""] | ["pattern", "side", "file"] => {}
            [pattern, side, file] => {
                let side = SIDES.into_iter().find(|known| *known == side);
                // An unknown pattern is a fault, because it may be misspelt.
                let known = patterns.iter().any(|known| known == pattern);
                match side {
                    Some(side) if known => {
                        found.entry((pattern.into(), side)).or_default().push(folder.join(file));
                    }
                    Some(_) => faults.push(format!("{shown}:{number}: no pattern `{pattern}`")),
                    None => {
                        faults.push(format!("{shown}:{number}: the side is `left` or `right`"));
                    }
                }
            }
            _ => faults.push(format!(
                "{shown}:{number}: {} cells; there are three: pattern, side, file",
                cells.len()
            )),
        }
    }
    found
}

/// Reads channels and 8-bit values, which training sets consist of. The size is compared before anything is decoded.
fn read_image(file: &Path, size_px: [u32; 2]) -> Result<(u32, Vec<u8>), String> {
    let shown = file.display();
    let bytes = reading::read(file, IMAGE).map_err(|error| error.to_string())?;
    let unreadable = |error| format!("{shown}: {error}");
    let found = fabkit_image::read_size_px(&bytes).map_err(unreadable)?;
    if found != size_px {
        let ([found_width, found_height], [width, height]) = (found, size_px);
        return Err(format!(
            "{shown} has {found_width} x {found_height} px; the camera has {width} x {height}"
        ));
    }
    // The image has the size of the camera's, which has its own limit.
    let DecodedImage { channels, values, .. } =
        fabkit_image::read(&bytes, u64::MAX).map_err(unreadable)?;
    match values {
        PixelValues::U8(values) => Ok((channels, values)),
        PixelValues::U16(_) => {
            Err(format!("{shown}: an image of 16 bits a sample; 8 bits are read"))
        }
    }
}
