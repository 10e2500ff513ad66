//! Camera and pose calibration from images.

pub mod boards;
mod error;
pub mod extrinsics;
pub mod intrinsics;
mod marks;
pub mod planning;
pub mod pose_file;

pub use error::CalibrationRunError;
pub use fabkit_calibration::pin_captures::{self as captures, PinCaptureError, images};
