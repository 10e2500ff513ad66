//! Edges of the profiles of extrusions and revolutions.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{Path, Point3, Segment, Vector3};

use super::faces::{AxialPose, Cell, PARTS_PER_QUARTER, SLACK_MM, ring_between};
use super::quadric::Quadric;

/// Edge of a profile.
pub(super) struct Edge<'a> {
    pub(super) from: [f64; 2],
    pub(super) segment: &'a Segment,
}

/// Returns all edges of a profile, its holes included.
pub(super) fn edges<'a>(outer: &'a Path, holes: &'a [Path]) -> Vec<Edge<'a>> {
    let of = |path: &'a Path| {
        let froms = std::iter::once(path.start).chain(path.segments.iter().map(Segment::to));
        froms.zip(&path.segments).map(|(from, segment)| Edge { from, segment })
    };
    std::iter::once(outer).chain(holes).flat_map(of).collect()
}

/// Returns the box around all edges.
pub(super) fn bounding_box(edges: &[Edge]) -> [[f64; 2]; 2] {
    let corners: Vec<[f64; 2]> = edges.iter().flat_map(Edge::bounds).collect();
    box_around(&corners)
}

/// Returns the smallest and largest coordinates of some points.
fn box_around(points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        [0, 1].map(|axis| points.iter().fold(start, |so_far, point| pick(so_far, point[axis])))
    };
    [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
}

impl Edge<'_> {
    /// Returns whether the edge is straight.
    pub(super) fn is_line(&self) -> bool {
        matches!(self.segment, Segment::Line { .. })
    }

    /// Returns whether the box around the edge contains no other part of its curve.
    pub(super) fn is_within_quarter(&self) -> bool {
        let [low, high] = self.bounds();
        let around = match self.segment {
            Segment::Line { .. } => return true,
            Segment::Arc { centre, .. } | Segment::EllipticArc { centre, .. } => centre,
        };
        (0..2).all(|axis| low[axis] >= around[axis] || high[axis] <= around[axis])
    }

    /// Returns the box around the edge.
    pub(super) fn bounds(&self) -> [[f64; 2]; 2] {
        box_around(self.monotonic_pieces().as_flattened())
    }

    /// Computes a lower bound of the distance of an extrusion's edge from the sensor's axis, mm: exact for lines, that
    /// of the whole circle for arcs, and 0 for elliptic arcs.
    pub(super) fn min_axis_distance(&self, up: &AxialPose) -> f64 {
        let place = |p: [f64; 2]| up.pose.point(Point3::new(p[0], p[1], 0.0)).coords.xy();
        let (a, b) = (place(self.from), place(self.segment.to()));
        match self.segment {
            Segment::Line { .. } => {
                let along = b - a;
                let share = (-a.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (a + share * along).norm()
            }
            Segment::Arc { centre, .. } => {
                let centre = place(*centre);
                (centre.norm() - (a - centre).norm()).abs()
            }
            Segment::EllipticArc { .. } => 0.0,
        }
    }

    /// Returns the cells of the wall that an extrusion has along the edge.
    pub(super) fn wall_cells(&self, up: &AxialPose, height: f64) -> Vec<Cell> {
        // Tighter than the distances of the box.
        let least_mm = self.min_axis_distance(up) - SLACK_MM;
        let wall = |ends: [[f64; 2]; 2]| {
            let cell = up.cell(box_around(&ends), [0.0, height]);
            let [near, far] = cell.radius_mm;
            Cell { radius_mm: [near.max(least_mm), far], ..cell }
        };
        self.monotonic_pieces().into_iter().map(wall).collect()
    }

    /// Returns the quadric of the wall that an extrusion has along the edge, if it is one.
    pub(super) fn wall_quadric(&self, up: &AxialPose) -> Option<Quadric> {
        let (a, b) = (self.from, self.segment.to());
        let point = up.pose.point(Point3::new(a[0], a[1], 0.0)).coords;
        match self.segment {
            Segment::Line { .. } => {
                let across = up.pose.vector(Vector3::new(b[1] - a[1], a[0] - b[0], 0.0));
                Some(Quadric::plane(across.normalize(), point))
            }
            Segment::Arc { centre, .. } => {
                let on_axis = up.pose.point(Point3::new(centre[0], centre[1], 0.0)).coords;
                let radius = (a[0] - centre[0]).hypot(a[1] - centre[1]);
                Some(Quadric::cone(on_axis, radius, 0.0))
            }
            Segment::EllipticArc { .. } => None,
        }
    }

    /// Returns the quadric of the face that a revolution sweeps along the edge, if it is one.
    pub(super) fn revolved_quadric(&self, up: &AxialPose) -> Option<Quadric> {
        let (a, b) = (self.from, self.segment.to());
        let on_axis = |z: f64| up.pose.point(Point3::new(0.0, 0.0, z)).coords;
        match self.segment {
            Segment::Line { .. } if a[1] == b[1] => {
                Some(Quadric::plane(Vector3::z(), on_axis(a[1])))
            }
            Segment::Line { .. } => {
                let growth = up.sign * (b[0] - a[0]) / (b[1] - a[1]);
                Some(Quadric::cone(on_axis(a[1]), a[0], growth))
            }
            // Only arcs about a point on the axis sweep spheres or ellipsoids; others sweep tori.
            Segment::Arc { centre, .. } if centre[0] == 0.0 => {
                let r = a[0].hypot(a[1] - centre[1]);
                Some(Quadric::ellipsoid(on_axis(centre[1]), r, r))
            }
            Segment::EllipticArc { centre, semi_axes_mm: [x, z], .. } if centre[0] == 0.0 => {
                Some(Quadric::ellipsoid(on_axis(centre[1]), *x, *z))
            }
            _ => None,
        }
    }

    /// Returns the cells of the swept face.
    pub(super) fn revolved_cells(&self, up: &AxialPose) -> Vec<Cell> {
        let parts = match self.segment {
            // A slanted line sweeps a cone, for which boxes are tight only in parts.
            Segment::Line { to } if self.from[0] != to[0] && self.from[1] != to[1] => {
                PARTS_PER_QUARTER
            }
            _ => 1,
        };
        let split = |[a, b]: [[f64; 2]; 2]| {
            let at = move |k: usize| {
                let s = k as f64 / parts as f64;
                [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
            };
            (0..parts).map(move |k| [at(k), at(k + 1)])
        };
        self.monotonic_pieces()
            .into_iter()
            .flat_map(split)
            .map(|[a, b]| ring_between(up, a, b))
            .collect()
    }

    /// Splits the edge into pieces that are monotonic in both coordinates, and returns their ends. The box around a
    /// piece is then the box around its ends.
    pub(super) fn monotonic_pieces(&self) -> Vec<[[f64; 2]; 2]> {
        let (a, b) = (self.from, self.segment.to());
        let (centre, half, ccw) = match *self.segment {
            Segment::Line { .. } => return vec![[a, b]],
            Segment::Arc { centre, ccw, .. } => {
                let r = (a[0] - centre[0]).hypot(a[1] - centre[1]);
                (centre, [r, r], ccw)
            }
            Segment::EllipticArc { centre, semi_axes_mm, ccw, .. } => (centre, semi_axes_mm, ccw),
        };
        let angle =
            |p: [f64; 2]| ((p[1] - centre[1]) / half[1]).atan2((p[0] - centre[0]) / half[0]);
        let (from, to) = if ccw { (angle(a), angle(b)) } else { (angle(b), angle(a)) };
        let turn = (to - from).rem_euclid(4.0 * FRAC_PI_2);
        let to = from + if turn == 0.0 { 4.0 * FRAC_PI_2 } else { turn };
        let step = FRAC_PI_2 / PARTS_PER_QUARTER as f64;
        // Pieces end at multiples of the step, so none contains an extreme of a coordinate in its interior.
        let (first, last) = ((from / step).floor() as i64 + 1, (to / step).ceil() as i64);
        let cuts = (first..last).map(|k| k as f64 * step);
        let cuts: Vec<f64> = std::iter::once(from).chain(cuts).chain(std::iter::once(to)).collect();
        let at = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            [centre[0] + half[0] * cos, centre[1] + half[1] * sin]
        };
        cuts.windows(2).map(|pair| [at(pair[0]), at(pair[1])]).collect()
    }
}
