//! Sensors for robot descriptions and simulators: URDF (ROS 1.9), MJCF (MuJoCo 3 and 4), SDF (Gazebo 1.9, and with
//! Drake's own elements), USD (Isaac Sim, TacEx) and TACTO's YAML.
//!
//! All use metres, kilograms and radians. Every link has the sensor's frame, so that nothing depends on how a reader
//! composes transforms. Soft layers are welded to the base, because a sensor has no joints. Meshes are Wavefront OBJ
//! files in metres beside the file, referenced by name alone; USD contains its meshes.

mod isaac;
mod mjcf;
mod numbers;
mod obj;
mod rotation;
mod sdf;
mod tacto;
mod urdf;
mod usd;
mod xml;

use std::sync::Arc;

use fabkit_geometry::{Matrix3, Pose, Vector3};

pub use isaac::{tacex, tacsl};
pub use mjcf::mjcf;
pub use obj::obj;
pub use sdf::{drake, sdf};
pub use tacto::tacto;
pub use urdf::urdf;
pub use usd::usd;

/// A sensor with its links.
///
/// ```
/// use fabkit_export::{Inertia, Robot, RobotCamera, RobotFrame, RobotLink, mjcf, tacto, urdf};
/// use fabkit_geometry::Pose;
///
/// let pose = Pose::translation(0.0, 0.0, -12.0);
/// let base = RobotLink {
///     name: "base".into(),
///     inertia: Inertia { mass_kg: 0.05, ..Inertia::ZERO },
///     visuals: Vec::new(),
///     collisions: Vec::new(),
///     friction: None,
/// };
/// let robot = Robot {
///     name: "empty".into(),
///     comment: "a sensor without shapes".into(),
///     links: vec![base],
///     frames: vec![RobotFrame { name: "camera_optical".into(), sensor_from_frame: pose }],
///     camera: RobotCamera {
///         frame: "camera_optical".into(),
///         sensor_from_camera: pose,
///         size_px: [640, 480],
///         focal_px: 240.0,
///         near_mm: 1.0,
///     },
///     touch: None,
///     light_sources: Vec::new(),
/// };
/// // All files are in metres and kilograms.
/// assert!(urdf(&robot).contains("<mass value=\"0.05\"/>"));
/// assert!(urdf(&robot).contains("<origin xyz=\"0 0 -0.012\" rpy=\"0 0 0\"/>"));
/// // MuJoCo's cameras look along -z with y up: half a turn about x from z forward and y down.
/// assert!(mjcf(&robot).contains("quat=\"0 1 0 0\" fovy=\"90\" resolution=\"640 480\""));
/// // TACTO draws a sensing surface, and this sensor has none.
/// assert_eq!(tacto(&robot), None);
/// ```
#[derive(Clone, Debug)]
pub struct Robot {
    /// Name, of the characters `[a-z0-9-]`.
    pub name: String,
    /// Origin of the file, one line.
    pub comment: String,
    /// Links, the base first; all others are welded to it.
    pub links: Vec<RobotLink>,
    /// Frames without a body.
    pub frames: Vec<RobotFrame>,
    /// Pinhole camera that approximates the sensor's camera.
    pub camera: RobotCamera,
    /// Sensing surface, whose vertices are the taxels.
    pub touch: Option<RobotSensingSurface>,
    /// Light sources that are lit in the sensor's usual lighting.
    pub light_sources: Vec<RobotLightSource>,
}

/// Sensing surface.
#[derive(Clone, Debug)]
pub struct RobotSensingSurface {
    /// Closed, convex mesh.
    pub mesh: Arc<RobotMesh>,
    /// Name of the link that it belongs to.
    pub link: String,
    /// Width along x and y, and height along z, of the sensing area, mm.
    pub size_mm: [f64; 3],
    /// Height of the highest point, mm.
    pub top_z_mm: f64,
    /// Depth to which it can be pressed, mm.
    pub max_indentation_mm: f64,
    /// Young's modulus of the layers below it in series, MPa.
    pub young_mpa: f64,
    /// Thickness of these layers below its middle, mm.
    pub thickness_mm: f64,
    /// Number of bins along each side of the optics pack's table from slopes to colours; `None` where light does not
    /// show slopes, or where the surface is not flat.
    pub slope_bins: Option<usize>,
    /// Tetrahedra of all these layers.
    pub tetrahedra: Arc<RobotTetrahedra>,
}

/// Soft layers as tetrahedra; the file beside holds them in metres.
#[derive(Clone, Debug)]
pub struct RobotTetrahedra {
    /// Name of the file: `robot-tetrahedra.vtk`.
    pub file: String,
    /// Nodes, sensor frame, mm.
    pub points_mm: Vec<[f64; 3]>,
    /// Corners of the tetrahedra, of positive volume.
    pub cells: Vec<[u32; 4]>,
    /// Triangles of the whole surface, counter-clockwise seen from outside.
    pub surface: Vec<[u32; 3]>,
}

/// A light source, reduced to a point.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotLightSource {
    /// Position, sensor frame, mm.
    pub place_mm: [f64; 3],
    /// Colour as red, green and blue.
    pub rgb: [f64; 3],
    /// Brightness relative to the brightest source, which has 1.
    pub share: f64,
}

/// A rigid body, or a soft layer that is treated as one.
#[derive(Clone, Debug)]
pub struct RobotLink {
    /// Unique name.
    pub name: String,
    /// Mass and inertia.
    pub inertia: Inertia,
    /// Visual shapes.
    pub visuals: Vec<RobotShape>,
    /// Collision shapes: each stands for the convex hull of its file.
    pub collisions: Vec<RobotShape>,
    /// Coulomb's friction coefficient, if known.
    pub friction: Option<f64>,
}

/// Mass, centre of mass and moments of inertia, in the sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub centre_m: Vector3<f64>,
    /// Moments of inertia about the centre, along the sensor's axes, kg m2.
    pub about_centre: Matrix3<f64>,
}

impl Inertia {
    /// Inertia without mass.
    pub const ZERO: Self = Self {
        mass_kg: 0.0,
        centre_m: Vector3::new(0.0, 0.0, 0.0),
        about_centre: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// Combines two bodies (Huygens-Steiner theorem).
    ///
    /// ```
    /// use fabkit_export::Inertia;
    /// use fabkit_geometry::{Matrix3, Vector3};
    /// let point = |x: f64| Inertia { mass_kg: 1.0, centre_m: Vector3::new(x, 0.0, 0.0), about_centre: Matrix3::zeros() };
    /// let dumbbell = point(-2.0).combined(&point(2.0));
    /// assert_eq!((dumbbell.mass_kg, dumbbell.centre_m.x), (2.0, 0.0));
    /// assert_eq!(dumbbell.about_centre.diagonal(), Vector3::new(0.0, 8.0, 8.0));
    /// ```
    #[must_use]
    pub fn combined(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        // Two massless bodies have no centre of mass.
        if mass_kg <= 0.0 {
            return *self;
        }
        let centre_m = (self.mass_kg * self.centre_m + other.mass_kg * other.centre_m) / mass_kg;
        let about = |part: &Self| {
            let off = part.centre_m - centre_m;
            let square = Matrix3::identity() * off.norm_squared() - off * off.transpose();
            part.about_centre + part.mass_kg * square
        };
        Self { mass_kg, centre_m, about_centre: about(self) + about(other) }
    }

    /// Returns the six moments in the order of all formats: xx, yy, zz, xy, xz, yz.
    fn moments(&self) -> [f64; 6] {
        let i = &self.about_centre;
        [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]]
    }
}

/// A triangle mesh, counter-clockwise seen from outside, sensor frame.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotMesh {
    /// Name of the file beside that holds it, such as `robot-touch.obj`.
    pub file: String,
    /// Vertices, mm.
    pub vertices_mm: Vec<[f64; 3]>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl RobotMesh {
    /// Returns the least and the largest of each coordinate, mm.
    ///
    /// ```
    /// use fabkit_export::RobotMesh;
    ///
    /// let triangle = RobotMesh {
    ///     file: "triangle.obj".into(),
    ///     vertices_mm: vec![[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, -3.0, 2.0]],
    ///     triangles: vec![[0, 1, 2]],
    /// };
    /// assert_eq!(triangle.bounds_mm(), [[0.0, -3.0, 1.0], [4.0, 0.0, 2.0]]);
    /// ```
    pub fn bounds_mm(&self) -> [[f64; 3]; 2] {
        let ends = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        self.vertices_mm.iter().fold(ends, |[least, most], vertex| {
            [0, 1].map(|end| {
                std::array::from_fn(|axis| match end {
                    0 => least[axis].min(vertex[axis]),
                    _ => most[axis].max(vertex[axis]),
                })
            })
        })
    }
}

/// A mesh with a name and a colour.
#[derive(Clone, Debug)]
pub struct RobotShape {
    /// Unique name.
    pub name: String,
    /// Mesh of the shape.
    pub mesh: Arc<RobotMesh>,
    /// Colour and opacity: red, green, blue and alpha, 0 to 1.
    pub rgba: [f64; 4],
}

/// A named frame that users rely on.
#[derive(Clone, Debug)]
pub struct RobotFrame {
    /// Unique name.
    pub name: String,
    /// Pose, mm.
    pub sensor_from_frame: Pose,
}

/// A pinhole camera with square pixels and its axis through the image's centre, which every format can express.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotCamera {
    /// Name of its frame in [`Robot::frames`]: z forward, x right, y down.
    pub frame: String,
    /// Pose, mm.
    pub sensor_from_camera: Pose,
    /// Number of columns and rows.
    pub size_px: [u32; 2],
    /// Focal length, px.
    pub focal_px: f64,
    /// Distance of the near clipping plane, mm.
    pub near_mm: f64,
}

impl RobotCamera {
    /// Returns the full angle of view along rows and columns, rad.
    ///
    /// ```
    /// use fabkit_export::RobotCamera;
    /// let camera = RobotCamera {
    ///     frame: "camera_optical".into(), sensor_from_camera: fabkit_geometry::Pose::identity(),
    ///     size_px: [640, 320], focal_px: 320.0, near_mm: 1.0,
    /// };
    /// let [across, down] = camera.view_rad().map(f64::to_degrees);
    /// assert!((across - 90.0).abs() < 1e-12 && (down - 53.13).abs() < 0.01);
    /// assert_eq!(camera.project([0.0, 0.0, 10.0]), Some([319.5, 159.5]));
    /// ```
    pub fn view_rad(&self) -> [f64; 2] {
        self.size_px.map(|px| 2.0 * (f64::from(px) / 2.0 / self.focal_px).atan())
    }

    /// Position of the optical axis in the image, column and row; 0 is the centre of the first pixel.
    pub fn middle_px(&self) -> [f64; 2] {
        self.size_px.map(|px| (f64::from(px) - 1.0) / 2.0)
    }

    /// Projects a point in the camera frame, mm, to column and row; `None` behind the camera or outside the image.
    ///
    /// ```
    /// use fabkit_export::RobotCamera;
    /// use fabkit_geometry::Pose;
    ///
    /// let camera = RobotCamera {
    ///     frame: "camera_optical".into(),
    ///     sensor_from_camera: Pose::identity(),
    ///     size_px: [640, 480],
    ///     focal_px: 240.0,
    ///     near_mm: 1.0,
    /// };
    /// // z points forward, x to the right: 1 mm at a distance of 10 mm is 24 px.
    /// assert_eq!(camera.project_into_image([1.0, 0.0, 10.0]), Some([343.5, 239.5]));
    /// assert_eq!(camera.project_into_image([0.0, 11.0, 10.0]), None);
    /// assert!(camera.project([0.0, 11.0, 10.0]).is_some());
    /// assert_eq!(camera.project([0.0, 0.0, -10.0]), None);
    /// ```
    pub fn project_into_image(&self, place_in_camera: [f64; 3]) -> Option<[f64; 2]> {
        let is_within = |(px, size): (&f64, &u32)| (-0.5..f64::from(*size) - 0.5).contains(px);
        self.project(place_in_camera).filter(|pixel| pixel.iter().zip(&self.size_px).all(is_within))
    }

    /// Projects a point in the camera frame, mm, to column and row, inside the image or outside; `None` behind the
    /// camera.
    pub fn project(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        let [column, row] = self.middle_px();
        (z > 0.0).then(|| [self.focal_px * x / z + column, self.focal_px * y / z + row])
    }
}
