//! Sensors as robots' descriptions and simulators read them: URDF (ROS 1.9), MJCF (MuJoCo 3 and 4) and SDF (Gazebo, 1.9).
//!
//! Metres, kilograms and radians throughout, which all three ask for. Every link has the sensor's frame, so that nothing
//! depends on how a reader composes transforms; what moves is welded to the base, because a sensor has no joints. Meshes are Wavefront
//! OBJ in metres beside the file, found by their names alone.

mod mjcf;
mod obj;
mod sdf;
mod urdf;
mod xml;

use fabkit_geometry::{Matrix3, Pose, Vector3};

pub use mjcf::mjcf;
pub use obj::obj;
pub use sdf::sdf;
pub use urdf::urdf;

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
    /// The camera, if a pinhole says something of it.
    pub camera: Option<RobotCamera>,
    /// The shape that is touched, by its file: its vertices feel.
    pub touch: Option<String>,
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

/// A mesh in a file beside.
#[derive(Clone, Debug)]
pub struct RobotShape {
    /// Unique.
    pub name: String,
    /// `robot-touch.obj`.
    pub file: String,
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

/// What a pinhole camera can say of a lens.
#[derive(Clone, Debug)]
pub struct RobotCamera {
    /// The frame's name in [`Robot::frames`]: z forward, x right, y down.
    pub frame: String,
    /// Where, mm.
    pub sensor_from_camera: Pose,
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// The whole angle of view along rows and columns, rad.
    pub view_rad: [f64; 2],
    /// The nearest that it sees, mm.
    pub near_mm: f64,
}
