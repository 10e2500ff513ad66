//! Spherical interface around the lens.

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Point3, Vector3};

use super::{
    DirectionWithJacobians, MAX_INTERFACE_PARAMETERS, ON_INTERFACE_TOLERANCE_MM, check_indices,
    refract,
};
use crate::error::{OutsideDomain, ViolationCollector};
use crate::roots::find_increasing_root;
use crate::view_ray::ViewRay;

/// Dome around the lens: air inside, gel outside.
///
/// Light is refracted only if the lens is off the centre; a concentric dome refracts none. The lens must be inside the
/// sphere. Centre, radius and the outer index can be calibrated.
///
/// ```
/// use fabkit_camera::{Camera, Interface, Point2, Point3, SphericalInterface};
/// let concentric = SphericalInterface {
///     centre_in_camera: Point3::origin(),
///     radius_mm: 11.0,
///     index_inside: 1.0,
///     index_outside: 1.41,
///     has_drawn_bodies_behind: false,
/// };
/// let bare = Camera::equidistant(640, 480, 2.5)?;
/// let dome = Camera::new(640, 480, *bare.lens(), Interface::Sphere(concentric))?;
/// let [in_air, in_gel] = [bare, dome].map(|c| c.unproject(&Point2::new(600.0, 50.0)).unwrap());
/// assert!((in_air.direction - in_gel.direction).norm() < 1e-12);
/// assert!((in_gel.origin_in_camera.coords.norm() - 11.0).abs() < 1e-12);
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalInterface {
    /// Centre of the sphere in the camera frame, mm.
    pub centre_in_camera: Point3<f64>,
    /// Radius of the sphere, mm.
    pub radius_mm: f64,
    /// Refractive index on the lens's side; 1 for air.
    pub index_inside: f64,
    /// Refractive index outside; about 1.41 for silicone.
    pub index_outside: f64,
    /// True if drawn bodies outside refract rays again; see
    /// [`Interface::has_drawn_bodies_behind`](super::Interface::has_drawn_bodies_behind).
    pub has_drawn_bodies_behind: bool,
}

impl SphericalInterface {
    /// Names and values of the parameters that can be calibrated.
    pub(super) fn parameters(&self) -> [(&'static str, f64); 5] {
        [
            ("interface_centre_x_mm", self.centre_in_camera.x),
            ("interface_centre_y_mm", self.centre_in_camera.y),
            ("interface_centre_z_mm", self.centre_in_camera.z),
            ("interface_radius_mm", self.radius_mm),
            ("interface_index_outside", self.index_outside),
        ]
    }

    pub(super) fn with_parameters(&self, parameters: [f64; 5]) -> Self {
        let [x_mm, y_mm, z_mm, radius_mm, index_outside] = parameters;
        let centre_in_camera = Point3::new(x_mm, y_mm, z_mm);
        Self { centre_in_camera, radius_mm, index_outside, ..*self }
    }

    /// Checks the limits of all values.
    pub(super) fn check(&self, rules: &mut ViolationCollector) {
        rules.above("interface_radius_mm", self.radius_mm, 0.0, 1000.0);
        let off_centre_mm = self.centre_in_camera.coords.norm();
        rules.require(
            // Close to the sphere itself the refraction becomes singular.
            off_centre_mm < 0.99 * self.radius_mm,
            "distance between the lens and interface_centre",
            off_centre_mm,
            format!("the lens must be inside the sphere, below 0.99 x {} mm", self.radius_mm),
        );
        check_indices(rules, self.index_inside, self.index_outside);
    }
}

/// [`SphericalInterface`] with the quantities precomputed that refraction needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SphereRefraction {
    centre: Vector3<f64>,
    radius_mm: f64,
    /// Refractive index outside relative to that of the lens's medium; at least 1.
    index: f64,
    index_inside: f64,
    /// Distance from the lens to the sphere's centre, mm.
    off_centre_mm: f64,
}

impl SphereRefraction {
    /// Precomputes the relative index and the lens's distance from the centre.
    pub(super) fn new(sphere: &SphericalInterface) -> Self {
        let centre = sphere.centre_in_camera.coords;
        Self {
            centre,
            radius_mm: sphere.radius_mm,
            index: sphere.index_outside / sphere.index_inside,
            index_inside: sphere.index_inside,
            off_centre_mm: centre.norm(),
        }
    }

    /// Finds the point of the sphere through which light from `point` reaches the lens.
    ///
    /// Everything happens in the plane of lens, centre and point. As seen from the centre, light that leaves the lens
    /// turns through an angle. Where it passes the sphere at the angle `phi`, its distance from the centre `b = a R
    /// sin(phi) / |lens - passage|` gives the sines on both sides (`b / R` and `b / (n R)`). Outside it turns by
    /// `asin(b / (n R)) - asin(b / (n p))` more until it is `p` away from the centre. The total grows with `phi`, and
    /// `phi` lies between 0 and the whole angle to the point.
    pub(super) fn direction_towards(
        &self,
        point: &Point3<f64>,
    ) -> Result<Vector3<f64>, OutsideDomain> {
        let (a, radius, n) = (self.off_centre_mm, self.radius_mm, self.index);
        let from_centre = point.coords - self.centre;
        let far = from_centre.norm();
        if !far.is_finite() {
            return Err(OutsideDomain::NoDirection);
        }
        if far < radius - ON_INTERFACE_TOLERANCE_MM {
            return Err(OutsideDomain::BeforeInterface { depth_mm: radius - far });
        }
        // Within the tolerance a point may lie slightly inside.
        let far = far.max(radius);
        let straight = self.centre + from_centre * (radius / far);
        // A concentric sphere is crossed along its normal.
        if a == 0.0 {
            return Ok(straight);
        }
        let to_lens = self.centre / -a;
        let along = to_lens.dot(&from_centre);
        let across = from_centre - to_lens * along;
        let aside = across.norm();
        if aside == 0.0 {
            return Ok(straight);
        }
        // Angle at the centre between the lens and the point.
        let whole = aside.atan2(along);
        let excess = |phi: f64| {
            let (sin, cos) = phi.sin_cos();
            let squared = radius * radius + a * a - 2.0 * a * radius * cos;
            let reach = squared.sqrt();
            let b = a * radius * sin / reach;
            let b_by_phi = a * radius * cos / reach - b * (a * radius * sin) / squared;
            // Sines of the angles to the radius, where the ray enters the medium and at the point.
            let (near, beyond) = (b / (n * radius), b / (n * far));
            let turned_by_b = 1.0 / (n * radius * (1.0 - near * near).sqrt())
                - 1.0 / (n * far * (1.0 - beyond * beyond).sqrt());
            let turned = phi + (near.asin() - beyond.asin());
            (turned - whole, 1.0 + turned_by_b * b_by_phi)
        };
        let phi = find_increasing_root(excess, 0.0, whole, whole * (radius / far).min(1.0));
        let (sin, cos) = phi.sin_cos();
        Ok(self.centre + (to_lens * cos + across * (sin / aside)) * radius)
    }

    /// Differentiates the passage by the point and by the parameters, by Fermat's principle.
    ///
    /// The passage `x` makes the optical path `|x| + n |point - x|` stationary on the sphere: its gradient is `mu (x -
    /// c)`. The implicit function theorem, applied to this in the two directions of the tangent plane, is regular even
    /// where the plane of incidence is undefined (lens at the centre, point on the axis). All terms are multiplied by
    /// `|point - x|`, so that a point on the sphere is no special case.
    pub(super) fn differentiate(
        &self,
        point: &Point3<f64>,
    ) -> Result<DirectionWithJacobians, OutsideDomain> {
        let x = self.direction_towards(point)?;
        let (n, radius) = (self.index, self.radius_mm);
        let reach = x.norm();
        let before = x / reach;
        let normal = (x - self.centre) / radius;
        let after = refract(&before, &normal, 1.0 / n);
        let behind = (point.coords - x).norm();
        let identity = Matrix3::identity();

        let by_target = (identity - after * after.transpose()) * -n;
        let hessian = (identity - before * before.transpose()) * (behind / reach) - by_target;
        let mu = behind * (before - after * n).dot(&normal) / radius;
        let tangents = tangent_plane(&normal);
        let curved = tangents.transpose() * hessian * tangents - Matrix2::identity() * mu;
        // Not singular, because `phi` in `direction_towards` is a simple root.
        let solve = tangents
            * curved.try_inverse().ok_or(OutsideDomain::NoDirection)?
            * tangents.transpose();

        let by_centre = identity - solve * hessian;
        let by_radius = normal - solve * (hessian * normal);
        let by_index = solve * after * (behind / self.index_inside);
        let mut by_parameters = [Vector3::zeros(); MAX_INTERFACE_PARAMETERS];
        for (by, column) in by_parameters.iter_mut().zip(by_centre.column_iter()) {
            by.copy_from(&column);
        }
        by_parameters[3] = by_radius;
        by_parameters[4] = by_index;
        Ok(DirectionWithJacobians { direction: x, by_point: -solve * by_target, by_parameters })
    }

    /// Computes the ray outside the sphere whose light reaches the lens from a unit direction.
    pub(super) fn refract_outward(&self, direction: &Vector3<f64>) -> ViewRay {
        let b = direction.dot(&self.centre);
        let slack = self.radius_mm * self.radius_mm - self.off_centre_mm * self.off_centre_mm;
        // The lens is inside the sphere, so the root is real and the positive solution is the one ahead.
        let x = direction * (b + (b * b + slack).sqrt());
        let normal = (x - self.centre) / self.radius_mm;
        ViewRay {
            origin_in_camera: Point3::from(x),
            direction: refract(direction, &normal, 1.0 / self.index),
        }
    }
}

/// Computes two unit vectors perpendicular to a unit normal (Duff et al., "Building an Orthonormal Basis, Revisited",
/// JCGT 2017).
fn tangent_plane(n: &Vector3<f64>) -> Matrix3x2<f64> {
    let sign = 1.0f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    Matrix3x2::from_columns(&[
        Vector3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vector3::new(b, sign + n.y * n.y * a, -n.y),
    ])
}
