//! A camera at its place, calibrated or as designed.

use std::ops::Range;

use fabkit_camera::files::{self, InvalidCameraFile, PoseFile};
use fabkit_camera::{Camera, CameraEstimate, InvalidCamera};
use fabkit_depth::truth::{PixelRays, Uncertainty};
use fabkit_geometry::{Matrix3, NominalCamera, Pose, Vector3};
use serde_json::{Value, json};

/// A camera, where it is, and how sure both are.
#[derive(Clone, Debug)]
pub struct Viewpoint {
    /// The camera with the covariance of its parameters.
    pub estimate: CameraEstimate,
    /// Camera frame to sensor frame, mm.
    pub sensor_from_camera: Pose,
    /// See [`Uncertainty::pose`].
    pub pose_covariance: Option<[[f64; 6]; 6]>,
    /// Whether the camera is the design's, and the pose.
    is_nominal: [bool; 2],
}

/// Why there is no viewpoint.
#[derive(Debug, thiserror::Error)]
pub enum InvalidViewpoint {
    /// A file with faults.
    #[error(transparent)]
    File(#[from] InvalidCameraFile),
    /// A design whose camera cannot be.
    #[error("the nominal camera: {0}")]
    Nominal(#[from] InvalidCamera),
    /// A matrix that mirrors, scales or shears.
    #[error(
        "camera_from_sensor is no rigid motion: its rotation is off by {residual:.1e} and has the \
         determinant {determinant:.6}"
    )]
    NotRigid {
        /// Largest entry of R^T R - 1.
        residual: f64,
        /// 1 for a rotation.
        determinant: f64,
    },
    /// A matrix that is no covariance.
    #[error("the pose's covariance {0}")]
    Covariance(&'static str),
}

impl Viewpoint {
    /// The camera of a design at its place, or what calibration files say instead: the text of a
    /// camera file, and a pose.
    ///
    /// # Errors
    /// [`InvalidViewpoint`].
    pub fn new(
        nominal: &NominalCamera,
        camera_file: Option<&str>,
        pose_file: Option<&PoseFile>,
    ) -> Result<Self, InvalidViewpoint> {
        let estimate = match camera_file {
            Some(text) => files::read(text)?,
            None => {
                let (width, height) = (nominal.width_px, nominal.height_px);
                let camera = Camera::equidistant(width, height, nominal.field_of_view.rad())?;
                CameraEstimate::from(camera)
            }
        };
        let (sensor_from_camera, pose_covariance) = match pose_file {
            Some(PoseFile { camera_from_sensor, covariance, .. }) => {
                if let Some(covariance) = covariance {
                    check_covariance(covariance)?;
                }
                (rigid(camera_from_sensor)?.inverse(), *covariance)
            }
            None => (nominal.sensor_from_camera, None),
        };
        let is_nominal = [camera_file.is_none(), pose_file.is_none()];
        Ok(Self { estimate, sensor_from_camera, pose_covariance, is_nominal })
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        self.estimate.camera()
    }

    /// One ray for each of `samples` x `samples` parts of each pixel.
    pub fn rays(&self, samples: u32) -> PixelRays {
        PixelRays::with_samples(self.camera(), &self.sensor_from_camera, samples)
    }

    /// Those of some rows of them alone.
    pub fn rays_of_rows(&self, samples: u32, rows: Range<u32>) -> PixelRays {
        PixelRays::of_rows(self.camera(), &self.sensor_from_camera, samples, rows)
    }

    /// With the standard deviation of printed or cast surfaces along their normals, mm.
    pub fn uncertainty(&self, shape_mm: f64) -> Uncertainty {
        let camera = self.estimate.covariance().cloned();
        Uncertainty { camera, pose: self.pose_covariance, shape_mm }
    }

    /// Whether neither camera nor pose say how sure they are.
    pub fn is_unsure(&self) -> bool {
        self.estimate.covariance().is_none() && self.pose_covariance.is_none()
    }

    /// Everything about it, for data cards.
    pub fn to_json(&self) -> Value {
        let camera = self.camera();
        let parameters: serde_json::Map<_, _> =
            camera.parameters().into_iter().map(|(n, v)| (n.to_owned(), json!(v))).collect();
        let word = |is_nominal| if is_nominal { "nominal" } else { "calibrated" };
        json!({
            "camera": word(self.is_nominal[0]),
            "pose": word(self.is_nominal[1]),
            "width_px": camera.width_px(),
            "height_px": camera.height_px(),
            "lens": camera.lens().model_name(),
            "interface": camera.interface().kind_name(),
            "parameters": parameters,
            "sensor_from_camera": self.sensor_from_camera,
        })
    }
}

fn rigid(matrix: &[[f64; 4]; 4]) -> Result<Pose, InvalidViewpoint> {
    let rotation = Matrix3::from_fn(|r, c| matrix[r][c]);
    let translation = Vector3::from_fn(|r, _| matrix[r][3]);
    // Six digits, as people write them, are rounded to a rotation; more than that is none.
    let residual = (rotation.transpose() * rotation - Matrix3::identity()).amax();
    let determinant = rotation.determinant();
    let not_rigid = InvalidViewpoint::NotRigid { residual, determinant };
    if !(residual < 1e-4 && determinant > 0.0) {
        return Err(not_rigid);
    }
    Pose::new(nearest_rotation(rotation), translation).ok_or(not_rigid)
}

/// Newton's iteration for the orthogonal polar factor (Higham, SIAM J. Sci. Stat. Comput. 7, 1986).
fn nearest_rotation(mut rotation: Matrix3<f64>) -> Matrix3<f64> {
    for _ in 0..4 {
        let Some(inverse) = rotation.try_inverse() else { break };
        rotation = 0.5 * (rotation + inverse.transpose());
    }
    rotation
}

fn check_covariance(matrix: &[[f64; 6]; 6]) -> Result<(), InvalidViewpoint> {
    let scale = |i: usize| matrix[i][i].abs().sqrt();
    if (0..6).any(|i| matrix[i][i] < 0.0) {
        return Err(InvalidViewpoint::Covariance("has a negative variance on its diagonal"));
    }
    for (r, c) in (0..6).flat_map(|r| (0..6).map(move |c| (r, c))) {
        let (value, mirrored, most) = (matrix[r][c], matrix[c][r], scale(r) * scale(c));
        let tolerance = 1e-6 * most;
        if (value - mirrored).abs() > tolerance {
            return Err(InvalidViewpoint::Covariance("is not symmetric"));
        }
        if value.abs() > most + tolerance {
            return Err(InvalidViewpoint::Covariance("has a correlation above 1"));
        }
    }
    Ok(())
}
