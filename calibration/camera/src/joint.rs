//! Joint estimate of a camera and its pose.
//!
//! Errors of camera and pose are correlated: a focal length that is calibrated slightly too long makes the pose come
//! out slightly too far, and at the pins the two errors cancel. Treating them as independent counts them twice; one
//! joint covariance does not.

use std::fmt;

use nalgebra::DMatrix;

use crate::camera::Camera;
use crate::estimate::{CameraEstimate, InvalidCovariance, check_covariance};

/// Number of parameters of a pose.
pub const POSE_PARAMETER_COUNT: usize = 6;

/// Names of a pose's parameters with units, in their order: a small rotation about the camera's axes through the
/// sensor's origin, then the sensor's origin in the camera frame.
pub const POSE_PARAMETERS: [&str; POSE_PARAMETER_COUNT] = [
    "rotation_x_rad",
    "rotation_y_rad",
    "rotation_z_rad",
    "translation_x_mm",
    "translation_y_mm",
    "translation_z_mm",
];

/// Camera with the joint covariance of its pose and its parameters.
///
/// This type alone defines the names and the order of the parameters: those of the pose, [`POSE_PARAMETERS`], then
/// those of the camera, [`Camera::parameters`]. A parameter that is unknown, or was fixed in the calibration, has a row
/// and a column of zeros.
///
/// ```
/// use fabkit_camera::{Camera, DMatrix, JointEstimate};
/// let camera = Camera::equidistant(640, 480, 2.8)?;
/// let names = JointEstimate::parameter_names(&camera);
/// assert_eq!((names[3], names[6], names.len()), ("translation_x_mm", "fx_px", 6 + 8));
/// let mut covariance = DMatrix::zeros(14, 14);
/// (covariance[(5, 5)], covariance[(6, 6)]) = (0.01, 4.0);
/// // Focal length and distance grow together: a correlation of 0.9.
/// (covariance[(5, 6)], covariance[(6, 5)]) = (0.18, 0.18);
/// let joint = JointEstimate::new(camera, covariance)?;
/// assert_eq!(joint.pose_covariance()[5][5], 0.01);
/// assert_eq!(joint.camera_estimate().sigmas().unwrap()[0], 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct JointEstimate {
    camera: Camera,
    covariance: DMatrix<f64>,
    is_joint: bool,
}

/// Groups of parameters of a [`JointEstimate`] that have a variance.
///
/// ```
/// use fabkit_camera::{Camera, CameraEstimate, DMatrix, JointEstimate};
/// let camera = Camera::equidistant(640, 480, 2.8)?;
/// let together = JointEstimate::new(camera, DMatrix::identity(14, 14))?;
/// assert_eq!(together.coverage().to_string(), "pose, lens, shape");
/// // The same variances from two files: nothing is known about their correlation.
/// let lens = CameraEstimate::new(camera, Some(DMatrix::identity(8, 8)))?;
/// let apart = JointEstimate::independent(&lens, Some(&together.pose_covariance()))?;
/// let expected = "pose, lens, shape; pose and camera as if independent";
/// assert_eq!(apart.coverage().to_string(), expected);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CovarianceCoverage {
    /// The pose has a variance.
    pub pose: bool,
    /// The lens has a variance: any of its intrinsics or coefficients.
    pub lens: bool,
    /// The refractive interface has a variance.
    pub interface: bool,
    /// Pose and camera both have a variance, but their correlation is unknown, so that they count as independent.
    pub assumes_independence: bool,
}

impl JointEstimate {
    /// Creates an estimate from the joint covariance of a pose and a camera that were solved for together.
    ///
    /// # Errors
    /// Fails for a matrix of another size, or one that is no covariance.
    pub fn new(camera: Camera, covariance: DMatrix<f64>) -> Result<Self, InvalidCovariance> {
        check_covariance(&Self::parameter_names(&camera), &covariance)?;
        Ok(Self { camera, covariance, is_joint: true })
    }

    /// Creates an estimate from a camera and a pose whose covariances are known separately, as in older files. Unknown
    /// entries are zero.
    ///
    /// # Errors
    /// Fails if the pose's matrix is no covariance.
    ///
    /// ```
    /// use fabkit_camera::{Camera, JointEstimate};
    /// let camera = Camera::equidistant(640, 480, 2.8)?;
    /// let mut pose = [[0.0; 6]; 6];
    /// pose[5][5] = 0.01; // mm2: the distance is known to 0.1 mm
    /// let joint = JointEstimate::independent(&camera.into(), Some(&pose))?;
    /// assert_eq!(joint.free_parameters().collect::<Vec<_>>(), [5]);
    /// assert_eq!(joint.names()[5], "translation_z_mm");
    /// assert_eq!(joint.camera_estimate().covariance(), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn independent(
        estimate: &CameraEstimate,
        pose: Option<&[[f64; POSE_PARAMETER_COUNT]; POSE_PARAMETER_COUNT]>,
    ) -> Result<Self, InvalidCovariance> {
        let camera = *estimate.camera();
        let count = POSE_PARAMETER_COUNT + camera.parameter_count();
        let mut covariance = DMatrix::zeros(count, count);
        if let Some(pose) = pose {
            let pose =
                DMatrix::from_fn(POSE_PARAMETER_COUNT, POSE_PARAMETER_COUNT, |r, c| pose[r][c]);
            check_covariance(&POSE_PARAMETERS, &pose)?;
            covariance
                .view_mut((0, 0), (POSE_PARAMETER_COUNT, POSE_PARAMETER_COUNT))
                .copy_from(&pose);
        }
        if let Some(matrix) = estimate.covariance() {
            covariance
                .view_mut((POSE_PARAMETER_COUNT, POSE_PARAMETER_COUNT), matrix.shape())
                .copy_from(matrix);
        }
        Ok(Self { camera, covariance, is_joint: false })
    }

    /// Most likely camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Covariance of all parameters, in the order of [`JointEstimate::names`] and in their units.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// Returns the names of the parameters with units, in the order of the covariance.
    pub fn names(&self) -> Vec<&'static str> {
        Self::parameter_names(&self.camera)
    }

    /// Returns the names of the parameters of a pose and `camera`, in the order of the covariance.
    pub fn parameter_names(camera: &Camera) -> Vec<&'static str> {
        let of_camera = camera.parameters().into_iter().map(|(name, _)| name);
        POSE_PARAMETERS.into_iter().chain(of_camera).collect()
    }

    /// Returns the pose's 6 x 6 block of the covariance.
    pub fn pose_covariance(&self) -> [[f64; POSE_PARAMETER_COUNT]; POSE_PARAMETER_COUNT] {
        std::array::from_fn(|r| std::array::from_fn(|c| self.covariance[(r, c)]))
    }

    /// Returns the camera's own estimate; without a covariance if all its variances are zero.
    pub fn camera_estimate(&self) -> CameraEstimate {
        let n = self.camera.parameter_count();
        let part =
            self.covariance.view((POSE_PARAMETER_COUNT, POSE_PARAMETER_COUNT), (n, n)).into_owned();
        let part = Some(part).filter(|part| part.diagonal().iter().any(|variance| *variance > 0.0));
        // The check cannot fail in theory, because a diagonal block of a covariance is a covariance.
        CameraEstimate::new(self.camera, part).unwrap_or_else(|_| self.camera.into())
    }

    /// Returns the indices of the parameters that have a variance.
    pub fn free_parameters(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.covariance.nrows()).filter(|&i| self.covariance[(i, i)] > 0.0)
    }

    /// Returns which groups of parameters have a variance.
    pub fn coverage(&self) -> CovarianceCoverage {
        // The interface's parameters are the camera's last ones.
        let of_interface = self.camera.parameter_count() - self.camera.interface().parameters().1;
        let any = |from: usize, to: usize| self.free_parameters().any(|i| (from..to).contains(&i));
        let pose = any(0, POSE_PARAMETER_COUNT);
        let lens = any(POSE_PARAMETER_COUNT, POSE_PARAMETER_COUNT + of_interface);
        let interface = any(POSE_PARAMETER_COUNT + of_interface, self.covariance.nrows());
        let as_if_independent = pose && (lens || interface) && !self.is_joint;
        CovarianceCoverage { pose, lens, interface, assumes_independence: as_if_independent }
    }
}

impl fmt::Display for CovarianceCoverage {
    /// Writes `pose, lens, shape`: the contributions to a sigma of ground truth, which always includes that of the
    /// shape.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [("pose", self.pose), ("lens", self.lens), ("interface", self.interface)];
        for (name, _) in parts.into_iter().filter(|(_, covered)| *covered) {
            write!(f, "{name}, ")?;
        }
        f.write_str("shape")?;
        if self.assumes_independence {
            f.write_str("; pose and camera as if independent")
        } else {
            Ok(())
        }
    }
}
