//! From pictures to cameras and poses.

pub mod boards;
pub mod captures;
mod error;
pub mod extrinsics;
pub mod intrinsics;
mod marks;
pub mod pictures;
pub mod planning;
pub mod pose_file;

pub use error::CalibratingError;
