//! A solid prepared for questions.

use nalgebra::{Point3, Vector3};

use crate::{Aabb, InvalidSolid, Solid};

/// A line with a direction; `t` is measured in lengths of `direction`, backwards too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Point at t = 0, mm.
    pub origin: Point3<f64>,
    /// Need not be of unit length; must not be zero.
    pub direction: Vector3<f64>,
}

/// Where a line passes through a solid's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Position on the ray, in lengths of its direction.
    pub t: f64,
    /// Unit normal, out of the solid.
    pub normal: Vector3<f64>,
    /// Whose surface: an index into [`Solid::leaves`].
    pub leaf: u32,
    /// Which face of that primitive, numbered as the primitive documents.
    pub face: u32,
    /// Into the solid; out of it otherwise.
    pub entering: bool,
}

/// A validated [`Solid`], flattened for bounds, containment and ray crossings.
#[derive(Clone, Debug)]
pub struct Body {}

impl Body {
    /// Prepares a solid.
    ///
    /// # Errors
    /// Whatever [`Solid::validate`] finds.
    pub fn new(_solid: &Solid) -> Result<Self, InvalidSolid> {
        todo!()
    }

    /// A box around the solid: exact for primitives and unions; for intersections and differences
    /// it encloses, and may be larger.
    pub fn bounds(&self) -> Aabb {
        todo!()
    }

    /// Whether the point lies inside. On the surface itself the answer may be either.
    pub fn contains(&self, _point: &Point3<f64>) -> bool {
        todo!()
    }

    /// All crossings along the whole line, in order, entering and leaving in turn. A line that
    /// starts inside an unbounded solid has its first crossing at minus infinity.
    pub fn crossings(&self, _ray: &Ray) -> Vec<Crossing> {
        todo!()
    }
}
