//! A camera at its place, calibrated or as designed.

use std::ops::Range;

use fabkit_camera::files::{self, InvalidCameraFile, PoseFile};
use fabkit_camera::{
    Camera, CameraEstimate, Interface, InvalidCamera, InvalidCovariance, JointEstimate,
};
use fabkit_depth::truth::{PixelRays, Uncertainty};
use fabkit_geometry::{Matrix3, NominalCamera, Point3, Pose, Sensor, Vector3};
use fabkit_optics::{InvalidStack, Sights, Stack, Window};
use serde_json::{Value, json};

/// A camera, where it is, and how sure both are.
#[derive(Clone, Debug)]
pub struct Viewpoint {
    /// The camera, and how sure it and its pose are.
    pub estimate: JointEstimate,
    /// Camera frame to sensor frame, mm.
    pub sensor_from_camera: Pose,
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
    /// A pose and a camera of which one holds what lies before the lens and the other does not.
    #[error(
        "the pose was solved with a camera whose model {}; the camera given has {}",
        .solved_with, .given
    )]
    Mixed {
        /// What the camera was that the pose was solved with.
        solved_with: &'static str,
        /// The kind of the given camera's interface, in words.
        given: String,
    },
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
    #[error("the pose's covariance: {0}")]
    Covariance(#[from] InvalidCovariance),
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
                let terms = nominal.lens.projection.terms();
                let camera = Camera::nominal(width, height, nominal.field_of_view.rad(), terms)?;
                CameraEstimate::from(camera)
            }
        };
        let (sensor_from_camera, estimate) = match pose_file {
            Some(pose) => {
                refuse_mixed(pose, estimate.camera())?;
                (rigid(&pose.camera_from_sensor)?.inverse(), pose.with_camera(&estimate)?)
            }
            None => (nominal.sensor_from_camera, JointEstimate::independent(&estimate, None)?),
        };
        let is_nominal = [camera_file.is_none(), pose_file.is_none()];
        Ok(Self { estimate, sensor_from_camera, is_nominal })
    }

    /// The same view in another number of pixels; nothing is said of how sure it is.
    ///
    /// # Errors
    /// A picture without pixels, or with more than cameras have.
    pub fn resized(&self, size_px: [u32; 2]) -> Result<Self, InvalidViewpoint> {
        let camera = CameraEstimate::from(self.camera().resized(size_px)?);
        let estimate = JointEstimate::independent(&camera, None)?;
        Ok(Self { estimate, ..self.clone() })
    }

    /// Whether the camera is a lens alone, so that the drawn bodies bend its rays: the design's, or one whose
    /// file says so. Other files were fitted to what the camera saw through the bodies: their model says how
    /// rays are bent, at all of them or, where it says so, at the first interface.
    pub fn is_drawn(&self) -> bool {
        self.is_nominal[0] || *self.camera().interface() == Interface::Drawn
    }

    /// A sensor's bodies as the camera's rays meet them.
    ///
    /// # Errors
    /// As for [`Stack::of`]; a pose that puts the pupil inside what light does not pass.
    pub fn stack(&self, sensor: &Sensor) -> Result<Stack, InvalidStack> {
        let stack = match self.is_drawn() {
            true => Stack::of(sensor)?,
            false if self.camera().interface().is_drawn_behind() => {
                self.behind_interface(sensor)?
            }
            false => Stack::straight(sensor)?,
        };
        stack.check_pupil(&self.sensor_from_camera.point(Point3::origin()))?;
        Ok(stack)
    }

    /// What bends rays behind the camera's own interface.
    fn behind_interface(&self, sensor: &Sensor) -> Result<Stack, InvalidStack> {
        let stack = Stack::of(sensor)?;
        let nominal = &sensor.camera.sensor_from_camera;
        let window = Window::of(&self.camera().in_air(), nominal, &Sights::new(stack.clone()));
        stack.behind(&window, nominal)
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
        Uncertainty { joint: Some(self.estimate.clone()), shape_mm }
    }

    /// What the sigma of ground truth contains: `pose, lens, shape`.
    pub fn sigma_of(&self) -> String {
        self.estimate.covered().to_string()
    }

    /// Whether a calibration says how sure camera or pose are.
    pub fn says_how_sure(&self) -> bool {
        !self.sigma_parameters().is_empty()
    }

    /// Names of the parameters whose variances are in the sigma of ground truth.
    pub fn sigma_parameters(&self) -> Vec<&'static str> {
        let names = self.estimate.names();
        self.estimate.free().map(|i| names[i]).collect()
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
            "interface": if self.is_drawn() { "drawn" } else { camera.interface().kind_name() },
            "is_drawn_behind": camera.interface().is_drawn_behind(),
            "parameters": parameters,
            "sensor_from_camera": self.sensor_from_camera,
        })
    }
}

/// Refuses a camera with an interface for a pose that was solved without one, and the other way round: light
/// would be bent twice, or not at all. Poses that do not say what they were solved with are believed.
fn refuse_mixed(pose: &PoseFile, camera: &Camera) -> Result<(), InvalidViewpoint> {
    let Some(joint) = &pose.joint else { return Ok(()) };
    let contains = joint.names.iter().any(|name| name.starts_with("interface_"));
    let given = match camera.interface() {
        Interface::None if !contains => return Ok(()),
        Interface::Flat(_) | Interface::Sphere(_) if contains => return Ok(()),
        Interface::None => "none".to_owned(),
        interface => format!("a {} one", interface.kind_name()),
    };
    Err(InvalidViewpoint::Mixed {
        solved_with: if contains { "contains the interface" } else { "has no interface" },
        given,
    })
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
