//! Why a calibration does not come about.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use fabkit_calibration::extrinsics::CalibrationError;
use fabkit_calibration::intrinsics::CalibrateError;
use fabkit_calibration::pin_captures::OTHER_CAMERA;
use fabkit_camera::files::InvalidCameraFile;
use fabkit_files::{ErrorKind, ErrorSubject, Explained, joined};
use fabkit_optics::InvalidStack;
use fabkit_text::InvalidDocument;

pub(super) const BOARD_HINT: &str = "`fabkit export SENSOR/boards` writes one beside each board";
pub(super) const CORNERS_HINT: &str =
    "the columns are view,corner,x_px,y_px and, if known, sigma_px";

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

impl Explained for CalibratingError {
    fn kind(&self) -> ErrorKind {
        match self {
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
            Self::NoForecast { .. } => "correct the sensor's `camera`",
            Self::Charuco => "use fabkit's own detector, or give what OpenCV found",
            Self::NoOpencv => "build fabkit with its feature `opencv`, or give what OpenCV found",
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

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Camera { file, .. } => ErrorSubject::at("bad_camera_file", file),
            Self::OtherSize { file, .. } => ErrorSubject::at("other_size", file.as_ref()),
            Self::Board(_) => ErrorSubject::new("bad_board"),
            Self::Corners(_) => ErrorSubject::new("bad_corners"),
            Self::Landmarks { .. } => ErrorSubject::new("bad_landmarks"),
            Self::Pose(_) => ErrorSubject::new("no_pose"),
            Self::Lens { .. } => ErrorSubject::new("no_lens"),
            other => ErrorSubject::of_kind(other.kind()),
        }
    }
}
