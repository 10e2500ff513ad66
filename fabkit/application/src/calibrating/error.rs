//! Why a calibration does not come about.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use fabkit_calibration::captures::InvalidList;
use fabkit_calibration::extrinsics::CalibrationError;
use fabkit_calibration::image::ImageError;
use fabkit_calibration::intrinsics::CalibrateError;
use fabkit_calibration::pins::DetectionError;
use fabkit_camera::files::InvalidCameraFile;
use fabkit_optics::InvalidStack;
use fabkit_text::InvalidDocument;

use super::captures::{LIST, MAX_PICTURES};
use crate::error::{ErrorKind, Explained, joined};

pub(super) const BOARD_HINT: &str = "`fabkit export SENSOR/boards` writes one beside each board";
pub(super) const CORNERS_HINT: &str =
    "the columns are view,corner,x_px,y_px and, if known, sigma_px";
const OTHER_CAMERA: &str =
    "is the camera's file the one of this camera, and are the landmarks this dome's?";

/// Why a calibration does not come about.
#[derive(Debug, thiserror::Error)]
pub enum CalibratingError {
    /// A board's file with problems, each with the file it is in.
    #[error("{}", joined(.0))]
    Board(Vec<String>),
    /// A list of corners with problems, each with the file it is in.
    #[error("{}", joined(.0))]
    Corners(Vec<String>),
    /// Bodies that no light can be followed through.
    #[error(transparent)]
    Light(#[from] InvalidStack),
    /// A picture of another size than the sensor's camera takes.
    #[error(
        "{file}: {} x {} px; the sensor's camera has {} x {} px",
        .size_px[0], .size_px[1], .expected_px[0], .expected_px[1]
    )]
    OtherSize {
        /// Which.
        file: String,
        /// Its width and height, px.
        size_px: [u32; 2],
        /// The camera's, px.
        expected_px: [u32; 2],
    },
    /// A picture that was given twice.
    #[error("{here} and {there} are the same picture")]
    SamePicture {
        /// The later one.
        here: String,
        /// The earlier one.
        there: String,
    },
    /// A capture whose name does not say which holes had pins.
    #[error("{file}: its name does not say which holes had pins")]
    Unlabelled {
        /// Its picture.
        file: String,
    },
    /// A camera that is none.
    #[error("{why}")]
    NoForecast {
        /// Why.
        why: String,
    },
    /// OpenCV's detector and a board that it is not for.
    #[error("OpenCV's detector finds checkerboards, and this is a ChArUco board")]
    Charuco,
    /// OpenCV's detector, which is not there.
    #[error("this fabkit was built without OpenCV")]
    NoOpencv,
    /// A view with a corner that the board does not have.
    #[error("{view}: the board has no corner {corner}; its last is {last}")]
    NoCorner {
        /// Which view.
        view: String,
        /// As given.
        corner: u32,
        /// The largest there is.
        last: usize,
    },
    /// A view with two places for one corner.
    #[error("{view} has corner {corner} twice")]
    CornerTwice {
        /// Which view.
        view: String,
        /// Which corner.
        corner: u32,
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
    /// A camera's file with faults.
    #[error("{}", faults(.file, .source))]
    Camera {
        /// Which.
        file: PathBuf,
        /// What is wrong.
        source: InvalidCameraFile,
    },
    /// Landmarks that are none.
    #[error("{}{source}", .file.iter().map(|f| format!("{}: ", f.display())).collect::<String>())]
    Landmarks {
        /// Where they were read.
        file: Option<PathBuf>,
        /// What is wrong.
        source: InvalidDocument,
    },
    /// A fixture that holds no pins.
    #[error("{fixture} has no pins, and so no landmarks")]
    NoPins {
        /// Which.
        fixture: String,
    },
    /// Marks that no pose explains.
    #[error("the marks in the pictures are not where the holes would be seen from any side")]
    NotAssigned,
    /// Marks that are at no hole that a label names.
    #[error("{doubtful} of {marks} marks are at no labelled hole:\n  {}", .discrepancies.join("\n  "))]
    Doubtful {
        /// How many.
        doubtful: usize,
        /// Of how many.
        marks: usize,
        /// Each as a sentence.
        discrepancies: Vec<String>,
    },
    /// Pins that do not tell the pose.
    #[error(transparent)]
    Pose(#[from] CalibrationError),
    /// Views that do not tell the lens.
    #[error("{source}{}", unused.iter().map(|(f, why)| format!("\n  {f}: {why}")).collect::<String>())]
    Lens {
        /// Why.
        source: CalibrateError,
        /// Pictures that could not be used, and why not.
        unused: Vec<(String, String)>,
    },
    /// An output that is no file's name.
    #[error("{} does not name a file", .0.display())]
    NoFile(PathBuf),
    /// A pose whose camera could not be named in it.
    #[error("{} is no name in UTF-8", .0.display())]
    NotUtf8(PathBuf),
}

impl CalibratingError {
    pub(super) fn board(file: Option<&Path>, problems: &[impl Display]) -> Self {
        Self::Board(problems.iter().map(|problem| within(file, problem)).collect())
    }

    pub(super) fn corners(file: &Path, problems: &[impl Display]) -> Self {
        Self::Corners(problems.iter().map(|problem| within(Some(file), problem)).collect())
    }
}

fn within(file: Option<&Path>, problem: &impl Display) -> String {
    file.map_or_else(|| problem.to_string(), |file| format!("{}: {problem}", file.display()))
}

fn faults(file: &Path, invalid: &InvalidCameraFile) -> String {
    let faults = invalid.faults.iter().map(|fault| within(Some(file), fault));
    faults.collect::<Vec<_>>().join("\n")
}

fn several(at: Option<&(String, u32)>) -> String {
    match at {
        None => "the landmarks have several kinds of pin".into(),
        Some((file, hole)) => format!("{file}: there are several kinds of pin for hole {hole}"),
    }
}

impl Explained for CalibratingError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::TooManyPictures { .. } => ErrorKind::Limit,
            Self::Folder { .. } => ErrorKind::Io,
            Self::Lens { source: CalibrateError::Covariance(_), .. } => ErrorKind::Bug,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Board(_) => BOARD_HINT,
            Self::Light(error) => return Some(error.hint().to_owned()).filter(|h| !h.is_empty()),
            Self::Corners(_) => CORNERS_HINT,
            Self::OtherSize { .. } => {
                "take all pictures with the sensor's camera at its own size, or change the sensor's \
                 camera.width_px and camera.height_px"
            }
            Self::SamePicture { .. } => {
                "give each picture once; the same one again is no new evidence"
            }
            Self::Unlabelled { .. } => {
                return Some(format!(
                    "name it after its holes, as 01_05_08.png, or list its pins in {LIST}"
                ));
            }
            Self::NoForecast { .. } => "correct the sensor's `camera`",
            Self::Charuco => "use fabkit's own detector, or give what OpenCV found",
            Self::NoOpencv => "build fabkit with its feature `opencv`, or give what OpenCV found",
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
            Self::Doubtful { .. } => "check the labels and the landmarks",
            Self::Pose(error) => match error {
                // What was computed from the file's is no covariance, because the file's hardly is one.
                CalibrationError::Covariance(_) => "look at the covariance in the camera's file",
                CalibrationError::OnePlane { .. } => {
                    "press pins in holes of at least two rings, or pins of two lengths"
                }
                CalibrationError::NoExplanation { .. } => OTHER_CAMERA,
            },
            Self::Lens { source, .. } => match source {
                CalibrateError::TooFewViews { .. } => {
                    "10 to 20 pictures of the board, tilted to all sides and out to the image's \
                     border, are usual"
                }
                CalibrateError::TooManyViews { .. } => "choose those that differ most",
                CalibrateError::NoStart { .. } => {
                    "is this the board, and are the sensor's camera.field_of_view and the size of \
                     the pictures right?"
                }
                CalibrateError::NoModel { .. } => "try all lens models",
                CalibrateError::NotObservable { .. } => "add pictures of the board in other poses",
                CalibrateError::Impossible { .. } => "look at the list of corners",
                CalibrateError::Covariance(_) => return None,
            },
            Self::NotUtf8(_) => {
                "the pose names the camera's file beside it, which is called after it"
            }
            _ => return None,
        };
        Some(hint.into())
    }
}
