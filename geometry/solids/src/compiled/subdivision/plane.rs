//! Restriction of a profile to a rectangle.

use nalgebra::Vector2;

use super::super::region::{Edge, Ellipse, Region};
use super::SLACK_MM;

/// Rectangle in the profile's plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    pub(super) min: Vector2<f64>,
    pub(super) max: Vector2<f64>,
}

/// Part of a region that lies in a rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RegionPart {
    Nothing,
    Everything,
    /// Points behind one edge.
    Behind(usize),
    /// Points behind both edges (convex corner), or behind at least one of the two (reflex corner).
    Corner {
        edges: [usize; 2],
        both: bool,
    },
    /// Points behind the first edge as far as its end, and behind the second edge beyond it.
    Seam([usize; 2]),
    /// Undecided: any part is possible.
    Unknown,
}

impl Rectangle {
    fn centre(&self) -> Vector2<f64> {
        0.5 * (self.min + self.max)
    }

    fn corners(&self) -> [Vector2<f64>; 4] {
        let (a, b) = (self.min, self.max);
        [a, Vector2::new(b.x, a.y), b, Vector2::new(a.x, b.y)]
    }

    /// Smallest and largest squared distance of the rectangle's points from an ellipse's centre, in coordinates scaled
    /// by the half axes.
    fn within(&self, ellipse: &Ellipse) -> [f64; 2] {
        let low = (self.min - ellipse.centre).component_div(&ellipse.half_axes);
        let high = (self.max - ellipse.centre).component_div(&ellipse.half_axes);
        let mut range = [0.0, 0.0];
        for i in 0..2 {
            let near = low[i].max(-high[i]).max(0.0);
            let far = high[i].abs().max(low[i].abs());
            range[0] += near * near;
            range[1] += far * far;
        }
        range
    }

    /// Returns whether an edge may cross the rectangle.
    fn is_met(&self, edge: &Edge) -> bool {
        match &edge.ellipse {
            None => {
                let apart = (0..2).any(|i| {
                    edge.from[i].min(edge.to[i]) >= self.max[i] - SLACK_MM
                        || edge.from[i].max(edge.to[i]) <= self.min[i] + SLACK_MM
                });
                if apart {
                    return false;
                }
                let along = edge.to - edge.from;
                // Separating axis: the normal of the edge. The two other axes were tested above.
                let side = along.perp(&(self.centre() - edge.from));
                let half = 0.5 * (self.max - self.min);
                side.abs() < along.x.abs() * half.y + along.y.abs() * half.x
            }
            Some(ellipse) => {
                let [near, far] = self.within(ellipse);
                let slack = 2.0 * SLACK_MM / ellipse.half_axes.amin();
                near < 1.0 - slack
                    && far > 1.0 + slack
                    && self.corners().iter().any(|corner| edge.arc_side(*corner) <= 0.0)
            }
        }
    }

    /// Returns whether the edge itself covers all of its line or ellipse that lies in the rectangle. Valid for edges
    /// with both ends outside the rectangle.
    fn contains_all_of_curve(&self, edge: &Edge) -> bool {
        edge.ellipse.is_none() || self.corners().iter().all(|corner| edge.arc_side(*corner) <= 0.0)
    }

    fn diagonal_mm(&self) -> f64 {
        (self.max - self.min).norm()
    }
}

/// Smallest radius of a pair of edges; `None` if an arc belongs to an ellipse that is not a circle.
fn least_radius_mm(edges: [&Edge; 2]) -> Option<f64> {
    edges.iter().try_fold(f64::INFINITY, |least, edge| match &edge.ellipse {
        None => Some(least),
        Some(e) if e.half_axes.x == e.half_axes.y => Some(least.min(e.half_axes.x)),
        Some(_) => None,
    })
}

/// Classifies a rectangle crossed by two edges, of which one continues where the other ends.
fn corner(rectangle: &Rectangle, region: &Region, a: usize, b: usize) -> RegionPart {
    let ends = |i: usize| (region.edges[i].from, region.edges[i].to);
    let follows = [ends(a).1 == ends(b).0, ends(b).1 == ends(a).0];
    if follows == [true; 2] && region.edges[a].ellipse == region.edges[b].ellipse {
        // Both arcs together form a whole ellipse.
        return RegionPart::Behind(a);
    }
    let edges = if follows == [true, false] {
        [a, b]
    } else if follows == [false, true] {
        [b, a]
    } else {
        return RegionPart::Unknown;
    };
    let [before, after] = edges.map(|i| &region.edges[i]);
    let Some(radius_mm) = least_radius_mm([before, after]) else { return RegionPart::Unknown };
    let turn = before.direction_at_end().perp(&after.direction_at_start());
    let diagonal_mm = rectangle.diagonal_mm();
    if turn.abs() < 1e-9 {
        // A seam, unless the profile reverses its direction. The rectangle must be small against the radii, so that the
        // edges run nearly straight within it.
        let goes_on = before.direction_at_end().dot(&after.direction_at_start()) > 0.0;
        return if goes_on && diagonal_mm < 0.5 * radius_mm {
            RegionPart::Seam(edges)
        } else {
            RegionPart::Unknown
        };
    }
    // Two circles that cross at this angle do not cross again within this distance.
    if diagonal_mm < radius_mm * turn.abs() {
        RegionPart::Corner { edges, both: turn * before.side() > 0.0 }
    } else {
        RegionPart::Unknown
    }
}

impl Region {
    /// Returns the part of the region that lies in a rectangle. `skip` selects edges that bound nothing.
    pub(super) fn part_in(
        &self,
        rectangle: &Rectangle,
        skip: impl Fn(&Edge) -> bool,
    ) -> RegionPart {
        let mut met = [0; 2];
        let mut count = 0;
        for (i, edge) in self.edges.iter().enumerate() {
            if !skip(edge) && rectangle.is_met(edge) {
                if count == met.len() {
                    return RegionPart::Unknown;
                }
                met[count] = i;
                count += 1;
            }
        }
        match count {
            0 if self.contains(rectangle.centre()) => RegionPart::Everything,
            0 => RegionPart::Nothing,
            1 if rectangle.contains_all_of_curve(&self.edges[met[0]]) => RegionPart::Behind(met[0]),
            1 => RegionPart::Unknown,
            _ => corner(rectangle, self, met[0], met[1]),
        }
    }
}
