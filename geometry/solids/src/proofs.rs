//! Proofs that two bodies do not meet, which save casting lines.
//!
//! Rules that sample lines call these functions first. A result is a list of boxes; lines that pass none of them would
//! have found nothing.

use nalgebra::{Point3, Vector3};

use crate::compiled::{subdivide_for_obstacles, subdivide_for_overlap};
use crate::{Aabb, CompiledSolid};

/// Number of boxes examined for a pair of bodies; this takes as long as casting a few hundred lines.
const OVERLAP_BOX_BUDGET: usize = 600;

/// Number of boxes examined for a tool.
const OBSTACLE_BOX_BUDGET: usize = 1_500;

/// Returns boxes outside of which two bodies are proven to share nothing but contact thinner than 1e-9 mm; none if they
/// share nothing at all.
///
/// Returns `None` if the intersection of their bounds is unbounded.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Solid, proofs::find_overlap_boxes};
/// let ball = CompiledSolid::new(&Solid::sphere(5.0))?;
/// let socket = Solid::cuboid(12.0, 12.0, 6.0).minus(Solid::sphere(5.0));
/// assert!(find_overlap_boxes(&ball, &CompiledSolid::new(&socket)?).is_some_and(|boxes| boxes.is_empty()));
/// let tight = Solid::cuboid(12.0, 12.0, 6.0).minus(Solid::sphere(4.9));
/// assert!(find_overlap_boxes(&ball, &CompiledSolid::new(&tight)?).is_some_and(|boxes| !boxes.is_empty()));
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
pub fn find_overlap_boxes(a: &CompiledSolid, b: &CompiledSolid) -> Option<Vec<Aabb>> {
    let common = a.bounds().common(&b.bounds());
    if common.is_empty() {
        return Some(Vec::new());
    }
    common.is_finite().then(|| subdivide_for_overlap(a, b, &common, OVERLAP_BOX_BUDGET))
}

/// Returns boxes such that a line in the direction that leaves the tool and then meets one of the other bodies passes
/// through one of them; none if there is no such line.
///
/// Returns `None` if the direction is not along an axis of the frame, or if a body is unbounded.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Solid, Vector3, proofs::find_obstacle_boxes};
/// let ball = CompiledSolid::new(&Solid::sphere(5.0))?;
/// let half = Solid::cuboid(12.0, 12.0, 6.0).minus(Solid::sphere(5.0));
/// let half = CompiledSolid::new(&half)?;
/// // Upwards it comes off; downwards the ball is in its way.
/// assert!(find_obstacle_boxes(&half, &[&ball], &Vector3::z()).is_some_and(|boxes| boxes.is_empty()));
/// assert!(find_obstacle_boxes(&half, &[&ball], &-Vector3::z()).is_some_and(|boxes| !boxes.is_empty()));
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
pub fn find_obstacle_boxes(
    tool: &CompiledSolid,
    others: &[&CompiledSolid],
    direction: &Vector3<f64>,
) -> Option<Vec<Aabb>> {
    let axis = direction.iamax();
    let is_along = (0..3).all(|i| (i == axis) != (direction[i] == 0.0));
    if !is_along {
        return None;
    }
    subdivide_for_obstacles(tool, others, axis, direction[axis] > 0.0, OBSTACLE_BOX_BUDGET)
}

/// Conservative raster of the projection of boxes along a direction: tells which of many parallel lines may pass one of
/// the boxes. Some surplus cells are set.
///
/// ```
/// use fabkit_geometry::{Aabb, Point3, Vector3, proofs::ProjectionRaster};
/// // A box of 2 mm in the middle of a square of 20 mm, for lines along z.
/// let small = Aabb { min: Point3::new(-1.0, -1.0, 0.0), max: Point3::new(1.0, 1.0, 3.0) };
/// let across = [Vector3::x(), Vector3::y()];
/// let raster = ProjectionRaster::from_boxes(&[small], &Point3::origin(), &across, [10.0, 10.0]);
/// assert!(raster.may_meet_box([0.5, 0.5])); // through the middle
/// assert!(!raster.may_meet_box([0.7, 0.5])); // at x = 4 mm
/// ```
#[derive(Clone, Debug)]
pub struct ProjectionRaster {
    is_set: Vec<bool>,
}

impl ProjectionRaster {
    /// Number of cells along each side.
    const SIDE: usize = 128;

    /// Rasterises boxes on a rectangle around `centre` that extends along two unit vectors across the lines by
    /// `half_mm` to either side.
    pub fn from_boxes(
        boxes: &[Aabb],
        centre: &Point3<f64>,
        across: &[Vector3<f64>; 2],
        half_mm: [f64; 2],
    ) -> Self {
        let mut is_set = vec![false; Self::SIDE * Self::SIDE];
        let range = |bounds: &Aabb, axis: usize| {
            let offset = (bounds.centre() - centre).dot(&across[axis]);
            let reach = 0.5 * across[axis].abs().dot(&(bounds.max - bounds.min));
            let cell = |v: f64| {
                let share = 0.5 + 0.5 * v / half_mm[axis];
                share * Self::SIDE as f64
            };
            let clamped = |v: f64| v.clamp(0.0, Self::SIDE as f64 - 1.0) as usize;
            // One surplus cell on each side makes rounding irrelevant.
            clamped(cell(offset - reach) - 1.0)..=clamped(cell(offset + reach) + 1.0)
        };
        for bounds in boxes {
            for j in range(bounds, 1) {
                for i in range(bounds, 0) {
                    is_set[j * Self::SIDE + i] = true;
                }
            }
        }
        Self { is_set }
    }

    /// Returns whether the line at this position may pass a box; positions are fractions of the rectangle's sides, from
    /// 0 to 1.
    pub fn may_meet_box(&self, shares: [f64; 2]) -> bool {
        let [i, j] = shares.map(|v| ((v * Self::SIDE as f64) as usize).min(Self::SIDE - 1));
        self.is_set[j * Self::SIDE + i]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_raster_includes_every_line_through_its_boxes() {
        let corner = |x, y, z| Point3::new(x, y, z);
        let boxes = [
            Aabb { min: corner(-3.0, 1.0, 2.0), max: corner(-2.9, 1.4, 2.2) },
            Aabb { min: corner(4.0, -4.0, -1.0), max: corner(4.5, -3.0, 0.0) },
        ];
        let direction = Vector3::new(0.1234, 0.0917, 1.0).normalize();
        let u = direction.cross(&Vector3::y()).normalize();
        let across = [u, direction.cross(&u)];
        let centre = corner(0.5, 0.0, 0.0);
        let shadow = ProjectionRaster::from_boxes(&boxes, &centre, &across, [7.0, 6.0]);
        let set = shadow.is_set.iter().filter(|&&set| set).count();
        assert!(set < 400, "{set}");
        for bounds in boxes {
            for k in 0..1000 {
                let [a, b, c] = [0.618, 0.414, 0.732].map(|g| (f64::from(k) * g).fract());
                let point =
                    bounds.min + (bounds.max - bounds.min).component_mul(&Vector3::new(a, b, c));
                let offset = point - centre;
                let share = |i: usize| 0.5 + 0.5 * offset.dot(&across[i]) / [7.0, 6.0][i];
                assert!(shadow.may_meet_box([share(0), share(1)]));
            }
        }
    }
}
