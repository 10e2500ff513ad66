//! Errors of the calibrations.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use fabkit_calibration::extrinsics::CalibrationError;
use fabkit_calibration::intrinsics::LensCalibrationError;
use fabkit_calibration::pin_captures::OTHER_CAMERA;
use fabkit_camera::files::InvalidCameraFile;
use fabkit_files::{ErrorKind, ErrorSubject, Explained, join_messages};
use fabkit_optics::InvalidStack;
use fabkit_text::InvalidDocument;

pub(super) const BOARD_HINT: &str = "`fabkit export SENSOR/boards` writes one beside each board";
pub(super) const CORNERS_HINT: &str =
    "the columns are view,corner,x_px,y_px and, if known, sigma_px";

/// Error of a camera or pose calibration.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationRunError {
    /// Problems of a board file, each with the file's name.
    #[error("{}", join_messages(.0))]
    Board(Vec<String>),
    /// Problems of a list of corners, each with the file's name.
    #[error("{}", join_messages(.0))]
    Corners(Vec<String>),
    /// Bodies through which no light can be traced.
    #[error(transparent)]
    Light(#[from] InvalidStack),
    /// Image whose size differs from the sensor camera's.
    #[error(
        "{file}: {} x {} px; the sensor's camera has {} x {} px",
        .size_px[0], .size_px[1], .expected_px[0], .expected_px[1]
    )]
    OtherSize {
        /// Image file.
        file: String,
        /// Width and height of the image, px.
        size_px: [u32; 2],
        /// Width and height of the camera's images, px.
        expected_px: [u32; 2],
    },
    /// Captures whose size differs from that of the camera's calibration.
    #[error(
        "the captures have {} x {} px, the camera is that of images of {} x {} px",
        .captures_px[0], .captures_px[1], .camera_px[0], .camera_px[1]
    )]
    CameraSize {
        /// Width and height of the captures, px.
        captures_px: [u32; 2],
        /// Width and height of the camera's images, px.
        camera_px: [u32; 2],
    },
    /// Image that was given twice.
    #[error("{here} and {there} are the same image")]
    SameImage {
        /// Later of the two names.
        here: String,
        /// Earlier of the two names.
        there: String,
    },
    /// Sensor camera for which no forecast can be computed.
    #[error("{why}")]
    NoForecast {
        /// Reason.
        why: String,
    },
    /// OpenCV's detector was requested for a ChArUco board.
    #[error("OpenCV's detector finds checkerboards, and this is a ChArUco board")]
    Charuco,
    /// OpenCV's detector was requested, but fabkit was built without it.
    #[error("this fabkit was built without OpenCV")]
    NoOpencv,
    /// View with a corner that the board does not have.
    #[error("{view}: the board has no corner {corner}; its last is {last}")]
    NoCorner {
        /// Name of the view.
        view: String,
        /// Corner id as given.
        corner: u32,
        /// Largest corner id of the board.
        last: usize,
    },
    /// View that gives two positions for one corner.
    #[error("{view} has corner {corner} twice")]
    CornerTwice {
        /// Name of the view.
        view: String,
        /// Corner id.
        corner: u32,
    },
    /// Camera file with faults.
    #[error("{}", faults(.file, .source))]
    Camera {
        /// Camera file.
        file: PathBuf,
        /// Faults of its content.
        source: InvalidCameraFile,
    },
    /// Invalid landmarks document.
    #[error("{}{source}", .file.iter().map(|f| format!("{}: ", f.display())).collect::<String>())]
    Landmarks {
        /// File that was read, if any.
        file: Option<PathBuf>,
        /// Fault of its content.
        source: InvalidDocument,
    },
    /// Fixture without pins.
    #[error("{fixture} has no pins, and so no landmarks")]
    NoPins {
        /// Name of the fixture.
        fixture: String,
    },
    /// Too many marks that lie at none of the holes named by the labels.
    #[error("{doubtful} of {marks} marks lie at no labelled hole:\n  {}", .discrepancies.join("\n  "))]
    Doubtful {
        /// Number of such marks.
        doubtful: usize,
        /// Number of all marks.
        marks: usize,
        /// One sentence for each discrepancy.
        discrepancies: Vec<String>,
    },
    /// Pins that do not determine the pose.
    #[error(transparent)]
    Pose(#[from] CalibrationError),
    /// Views that do not determine the lens.
    #[error("{source}{}", unused.iter().map(|(f, why)| format!("\n  {f}: {why}")).collect::<String>())]
    Lens {
        /// Error of the lens calibration.
        source: LensCalibrationError,
        /// Unusable images, each with the reason.
        unused: Vec<(String, String)>,
    },
    /// Output path that does not name a file.
    #[error("{} does not name a file", .0.display())]
    NotAFileName(PathBuf),
    /// Output path that is not UTF-8, so that the pose file cannot name its camera file.
    #[error("{} is no name in UTF-8", .0.display())]
    NotUtf8(PathBuf),
}

impl CalibrationRunError {
    pub(super) fn board(file: Option<&Path>, problems: &[impl Display]) -> Self {
        Self::Board(problems.iter().map(|problem| with_file_name(file, problem)).collect())
    }

    pub(super) fn corners(file: &Path, problems: &[impl Display]) -> Self {
        Self::Corners(problems.iter().map(|problem| with_file_name(Some(file), problem)).collect())
    }
}

fn with_file_name(file: Option<&Path>, problem: &impl Display) -> String {
    file.map_or_else(|| problem.to_string(), |file| format!("{}: {problem}", file.display()))
}

fn faults(file: &Path, invalid: &InvalidCameraFile) -> String {
    let faults = invalid.faults.iter().map(|fault| with_file_name(Some(file), fault));
    faults.collect::<Vec<_>>().join("\n")
}

impl Explained for CalibrationRunError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Lens { source: LensCalibrationError::Covariance(_), .. } => ErrorKind::Bug,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Board(_) => BOARD_HINT,
            Self::Light(error) => return Some(error.hint().to_owned()).filter(|h| !h.is_empty()),
            Self::Corners(_) => CORNERS_HINT,
            Self::OtherSize { .. } => {
                "take all images with the sensor's camera at its own size, or change the sensor's \
                 camera.width_px and camera.height_px"
            }
            Self::CameraSize { .. } => {
                "give the captures at the size of the calibration, or scale the camera: fx and cx + 0.5 \
                 grow with the width, fy and cy + 0.5 with the height"
            }
            Self::SameImage { .. } => "give each image only once: a copy is no new evidence",
            Self::NoForecast { .. } => "correct the sensor's `camera`",
            Self::Charuco => "use fabkit's own detector, or give what OpenCV found",
            Self::NoOpencv => "build fabkit with its feature `opencv`, or give what OpenCV found",
            Self::Doubtful { .. } => "check the labels and the landmarks",
            Self::Pose(error) => match error {
                // The reported covariance was derived from the file's, so the file's is most likely not a valid one.
                CalibrationError::Covariance(_) => "look at the covariance in the camera's file",
                CalibrationError::OnePlane { .. } => {
                    "press pins in holes of at least two rings, or pins of two lengths"
                }
                CalibrationError::NoExplanation { .. } => OTHER_CAMERA,
            },
            Self::Lens { source, .. } => match source {
                LensCalibrationError::TooFewViews { .. } => {
                    "10 to 20 images of the board, tilted to all sides and out to the image's \
                     border, are usual"
                }
                LensCalibrationError::TooManyViews { .. } => "choose those that differ most",
                LensCalibrationError::NoInitialPose { .. } => {
                    "is this the right board, and are the sensor's camera.field_of_view and the image size right?"
                }
                LensCalibrationError::NoModel { .. } => "try all lens models",
                LensCalibrationError::NotObservable { .. } => {
                    "add images of the board in other poses"
                }
                LensCalibrationError::ImpossibleCorner { .. } => "look at the list of corners",
                LensCalibrationError::Covariance(_) => return None,
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
            Self::Camera { file, .. } => ErrorSubject::from_path("bad_camera_file", file),
            Self::OtherSize { file, .. } => ErrorSubject::from_path("other_size", file.as_ref()),
            Self::CameraSize { .. } => ErrorSubject::new("other_size"),
            Self::Board(_) => ErrorSubject::new("bad_board"),
            Self::Corners(_) => ErrorSubject::new("bad_corners"),
            Self::Landmarks { .. } => ErrorSubject::new("bad_landmarks"),
            Self::Pose(_) => ErrorSubject::new("no_pose"),
            Self::Lens { .. } => ErrorSubject::new("no_lens"),
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}
