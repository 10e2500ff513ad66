//! Upright prisms with rounded edges around the axis: housings and pads of flat sensors.

use fabkit_geometry::{Angle, Path, Pose, Solid};

use super::edge;

/// Upright prism around the axis, by half its edges and the radius of its upright edges, mm.
///
/// ```
/// use fabkit_designs::blocks::Rect;
/// let pad = Rect { half: [10.0, 8.0], corner: 2.0 };
/// // A wall of 1.5 mm leaves an outline inside it at that distance.
/// let inside = pad.shrunk(1.5);
/// assert_eq!((inside.half, inside.corner), ([8.5, 6.5], 0.5));
/// assert!((pad.inset_of(inside) - 1.5).abs() < 1e-12);
/// assert_eq!((pad.longer(), pad.narrow(), pad.straight(1)), (0, 8.0, 16.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Half the edges along x and y.
    pub half: [f64; 2],
    /// Radius of the upright edges.
    pub corner: f64,
}

/// Smallest radius of an edge inside a part, mm: that of a nozzle.
const LEAST_CORNER_MM: f64 = 0.5;

impl Rect {
    /// Returns a circle of a radius around the axis, mm.
    pub fn round(radius_mm: f64) -> Self {
        Self { half: [radius_mm; 2], corner: radius_mm }
    }

    /// Returns the outline seen along z.
    pub fn path(self) -> Path {
        Path::rectangle([0.0; 2], self.half.map(|half| 2.0 * half), self.corner)
    }

    /// Returns the prism between two heights.
    pub fn prism(self, heights: [f64; 2]) -> Solid {
        Solid::prism(self.path(), heights)
    }

    /// Returns the prism with its upper rim rounded by a radius (mm) of at most that of the upright edges.
    pub fn rimmed(self, [bottom, top]: [f64; 2], fillet_mm: f64) -> Solid {
        if fillet_mm == 0.0 {
            return self.prism([bottom, top]);
        }
        // Posts in the corners and slabs between them: each has flat faces and rounded edges in one outline, so that
        // they continue each other smoothly.
        let [x, y] = self.half.map(|half| half - self.corner);
        let quarter = Angle::from_deg(90.0).expect("finite");
        let across = |half: f64| {
            edge::rounded(&[
                ([-half, bottom], 0.0),
                ([half, bottom], 0.0),
                ([half, top], fillet_mm),
                ([-half, top], fillet_mm),
            ])
        };
        let upright = Pose::rotation_x(quarter);
        let slabs = [
            Solid::prism(across(self.half[0]), [-y, y]).placed(upright),
            Solid::prism(across(self.half[1]), [-x, x])
                .placed(Pose::rotation_z(quarter).then_in(upright)),
        ];
        let post = Solid::revolution(edge::rounded(&[
            ([0.0, bottom], 0.0),
            ([self.corner, bottom], 0.0),
            ([self.corner, top], fillet_mm),
            ([0.0, top], 0.0),
        ]));
        let posts = super::corners([x, y]).map(|[x, y]| post.clone().at(x, y, 0.0));
        Solid::union(slabs.into_iter().chain(posts))
    }

    /// Returns the distance of another outline around the axis inside this one, mm; negative if it protrudes.
    pub fn inset_of(self, inner: Self) -> f64 {
        let beside = [0, 1].map(|i| self.half[i] - inner.half[i]);
        // Corners matter only if the centre of the inner arc lies farther out than that of this outline.
        let off = [0, 1].map(|i| self.corner - inner.corner - beside[i]);
        let at_corner = if off[0] > 0.0 && off[1] > 0.0 {
            self.corner - inner.corner - off[0].hypot(off[1])
        } else {
            f64::INFINITY
        };
        beside[0].min(beside[1]).min(at_corner)
    }

    /// Returns the outline offset inwards on all sides; edges stay parallel as far as the smallest radius allows.
    #[must_use]
    pub fn shrunk(self, by_mm: f64) -> Self {
        let corner = (self.corner - by_mm).max(LEAST_CORNER_MM);
        Self { half: self.half.map(|half| half - by_mm), corner }
    }

    /// Returns half the shorter edge.
    pub fn narrow(self) -> f64 {
        self.half[0].min(self.half[1])
    }

    /// Returns the axis along which it is longer: 0 for x, 1 for y.
    pub fn longer(self) -> usize {
        usize::from(self.half[1] > self.half[0])
    }

    /// Returns the length of the straight part of the walls that face along an axis.
    pub fn straight(self, axis: usize) -> f64 {
        2.0 * (self.half[1 - axis] - self.corner)
    }

    /// Returns whether a point lies inside, at least `apart_mm` from the boundary.
    ///
    /// ```
    /// use fabkit_designs::blocks::Rect;
    /// let disc = Rect::round(5.0);
    /// assert!(disc.holds([3.0, 4.0], 0.0));
    /// assert!(!disc.holds([3.0, 4.0], 0.1));
    /// ```
    pub fn holds(self, at: [f64; 2], apart_mm: f64) -> bool {
        let corner = self.corner.max(apart_mm);
        let beyond = [0, 1].map(|i| (at[i].abs() - (self.half[i] - corner)).max(0.0));
        beyond[0].hypot(beyond[1]) <= corner - apart_mm + 1e-9
    }

    /// Returns the outline with the smallest corner radius r that leaves `wall_mm` to a point which lies x and y beyond
    /// both edges: (r + x)^2 + (r + y)^2 = (r + wall)^2.
    #[must_use]
    pub fn rounded_off(self, at: [f64; 2], wall_mm: f64) -> Self {
        let [x, y] = [0, 1].map(|i| at[i] - self.half[i]);
        // Larger root of r^2 + 2 half_b r + c = 0.
        let half_b = x + y - wall_mm;
        let c = x * x + y * y - wall_mm * wall_mm;
        let corner = -half_b + (half_b * half_b - c).max(0.0).sqrt();
        Self { corner: corner.max(1.0), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_edge_leaves_the_wall_that_was_asked_for() {
        for at in [[10.2, 8.1], [10.0, 8.5], [9.9, 8.4]] {
            let rect = Rect { half: [10.0, 8.0], corner: 0.0 }.rounded_off(at, 1.45);
            let centre = rect.half.map(|half| half - rect.corner);
            let wall = (at[0] - centre[0]).hypot(at[1] - centre[1]) - rect.corner;
            assert!((wall - 1.45).abs() < 1e-12, "{at:?}: {wall}");
        }
    }

    #[test]
    fn an_inset_is_the_smallest_distance_of_two_outlines() {
        for (outer, inner) in [(3.0, 0.5), (0.5, 3.0), (4.0, 3.9), (2.0, 2.0)] {
            for half in [[9.0, 7.0], [9.5, 6.0], [9.6, 7.7]] {
                let outer = Rect { half: [10.0, 8.0], corner: outer };
                let inner = Rect { half, corner: inner };
                // Points of a quarter of the inner outline, by their distance to the outer one.
                let nearest = (0..=9000).map(|i| {
                    let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_2 / 9e3).sin_cos();
                    let at = [cos, sin].map(|part| part * inner.corner);
                    let at = [0, 1].map(|i| inner.half[i] - inner.corner + at[i]);
                    let off = [0, 1].map(|i| (at[i] - outer.half[i] + outer.corner).max(0.0));
                    let beside = (outer.half[0] - at[0]).min(outer.half[1] - at[1]);
                    if off[0] > 0.0 && off[1] > 0.0 {
                        outer.corner - off[0].hypot(off[1])
                    } else {
                        beside
                    }
                });
                let expected = nearest.fold(f64::INFINITY, f64::min);
                // A step along an arc of 4 mm is 0.7 um long; off it the distance changes by less.
                let found = outer.inset_of(inner);
                assert!((found - expected).abs() < 1e-3, "{outer:?} {inner:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn contains_respects_rounded_corners() {
        let rect = Rect { half: [10.0, 8.0], corner: 3.0 };
        let diagonal = 2.0 / 2f64.sqrt();
        assert!(rect.holds([9.0, 0.0], 1.0) && !rect.holds([9.01, 0.0], 1.0));
        assert!(rect.holds([7.0 + diagonal, -5.0 - diagonal], 1.0));
        assert!(!rect.holds([7.01 + diagonal, 5.01 + diagonal], 1.0));
    }
}
