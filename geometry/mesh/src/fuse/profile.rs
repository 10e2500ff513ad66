//! Union and difference of two profiles in the half plane through their axis.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use fabkit_geometry::{Path, Segment, Solid};

/// Tolerance, mm: segments that come nearer without crossing, or that cross nearer to an end, are not decided here.
const NEAR_MM: f64 = 1e-6;

/// Distance below which a point counts as on the axis, mm.
const ON_AXIS_MM: f64 = 1e-9;

/// Boolean operation on two profiles.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum ProfileOperation {
    Add,
    Cut,
}

/// Arc of an axis-aligned ellipse.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EllipseArc {
    pub centre: [f64; 2],
    pub axes: [f64; 2],
    pub ccw: bool,
    /// True if it is written as a circular arc.
    round: bool,
}

/// Segment of an outline; coordinates are distance from the axis and z, mm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OutlineSegment {
    pub from: [f64; 2],
    pub to: [f64; 2],
    pub bend: Option<EllipseArc>,
    face: u32,
}

/// Closed outline, counter-clockwise, without its segments on the axis.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub segs: Vec<OutlineSegment>,
}

/// Error: two segments come too near each other for a decision.
struct Undecidable;

impl EllipseArc {
    fn angle(&self, p: [f64; 2]) -> f64 {
        let [x, y] = self.unit(p);
        y.atan2(x)
    }

    /// Returns a point relative to the centre, in units of the half axes.
    fn unit(&self, p: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (p[i] - self.centre[i]) / self.axes[i])
    }

    fn point(&self, angle: f64) -> [f64; 2] {
        let (s, c) = angle.sin_cos();
        [self.centre[0] + self.axes[0] * c, self.centre[1] + self.axes[1] * s]
    }

    fn is_circle(&self) -> bool {
        self.axes[0] == self.axes[1]
    }
}

impl OutlineSegment {
    fn line(from: [f64; 2], to: [f64; 2], face: u32) -> Self {
        Self { from, to, bend: None, face }
    }

    fn is_on_axis(&self) -> bool {
        self.bend.is_none() && self.from[0] < ON_AXIS_MM && self.to[0] < ON_AXIS_MM
    }

    fn reversed(mut self) -> Self {
        std::mem::swap(&mut self.from, &mut self.to);
        if let Some(bend) = &mut self.bend {
            bend.ccw = !bend.ccw;
        }
        self
    }

    /// Returns the start angle of an arc, followed counter-clockwise, and the angle that it sweeps, rad.
    fn sweep(&self, bend: &EllipseArc) -> [f64; 2] {
        let [from, to] = if bend.ccw { [self.from, self.to] } else { [self.to, self.from] };
        let start = bend.angle(from);
        [start, (bend.angle(to) - start).rem_euclid(TAU)]
    }

    /// Returns the position along the segment, as a fraction of its length, of a point on the line or ellipse that
    /// carries it; outside of 0 to 1 beyond the ends.
    fn share(&self, p: [f64; 2]) -> f64 {
        match &self.bend {
            None => {
                let (way, there) = (minus(self.to, self.from), minus(p, self.from));
                dot(way, there) / dot(way, way)
            }
            Some(bend) => {
                let [start, sweep] = self.sweep(bend);
                // Points just before the start get a small negative fraction, not one of almost a turn.
                let gap = TAU - sweep;
                let along = (bend.angle(p) - start + gap / 2.0).rem_euclid(TAU) - gap / 2.0;
                if bend.ccw { along / sweep } else { 1.0 - along / sweep }
            }
        }
    }

    fn length_mm(&self) -> f64 {
        match &self.bend {
            None => minus(self.to, self.from)[0].hypot(minus(self.to, self.from)[1]),
            Some(bend) => self.sweep(bend)[1] * bend.axes[0].min(bend.axes[1]),
        }
    }

    fn middle(&self) -> [f64; 2] {
        match &self.bend {
            None => [0, 1].map(|i| (self.from[i] + self.to[i]) / 2.0),
            Some(bend) => {
                let [start, sweep] = self.sweep(bend);
                bend.point(start + sweep / 2.0)
            }
        }
    }

    /// Returns a box around the segment; for an arc, around its whole ellipse.
    fn bounds(&self) -> [[f64; 2]; 2] {
        match &self.bend {
            None => [
                [0, 1].map(|i| self.from[i].min(self.to[i])),
                [0, 1].map(|i| self.from[i].max(self.to[i])),
            ],
            Some(bend) => {
                [-1.0, 1.0].map(|sign| [0, 1].map(|i| bend.centre[i] + sign * bend.axes[i]))
            }
        }
    }

    /// Counts the crossings with a ray from a point in the direction away from the axis.
    fn crossings(&self, [r, z]: [f64; 2]) -> usize {
        let Some(bend) = &self.bend else {
            let ([r0, z0], [r1, z1]) = (self.from, self.to);
            let beyond = (z0 > z) != (z1 > z) && r0 + (z - z0) / (z1 - z0) * (r1 - r0) > r;
            return usize::from(beyond);
        };
        let [start, sweep] = self.sweep(bend);
        let [first, last] = if bend.ccw { [self.from, self.to] } else { [self.to, self.from] };
        // The arc is divided at its highest and lowest points.
        let mut turns = vec![(start, first[1])];
        for k in -3..=5 {
            let angle = FRAC_PI_2 + f64::from(k) * PI;
            if angle > start + 1e-9 && angle < start + sweep - 1e-9 {
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                turns.push((angle, bend.centre[1] + sign * bend.axes[1]));
            }
        }
        turns.push((start + sweep, last[1]));
        let height = (z - bend.centre[1]) / bend.axes[1];
        let half = bend.axes[0] * (1.0 - height * height).max(0.0).sqrt();
        let beyond = |pair: &&[(f64, f64)]| {
            let [(a, za), (b, zb)] = [pair[0], pair[1]];
            let side = if ((a + b) / 2.0).cos() >= 0.0 { 1.0 } else { -1.0 };
            (za > z) != (zb > z) && bend.centre[0] + side * half > r
        };
        turns.windows(2).filter(beyond).count()
    }

    /// Finds the crossings with another segment.
    fn find_crossings(&self, other: &Self) -> Result<Vec<[f64; 2]>, Undecidable> {
        let ([low, high], [other_low, other_high]) = (self.bounds(), other.bounds());
        if (0..2).any(|i| low[i] > other_high[i] + NEAR_MM || other_low[i] > high[i] + NEAR_MM) {
            return Ok(Vec::new());
        }
        let candidates = match (&self.bend, &other.bend) {
            (None, None) => self.line_with_line(other)?,
            (None, Some(bend)) => self.line_with(bend)?,
            (Some(bend), None) => other.line_with(bend)?,
            (Some(a), Some(b)) => self.bend_with(other, a, b)?,
        };
        let mut found = Vec::new();
        for point in candidates {
            let (mut inside, mut beyond) = (true, false);
            for seg in [self, other] {
                let (share, margin) = (seg.share(point), NEAR_MM / seg.length_mm());
                beyond |= share < -margin || share > 1.0 + margin;
                inside &= share > margin && share < 1.0 - margin;
            }
            match (beyond, inside) {
                (true, _) => {}
                (false, true) => found.push(point),
                (false, false) => return Err(Undecidable),
            }
        }
        Ok(found)
    }

    /// Sets a coordinate that both ends of the line share exactly, so that rounding does not change it.
    fn snap_shared_coordinates(&self, point: &mut [f64; 2]) {
        for (x, (from, to)) in point.iter_mut().zip(self.from.iter().zip(&self.to)) {
            if from == to {
                *x = *from;
            }
        }
    }

    fn line_with_line(&self, other: &Self) -> Result<Vec<[f64; 2]>, Undecidable> {
        let (a, b) = (minus(self.to, self.from), minus(other.to, other.from));
        let gap = minus(other.from, self.from);
        let scale = self.length_mm() * other.length_mm();
        if cross(a, b).abs() > 1e-9 * scale {
            let t = cross(gap, b) / cross(a, b);
            let mut point = [0, 1].map(|i| self.from[i] + t * a[i]);
            for seg in [self, other] {
                seg.snap_shared_coordinates(&mut point);
            }
            return Ok(vec![point]);
        }
        let apart_mm = cross(a, gap).abs() / self.length_mm();
        let shares = [self.share(other.from), self.share(other.to)];
        let margin = NEAR_MM / self.length_mm();
        let passes =
            shares.iter().all(|s| *s < -margin) || shares.iter().all(|s| *s > 1.0 + margin);
        if apart_mm > NEAR_MM || passes { Ok(Vec::new()) } else { Err(Undecidable) }
    }

    fn line_with(&self, bend: &EllipseArc) -> Result<Vec<[f64; 2]>, Undecidable> {
        let (p, q) = (bend.unit(self.from), bend.unit(self.to));
        let way = minus(q, p);
        let (a, b, c) = (dot(way, way), dot(p, way), dot(p, p) - 1.0);
        let root2 = b * b - a * c;
        // Tolerance of the half chord, in units of the half axes.
        let margin = NEAR_MM / bend.axes[0].min(bend.axes[1]);
        // Near a tangent the crossings are ill-conditioned.
        if root2.abs() < a * margin {
            return Err(Undecidable);
        }
        if root2 < 0.0 {
            return Ok(Vec::new());
        }
        let at = |t: f64| {
            let mut point = [0, 1].map(|i| self.from[i] + t * (self.to[i] - self.from[i]));
            self.snap_shared_coordinates(&mut point);
            point
        };
        Ok([-1.0, 1.0].map(|sign| at((-b + sign * root2.sqrt()) / a)).to_vec())
    }

    fn bend_with(
        &self,
        other: &Self,
        a: &EllipseArc,
        b: &EllipseArc,
    ) -> Result<Vec<[f64; 2]>, Undecidable> {
        let way = minus(b.centre, a.centre);
        let apart_mm = way[0].hypot(way[1]);
        let wider = [0, 1].map(|i| a.axes[i] - b.axes[i]);
        // Concentric arcs either lie within each other or coincide.
        if apart_mm < ON_AXIS_MM {
            if wider.iter().all(|w| *w > NEAR_MM) || wider.iter().all(|w| *w < -NEAR_MM) {
                return Ok(Vec::new());
            }
            return Err(Undecidable);
        }
        // Two different ellipses have no closed form here.
        if !a.is_circle() || !b.is_circle() {
            return Err(Undecidable);
        }
        let (r, s) = (a.axes[0], b.axes[0]);
        // Distance of the common chord from the centre of the first circle.
        let along = (apart_mm * apart_mm + r * r - s * s) / (2.0 * apart_mm);
        let height2 = r * r - along * along;
        if height2.abs() < 2.0 * r.max(s) * NEAR_MM {
            return Err(Undecidable);
        }
        if height2 < 0.0 {
            return Ok(Vec::new());
        }
        debug_assert!(self.bend.is_some() && other.bend.is_some());
        let unit = way.map(|w| w / apart_mm);
        let at = |height: f64| {
            [
                a.centre[0] + along * unit[0] - height * unit[1],
                a.centre[1] + along * unit[1] + height * unit[0],
            ]
        };
        Ok(vec![at(height2.sqrt()), at(-height2.sqrt())])
    }

    /// Returns its pieces between the given points on it.
    fn divided(&self, mut at: Vec<[f64; 2]>) -> Vec<Self> {
        at.sort_by(|a, b| self.share(*a).total_cmp(&self.share(*b)));
        at.push(self.to);
        let mut from = self.from;
        let piece = |to: [f64; 2]| {
            let piece = Self { from, to, ..self.clone() };
            from = to;
            piece
        };
        at.into_iter().map(piece).collect()
    }
}

impl Outline {
    /// Returns the outline of a primitive that is solid up to its axis; `faces` are the numbers of its faces.
    pub fn from_primitive(primitive: &Solid, faces: &[u32]) -> Option<Self> {
        let face = |i: usize| faces.get(i).copied().unwrap_or_default();
        let segs = match primitive {
            Solid::Cylinder(s) => frustum([s.radius_mm; 2], s.height_mm, face),
            Solid::Cone(s) => frustum([s.bottom_radius_mm, s.top_radius_mm], s.height_mm, face),
            Solid::Sphere(s) => {
                let [low, high] = [[0.0, -s.radius_mm], [0.0, s.radius_mm]];
                let axes = [s.radius_mm; 2];
                let bend = EllipseArc { centre: [0.0; 2], axes, ccw: true, round: true };
                vec![OutlineSegment {
                    bend: Some(bend),
                    ..OutlineSegment::line(low, high, face(0))
                }]
            }
            Solid::Revolution(s) if s.profile.holes.is_empty() => {
                let path = &s.profile.outer;
                let segs = of_path(path, face);
                if path.signed_area_mm2() > 0.0 {
                    segs
                } else {
                    segs.into_iter().rev().map(OutlineSegment::reversed).collect()
                }
            }
            _ => return None,
        };
        let segs = segs.into_iter().filter(|seg| !seg.is_on_axis() && seg.from != seg.to);
        Some(Self { segs: segs.collect() })
    }

    pub fn shifted(mut self, by_mm: f64) -> Self {
        for seg in &mut self.segs {
            for z in [&mut seg.from[1], &mut seg.to[1]] {
                *z += by_mm;
            }
            if let Some(bend) = &mut seg.bend {
                bend.centre[1] += by_mm;
            }
        }
        self
    }

    fn contains(&self, point: [f64; 2]) -> bool {
        self.segs.iter().map(|seg| seg.crossings(point)).sum::<usize>() % 2 == 1
    }

    /// Combines two outlines if they cross and the result is one closed outline.
    pub fn combined(
        &self,
        other: &Self,
        rule: ProfileOperation,
        may_divide: impl Fn(&OutlineSegment) -> bool,
    ) -> Option<Self> {
        let mut own: Vec<Vec<[f64; 2]>> = vec![Vec::new(); self.segs.len()];
        let mut others: Vec<Vec<[f64; 2]>> = vec![Vec::new(); other.segs.len()];
        for (a, own) in self.segs.iter().zip(&mut own) {
            for (b, others) in other.segs.iter().zip(&mut others) {
                let points = a.find_crossings(b).ok()?;
                own.extend(&points);
                others.extend(points);
            }
        }
        // Outlines that do not cross are apart or nested: no fusion.
        if own.iter().all(Vec::is_empty) {
            return None;
        }
        let mut pieces = Vec::new();
        for (segs, at, beyond) in [(&self.segs, own, other), (&other.segs, others, self)] {
            let is_tool = std::ptr::eq(beyond, self) && rule == ProfileOperation::Cut;
            for (seg, at) in segs.iter().zip(at) {
                let is_divided = !at.is_empty();
                let divided = seg.divided(at);
                if divided.iter().any(|piece| piece.length_mm() < NEAR_MM) {
                    return None;
                }
                // Union keeps the pieces outside of the other outline; a cut keeps the tool's pieces inside the base,
                // reversed.
                let kept = divided.into_iter().filter(|p| beyond.contains(p.middle()) == is_tool);
                let before = pieces.len();
                pieces.extend(kept.map(|p| if is_tool { p.reversed() } else { p }));
                if is_divided && pieces.len() > before && !may_divide(seg) {
                    return None;
                }
            }
        }
        in_order(pieces).map(|segs| Self { segs })
    }

    /// Converts to a path, with the face number of each segment.
    pub fn into_path(self) -> (Path, Vec<u32>) {
        let mut path = Path::from(self.segs[0].from);
        let mut faces = Vec::with_capacity(self.segs.len() + 1);
        for OutlineSegment { from, to, bend, face } in self.segs {
            if path.end() != from {
                path = path.line(from);
                faces.push(face);
            }
            path = match bend {
                None => path.line(to),
                Some(bend) if bend.round => path.arc(to, bend.centre, bend.ccw),
                Some(bend) => path.elliptic_arc(to, bend.centre, bend.axes, bend.ccw),
            };
            faces.push(face);
        }
        let closed = path.close();
        // The closing segment along the axis sweeps no surface; its face number does not matter.
        faces.resize(closed.segments.len(), faces[0]);
        (closed, faces)
    }
}

/// Orders pieces to one closed outline; `None` if they do not form one. It may run along the axis once.
fn in_order(mut pieces: Vec<OutlineSegment>) -> Option<Vec<OutlineSegment>> {
    let on_axis = |p: [f64; 2]| p[0] < ON_AXIS_MM;
    let from_axis = |piece: &OutlineSegment| on_axis(piece.from);
    match pieces.iter().filter(|piece| from_axis(piece)).count() {
        0 => {}
        1 => {
            let first = pieces.iter().position(from_axis)?;
            pieces.swap(0, first);
        }
        _ => return None,
    }
    for done in 1..pieces.len() {
        // Exact comparison is enough: common ends are the same computed point.
        let end = pieces[done - 1].to;
        let next = (done..pieces.len()).find(|&i| pieces[i].from == end)?;
        pieces.swap(done, next);
    }
    let (first, last) = (pieces.first()?.from, pieces.last()?.to);
    (first == last || (on_axis(first) && on_axis(last))).then_some(pieces)
}

/// Returns the outline of a cylinder or cone. The side is face 0, the bottom 1 and the top 2.
fn frustum(
    [bottom, top]: [f64; 2],
    height_mm: f64,
    face: impl Fn(usize) -> u32,
) -> Vec<OutlineSegment> {
    let corners = [[0.0, 0.0], [bottom, 0.0], [top, height_mm], [0.0, height_mm]];
    let sides = corners.windows(2).zip([1, 0, 2]);
    sides.map(|(ends, i)| OutlineSegment::line(ends[0], ends[1], face(i))).collect()
}

fn of_path(path: &Path, face: impl Fn(usize) -> u32) -> Vec<OutlineSegment> {
    let mut from = path.start;
    let seg = |(i, segment): (usize, &Segment)| {
        let to = segment.to();
        let bend = match *segment {
            Segment::Line { .. } => None,
            Segment::Arc { centre, ccw, .. } => {
                // The radius is taken from the same end in both directions, so that shared arcs have equal radii.
                let end = minus(if ccw { to } else { from }, centre);
                Some(EllipseArc { centre, axes: [end[0].hypot(end[1]); 2], ccw, round: true })
            }
            Segment::EllipticArc { centre, semi_axes_mm, ccw, .. } => {
                Some(EllipseArc { centre, axes: semi_axes_mm, ccw, round: false })
            }
        };
        let seg = OutlineSegment { bend, ..OutlineSegment::line(from, to, face(i)) };
        from = to;
        seg
    };
    path.segments.iter().enumerate().map(seg).collect()
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
