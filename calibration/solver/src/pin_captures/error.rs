//! Why captures of pins cannot be read.

use std::io;
use std::path::PathBuf;

use fabkit_files::{ErrorKind, ErrorSubject, Explained};

use super::{LIST, MAX_PICTURES};
use crate::captures::InvalidList;
use crate::image::ImageError;
use crate::pins::DetectionError;

/// What to look at where pins are not where they should be seen.
pub const OTHER_CAMERA: &str =
    "is the camera's file the one of this camera, and are the landmarks this dome's?";

/// Why captures of pins cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PinCaptureError {
    /// Marks that no pose explains.
    #[error("the marks in the pictures are not where the holes would be seen from any side")]
    NotAssigned,
    /// A capture whose name does not say which holes had pins.
    #[error("{file}: its name does not say which holes had pins")]
    Unlabelled {
        /// Its picture.
        file: String,
    },
    /// A picture that is none.
    #[error("{file}: {source}")]
    Picture {
        /// Which.
        file: String,
        /// Why.
        source: ImageError,
    },
    /// A picture in which nobody can look for pins.
    #[error("{file}: {source}")]
    Undetected {
        /// Which.
        file: String,
        /// Why.
        source: DetectionError,
    },
    /// A folder that cannot be read.
    #[error("cannot read {}: {source}", .folder.display())]
    Folder {
        /// Which.
        folder: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// More pictures than anybody takes.
    #[error("{} holds more than {MAX_PICTURES} pictures", .folder.display())]
    TooManyPictures {
        /// Where.
        folder: PathBuf,
    },
    /// A folder without captures.
    #[error("{} holds no captures", .folder.display())]
    NoCaptures {
        /// Which.
        folder: PathBuf,
    },
    /// Captures, and nothing to compare them with.
    #[error("{} has no picture without contact", .folder.display())]
    NoReference {
        /// Which folder.
        folder: PathBuf,
    },
    /// A list of captures that cannot be read.
    #[error("{}: {source}", .file.display())]
    List {
        /// Which file.
        file: PathBuf,
        /// Why.
        source: InvalidList,
    },
    /// Pins of several kinds, and nobody says which was used.
    #[error("{}: {kinds}", several(.at.as_ref()))]
    SeveralKinds {
        /// The capture and the hole, where it is about one.
        at: Option<(String, u32)>,
        /// Which there are.
        kinds: String,
    },
    /// A hole that the dome does not have.
    #[error("{file}: the landmarks have no hole {hole}")]
    NoHole {
        /// Which capture.
        file: String,
        /// As given.
        hole: u32,
    },
    /// A kind of pin that the hole does not have.
    #[error("{file}: hole {hole} has no pin of kind `{kind}`")]
    NoSuchPin {
        /// Which capture.
        file: String,
        /// Which hole.
        hole: u32,
        /// As given.
        kind: String,
        /// Which there are.
        kinds: String,
    },
    /// A capture of which some pins were measured by hand.
    #[error("{file}: some pins have a pixel and some have none")]
    HalfMeasured {
        /// Which.
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
            Self::TooManyPictures { .. } => ErrorKind::Limit,
            Self::Folder { .. } => ErrorKind::Io,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Unlabelled { .. } => {
                return Some(format!(
                    "name it after its holes, as 01_05_08.png, or list its pins in {LIST}"
                ));
            }
            Self::Undetected { source, .. } => match source {
                DetectionError::Size { .. } => "all pictures come from one camera at one size",
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
                return Some(format!("say which was used, here or in the column `kind` of {LIST}"));
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
                ErrorSubject::of_io(folder, source, "file_unreadable")
            }
            Self::NoCaptures { folder } => ErrorSubject::at("no_captures", folder),
            Self::Unlabelled { file } => ErrorSubject::at("unlabelled", file.as_ref()),
            Self::NoReference { folder } => ErrorSubject::at("no_reference", folder),
            Self::TooManyPictures { folder } => ErrorSubject::at("too_many_pictures", folder),
            Self::List { file, .. } => ErrorSubject::at("bad_list", file),
            Self::Picture { file, .. } => ErrorSubject::at("bad_picture", file.as_ref()),
            Self::NotAssigned => ErrorSubject::new("no_pose"),
            other => ErrorSubject::of_kind(other.kind()),
        }
    }
}
