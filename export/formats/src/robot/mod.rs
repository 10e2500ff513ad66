//! Sensors as robots' descriptions and simulators read them: URDF (ROS 1.9), MJCF (MuJoCo 3 and 4), SDF (Gazebo 1.9, and with Drake's
//! own elements), USD (Isaac Sim, TacEx) and TACTO's YAML.
//!
//! Metres, kilograms and radians throughout, which all of them ask for. Every link has the sensor's frame, so that nothing
//! depends on how a reader composes transforms; what moves is welded to the base, because a sensor has no joints. Meshes are Wavefront
//! OBJ in metres beside the file, found by their names alone; USD holds them itself.

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
#[derive(Clone, Debug)]
pub struct Robot {
    /// `[a-z0-9-]`.
    pub name: String,
    /// Where it comes from, one line.
    pub comment: String,
    /// The base first; all others are welded to it.
    pub links: Vec<RobotLink>,
    /// Frames without a body.
    pub frames: Vec<RobotFrame>,
    /// The pinhole that stands for the camera.
    pub camera: RobotCamera,
    /// The shape that is touched: its vertices feel.
    pub touch: Option<RobotTouch>,
    /// What shines in its usual light.
    pub lamps: Vec<RobotLamp>,
}

/// What is touched.
#[derive(Clone, Debug)]
pub struct RobotTouch {
    /// Closed, convex.
    pub mesh: Arc<RobotMesh>,
    /// The link that it belongs to.
    pub link: String,
    /// Width along x and y, and height along z, of all that is felt, mm.
    pub size_mm: [f64; 3],
    /// Its highest place, mm.
    pub top_z_mm: f64,
    /// How deep it can be pressed, mm.
    pub soft_mm: f64,
    /// Layers below it in series, as one: Young's modulus, MPa.
    pub young_mpa: f64,
    /// All of them, below its middle, mm.
    pub thickness_mm: f64,
    /// Steps of each side of the table from slopes to colours that an optics pack has; nothing where light shows something else,
    /// or where the surface is not flat.
    pub slope_bins: Option<usize>,
    /// Tetrahedra of all of them.
    pub tetrahedra: Arc<RobotTetrahedra>,
}

/// Soft layers as tetrahedra, in metres in the file beside.
#[derive(Clone, Debug)]
pub struct RobotTetrahedra {
    /// `robot-tetrahedra.vtk`.
    pub file: String,
    /// Nodes, sensor frame, mm.
    pub points_mm: Vec<[f64; 3]>,
    /// Corners, of positive volume.
    pub cells: Vec<[u32; 4]>,
    /// Triangles of the whole surface, counter-clockwise from outside.
    pub surface: Vec<[u32; 3]>,
}

/// A lamp as a point.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotLamp {
    /// Sensor frame, mm.
    pub place_mm: [f64; 3],
    /// Its colour.
    pub rgb: [f64; 3],
    /// How bright beside the others: 1 is the brightest.
    pub share: f64,
}

/// A rigid body, or a soft layer taken for one.
#[derive(Clone, Debug)]
pub struct RobotLink {
    /// Unique.
    pub name: String,
    /// Its mass.
    pub inertia: Inertia,
    /// What is seen of it.
    pub visuals: Vec<RobotShape>,
    /// What is touched of it: each the convex hull of its file.
    pub collisions: Vec<RobotShape>,
    /// Coulomb's coefficient, where it is known.
    pub friction: Option<f64>,
}

/// Mass and how it is spread, in the sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub centre_m: Vector3<f64>,
    /// About the centre, axes as the sensor's, kg m2.
    pub about_centre: Matrix3<f64>,
}

impl Inertia {
    /// Nothing.
    pub const NOTHING: Self = Self {
        mass_kg: 0.0,
        centre_m: Vector3::new(0.0, 0.0, 0.0),
        about_centre: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// Both together (Huygens and Steiner).
    ///
    /// ```
    /// use fabkit_export::Inertia;
    /// use fabkit_geometry::{Matrix3, Vector3};
    /// let point = |x: f64| Inertia { mass_kg: 1.0, centre_m: Vector3::new(x, 0.0, 0.0), about_centre: Matrix3::zeros() };
    /// let dumbbell = point(-2.0).and(&point(2.0));
    /// assert_eq!((dumbbell.mass_kg, dumbbell.centre_m.x), (2.0, 0.0));
    /// assert_eq!(dumbbell.about_centre.diagonal(), Vector3::new(0.0, 8.0, 8.0));
    /// ```
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
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

    /// Six numbers as all formats want them: xx, yy, zz, xy, xz, yz.
    fn six(&self) -> [f64; 6] {
        let i = &self.about_centre;
        [i[(0, 0)], i[(1, 1)], i[(2, 2)], i[(0, 1)], i[(0, 2)], i[(1, 2)]]
    }
}

/// Triangles, counter-clockwise seen from outside, sensor frame.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotMesh {
    /// The file beside that holds it: `robot-touch.obj`.
    pub file: String,
    /// mm.
    pub vertices_mm: Vec<[f64; 3]>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
}

impl RobotMesh {
    /// Least and largest of each coordinate, mm.
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
    /// Unique.
    pub name: String,
    /// What it looks like.
    pub mesh: Arc<RobotMesh>,
    /// Red, green, blue and opacity, 0 to 1.
    pub rgba: [f64; 4],
}

/// A place that others rely on.
#[derive(Clone, Debug)]
pub struct RobotFrame {
    /// Unique.
    pub name: String,
    /// Where, mm.
    pub sensor_from_frame: Pose,
}

/// A pinhole with square pixels, its axis in the middle of its picture: what every format can say.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotCamera {
    /// The frame's name in [`Robot::frames`]: z forward, x right, y down.
    pub frame: String,
    /// Where, mm.
    pub sensor_from_camera: Pose,
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// Focal length, px.
    pub focal_px: f64,
    /// The nearest that it sees, mm.
    pub near_mm: f64,
}

impl RobotCamera {
    /// The whole angle of view along rows and columns, rad.
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

    /// Where its axis meets the picture: column and row, 0 in the middle of the first pixel.
    pub fn middle_px(&self) -> [f64; 2] {
        self.size_px.map(|px| (f64::from(px) - 1.0) / 2.0)
    }

    /// Where a place in its frame, mm, is in its picture: column and row; nothing of what lies behind or beside.
    pub fn sees(&self, place_in_camera: [f64; 3]) -> Option<[f64; 2]> {
        let is_within = |(px, size): (&f64, &u32)| (-0.5..f64::from(*size) - 0.5).contains(px);
        self.project(place_in_camera).filter(|pixel| pixel.iter().zip(&self.size_px).all(is_within))
    }

    /// Where a place in its frame, mm, is seen, in its picture or beside: column and row; nothing of what lies behind.
    pub fn project(&self, [x, y, z]: [f64; 3]) -> Option<[f64; 2]> {
        let [column, row] = self.middle_px();
        (z > 0.0).then(|| [self.focal_px * x / z + column, self.focal_px * y / z + row])
    }
}
