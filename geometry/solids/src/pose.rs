//! Rigid motions.

use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::Angle;

/// A rigid motion: a proper rotation followed by a translation in mm.
///
/// A pose named `a_from_b` maps coordinates in frame `b` to coordinates in frame `a`, so that
/// `a_from_c = a_from_b.then_in(b_from_c)` reads from left to right.
///
/// JSON: `{"rotation": [[r00, r01, r02], ...rows], "translation_mm": [x, y, z]}`.
///
/// ```
/// use fabkit_geometry::{Angle, Point3, Pose};
/// let quarter = Pose::rotation_z(Angle::from_deg(90.0).unwrap());
/// assert_eq!(quarter.point(Point3::new(1.0, 0.0, 0.0)), Point3::new(0.0, 1.0, 0.0)); // exactly
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "PoseForm", try_from = "PoseForm")]
pub struct Pose {
    rotation: Matrix3<f64>,
    translation_mm: Vector3<f64>,
}

impl Pose {
    /// Creates a pose from its axes and origin; `None` unless the axes form a right-handed orthonormal frame.
    ///
    /// ```
    /// use fabkit_geometry::{Point3, Pose, Vector3};
    /// let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    /// let looking_down = Pose::with_axes([x, -y, -z], Point3::new(0.0, 0.0, 50.0)).unwrap();
    /// assert_eq!(looking_down.point(Point3::new(0.0, 0.0, 50.0)), Point3::origin());
    /// assert!(Pose::with_axes([x, y, -z], Point3::origin()).is_none()); // left-handed
    /// assert!(Pose::with_axes([2.0 * x, y, z], Point3::origin()).is_none()); // x is not of unit length
    /// ```
    pub fn with_axes(axes: [Vector3<f64>; 3], origin: Point3<f64>) -> Option<Self> {
        Self::new(Matrix3::from_columns(&axes), origin.coords)
    }

    /// Returns the identity.
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation_mm: Vector3::zeros() }
    }

    /// Creates a pose from a rotation matrix and a translation in mm; `None` unless [`Pose::is_rigid`].
    pub fn new(rotation: Matrix3<f64>, translation_mm: Vector3<f64>) -> Option<Self> {
        let pose = Self { rotation, translation_mm };
        pose.is_rigid().then_some(pose)
    }

    /// Creates a translation, mm.
    pub fn translation(x_mm: f64, y_mm: f64, z_mm: f64) -> Self {
        Self { rotation: Matrix3::identity(), translation_mm: Vector3::new(x_mm, y_mm, z_mm) }
    }

    /// Creates a rotation about x; multiples of 90 degrees are exact.
    pub fn rotation_x(angle: Angle) -> Self {
        let (s, c) = sin_cos(angle);
        Self::from_rows([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    }

    /// Creates a rotation about y; multiples of 90 degrees are exact.
    pub fn rotation_y(angle: Angle) -> Self {
        let (s, c) = sin_cos(angle);
        Self::from_rows([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    }

    /// Creates a rotation about z; multiples of 90 degrees are exact.
    pub fn rotation_z(angle: Angle) -> Self {
        let (s, c) = sin_cos(angle);
        Self::from_rows([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    }

    /// Creates a pose that maps the z axis at the origin to `axis` at `point`.
    ///
    /// The x axis follows by the smallest possible rotation, so that neighbouring axes get neighbouring frames
    /// everywhere but near -z (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017). `axis` need not be
    /// of unit length but must not be zero.
    ///
    /// ```
    /// use fabkit_geometry::{Point3, Pose, Vector3};
    /// let seat = Pose::z_to(Vector3::new(0.0, 3.0, 0.0), Point3::new(0.0, 12.0, 5.0));
    /// assert_eq!(seat.vector(Vector3::z()), Vector3::y());
    /// assert_eq!(seat.point(Point3::new(0.0, 0.0, 2.0)), Point3::new(0.0, 14.0, 5.0));
    /// ```
    pub fn z_to(axis: Vector3<f64>, point: Point3<f64>) -> Self {
        let n = axis.normalize();
        // The sign keeps the denominator below away from 0 for axes near -z.
        let sign = 1.0f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        let x = Vector3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
        let y = Vector3::new(b, sign + n.y * n.y * a, -n.y);
        Self { rotation: Matrix3::from_columns(&[x, y, n]), translation_mm: point.coords }
    }

    fn from_rows(rows: [[f64; 3]; 3]) -> Self {
        Self { rotation: Matrix3::from_fn(|r, c| rows[r][c]), translation_mm: Vector3::zeros() }
    }

    /// Composes two poses: `(a_from_b).then_in(b_from_c)` is `a_from_c`.
    ///
    /// ```
    /// use fabkit_geometry::{Angle, Point3, Pose};
    /// let sensor_from_board = Pose::translation(0.0, 0.0, -10.0);
    /// let board_from_led = Pose::translation(7.0, 0.0, 1.5);
    /// let sensor_from_led = sensor_from_board.then_in(board_from_led);
    /// assert_eq!(sensor_from_led.point(Point3::origin()), Point3::new(7.0, 0.0, -8.5));
    /// // The right one acts first: with the board turned, the LED moves around the axis.
    /// let turned = Pose::rotation_z(Angle::from_deg(90.0).unwrap()).then_in(board_from_led);
    /// assert_eq!(turned.point(Point3::origin()), Point3::new(0.0, 7.0, 1.5));
    /// ```
    #[must_use]
    pub fn then_in(&self, inner: Pose) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation_mm: self.rotation * inner.translation_mm + self.translation_mm,
        }
    }

    /// Returns the inverse: `(a_from_b).inverse()` is `b_from_a`.
    ///
    /// ```
    /// use fabkit_geometry::{Angle, Point3, Pose};
    /// let turn = Pose::rotation_z(Angle::from_deg(90.0).unwrap());
    /// let sensor_from_camera = Pose::translation(0.0, 0.0, -30.0).then_in(turn);
    /// let camera_from_sensor = sensor_from_camera.inverse();
    /// assert_eq!(camera_from_sensor.point(Point3::new(0.0, 2.0, -30.0)), Point3::new(2.0, 0.0, 0.0));
    /// assert_eq!(camera_from_sensor.then_in(sensor_from_camera), Pose::identity());
    /// ```
    #[must_use]
    pub fn inverse(&self) -> Self {
        let back = self.rotation.transpose();
        Self { rotation: back, translation_mm: -(back * self.translation_mm) }
    }

    /// Transforms a point.
    pub fn point(&self, point: Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * point.coords + self.translation_mm)
    }

    /// Rotates a direction.
    ///
    /// ```
    /// use fabkit_geometry::{Point3, Pose, Vector3};
    /// let lifted = Pose::translation(0.0, 0.0, 5.0);
    /// assert_eq!(lifted.point(Point3::new(0.0, 0.0, 1.0)), Point3::new(0.0, 0.0, 6.0));
    /// assert_eq!(lifted.vector(Vector3::z()), Vector3::z()); // a direction has no place
    /// ```
    pub fn vector(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.rotation * vector
    }

    /// Returns the rotation matrix.
    pub fn rotation(&self) -> &Matrix3<f64> {
        &self.rotation
    }

    /// Returns the translation, mm.
    pub fn translation_mm(&self) -> &Vector3<f64> {
        &self.translation_mm
    }

    /// Returns whether every number is finite and the rotation is proper (no reflection, no scale) to 1e-9.
    pub fn is_rigid(&self) -> bool {
        let r = &self.rotation;
        let residual = (r.transpose() * r - Matrix3::identity()).amax();
        self.translation_mm.iter().all(|v| v.is_finite())
            && residual < 1e-9
            && (r.determinant() - 1.0).abs() < 1e-9
    }
}

/// Computes sine and cosine, exact at multiples of 90 degrees.
fn sin_cos(angle: Angle) -> (f64, f64) {
    let quarters = angle.rad() / std::f64::consts::FRAC_PI_2;
    // Angles in degrees convert to multiples of pi / 2 only up to rounding.
    if (quarters - quarters.round()).abs() > 1e-13 * quarters.abs().max(1.0) {
        return angle.rad().sin_cos();
    }
    match quarters.round().rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PoseForm {
    rotation: [[f64; 3]; 3],
    translation_mm: [f64; 3],
}

impl From<Pose> for PoseForm {
    fn from(pose: Pose) -> Self {
        let rotation = std::array::from_fn(|r| std::array::from_fn(|c| pose.rotation[(r, c)]));
        Self { rotation, translation_mm: pose.translation_mm.into() }
    }
}

impl TryFrom<PoseForm> for Pose {
    type Error = &'static str;

    fn try_from(form: PoseForm) -> Result<Self, Self::Error> {
        let mut pose = Pose::from_rows(form.rotation);
        pose.translation_mm = form.translation_mm.into();
        pose.is_rigid().then_some(pose).ok_or("a pose must be finite, without mirror or scale")
    }
}
