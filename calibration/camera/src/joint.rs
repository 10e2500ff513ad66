//! A camera at its place: what is known of camera and pose together.
//!
//! A lens that is calibrated a little long makes a pose come out a little far, and where the pins
//! were, the two errors cancel. Who takes them for independent counts them twice; what carries both
//! is one covariance.

use std::fmt;

use nalgebra::DMatrix;

use crate::camera::Camera;
use crate::estimate::{CameraEstimate, InvalidCovariance, check};

/// How many parameters a pose has.
pub const POSE_COUNT: usize = 6;

/// The parameters of a pose, with units, in their order: a small rotation about the camera's axes
/// through the sensor's origin, then the sensor's origin in the camera frame.
pub const POSE_PARAMETERS: [&str; POSE_COUNT] = [
    "rotation_x_rad",
    "rotation_y_rad",
    "rotation_z_rad",
    "translation_x_mm",
    "translation_y_mm",
    "translation_z_mm",
];

/// A camera, and how sure it and its pose are, together.
///
/// The one place that says what the parameters are called and how they are ordered: those of the
/// pose, [`POSE_PARAMETERS`], then those of the camera, [`Camera::parameters`]. A parameter that
/// nothing is known about, or that was held, has a row and a column of zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct JointEstimate {
    camera: Camera,
    covariance: DMatrix<f64>,
    is_joint: bool,
}

/// What a [`JointEstimate`] covers: which of its parameters have a variance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Covered {
    /// The pose.
    pub pose: bool,
    /// The lens: its intrinsics and coefficients.
    pub lens: bool,
    /// The refractive interface.
    pub interface: bool,
    /// Pose and camera are both covered, but what they have in common is not known: they count as
    /// independent.
    pub as_if_independent: bool,
}

impl JointEstimate {
    /// A camera with the covariance of its pose and its parameters, which were solved for together.
    ///
    /// # Errors
    /// A matrix of another size, or one that is no covariance.
    pub fn new(camera: Camera, covariance: DMatrix<f64>) -> Result<Self, InvalidCovariance> {
        check(&Self::names_for(&camera), &covariance)?;
        Ok(Self { camera, covariance, is_joint: true })
    }

    /// A camera and a pose of which each is known by itself, as files from before say it. Zeros
    /// stand for what nobody says.
    ///
    /// # Errors
    /// A matrix of the pose that is no covariance.
    pub fn independent(
        estimate: &CameraEstimate,
        pose: Option<&[[f64; POSE_COUNT]; POSE_COUNT]>,
    ) -> Result<Self, InvalidCovariance> {
        let camera = *estimate.camera();
        let count = POSE_COUNT + camera.parameter_count();
        let mut covariance = DMatrix::zeros(count, count);
        if let Some(pose) = pose {
            let pose = DMatrix::from_fn(POSE_COUNT, POSE_COUNT, |r, c| pose[r][c]);
            check(&POSE_PARAMETERS, &pose)?;
            covariance.view_mut((0, 0), (POSE_COUNT, POSE_COUNT)).copy_from(&pose);
        }
        if let Some(matrix) = estimate.covariance() {
            covariance.view_mut((POSE_COUNT, POSE_COUNT), matrix.shape()).copy_from(matrix);
        }
        Ok(Self { camera, covariance, is_joint: false })
    }

    /// The most likely camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Of all parameters, in the order of [`JointEstimate::names`] and in their units.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// Names of the parameters with units, in the order of the covariance.
    pub fn names(&self) -> Vec<&'static str> {
        Self::names_for(&self.camera)
    }

    /// The names of pose and camera, in their order, whatever is known about them.
    pub fn names_for(camera: &Camera) -> Vec<&'static str> {
        let of_camera = camera.parameters().into_iter().map(|(name, _)| name);
        POSE_PARAMETERS.into_iter().chain(of_camera).collect()
    }

    /// The pose's part of the covariance, whatever the camera's parameters are.
    pub fn pose_covariance(&self) -> [[f64; POSE_COUNT]; POSE_COUNT] {
        std::array::from_fn(|r| std::array::from_fn(|c| self.covariance[(r, c)]))
    }

    /// The camera by itself, wherever it is; without a covariance if nothing is known about it.
    pub fn camera_estimate(&self) -> CameraEstimate {
        let n = self.camera.parameter_count();
        let part = self.covariance.view((POSE_COUNT, POSE_COUNT), (n, n)).into_owned();
        let part = Some(part).filter(|part| part.diagonal().iter().any(|variance| *variance > 0.0));
        // A part of a covariance is one.
        CameraEstimate::new(self.camera, part).unwrap_or_else(|_| self.camera.into())
    }

    /// The parameters that have a variance, by their place in the order.
    pub fn free(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.covariance.nrows()).filter(|&i| self.covariance[(i, i)] > 0.0)
    }

    /// What the covariance covers.
    pub fn covered(&self) -> Covered {
        let of_interface = self.camera.parameter_count() - self.camera.interface().parameters().1;
        let any = |from: usize, to: usize| self.free().any(|i| (from..to).contains(&i));
        let pose = any(0, POSE_COUNT);
        let lens = any(POSE_COUNT, POSE_COUNT + of_interface);
        let interface = any(POSE_COUNT + of_interface, self.covariance.nrows());
        let as_if_independent = pose && (lens || interface) && !self.is_joint;
        Covered { pose, lens, interface, as_if_independent }
    }
}

impl fmt::Display for Covered {
    /// `pose, lens, shape`: for the account of what a sigma of ground truth contains, which always
    /// has the shape's.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [("pose", self.pose), ("lens", self.lens), ("interface", self.interface)];
        for (name, _) in parts.into_iter().filter(|(_, covered)| *covered) {
            write!(f, "{name}, ")?;
        }
        f.write_str("shape")?;
        match self.as_if_independent {
            true => f.write_str("; pose and camera as if independent"),
            false => Ok(()),
        }
    }
}
