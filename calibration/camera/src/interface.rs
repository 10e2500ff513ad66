//! A refracting surface between the lens and the scene.

mod flat;
mod sphere;

use nalgebra::{Matrix3, Point3, Vector3};

pub use flat::Flat;
pub use sphere::Sphere;

use crate::error::{OutsideDomain, Rules};
use crate::view_ray::ViewRay;
use flat::FlatRefraction;
use sphere::SphereRefraction;

/// Most parameters that an interface has.
pub(crate) const MAX_INTERFACE_PARAMETERS: usize = 5;

/// A point this little in front of the interface counts as lying on it: it was computed there.
const ON_INTERFACE_MM: f64 = 1e-9;

/// What light passes on its way to the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interface {
    /// Nothing: lens and scene share one medium, or the lens was fitted to what it saw through all that there is.
    None,
    /// The lens is known by itself, and what it looks through from a drawing. Rays are those that leave the
    /// lens: whoever has the drawing follows them further.
    Drawn,
    /// A plane, or a plane-parallel pane of glass.
    Flat(Flat),
    /// A sphere around the lens.
    Sphere(Sphere),
}

impl Interface {
    /// How the interface is called in messages and files.
    pub fn kind_name(&self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Drawn => "drawn",
            Self::Flat(_) => "flat",
            Self::Sphere(_) => "sphere",
        }
    }

    /// Whether rays are bent again behind it, by bodies that are drawn: a camera's own rays are then those that leave its
    /// interface, and whoever has the drawing follows them further.
    pub fn is_drawn_behind(&self) -> bool {
        match self {
            Self::None | Self::Drawn => false,
            Self::Flat(flat) => flat.is_drawn_behind,
            Self::Sphere(sphere) => sphere.is_drawn_behind,
        }
    }

    /// Names with units and values of what can be calibrated.
    pub(crate) fn parameters(&self) -> ([(&'static str, f64); MAX_INTERFACE_PARAMETERS], usize) {
        let mut all = [("", 0.0); MAX_INTERFACE_PARAMETERS];
        let count = match self {
            Self::None | Self::Drawn => 0,
            Self::Flat(flat) => fill(&mut all, flat.parameters()),
            Self::Sphere(sphere) => fill(&mut all, sphere.parameters()),
        };
        (all, count)
    }

    /// The same interface with other numbers; `parameters` has as many as it has now.
    pub(crate) fn with_parameters(&self, parameters: &[f64]) -> Self {
        let value = |i: usize| parameters.get(i).copied().unwrap_or(f64::NAN);
        match self {
            Self::None | Self::Drawn => *self,
            Self::Flat(flat) => Self::Flat(flat.with_parameters(std::array::from_fn(value))),
            Self::Sphere(sphere) => {
                Self::Sphere(sphere.with_parameters(std::array::from_fn(value)))
            }
        }
    }

    pub(crate) fn check(&self, rules: &mut Rules) {
        match self {
            Self::None | Self::Drawn => {}
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

/// Both indices within what exists, and the scene's not below the lens's.
///
/// The lens looks out of the thinner medium, as a lens in air does. Then no ray is ever reflected
/// totally, and every point behind the interface is seen.
fn check_indices(rules: &mut Rules, index_inside: f64, index_outside: f64) {
    rules.within("interface_index_inside", index_inside, 1.0, 4.0);
    rules.require(
        index_outside >= index_inside && index_outside <= 4.0,
        "interface_index_outside",
        index_outside,
        format!("must be at least the index on the lens's side ({index_inside}) and at most 4"),
    );
}

/// An interface prepared for questions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Refraction {
    None,
    Flat(FlatRefraction),
    Sphere(SphereRefraction),
}

/// A direction in front of the lens with its derivatives.
pub(crate) struct Bent {
    /// Of any length.
    pub direction: Vector3<f64>,
    pub by_point: Matrix3<f64>,
    pub by_parameters: [Vector3<f64>; MAX_INTERFACE_PARAMETERS],
}

impl Refraction {
    pub(crate) fn new(interface: &Interface) -> Self {
        match interface {
            Interface::None | Interface::Drawn => Self::None,
            Interface::Flat(flat) => Self::Flat(FlatRefraction::new(flat)),
            Interface::Sphere(sphere) => Self::Sphere(SphereRefraction::new(sphere)),
        }
    }

    /// Direction, of any length, in which the lens sees a point.
    #[inline]
    pub(crate) fn towards(&self, point: &Point3<f64>) -> Result<Vector3<f64>, OutsideDomain> {
        match self {
            Self::None => Ok(point.coords),
            Self::Flat(flat) => flat.towards(point),
            Self::Sphere(sphere) => sphere.towards(point),
        }
    }

    pub(crate) fn differentiate(&self, point: &Point3<f64>) -> Result<Bent, OutsideDomain> {
        match self {
            Self::None => Ok(Bent {
                direction: point.coords,
                by_point: Matrix3::identity(),
                by_parameters: [Vector3::zeros(); MAX_INTERFACE_PARAMETERS],
            }),
            Self::Flat(flat) => flat.differentiate(point),
            Self::Sphere(sphere) => sphere.differentiate(point),
        }
    }

    /// The ray in the last medium that reaches the lens from unit `direction`.
    #[inline]
    pub(crate) fn outward(&self, direction: Vector3<f64>) -> Result<ViewRay, OutsideDomain> {
        match self {
            Self::None => Ok(ViewRay { origin_in_camera: Point3::origin(), direction }),
            Self::Flat(flat) => flat.outward(&direction),
            Self::Sphere(sphere) => Ok(sphere.outward(&direction)),
        }
    }
}

/// Snell's law for a unit `direction` that leaves through a surface with unit `normal`, both
/// pointing outward, from index `ratio * n` into index `n`.
fn refract(direction: &Vector3<f64>, normal: &Vector3<f64>, ratio: f64) -> Vector3<f64> {
    let along = (direction - normal * direction.dot(normal)) * ratio;
    along + normal * (1.0 - along.norm_squared()).max(0.0).sqrt()
}
