//! Profile prepared for point tests and for finding where lines may cross its boundary.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

use nalgebra::Vector2;

use crate::{Path, Profile, Segment};

/// Tolerance with which an edge accepts a point near one of its ends, relative to its size: far more than rounding and
/// than the tolerance of validation for an arc's ends.
const SLACK: f64 = 1e-6;

/// Ellipse that an arc is part of; a circle if the half axes agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipse {
    pub(crate) centre: Vector2<f64>,
    pub(crate) half_axes: Vector2<f64>,
}

/// Segment of a path with derived quantities.
#[derive(Clone, Debug)]
pub(crate) struct Edge {
    pub(crate) from: Vector2<f64>,
    pub(crate) to: Vector2<f64>,
    /// Ellipse of an arc; `None` for a straight line.
    pub(crate) ellipse: Option<Ellipse>,
    /// True if the arc runs counter-clockwise.
    ccw: bool,
    /// Side on which the region lies: 1 left, -1 right.
    left: f64,
    /// Corner of a box around the edge that is somewhat larger than the tolerance of [`Edge::accepts`] at its ends.
    pub(crate) low: Vector2<f64>,
    pub(crate) high: Vector2<f64>,
}

impl Edge {
    fn new(from: [f64; 2], segment: &Segment, left: f64) -> Self {
        let (from, to) = (Vector2::from(from), Vector2::from(segment.to()));
        let (ellipse, ccw) = match segment {
            Segment::Line { .. } => (None, true),
            Segment::Arc { centre, ccw, .. } => {
                let centre = Vector2::from(*centre);
                let radius = (from - centre).norm();
                (Some(Ellipse { centre, half_axes: Vector2::new(radius, radius) }), *ccw)
            }
            Segment::EllipticArc { centre, semi_axes_mm, ccw, .. } => {
                let (centre, half_axes) = (Vector2::from(*centre), Vector2::from(*semi_axes_mm));
                (Some(Ellipse { centre, half_axes }), *ccw)
            }
        };
        let mut edge = Self { from, to, ellipse, ccw, left, low: from, high: to };
        (edge.low, edge.high) = edge.around();
        edge
    }

    fn around(&self) -> (Vector2<f64>, Vector2<f64>) {
        let (x, y) = (Vector2::x(), Vector2::y());
        let high = Vector2::new(self.support(x), self.support(y));
        let low = -Vector2::new(self.support(-x), self.support(-y));
        // Twice the slack, and far more than the rounding of points on a line.
        let grown = 2.0 * SLACK * (high - low).amax() + 1e-9 * low.amax().max(high.amax());
        (low.add_scalar(-grown), high.add_scalar(grown))
    }

    /// Returns whether the line through `origin` meets a straight edge's line only beyond the ends of the edge and
    /// beyond their slack.
    pub(crate) fn is_missed_by_line(&self, origin: Vector2<f64>, direction: Vector2<f64>) -> bool {
        let (a, b) = (direction.perp(&(self.from - origin)), direction.perp(&(self.to - origin)));
        a * b > 0.0 && a.abs().min(b.abs()) > SLACK * (a - b).abs()
    }

    /// Returns the signed angle (eccentric for ellipses) that an arc sweeps; 0 for a line.
    pub(crate) fn sweep(&self) -> f64 {
        let Some(Ellipse { centre, half_axes }) = self.ellipse else { return 0.0 };
        let unit = |p: Vector2<f64>| (p - centre).component_div(&half_axes);
        let (a, b) = (unit(self.from), unit(self.to));
        // The angle from a to b, which is exact for small arcs too.
        let turn = a.perp(&b).atan2(a.dot(&b));
        if self.ccw { turn.rem_euclid(TAU) } else { -((-turn).rem_euclid(TAU)) }
    }

    /// Returns the point at a parameter from 0 to 1, and its derivative.
    pub(crate) fn at(&self, s: f64) -> (Vector2<f64>, Vector2<f64>) {
        let Some(Ellipse { centre, half_axes }) = self.ellipse else {
            let along = self.to - self.from;
            return (self.from + s * along, along);
        };
        let sweep = self.sweep();
        let start = (self.from - centre).component_div(&half_axes);
        let (sin, cos) = (s * sweep).sin_cos();
        let unit = Vector2::new(start.x * cos - start.y * sin, start.x * sin + start.y * cos);
        let tangent = Vector2::new(-unit.y, unit.x) * sweep;
        (centre + unit.component_mul(&half_axes), tangent.component_mul(&half_axes))
    }

    /// Returns whether a point of the edge's full line or ellipse belongs to the edge, with a tolerance at the ends.
    pub(crate) fn accepts(&self, p: Vector2<f64>) -> bool {
        let chord = self.to - self.from;
        match &self.ellipse {
            None => {
                let along = (p - self.from).dot(&chord) / chord.norm_squared();
                (-SLACK..=1.0 + SLACK).contains(&along)
            }
            // A counter-clockwise arc lies to the right of its chord, however long it is.
            Some(ellipse) => {
                let side = chord.perp(&(p - self.from)) * if self.ccw { 1.0 } else { -1.0 };
                side <= SLACK * chord.norm() * ellipse.half_axes.amax()
            }
        }
    }

    /// Returns a negative value on an arc's side of its chord, where all of the arc lies; 0 for a straight line.
    pub(crate) fn arc_side(&self, p: Vector2<f64>) -> f64 {
        // A counter-clockwise arc lies to the right of its chord, however long it is.
        let turn = if self.ccw { 1.0 } else { -1.0 };
        if self.ellipse.is_some() {
            (self.to - self.from).perp(&(p - self.from)) * turn
        } else {
            0.0
        }
    }

    /// Returns the side on which the region lies: 1 left, -1 right.
    pub(crate) fn side(&self) -> f64 {
        self.left
    }

    /// Returns the unit direction at the start of the edge.
    pub(crate) fn direction_at_start(&self) -> Vector2<f64> {
        self.direction(self.from)
    }

    /// Returns the unit direction at the end of the edge.
    pub(crate) fn direction_at_end(&self) -> Vector2<f64> {
        self.direction(self.to)
    }

    fn direction(&self, p: Vector2<f64>) -> Vector2<f64> {
        let outward = self.outward(p) * self.left;
        Vector2::new(-outward.y, outward.x).normalize()
    }

    /// Returns the normal out of the region at a point of the edge; not of unit length.
    pub(crate) fn outward(&self, p: Vector2<f64>) -> Vector2<f64> {
        match &self.ellipse {
            None => {
                let along = self.to - self.from;
                Vector2::new(along.y, -along.x) * self.left
            }
            Some(Ellipse { centre, half_axes }) => {
                let from_centre = (p - centre).component_div(half_axes).component_div(half_axes);
                // A counter-clockwise arc with the region to its left bulges outwards.
                from_centre * if self.ccw { self.left } else { -self.left }
            }
        }
    }

    /// Returns the largest projection of the edge on a direction.
    fn support(&self, u: Vector2<f64>) -> f64 {
        let ends = self.from.dot(&u).max(self.to.dot(&u));
        let Some(Ellipse { centre, half_axes }) = &self.ellipse else { return ends };
        let scaled = half_axes.component_mul(&u);
        let reach = scaled.norm();
        if reach == 0.0 {
            return ends;
        }
        // Point of the full ellipse with the normal u; it counts only if the arc includes it.
        let farthest = centre + half_axes.component_mul(&scaled) / reach;
        if self.accepts(farthest) { ends.max(centre.dot(&u) + reach) } else { ends }
    }

    /// Splits the edge where y reverses, so that each piece meets a horizontal line at most once.
    fn monotone(&self, pieces: &mut Vec<Piece>) {
        let Some(ellipse) = self.ellipse else {
            pieces.push(Piece { from: self.from, to: self.to, bulge: None });
            return;
        };
        let angle = |p: Vector2<f64>| {
            let q = (p - ellipse.centre).component_div(&ellipse.half_axes);
            q.y.atan2(q.x)
        };
        let turn = if self.ccw { 1.0 } else { -1.0 };
        let start = angle(self.from);
        let swept = |angle: f64| (turn * (angle - start)).rem_euclid(TAU);
        let total = swept(angle(self.to));
        let mut turns: Vec<(f64, Vector2<f64>)> = [FRAC_PI_2, -FRAC_PI_2]
            .into_iter()
            .map(|a| {
                let top = ellipse.centre + Vector2::new(0.0, ellipse.half_axes.y * a.signum());
                (swept(a), top)
            })
            .filter(|&(at, _)| 0.0 < at && at < total)
            .collect();
        turns.sort_by(|a, b| a.0.total_cmp(&b.0));
        turns.push((total, self.to));
        let (mut from, mut from_at) = (self.from, 0.0);
        for (at, to) in turns {
            // The side of a piece follows from its middle, far from the turning points.
            let middle = start + turn * 0.5 * (from_at + at);
            let bulge = Some((ellipse, middle.cos().signum()));
            pieces.push(Piece { from, to, bulge });
            (from, from_at) = (to, at);
        }
    }
}

/// Piece of the boundary along which y is monotonic.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: Vector2<f64>,
    to: Vector2<f64>,
    /// Ellipse, and the side of its centre on which the piece lies: 1 right, -1 left.
    bulge: Option<(Ellipse, f64)>,
}

impl Piece {
    /// Returns whether a ray from `p` toward +x crosses the piece. Half-open in y: of two pieces that share an end,
    /// exactly one counts it.
    fn is_right_of(&self, p: Vector2<f64>) -> bool {
        if (self.from.y <= p.y) == (self.to.y <= p.y) {
            return false;
        }
        match &self.bulge {
            None => {
                let cross = (self.to - self.from).perp(&(p - self.from));
                if self.to.y > self.from.y { cross > 0.0 } else { cross < 0.0 }
            }
            Some((Ellipse { centre, half_axes }, side)) => {
                let v = (p.y - centre.y) / half_axes.y;
                let half_width = half_axes.x * (1.0 - v * v).max(0.0).sqrt();
                p.x < centre.x + side * half_width
            }
        }
    }
}

/// [`Profile`] prepared for queries.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    /// Edges in the order of face numbers: outer path first, then the holes.
    pub(crate) edges: Vec<Edge>,
    pieces: Vec<Piece>,
    /// Range of pieces of each path.
    paths: Vec<Range<usize>>,
    outer_edges: usize,
}

impl Region {
    pub(crate) fn new(profile: &Profile) -> Self {
        let (mut edges, mut pieces, mut paths) = (Vec::new(), Vec::new(), Vec::new());
        for (i, path) in profile.paths().enumerate() {
            let is_hole = i > 0;
            // Either orientation is allowed: the region lies inside the outer path and outside the holes.
            let left = if (signed_area(path) > 0.0) == is_hole { -1.0 } else { 1.0 };
            let first_piece = pieces.len();
            let mut from = path.start;
            for segment in &path.segments {
                let edge = Edge::new(from, segment, left);
                edge.monotone(&mut pieces);
                edges.push(edge);
                from = segment.to();
            }
            paths.push(first_piece..pieces.len());
        }
        Self { edges, pieces, paths, outer_edges: profile.outer.segments.len() }
    }

    /// Returns whether the point lies inside the outer path and outside every hole.
    pub(crate) fn contains(&self, p: Vector2<f64>) -> bool {
        let within = |path: &Range<usize>| {
            // Even-odd rule for each path.
            self.pieces[path.clone()].iter().filter(|piece| piece.is_right_of(p)).count() % 2 == 1
        };
        self.paths.first().is_some_and(within) && !self.paths.iter().skip(1).any(within)
    }

    /// Returns the largest projection of the region on a direction.
    pub(crate) fn support(&self, u: Vector2<f64>) -> f64 {
        let outer = &self.edges[..self.outer_edges];
        outer.iter().map(|edge| edge.support(u)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Computes the length of a path of lines and circular arcs, mm.
pub(crate) fn path_length(path: &Path) -> f64 {
    let mut from = path.start;
    let lengths = path.segments.iter().map(|segment| {
        let edge = Edge::new(from, segment, 1.0);
        from = segment.to();
        match edge.ellipse {
            None => (edge.to - edge.from).norm(),
            Some(Ellipse { half_axes, .. }) => edge.sweep().abs() * half_axes.x,
        }
    });
    lengths.sum()
}

/// Computes the area enclosed by a path, mm^2; positive for counter-clockwise paths (Green's theorem, exact for arcs).
pub(crate) fn signed_area(path: &Path) -> f64 {
    let mut twice_area = 0.0;
    let mut from = Vector2::from(path.start);
    // Relative to the first point, so that a small path far from the origin keeps its digits.
    let base = from;
    for segment in &path.segments {
        let edge = Edge::new(from.into(), segment, 1.0);
        twice_area += (edge.from - base).perp(&(edge.to - base));
        if let Some(Ellipse { half_axes, .. }) = edge.ellipse {
            // Twice the area between the arc and its chord.
            let sweep = edge.sweep();
            twice_area += (sweep - sweep.sin()) * half_axes.x * half_axes.y;
        }
        from = edge.to;
    }
    0.5 * twice_area
}
