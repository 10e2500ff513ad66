//! Refracting surfaces between the lens and the scene.

mod flat;
mod sphere;

use nalgebra::{Matrix3, Point3, Vector3};

pub use flat::FlatInterface;
pub use sphere::SphericalInterface;

use crate::error::{OutsideDomain, ViolationCollector};
use crate::view_ray::ViewRay;
use flat::FlatRefraction;
use sphere::SphereRefraction;

/// Largest number of parameters of an interface.
pub(crate) const MAX_INTERFACE_PARAMETERS: usize = 5;

/// Tolerance, mm: a point this little in front of the interface counts as lying on it, because it was computed as a
/// point of it.
const ON_INTERFACE_TOLERANCE_MM: f64 = 1e-9;

/// Refracting surface between the lens and the scene.
///
/// ```
/// use fabkit_camera::{Camera, FlatInterface, Interface, OutsideDomain, Point3};
/// let in_air = Camera::equidistant(640, 480, 2.5)?;
/// let gel = Interface::Flat(FlatInterface::bare_in_air(5.0, 1.41));
/// let camera = Camera::new(640, 480, *in_air.lens(), gel)?;
/// // Gel lifts what is in it, as water does: a point is seen farther from the axis than in air.
/// let in_gel = Point3::new(4.0, 0.0, 10.0);
/// assert!(camera.project(&in_gel)?.x > in_air.project(&in_gel)?.x + 10.0);
/// // Points are points behind the interface; there are none 4 mm ahead.
/// let before = camera.project(&Point3::new(0.0, 0.0, 4.0)).unwrap_err();
/// assert_eq!(before, OutsideDomain::BeforeInterface { depth_mm: 1.0 });
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interface {
    /// No surface: lens and scene share one medium, or the lens was calibrated through all media in front of it.
    None,
    /// The lens is calibrated alone, and a drawing describes the media in front of it. Rays are those that leave the
    /// lens; the owner of the drawing traces them further.
    FromDrawing,
    /// Plane, or plane-parallel pane of glass.
    Flat(FlatInterface),
    /// Sphere around the lens.
    Sphere(SphericalInterface),
}

impl Interface {
    /// Name of the interface's kind in messages and files.
    pub fn kind_name(&self) -> &'static str {
        match self {
            Self::None => "none",
            Self::FromDrawing => "drawn",
            Self::Flat(_) => "flat",
            Self::Sphere(_) => "sphere",
        }
    }

    /// Returns whether drawn bodies behind the interface refract rays again. The camera's rays are then those that
    /// leave its interface; the owner of the drawing traces them further.
    pub fn has_drawn_bodies_behind(&self) -> bool {
        match self {
            Self::None | Self::FromDrawing => false,
            Self::Flat(flat) => flat.has_drawn_bodies_behind,
            Self::Sphere(sphere) => sphere.has_drawn_bodies_behind,
        }
    }

    /// Returns names with units and values of the parameters that can be calibrated, and their number.
    pub(crate) fn parameters(&self) -> ([(&'static str, f64); MAX_INTERFACE_PARAMETERS], usize) {
        let mut all = [("", 0.0); MAX_INTERFACE_PARAMETERS];
        let count = match self {
            Self::None | Self::FromDrawing => 0,
            Self::Flat(flat) => fill(&mut all, flat.parameters()),
            Self::Sphere(sphere) => fill(&mut all, sphere.parameters()),
        };
        (all, count)
    }

    /// Returns the same interface with other parameter values; `parameters` has as many as [`Interface::parameters`].
    pub(crate) fn with_parameters(&self, parameters: &[f64]) -> Self {
        // Missing values become NaN, which `check` refuses.
        let value = |i: usize| parameters.get(i).copied().unwrap_or(f64::NAN);
        match self {
            Self::None | Self::FromDrawing => *self,
            Self::Flat(flat) => Self::Flat(flat.with_parameters(std::array::from_fn(value))),
            Self::Sphere(sphere) => {
                Self::Sphere(sphere.with_parameters(std::array::from_fn(value)))
            }
        }
    }

    pub(crate) fn check(&self, rules: &mut ViolationCollector) {
        match self {
            Self::None | Self::FromDrawing => {}
            Self::Flat(flat) => flat.check(rules),
            Self::Sphere(sphere) => sphere.check(rules),
        }
    }
}

fn fill<const N: usize>(
    all: &mut [(&'static str, f64); MAX_INTERFACE_PARAMETERS],
    parameters: [(&'static str, f64); N],
) -> usize {
    all[..N].copy_from_slice(&parameters);
    N
}

/// Checks that both refractive indices are 1 to 4, and that the scene's is not below the lens's.
///
/// The lens is in the optically thinner medium, as a lens in air is. Then no ray is totally reflected, and every point
/// behind the interface is visible.
fn check_indices(rules: &mut ViolationCollector, index_inside: f64, index_outside: f64) {
    rules.within("interface_index_inside", index_inside, 1.0, 4.0);
    rules.require(
        index_outside >= index_inside && index_outside <= 4.0,
        "interface_index_outside",
        index_outside,
        format!("must be at least the index on the lens's side ({index_inside}) and at most 4"),
    );
}

/// Interface with the quantities precomputed that refraction needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Refraction {
    None,
    Flat(FlatRefraction),
    Sphere(SphereRefraction),
}

/// Direction in front of the lens, with its derivatives by the point and by the interface's parameters.
pub(crate) struct DirectionWithJacobians {
    /// Direction, of any length.
    pub direction: Vector3<f64>,
    pub by_point: Matrix3<f64>,
    pub by_parameters: [Vector3<f64>; MAX_INTERFACE_PARAMETERS],
}

impl Refraction {
    pub(crate) fn new(interface: &Interface) -> Self {
        match interface {
            Interface::None | Interface::FromDrawing => Self::None,
            Interface::Flat(flat) => Self::Flat(FlatRefraction::new(flat)),
            Interface::Sphere(sphere) => Self::Sphere(SphereRefraction::new(sphere)),
        }
    }

    /// Computes the direction, of any length, from the lens towards the image of a point behind the interface.
    #[inline]
    pub(crate) fn direction_towards(
        &self,
        point: &Point3<f64>,
    ) -> Result<Vector3<f64>, OutsideDomain> {
        match self {
            Self::None => Ok(point.coords),
            Self::Flat(flat) => flat.direction_towards(point),
            Self::Sphere(sphere) => sphere.direction_towards(point),
        }
    }

    /// Computes [`Refraction::direction_towards`] with derivatives by the point and by the interface's parameters.
    pub(crate) fn differentiate(
        &self,
        point: &Point3<f64>,
    ) -> Result<DirectionWithJacobians, OutsideDomain> {
        match self {
            Self::None => Ok(DirectionWithJacobians {
                direction: point.coords,
                by_point: Matrix3::identity(),
                by_parameters: [Vector3::zeros(); MAX_INTERFACE_PARAMETERS],
            }),
            Self::Flat(flat) => flat.differentiate(point),
            Self::Sphere(sphere) => sphere.differentiate(point),
        }
    }

    /// Computes the ray, in the last medium, whose light reaches the lens from the unit `direction`.
    #[inline]
    pub(crate) fn refract_outward(
        &self,
        direction: Vector3<f64>,
    ) -> Result<ViewRay, OutsideDomain> {
        match self {
            Self::None => Ok(ViewRay { origin_in_camera: Point3::origin(), direction }),
            Self::Flat(flat) => flat.refract_outward(&direction),
            Self::Sphere(sphere) => Ok(sphere.refract_outward(&direction)),
        }
    }
}

/// Refracts a unit `direction` by Snell's law at a surface with unit `normal`. Both point outward; `ratio` is the index
/// before the surface over the index behind it.
fn refract(direction: &Vector3<f64>, normal: &Vector3<f64>, ratio: f64) -> Vector3<f64> {
    let along = (direction - normal * direction.dot(normal)) * ratio;
    // Rounding may push the argument slightly below zero; total reflection does not occur (see `check_indices`).
    along + normal * (1.0 - along.norm_squared()).max(0.0).sqrt()
}
