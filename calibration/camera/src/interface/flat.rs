//! Flat interface: a plane, or a pane of glass, between the lens and the gel.

use nalgebra::{Matrix3, Point3, Vector3};

use super::{
    DirectionWithJacobians, MAX_INTERFACE_PARAMETERS, ON_INTERFACE_TOLERANCE_MM, check_indices,
    refract,
};
use crate::error::{OutsideDomain, ViolationCollector};
use crate::view_ray::ViewRay;

/// Flat window: lens in one medium (air), then a pane of glass or nothing, then the gel.
///
/// The plane's unit normal, toward the gel, is +z turned about y by `tilt_y_rad` and then about x
/// by `tilt_x_rad`: `(sin ty, -sin tx cos ty, cos tx cos ty)` in the camera frame.
///
/// Distance, both tilts and the outer index can be calibrated. The inner index cannot be distinguished from the outer
/// one, and a pane's thickness hardly from the distance, so these are inputs.
///
/// ```
/// use fabkit_camera::{Camera, FlatInterface, Interface, Point2};
/// // A window of 2 mm glass with air on both sides shifts rays, and does not turn them.
/// let window = FlatInterface {
///     glass_thickness_mm: 2.0,
///     index_glass: 1.5,
///     ..FlatInterface::bare_in_air(5.0, 1.0)
/// };
/// let bare = Camera::equidistant(640, 480, 2.5)?;
/// let behind = Camera::new(640, 480, *bare.lens(), Interface::Flat(window))?;
/// let [straight, shifted] = [bare, behind].map(|c| c.unproject(&Point2::new(500.0, 239.5)).unwrap());
/// assert!((straight.direction - shifted.direction).norm() < 1e-12);
/// assert!((shifted.origin_in_camera.z - 7.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatInterface {
    /// Distance from the lens's centre to the first surface, along its normal, mm.
    pub distance_mm: f64,
    /// Rotation of the normal about the camera's x axis, radians.
    pub tilt_x_rad: f64,
    /// Rotation of the normal about the camera's y axis, radians.
    pub tilt_y_rad: f64,
    /// Refractive index on the lens's side; 1 for air.
    pub index_inside: f64,
    /// Refractive index behind the window; about 1.41 for silicone.
    pub index_outside: f64,
    /// Thickness of the pane, mm; 0 for a bare surface.
    pub glass_thickness_mm: f64,
    /// Refractive index of the pane; without effect at thickness 0.
    pub index_glass: f64,
    /// True if drawn bodies behind the window refract rays again; see
    /// [`Interface::has_drawn_bodies_behind`](super::Interface::has_drawn_bodies_behind).
    pub has_drawn_bodies_behind: bool,
}

impl FlatInterface {
    /// Creates a bare surface perpendicular to the optical axis, with air on the lens's side.
    ///
    /// ```
    /// use fabkit_camera::{Camera, FlatInterface, Interface, Point2, Point3};
    /// let lens = *Camera::equidistant(640, 480, 160f64.to_radians())?.lens();
    /// let gel = Interface::Flat(FlatInterface::bare_in_air(5.0, 1.41));
    /// let camera = Camera::new(640, 480, lens, gel)?;
    /// // 45 degrees off the axis, as 80 degrees are 400 px: 5 mm aside at a distance of 5 mm.
    /// let ray = camera.unproject(&Point2::new(319.5 + 225.0, 239.5))?;
    /// assert!((ray.origin_in_camera - Point3::new(5.0, 0.0, 5.0)).norm() < 1e-12);
    /// // Snell's law: the sine of the angle in the gel is 1.41 times smaller.
    /// assert!((1.41 * ray.direction.x - 45f64.to_radians().sin()).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn bare_in_air(distance_mm: f64, index_outside: f64) -> Self {
        Self {
            distance_mm,
            tilt_x_rad: 0.0,
            tilt_y_rad: 0.0,
            index_inside: 1.0,
            index_outside,
            glass_thickness_mm: 0.0,
            index_glass: 1.5,
            has_drawn_bodies_behind: false,
        }
    }

    /// Computes the plane's unit normal towards the gel, camera frame.
    ///
    /// ```
    /// use fabkit_camera::FlatInterface;
    /// let level = FlatInterface::bare_in_air(5.0, 1.41);
    /// let tilted_x = FlatInterface { tilt_x_rad: 0.1, ..level }.normal();
    /// let tilted_y = FlatInterface { tilt_y_rad: 0.1, ..level }.normal();
    /// // The camera's y axis points down: a tilt about x turns the normal up in the image.
    /// assert!(tilted_x.x == 0.0 && (tilted_x.y + 0.1f64.sin()).abs() < 1e-12);
    /// assert!((tilted_y.x - 0.1f64.sin()).abs() < 1e-12 && tilted_y.y == 0.0);
    /// ```
    pub fn normal(&self) -> Vector3<f64> {
        let (sx, cx) = self.tilt_x_rad.sin_cos();
        let (sy, cy) = self.tilt_y_rad.sin_cos();
        Vector3::new(sy, -sx * cy, cx * cy)
    }

    /// Names and values of the parameters that can be calibrated.
    pub(super) fn parameters(&self) -> [(&'static str, f64); 4] {
        [
            ("interface_distance_mm", self.distance_mm),
            ("interface_tilt_x_rad", self.tilt_x_rad),
            ("interface_tilt_y_rad", self.tilt_y_rad),
            ("interface_index_outside", self.index_outside),
        ]
    }

    pub(super) fn with_parameters(&self, parameters: [f64; 4]) -> Self {
        let [distance_mm, tilt_x_rad, tilt_y_rad, index_outside] = parameters;
        Self { distance_mm, tilt_x_rad, tilt_y_rad, index_outside, ..*self }
    }

    /// Checks the limits of all values.
    pub(super) fn check(&self, rules: &mut ViolationCollector) {
        rules.above("interface_distance_mm", self.distance_mm, 0.0, 1000.0);
        rules.within("interface_tilt_x_rad", self.tilt_x_rad, -1.0, 1.0);
        rules.within("interface_tilt_y_rad", self.tilt_y_rad, -1.0, 1.0);
        check_indices(rules, self.index_inside, self.index_outside);
        rules.within("interface_glass_thickness_mm", self.glass_thickness_mm, 0.0, 1000.0);
        let glass = self.glass_thickness_mm == 0.0
            || (self.index_glass >= self.index_inside && self.index_glass <= 4.0);
        let limit = "must be at least the index on the lens's side and at most 4";
        rules.require(glass, "interface_index_glass", self.index_glass, limit);
    }
}

/// [`FlatInterface`] with its normal precomputed, and indices relative to the lens's side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlatRefraction {
    normal_in_camera: Vector3<f64>,
    normal_by_tilt: [Vector3<f64>; 2],
    distance_mm: f64,
    glass: Layer,
    gel_index: f64,
    index_inside: f64,
}

/// Plane-parallel layer that light crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Layer {
    thickness_mm: f64,
    /// Refractive index relative to the medium of the lens, at least 1.
    index: f64,
}

impl Layer {
    /// Computes the sideways shift of light in this layer, mm, and its derivative by `w`.
    ///
    /// `w` is the tangent of the angle to the normal on the lens's side. Both results are concave in `w`.
    fn shift(&self, w: f64) -> (f64, f64) {
        let squared = self.index * self.index;
        let root = (squared + (squared - 1.0) * w * w).sqrt();
        (self.thickness_mm * w / root, self.thickness_mm * squared / (root * root * root))
    }
}

/// Light path to a point, in the plane of the normal and the point.
struct LightPath {
    /// Tangent of the angle to the normal on the lens's side.
    w: f64,
    /// Derivative of the point's distance from the normal by `w`, mm.
    slope_mm: f64,
    /// Height of the point above the plane through the lens's centre, along the normal, mm.
    height_mm: f64,
    gel: Layer,
    /// Vector from the normal through the lens's centre to the point, mm.
    perpendicular: Vector3<f64>,
    /// Length of `perpendicular`, mm.
    radius_mm: f64,
}

impl FlatRefraction {
    /// Precomputes normal, derivatives and relative indices.
    pub(super) fn new(flat: &FlatInterface) -> Self {
        // Derivatives of `FlatInterface::normal` by both tilts.
        let (sx, cx) = flat.tilt_x_rad.sin_cos();
        let (sy, cy) = flat.tilt_y_rad.sin_cos();
        Self {
            normal_in_camera: flat.normal(),
            normal_by_tilt: [
                Vector3::new(0.0, -cx * cy, -sx * cy),
                Vector3::new(cy, sx * sy, -cx * sy),
            ],
            distance_mm: flat.distance_mm,
            // Index 1 instead of the given one, which has no meaning (it may even be 0) without a pane.
            glass: if flat.glass_thickness_mm > 0.0 {
                Layer {
                    thickness_mm: flat.glass_thickness_mm,
                    index: flat.index_glass / flat.index_inside,
                }
            } else {
                Layer { thickness_mm: 0.0, index: 1.0 }
            },
            gel_index: flat.index_outside / flat.index_inside,
            index_inside: flat.index_inside,
        }
    }

    /// Computes the light path to a point.
    ///
    /// The point's distance from the normal is the sum of the layers' shifts, which is increasing and concave in `w`.
    /// The paraxial solution is too small, so Newton's method, started there, climbs to the solution without
    /// overshooting it.
    fn find_path(&self, point: &Point3<f64>) -> Result<LightPath, OutsideDomain> {
        let height_mm = self.normal_in_camera.dot(&point.coords);
        let depth_mm = height_mm - self.distance_mm - self.glass.thickness_mm;
        if !depth_mm.is_finite() {
            return Err(OutsideDomain::NoDirection);
        }
        if depth_mm < -ON_INTERFACE_TOLERANCE_MM {
            return Err(OutsideDomain::BeforeInterface { depth_mm: -depth_mm });
        }
        let gel = Layer { thickness_mm: depth_mm.max(0.0), index: self.gel_index };
        // The path lies in the plane of the normal and the point: two coordinates are enough.
        let perpendicular = point.coords - self.normal_in_camera * height_mm;
        let radius_mm = perpendicular.norm();
        if !radius_mm.is_finite() {
            return Err(OutsideDomain::NoDirection);
        }
        let paraxial_mm = self.distance_mm
            + self.glass.thickness_mm / self.glass.index
            + gel.thickness_mm / gel.index;
        let mut w = radius_mm / paraxial_mm;
        let mut slope_mm = paraxial_mm;
        // Converges quadratically from the first step on; ten steps would do even at grazing angles.
        for _ in 0..50 {
            let (glass, glass_slope) = self.glass.shift(w);
            let (in_gel, gel_slope) = gel.shift(w);
            slope_mm = self.distance_mm + glass_slope + gel_slope;
            let step = (radius_mm - self.distance_mm * w - glass - in_gel) / slope_mm;
            w += step;
            if step <= 1e-9 * w {
                // The error that remains is of the order of the square of this step.
                break;
            }
        }
        Ok(LightPath { w, slope_mm, height_mm, gel, perpendicular, radius_mm })
    }

    pub(super) fn direction_towards(
        &self,
        point: &Point3<f64>,
    ) -> Result<Vector3<f64>, OutsideDomain> {
        let path = self.find_path(point)?;
        Ok(if path.radius_mm > 0.0 {
            self.normal_in_camera + path.perpendicular * (path.w / path.radius_mm)
        } else {
            self.normal_in_camera
        })
    }

    /// Computes [`FlatRefraction::direction_towards`] with derivatives by the point and by the parameters.
    pub(super) fn differentiate(
        &self,
        point: &Point3<f64>,
    ) -> Result<DirectionWithJacobians, OutsideDomain> {
        let path = self.find_path(point)?;
        let normal = self.normal_in_camera;
        let by_radius = 1.0 / path.slope_mm;
        // On the normal through the lens any azimuth will do, because both stretches are equal there.
        let (azimuth, around) = if path.radius_mm > 0.0 {
            (path.perpendicular / path.radius_mm, path.w / path.radius_mm)
        } else {
            (normal.cross(&least_axis(&normal)).normalize(), by_radius)
        };
        // Derivatives of `w` at a fixed point, from the condition that the shifts add up to its radius.
        let squared = self.gel_index * self.gel_index;
        let root = (squared + (squared - 1.0) * path.w * path.w).sqrt();
        // Moving the point deeper shifts it sideways by the tangent in the gel.
        let tangent_in_gel = path.w / root;
        let by_height = -tangent_in_gel * by_radius;
        let by_distance = (tangent_in_gel - path.w) * by_radius;
        let by_index = path.gel.thickness_mm * path.w * self.gel_index * (1.0 + path.w * path.w)
            / (root * root * root)
            * by_radius
            / self.index_inside;

        let outward = azimuth * azimuth.transpose();
        let by_perpendicular = (Matrix3::identity() - outward) * around + outward * by_radius;
        let by_point = by_perpendicular * (Matrix3::identity() - normal * normal.transpose())
            + azimuth * normal.transpose() * by_height;
        // Tilting the normal changes both the point's height above the plane and its distance from the normal.
        let by_tilt = self.normal_by_tilt.map(|turn| {
            let higher = turn.dot(&point.coords);
            let across = -(normal * higher + turn * path.height_mm);
            turn + by_perpendicular * across + azimuth * (by_height * higher)
        });
        let mut by_parameters = [Vector3::zeros(); MAX_INTERFACE_PARAMETERS];
        by_parameters[0] = azimuth * by_distance;
        by_parameters[1..3].copy_from_slice(&by_tilt);
        by_parameters[3] = azimuth * by_index;
        let direction = normal + path.perpendicular * around;
        Ok(DirectionWithJacobians { direction, by_point, by_parameters })
    }

    /// Computes the ray in the gel whose light reaches the lens from a unit direction.
    pub(super) fn refract_outward(
        &self,
        direction: &Vector3<f64>,
    ) -> Result<ViewRay, OutsideDomain> {
        let normal = self.normal_in_camera;
        let cosine = direction.dot(&normal);
        // At 1e-6 the passage is a million distances to the side, where rounding would dominate.
        if cosine < 1e-6 {
            return Err(OutsideDomain::MissesInterface { angle_rad: cosine.acos() });
        }
        let on_glass = direction * (self.distance_mm / cosine);
        let in_glass = refract(direction, &normal, 1.0 / self.glass.index);
        let on_gel = on_glass + in_glass * (self.glass.thickness_mm / in_glass.dot(&normal));
        Ok(ViewRay {
            origin_in_camera: Point3::from(on_gel),
            direction: refract(direction, &normal, 1.0 / self.gel_index),
        })
    }
}

/// Returns the coordinate axis that is least parallel to a vector.
fn least_axis(vector: &Vector3<f64>) -> Vector3<f64> {
    let mut axis = Vector3::zeros();
    axis[vector.iamin()] = 1.0;
    axis
}
