//! Camera and pose of a sensor, nominal or calibrated.

use std::ops::Range;

use fabkit_camera::files::{self, CameraFile, InvalidCameraFile, PoseFile};
use fabkit_camera::{
    Camera, CameraEstimate, Interface, InvalidCamera, InvalidCovariance, JointEstimate,
};
use fabkit_depth::ground_truth::{PixelRays, Uncertainty};
use fabkit_geometry::{Matrix3, NominalCamera, Point3, Pose, Sensor, Vector3};
use fabkit_optics::{FirstInterface, InvalidStack, OpticalStack, ViewStacks};
use serde_json::{Value, json};

/// A camera, its pose, and the uncertainty of both.
///
/// ```
/// use fabkit_geometry::Point3;
/// use fabkit_scene::ground_truth::Viewpoint;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None)?.resized([64, 48])?;
/// // The camera looks along the sensor's axis: what lies on its own axis is in the middle of the image.
/// let middle = viewpoint.camera().project(&Point3::new(0.0, 0.0, 10.0))?;
/// assert_eq!([middle.x, middle.y], [31.5, 23.5]);
/// // The nominal camera is a bare lens: bodies of the design refract its rays, and nothing is uncertain.
/// assert!(viewpoint.is_bare_lens() && !viewpoint.has_uncertainty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Viewpoint {
    /// Camera model with the joint covariance of its parameters and pose.
    pub estimate: JointEstimate,
    /// Pose that maps the camera frame to the sensor frame, mm.
    pub sensor_from_camera: Pose,
    /// Whether camera and pose are the design's rather than calibrated.
    is_nominal: [bool; 2],
    /// Unusual values of the camera file, each a sentence.
    warnings: Vec<String>,
}

/// Reason why camera and pose form no viewpoint.
#[derive(Debug, thiserror::Error)]
pub enum InvalidViewpoint {
    /// A camera file with faults.
    #[error(transparent)]
    File(#[from] InvalidCameraFile),
    /// A nominal camera that is not valid.
    #[error("the nominal camera: {0}")]
    Nominal(#[from] InvalidCamera),
    /// A pose and a camera of which one model contains the interface before the lens and the other does not.
    #[error(
        "the pose was solved with a camera whose model {}; the camera given has {}",
        .solved_with, .given
    )]
    Mixed {
        /// Description of the camera model that the pose was solved with.
        solved_with: &'static str,
        /// Description of the given camera's interface.
        given: String,
    },
    /// A matrix that mirrors, scales or shears.
    #[error(
        "camera_from_sensor is no rigid motion: its rotation is off by {residual:.1e} and has the \
         determinant {determinant:.6}"
    )]
    NotRigid {
        /// Largest absolute entry of R^T R - 1.
        residual: f64,
        /// Determinant of the matrix; 1 for a rotation.
        determinant: f64,
    },
    /// A matrix that is no covariance.
    #[error("the pose's covariance: {0}")]
    Covariance(#[from] InvalidCovariance),
}

impl Viewpoint {
    /// Creates a viewpoint from a design's nominal camera, replaced by the text of a camera file and by a pose where
    /// given.
    ///
    /// # Errors
    /// [`InvalidViewpoint`].
    pub fn new(
        nominal: &NominalCamera,
        camera_file: Option<&str>,
        pose_file: Option<&PoseFile>,
    ) -> Result<Self, InvalidViewpoint> {
        let camera_file = camera_file.map(|text| files::read_file(text, None)).transpose()?;
        Self::from_files(nominal, camera_file.as_ref(), pose_file)
    }

    /// Creates a viewpoint as [`Viewpoint::new`], from a camera that has been read.
    ///
    /// # Errors
    /// [`InvalidViewpoint`].
    pub fn from_files(
        nominal: &NominalCamera,
        camera_file: Option<&CameraFile>,
        pose_file: Option<&PoseFile>,
    ) -> Result<Self, InvalidViewpoint> {
        let mut warnings = camera_file.map_or_else(Vec::new, CameraFile::warnings);
        let estimate = match camera_file {
            Some(file) => {
                warnings.extend(other_size(nominal, file.estimate.camera()));
                file.estimate.clone()
            }
            None => {
                let (width, height) = (nominal.width_px, nominal.height_px);
                let terms = nominal.lens.projection.terms();
                let camera =
                    Camera::from_data_sheet(width, height, nominal.field_of_view.rad(), terms)?;
                CameraEstimate::from(camera)
            }
        };
        let (sensor_from_camera, estimate) = match pose_file {
            Some(pose) => {
                refuse_mixed(pose, estimate.camera())?;
                (rigid_pose(&pose.camera_from_sensor)?.inverse(), pose.with_camera(&estimate)?)
            }
            None => (nominal.sensor_from_camera, JointEstimate::independent(&estimate, None)?),
        };
        let is_nominal = [camera_file.is_none(), pose_file.is_none()];
        Ok(Self { estimate, sensor_from_camera, is_nominal, warnings })
    }

    /// Returns the same view with another number of pixels. Uncertainties are dropped.
    ///
    /// # Errors
    /// Returns an error for an image without pixels, or with more than cameras may have.
    pub fn resized(&self, size_px: [u32; 2]) -> Result<Self, InvalidViewpoint> {
        let camera = CameraEstimate::from(self.camera().resized(size_px)?);
        let estimate = JointEstimate::independent(&camera, None)?;
        Ok(Self { estimate, ..self.clone() })
    }

    /// Returns whether the camera is a bare lens whose rays the design's bodies refract: the nominal camera, or one
    /// whose file says so. Other camera files were fitted to images seen through the bodies: their model contains the
    /// refraction, of all bodies or, where the file says so, of the first interface.
    pub fn is_bare_lens(&self) -> bool {
        self.is_nominal[0] || *self.camera().interface() == Interface::FromDrawing
    }

    /// Returns the sensor's bodies as the camera's rays meet them.
    ///
    /// # Errors
    /// Returns the errors of [`OpticalStack::from_sensor`], and one for a pose that puts the pupil inside an opaque body.
    pub fn stack(&self, sensor: &Sensor) -> Result<OpticalStack, InvalidStack> {
        let stack = match self.is_bare_lens() {
            true => OpticalStack::from_sensor(sensor)?,
            false if self.camera().interface().has_drawn_bodies_behind() => {
                self.behind_interface(sensor)?
            }
            false => OpticalStack::without_refraction(sensor)?,
        };
        stack.check_pupil(&self.sensor_from_camera.point(Point3::origin()))?;
        Ok(stack)
    }

    /// Returns the stack of bodies behind the camera's own interface.
    fn behind_interface(&self, sensor: &Sensor) -> Result<OpticalStack, InvalidStack> {
        let stack = OpticalStack::from_sensor(sensor)?;
        let nominal = &sensor.camera.sensor_from_camera;
        // The camera's model contains the first interface of this window, so only the bodies behind it are left to the
        // stack.
        let window = FirstInterface::from_camera(
            &self.camera().without_interface(),
            nominal,
            &ViewStacks::new(stack.clone()),
        );
        stack.starting_behind(&window, nominal)
    }

    /// Returns what is unusual about the camera file, each as a sentence.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Returns the camera model.
    pub fn camera(&self) -> &Camera {
        self.estimate.camera()
    }

    /// Returns one ray for each of `samples` x `samples` parts of each pixel.
    pub fn rays(&self, samples: u32) -> PixelRays {
        PixelRays::with_samples(self.camera(), &self.sensor_from_camera, samples)
    }

    /// Returns the same rays as [`Viewpoint::rays`] for some rows alone. `rows` counts rows of rays.
    pub fn rays_of_rows(&self, samples: u32, rows: Range<u32>) -> PixelRays {
        PixelRays::from_rows(self.camera(), &self.sensor_from_camera, samples, rows)
    }

    /// Returns the uncertainty of camera and pose, joined with the standard deviation of printed or cast surfaces along
    /// their normals, mm.
    pub fn uncertainty(&self, shape_mm: f64) -> Uncertainty {
        Uncertainty { joint: Some(self.estimate.clone()), shape_mm }
    }

    /// Returns the contributions to the sigma of ground truth, as in `pose, lens, shape`.
    pub fn sigma_contributions(&self) -> String {
        self.estimate.coverage().to_string()
    }

    /// Returns whether a calibration states uncertainties of camera or pose.
    pub fn has_uncertainty(&self) -> bool {
        !self.sigma_parameters().is_empty()
    }

    /// Returns the names of the parameters whose variances contribute to the sigma of ground truth.
    pub fn sigma_parameters(&self) -> Vec<&'static str> {
        let names = self.estimate.names();
        self.estimate.free_parameters().map(|i| names[i]).collect()
    }

    /// Returns all data of the viewpoint as JSON, for data cards.
    pub fn to_json(&self) -> Value {
        let camera = self.camera();
        let parameters: serde_json::Map<_, _> =
            camera.parameters().into_iter().map(|(n, v)| (n.to_owned(), json!(v))).collect();
        let word = |is_nominal| if is_nominal { "nominal" } else { "calibrated" };
        let mut document = json!({
            "camera": word(self.is_nominal[0]),
            "pose": word(self.is_nominal[1]),
            "width_px": camera.width_px(),
            "height_px": camera.height_px(),
            "lens": camera.lens().model_name(),
            "interface": if self.is_bare_lens() { "drawn" } else { camera.interface().kind_name() },
            "is_drawn_behind": camera.interface().has_drawn_bodies_behind(),
            "parameters": parameters,
            "sensor_from_camera": self.sensor_from_camera,
        });
        if !self.warnings.is_empty() {
            document["warnings"] = json!(self.warnings);
        }
        document
    }
}

/// Describes a camera file whose image is not as large as the design's, though it may be the same camera.
fn other_size(nominal: &NominalCamera, camera: &Camera) -> Option<String> {
    let [width, height] = [camera.width_px(), camera.height_px()];
    let is_same = [width, height] == [nominal.width_px, nominal.height_px];
    (!is_same).then(|| {
        format!(
            "the camera file is for images of {width} x {height} px, the design's camera takes \
             {} x {} px",
            nominal.width_px, nominal.height_px
        )
    })
}

/// Refuses a camera with an interface for a pose that was solved without one, and the reverse: refraction would count
/// twice, or not at all. Poses that do not name the parameters they were solved with are accepted.
fn refuse_mixed(pose: &PoseFile, camera: &Camera) -> Result<(), InvalidViewpoint> {
    let Some(joint) = &pose.joint else { return Ok(()) };
    // Interface parameters in the joint estimate show which camera model the pose was solved with.
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

fn rigid_pose(matrix: &[[f64; 4]; 4]) -> Result<Pose, InvalidViewpoint> {
    let rotation = Matrix3::from_fn(|r, c| matrix[r][c]);
    let translation = Vector3::from_fn(|r, _| matrix[r][3]);
    // Matrices written by hand have about six digits and are rounded to the nearest rotation; larger errors are
    // refused.
    let residual = (rotation.transpose() * rotation - Matrix3::identity()).amax();
    let determinant = rotation.determinant();
    let not_rigid = InvalidViewpoint::NotRigid { residual, determinant };
    if !(residual < 1e-4 && determinant > 0.0) {
        return Err(not_rigid);
    }
    Pose::new(nearest_rotation(rotation), translation).ok_or(not_rigid)
}

/// Projects a matrix to the nearest rotation with Newton's iteration for the orthogonal polar factor (Higham, SIAM J.
/// Sci. Stat. Comput. 7, 1986).
fn nearest_rotation(mut rotation: Matrix3<f64>) -> Matrix3<f64> {
    // Convergence is quadratic: an error of 1e-4 falls to rounding in two steps.
    for _ in 0..4 {
        let Some(inverse) = rotation.try_inverse() else { break };
        rotation = 0.5 * (rotation + inverse.transpose());
    }
    rotation
}
