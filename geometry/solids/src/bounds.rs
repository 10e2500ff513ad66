//! Axis-aligned bounding boxes.

use nalgebra::Point3;

/// Axis-aligned box, mm. Infinite where a solid is unbounded.
///
/// ```
/// use fabkit_geometry::{Aabb, Point3};
/// let lid = Aabb { min: Point3::new(0.0, 0.0, 5.0), max: Point3::new(4.0, 4.0, 6.0) };
/// let base = Aabb { min: Point3::origin(), max: Point3::new(4.0, 4.0, 2.0) };
/// assert_eq!(lid.hull(&base).size_mm(), [4.0, 4.0, 6.0]);
/// assert!(lid.common(&base).is_empty()); // 3 mm of air between them
/// assert_eq!(Aabb::nothing().hull(&lid), lid);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner, mm.
    pub min: Point3<f64>,
    /// Largest corner, mm.
    pub max: Point3<f64>,
}

impl Aabb {
    /// Returns the box that contains all of space.
    pub fn everything() -> Self {
        let inf = f64::INFINITY;
        Self { min: Point3::new(-inf, -inf, -inf), max: Point3::new(inf, inf, inf) }
    }

    /// Returns the empty box, the neutral element of [`Aabb::hull`].
    pub fn nothing() -> Self {
        let Self { min, max } = Self::everything();
        Self { min: max, max: min }
    }

    /// Returns the smallest box that contains both boxes.
    #[must_use]
    pub fn hull(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// Returns the intersection of both boxes; empty if they are apart.
    #[must_use]
    pub fn common(&self, other: &Self) -> Self {
        Self { min: self.min.sup(&other.min), max: self.max.inf(&other.max) }
    }

    /// Returns whether the box contains no point.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|i| self.min[i] > self.max[i])
    }

    /// Returns whether all six bounds are finite.
    pub fn is_finite(&self) -> bool {
        self.min.iter().chain(self.max.iter()).all(|v| v.is_finite())
    }

    /// Returns the box enlarged by `margin_mm` on every side.
    #[must_use]
    pub fn grown(&self, margin_mm: f64) -> Self {
        Self { min: self.min.map(|v| v - margin_mm), max: self.max.map(|v| v + margin_mm) }
    }

    /// Returns the centre of the box, mm.
    pub fn centre(&self) -> Point3<f64> {
        nalgebra::center(&self.min, &self.max)
    }

    /// Returns the edge lengths, mm.
    pub fn size_mm(&self) -> [f64; 3] {
        (self.max - self.min).into()
    }

    /// Returns whether the point lies in the closed box.
    pub fn contains(&self, point: &Point3<f64>) -> bool {
        (0..3).all(|i| self.min[i] <= point[i] && point[i] <= self.max[i])
    }
}
