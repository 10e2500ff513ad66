//! Two half presses as one: left of the seam from one map, right of it from the other.

use fabkit_geometry::Vector3;

use super::reference::ReferenceSurface;

/// On which side of a plane through the sensor's axis each pixel sees the surface.
///
/// Halves that meet at a plane can be pressed, captured and cast separately: what one does is not
/// seen on the other's side. Near the plane the gel does not know which half it belongs to, so a
/// margin is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seam {
    sides: Vec<Side>,
}

/// A pixel's place relative to the seam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// On the side that the seam's normal points away from.
    Left,
    /// On the side that the seam's normal points to.
    Right,
    /// Within the margin, or no surface at all.
    Neither,
}

impl Seam {
    /// The plane through z whose normal, from left to right, is `left_to_right` (sensor frame).
    ///
    /// A pixel belongs to a side if the *unpressed* surface it sees lies further than `margin_mm`
    /// from the plane.
    pub fn new(surface: &ReferenceSurface, left_to_right: Vector3<f64>, margin_mm: f64) -> Self {
        let normal = left_to_right.normalize();
        let side = |signed_mm: f64| {
            if signed_mm > margin_mm {
                Side::Right
            } else if signed_mm < -margin_mm {
                Side::Left
            } else {
                Side::Neither
            }
        };
        let points = surface.untouched();
        let sides = points.point_in_sensor().map(|point| side(point.coords.dot(&normal))).collect();
        Self { sides }
    }

    /// The side of each pixel.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// A map or a picture composed of two, value by value; `neither` fills the margin.
    ///
    /// # Panics
    /// If the two are not as long as the seam has pixels.
    pub fn stitch<T: Copy>(&self, left: &[T], right: &[T], neither: T) -> Vec<T> {
        assert_eq!((left.len(), right.len()), (self.sides.len(), self.sides.len()));
        let pick = |((side, &left), &right): ((&Side, &T), &T)| match side {
            Side::Left => left,
            Side::Right => right,
            Side::Neither => neither,
        };
        self.sides.iter().zip(left).zip(right).map(pick).collect()
    }
}
