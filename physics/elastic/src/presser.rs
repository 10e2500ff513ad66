//! Rigid bodies that press.

use std::cell::RefCell;

use fabkit_geometry::{CompiledSolid, Point3, Pose, Ray, Scratch, Vector3};

use crate::ElasticError;

/// A rigid body, seen from a surface that it presses on.
pub trait Presser {
    /// How far from a place, along a unit vector out of the soft body, the presser begins, mm.
    ///
    /// Negative where the place lies inside the presser, by how far the presser reaches below it, and
    /// infinite where the line misses the presser. What lies more than `reach_mm` below the place is another
    /// part of the presser on the other side of the body, and does not count; but a stretch that begins there
    /// and reaches above does. All in the soft body's frame.
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64;
}

impl<F: Fn(&Point3<f64>, &Vector3<f64>, f64) -> f64> Presser for F {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        self(place, outward, reach_mm)
    }
}

/// The begin of the first stretch that is not wholly deeper than what may be pressed.
fn first_begin(stretches: impl IntoIterator<Item = [f64; 2]>, reach_mm: f64) -> f64 {
    let first = stretches.into_iter().find(|[_, end]| *end > -reach_mm);
    first.map_or(f64::INFINITY, |[begin, _]| begin)
}

/// A ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    centre_mm: Point3<f64>,
    radius_mm: f64,
}

impl Ball {
    /// From its centre in the soft body's frame and its radius, mm.
    ///
    /// # Errors
    /// A radius that is not positive, a centre that is not finite.
    pub fn new(centre_mm: Point3<f64>, radius_mm: f64) -> Result<Self, ElasticError> {
        let hint = "positive and finite, in mm";
        if !(radius_mm > 0.0 && radius_mm.is_finite()) {
            return Err(ElasticError::Press { what: "a radius", value: radius_mm, hint });
        }
        match centre_mm.iter().find(|value| !value.is_finite()) {
            Some(&value) => Err(ElasticError::Press { what: "a centre", value, hint }),
            None => Ok(Self { centre_mm, radius_mm }),
        }
    }
}

impl Presser for Ball {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        let to_centre = self.centre_mm - place;
        let along = to_centre.dot(outward);
        let off_squared = (to_centre - along * outward).norm_squared();
        let half_squared = self.radius_mm.powi(2) - off_squared;
        if half_squared <= 0.0 {
            return f64::INFINITY;
        }
        let half = half_squared.sqrt();
        first_begin([[along - half, along + half]], reach_mm)
    }
}

/// Any exact solid in its place; one for each thread that presses.
#[derive(Debug)]
pub struct SolidPresser<'a> {
    solid: &'a CompiledSolid,
    presser_from_body: Pose,
    work: RefCell<(Scratch, Vec<[f64; 2]>)>,
}

impl<'a> SolidPresser<'a> {
    /// From a solid and the pose that maps its frame to the soft body's.
    pub fn new(solid: &'a CompiledSolid, body_from_presser: &Pose) -> Self {
        Self { solid, presser_from_body: body_from_presser.inverse(), work: RefCell::default() }
    }
}

impl Presser for SolidPresser<'_> {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        let ray = Ray {
            origin: self.presser_from_body.point(*place),
            direction: self.presser_from_body.vector(*outward),
        };
        let (scratch, stretches) = &mut *self.work.borrow_mut();
        self.solid.stretches_into(&ray, scratch, stretches);
        first_begin(stretches.iter().copied(), reach_mm)
    }
}

/// Several bodies at once: what is met first counts.
impl<P: Presser> Presser for [P] {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        let gaps = self.iter().map(|body| body.gap_mm(place, outward, reach_mm));
        gaps.fold(f64::INFINITY, f64::min)
    }
}

impl<P: Presser> Presser for Vec<P> {
    fn gap_mm(&self, place: &Point3<f64>, outward: &Vector3<f64>, reach_mm: f64) -> f64 {
        self.as_slice().gap_mm(place, outward, reach_mm)
    }
}

/// How a presser moves: from where it stands until it touches, and on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    pub(crate) way: Option<(Vector3<f64>, f64)>,
    pub(crate) friction: f64,
    pub(crate) shear_mm: Vector3<f64>,
    pub(crate) shear_steps: usize,
}

impl Press {
    /// The presser is where it shall be.
    pub fn in_place() -> Self {
        Self { way: None, friction: 0.0, shear_mm: Vector3::zeros(), shear_steps: 1 }
    }

    /// The presser moves along a direction, in the soft body's frame, until it touches the surface at rest,
    /// and then `depth_mm` further.
    ///
    /// # Errors
    /// A depth that is not positive, a direction of no length.
    pub fn along(direction: Vector3<f64>, depth_mm: f64) -> Result<Self, ElasticError> {
        if !(depth_mm > 0.0 && depth_mm.is_finite()) {
            let hint = "positive and finite, in mm";
            return Err(ElasticError::Press { what: "a depth", value: depth_mm, hint });
        }
        let length = direction.norm();
        if !(length > 0.0 && length.is_finite()) {
            let hint = "the length of a direction: it must be positive and finite";
            return Err(ElasticError::Press { what: "a length", value: length, hint });
        }
        Ok(Self { way: Some((direction / length, depth_mm)), ..Self::in_place() })
    }

    /// The presser then moves on by `way_mm`, in the soft body's frame, in `steps` equal steps, and holds the
    /// surface by Coulomb's friction. Steps tell what has slipped from what sticks: a way that does not turn
    /// back needs few.
    ///
    /// # Errors
    /// A friction that is negative or not finite, a way that is not finite, no steps.
    pub fn sheared(
        self,
        friction: f64,
        way_mm: Vector3<f64>,
        steps: usize,
    ) -> Result<Self, ElasticError> {
        if !(friction >= 0.0 && friction.is_finite()) {
            let hint = "at least 0, and finite; silicone on what is printed has 0.5 to 1.5";
            return Err(ElasticError::Press { what: "a friction", value: friction, hint });
        }
        if let Some(&value) = way_mm.iter().find(|value| !value.is_finite()) {
            return Err(ElasticError::Press { what: "a shear", value, hint: "finite, in mm" });
        }
        if steps == 0 {
            let hint = "at least 1";
            return Err(ElasticError::Press { what: "a number of steps", value: 0.0, hint });
        }
        Ok(Self { friction, shear_mm: way_mm, shear_steps: steps, ..self })
    }
}
