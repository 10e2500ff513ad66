//! Where lines need not be cast: what two bodies provably do not have in common.
//!
//! Rules that sample lines ask these first. An answer is a list of boxes; lines that pass none of
//! them would have found nothing.

use nalgebra::{Point3, Vector3};

use crate::compiled::{held_boxes, meeting_boxes};
use crate::{Aabb, CompiledSolid};

/// Boxes looked at for a pair of bodies; as many take as long as a few hundred lines.
const MEETING_BOXES: usize = 600;

/// Boxes looked at for a tool.
const HELD_BOXES: usize = 1_500;

/// Boxes outside of which two bodies have nothing in common but contact, thinner than 1e-9 mm; none
/// if they have nothing in common at all.
///
/// `None` where what their bounds have in common is unbounded.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Solid, proofs::meetings};
/// let ball = CompiledSolid::new(&Solid::sphere(5.0))?;
/// let socket = Solid::cuboid(12.0, 12.0, 6.0).minus(Solid::sphere(5.0));
/// assert!(meetings(&ball, &CompiledSolid::new(&socket)?).is_some_and(|boxes| boxes.is_empty()));
/// let tight = Solid::cuboid(12.0, 12.0, 6.0).minus(Solid::sphere(4.9));
/// assert!(meetings(&ball, &CompiledSolid::new(&tight)?).is_some_and(|boxes| !boxes.is_empty()));
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
pub fn meetings(a: &CompiledSolid, b: &CompiledSolid) -> Option<Vec<Aabb>> {
    let common = a.bounds().common(&b.bounds());
    if common.is_empty() {
        return Some(Vec::new());
    }
    common.is_finite().then(|| meeting_boxes(a, b, &common, MEETING_BOXES))
}

/// Boxes outside of whose shadows no line in a direction leaves a tool and meets one of the other
/// bodies further on; none if there is no such line.
///
/// `None` where the direction is along no axis of the frame, or a body is unbounded.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Solid, Vector3, proofs::obstacles};
/// let ball = CompiledSolid::new(&Solid::sphere(5.0))?;
/// let half = Solid::cuboid(12.0, 12.0, 6.0).minus(Solid::sphere(5.0));
/// let half = CompiledSolid::new(&half)?;
/// // Upwards it comes off; downwards the ball is in its way.
/// assert!(obstacles(&half, &[&ball], &Vector3::z()).is_some_and(|boxes| boxes.is_empty()));
/// assert!(obstacles(&half, &[&ball], &-Vector3::z()).is_some_and(|boxes| !boxes.is_empty()));
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
pub fn obstacles(
    tool: &CompiledSolid,
    others: &[&CompiledSolid],
    direction: &Vector3<f64>,
) -> Option<Vec<Aabb>> {
    let axis = direction.iamax();
    let is_along = (0..3).all(|i| (i == axis) != (direction[i] == 0.0));
    if !is_along {
        return None;
    }
    held_boxes(tool, others, axis, direction[axis] > 0.0, HELD_BOXES)
}

/// Which of many parallel lines may pass any of some boxes: a grid over their shadow, in which some
/// cells too many are set.
#[derive(Clone, Debug)]
pub struct Shadow {
    is_set: Vec<bool>,
}

impl Shadow {
    /// Cells along each side.
    const SIDE: usize = 128;

    /// The shadow of boxes on a rectangle around `centre`: along two unit vectors across the lines,
    /// as far as `half_mm` to either side.
    pub fn of(
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
            // A cell more on each side, so that rounding decides nothing.
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

    /// Whether the line at this place may pass a box; the rectangle's sides are from 0 to 1.
    pub fn holds(&self, shares: [f64; 2]) -> bool {
        let [i, j] = shares.map(|v| ((v * Self::SIDE as f64) as usize).min(Self::SIDE - 1));
        self.is_set[j * Self::SIDE + i]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shadow_holds_every_line_through_its_boxes() {
        let corner = |x, y, z| Point3::new(x, y, z);
        let boxes = [
            Aabb { min: corner(-3.0, 1.0, 2.0), max: corner(-2.9, 1.4, 2.2) },
            Aabb { min: corner(4.0, -4.0, -1.0), max: corner(4.5, -3.0, 0.0) },
        ];
        let direction = Vector3::new(0.1234, 0.0917, 1.0).normalize();
        let u = direction.cross(&Vector3::y()).normalize();
        let across = [u, direction.cross(&u)];
        let centre = corner(0.5, 0.0, 0.0);
        let shadow = Shadow::of(&boxes, &centre, &across, [7.0, 6.0]);
        let set = shadow.is_set.iter().filter(|&&set| set).count();
        assert!(set < 400, "{set}");
        for bounds in boxes {
            for k in 0..1000 {
                let [a, b, c] = [0.618, 0.414, 0.732].map(|g| (f64::from(k) * g).fract());
                let point =
                    bounds.min + (bounds.max - bounds.min).component_mul(&Vector3::new(a, b, c));
                let offset = point - centre;
                let share = |i: usize| 0.5 + 0.5 * offset.dot(&across[i]) / [7.0, 6.0][i];
                assert!(shadow.holds([share(0), share(1)]));
            }
        }
    }
}
