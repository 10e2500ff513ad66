//! Errors of captures of pins.

use std::io;
use std::path::PathBuf;

use fabkit_files::{ErrorKind, ErrorSubject, Explained};

use super::{LIST_FILE_NAME, MAX_IMAGES};
use crate::captures::InvalidList;
use crate::image::ImageError;
use crate::pin_detection::DetectionError;

/// Hint for pins that are not where they are expected.
pub const OTHER_CAMERA: &str =
    "does the camera's file belong to this camera, and do the landmarks belong to this dome?";

/// Reason why captures of pins cannot be read.
///
/// ```
/// use fabkit_calibration::pin_captures::PinCaptureError;
/// use fabkit_files::Explained;
/// // An error says what is wrong, and what to do about it.
/// let error = PinCaptureError::Unlabelled { file: "IMG_0042.png".into() };
/// assert_eq!(error.to_string(), "IMG_0042.png: its name does not say which holes had pins");
/// assert!(error.hint().unwrap().starts_with("name it after its holes, as 01_05_08.png"));
/// ```
#[derive(Debug, thiserror::Error)]
pub enum PinCaptureError {
    /// No pose explains the marks.
    #[error("no pose of the camera puts the holes where the images show marks")]
    NotAssigned,
    /// The name of a capture does not say which holes had pins.
    #[error("{file}: its name does not say which holes had pins")]
    Unlabelled {
        /// Image of the capture.
        file: String,
    },
    /// An image cannot be read.
    #[error("{file}: {source}")]
    Image {
        /// Name of the image.
        file: String,
        /// Reason.
        source: ImageError,
    },
    /// An image cannot be searched for pins.
    #[error("{file}: {source}")]
    DetectionFailed {
        /// Name of the image.
        file: String,
        /// Reason.
        source: DetectionError,
    },
    /// A folder cannot be read.
    #[error("cannot read {}: {source}", .folder.display())]
    Folder {
        /// Folder concerned.
        folder: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A folder has too many images.
    #[error("{} holds more than {MAX_IMAGES} images", .folder.display())]
    TooManyImages {
        /// Folder concerned.
        folder: PathBuf,
    },
    /// A folder has no captures.
    #[error("{} holds no captures", .folder.display())]
    NoCaptures {
        /// Folder concerned.
        folder: PathBuf,
    },
    /// There is no image without contact to compare captures with.
    #[error("{} has no image without contact", .folder.display())]
    NoReference {
        /// Folder concerned.
        folder: PathBuf,
    },
    /// A list of captures cannot be read.
    #[error("{}: {source}", .file.display())]
    List {
        /// Path of the list.
        file: PathBuf,
        /// Reason.
        source: InvalidList,
    },
    /// There are pins of several kinds, and the kind in use is not given.
    #[error("{}: {kinds}", several(.at.as_ref()))]
    SeveralKinds {
        /// Capture and hole, if the error concerns one.
        at: Option<(String, u32)>,
        /// Kinds that exist, for messages.
        kinds: String,
    },
    /// The dome has no such hole.
    #[error("{file}: the landmarks have no hole {hole}")]
    NoHole {
        /// Name of the capture.
        file: String,
        /// Hole as given.
        hole: u32,
    },
    /// The hole has no pin of this kind.
    #[error("{file}: hole {hole} has no pin of kind `{kind}`")]
    NoSuchPin {
        /// Name of the capture.
        file: String,
        /// Number of the hole.
        hole: u32,
        /// Kind as given.
        kind: String,
        /// Kinds that exist, for messages.
        kinds: String,
    },
    /// A list gives pixels for some pins of a capture only.
    #[error("{file}: some pins have a pixel and some have none")]
    PartlyMeasured {
        /// Name of the capture.
        file: String,
    },
}

fn several(at: Option<&(String, u32)>) -> String {
    match at {
        None => "the landmarks have several kinds of pin".into(),
        Some((file, hole)) => format!("{file}: there are several kinds of pin for hole {hole}"),
    }
}

impl Explained for PinCaptureError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::TooManyImages { .. } => ErrorKind::Limit,
            Self::Folder { .. } => ErrorKind::Io,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Unlabelled { .. } => {
                return Some(format!(
                    "name it after its holes, as 01_05_08.png, or list its pins in {LIST_FILE_NAME}"
                ));
            }
            Self::DetectionFailed { source, .. } => match source {
                DetectionError::Size { .. } => "all images come from one camera at one size",
                DetectionError::Identical => "take the reference without contact",
                DetectionError::Exposure { .. } => {
                    "lower or raise the exposure until the surface is grey, not white or black"
                }
            },
            Self::NoCaptures { .. } => {
                "captures are PNG, JPEG, TIFF or BMP files, named after their holes as in 01_05_08.png"
            }
            Self::NoReference { .. } => "save one there as ref.png, or name it",
            Self::SeveralKinds { .. } => {
                return Some(format!(
                    "say which was used, here or in the column `kind` of {LIST_FILE_NAME}"
                ));
            }
            Self::NoSuchPin { kinds, .. } => return Some(format!("its kinds are: {kinds}")),
            Self::NotAssigned => OTHER_CAMERA,
            _ => return None,
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Folder { folder, source } => {
                ErrorSubject::from_io(folder, source, "file_unreadable")
            }
            Self::NoCaptures { folder } => ErrorSubject::from_path("no_captures", folder),
            Self::Unlabelled { file } => ErrorSubject::from_path("unlabelled", file.as_ref()),
            Self::NoReference { folder } => ErrorSubject::from_path("no_reference", folder),
            Self::TooManyImages { folder } => ErrorSubject::from_path("too_many_pictures", folder),
            Self::List { file, .. } => ErrorSubject::from_path("bad_list", file),
            Self::Image { file, .. } => ErrorSubject::from_path("bad_picture", file.as_ref()),
            Self::NotAssigned => ErrorSubject::new("no_pose"),
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}
