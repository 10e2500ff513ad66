//! Plane regions bounded by lines and arcs.

use serde::{Deserialize, Serialize};

use crate::Angle;

/// Segment of a [`Path`]; it starts at the end of the previous one.
///
/// JSON: `{"line": {"to": [x, y]}}`, `{"arc": {"to": .., "centre": .., "ccw": true}}`, ...
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Segment {
    /// Straight line.
    Line {
        /// End point, mm.
        to: [f64; 2],
    },
    /// Circular arc; start and end must have the same distance from the centre.
    Arc {
        /// End point, mm.
        to: [f64; 2],
        /// Centre of the circle, mm.
        centre: [f64; 2],
        /// True if the arc runs counter-clockwise from start to end.
        ccw: bool,
    },
    /// Arc of an axis-aligned ellipse. Only in revolutions.
    EllipticArc {
        /// End point, mm.
        to: [f64; 2],
        /// Centre of the ellipse, mm.
        centre: [f64; 2],
        /// Half axes along x and y, mm.
        semi_axes_mm: [f64; 2],
        /// True if the arc runs counter-clockwise from start to end.
        ccw: bool,
    },
}

impl Segment {
    /// Returns the end point, mm.
    pub fn to(&self) -> [f64; 2] {
        match self {
            Self::Line { to } | Self::Arc { to, .. } | Self::EllipticArc { to, .. } => *to,
        }
    }
}

impl Segment {
    /// Returns the start point and the segment after an offset of `by_mm` to its right.
    fn offset_right(&self, from: [f64; 2], by_mm: f64) -> ([f64; 2], Self) {
        match *self {
            Self::Line { to } => {
                let (x, y) = (to[0] - from[0], to[1] - from[1]);
                let scale = by_mm / x.hypot(y);
                let moved = |p: [f64; 2]| [p[0] + scale * y, p[1] - scale * x];
                (moved(from), Self::Line { to: moved(to) })
            }
            Self::Arc { to, centre, ccw } => {
                // To the right is outwards on a counter-clockwise arc and inwards on a clockwise one.
                let by_mm = if ccw { by_mm } else { -by_mm };
                let moved = |p: [f64; 2]| {
                    let (x, y) = (p[0] - centre[0], p[1] - centre[1]);
                    let scale = 1.0 + by_mm / x.hypot(y);
                    [centre[0] + scale * x, centre[1] + scale * y]
                };
                (moved(from), Self::Arc { to: moved(to), centre, ccw })
            }
            Self::EllipticArc { .. } => (from, self.clone()),
        }
    }

    fn set_to(&mut self, end: [f64; 2]) {
        match self {
            Self::Line { to } | Self::Arc { to, .. } | Self::EllipticArc { to, .. } => *to = end,
        }
    }
}

/// Distance below which two end points count as one, relative to their distance from a corner (or from the origin).
const SAME_POINT: f64 = 1e-9;

/// Closed curve: the last segment must end where the first starts.
///
/// A circle consists of two half arcs. Paths are built point by point:
///
/// ```
/// use fabkit_geometry::Path;
/// let half_disc = Path::from([0.0, -5.0]).arc([0.0, 5.0], [0.0, 0.0], true).close();
/// assert_eq!(half_disc.segments.len(), 2);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Path {
    /// First point, mm.
    pub start: [f64; 2],
    /// Segments in order.
    pub segments: Vec<Segment>,
}

impl Path {
    /// Starts a path at a point.
    pub fn from(start: [f64; 2]) -> Self {
        Self { start, segments: Vec::new() }
    }

    /// Adds a straight line.
    #[must_use]
    pub fn line(mut self, to: [f64; 2]) -> Self {
        self.segments.push(Segment::Line { to });
        self
    }

    /// Adds a circular arc.
    #[must_use]
    pub fn arc(mut self, to: [f64; 2], centre: [f64; 2], ccw: bool) -> Self {
        self.segments.push(Segment::Arc { to, centre, ccw });
        self
    }

    /// Adds an arc of an axis-aligned ellipse.
    ///
    /// ```
    /// use fabkit_geometry::{CompiledSolid, Path, Point3, Solid};
    /// // A quarter of an ellipse, turned around z, is half an ellipsoid: 12 mm wide to each side, 15 mm high.
    /// let quarter = Path::from([0.0, 0.0])
    ///     .line([12.0, 0.0])
    ///     .elliptic_arc([0.0, 15.0], [0.0, 0.0], [12.0, 15.0], true)
    ///     .close();
    /// let dome = CompiledSolid::new(&Solid::revolution(quarter))?;
    /// assert!(dome.contains(&Point3::new(0.0, 0.0, 14.9)) && dome.contains(&Point3::new(0.0, 11.9, 0.1)));
    /// assert!(!dome.contains(&Point3::new(12.0 * 0.8, 0.0, 15.0 * 0.61))); // 0.8^2 + 0.6^2 = 1
    /// # Ok::<(), fabkit_geometry::InvalidSolid>(())
    /// ```
    #[must_use]
    pub fn elliptic_arc(
        mut self,
        to: [f64; 2],
        centre: [f64; 2],
        semi_axes_mm: [f64; 2],
        ccw: bool,
    ) -> Self {
        self.segments.push(Segment::EllipticArc { to, centre, semi_axes_mm, ccw });
        self
    }

    /// Closes the path with a straight line if it is still open. An end that misses the start only by rounding is moved
    /// there, because other CAD kernels fail on lines of 1e-15 mm.
    ///
    /// ```
    /// use fabkit_geometry::Path;
    /// let corners = [0.0f64, 120.0, 240.0, 360.0].map(f64::to_radians);
    /// let [first, rest @ ..] = corners.map(|rad| [3.0 * rad.cos(), 3.0 * rad.sin()]);
    /// let triangle = rest.into_iter().fold(Path::from(first), |path, corner| path.line(corner)).close();
    /// assert_eq!((triangle.segments.len(), triangle.end()), (3, triangle.start));
    /// ```
    #[must_use]
    pub fn close(mut self) -> Self {
        let (start, end) = (self.start, self.end());
        // Rounding errors of the end grow with its distance from the origin.
        let far_mm = start[0].hypot(start[1]).max(1.0);
        let gap_mm = (end[0] - start[0]).hypot(end[1] - start[1]);
        match self.segments.last_mut() {
            Some(last) if gap_mm <= SAME_POINT * far_mm => {
                last.set_to(start);
                self
            }
            _ => self.line(start),
        }
    }

    /// Returns the last point, mm.
    pub fn end(&self) -> [f64; 2] {
        self.segments.last().map_or(self.start, Segment::to)
    }

    /// Creates a closed polygon through the points.
    ///
    /// ```
    /// use fabkit_geometry::Path;
    /// let triangle = Path::polygon(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]);
    /// assert_eq!(triangle.signed_area_mm2(), 6.0); // counter-clockwise
    /// let other_way = Path::polygon(&[[0.0, 0.0], [0.0, 3.0], [4.0, 0.0]]);
    /// assert_eq!(other_way.signed_area_mm2(), -6.0);
    /// ```
    pub fn polygon(points: &[[f64; 2]]) -> Self {
        let start = points.first().copied().unwrap_or_default();
        points.iter().skip(1).fold(Self::from(start), |path, &to| path.line(to)).close()
    }

    /// Creates a circle as two arcs, counter-clockwise.
    pub fn circle(centre: [f64; 2], radius_mm: f64) -> Self {
        let [x, y] = centre;
        let (right, left) = ([x + radius_mm, y], [x - radius_mm, y]);
        Self::from(right).arc(left, centre, true).arc(right, centre, true)
    }

    /// Creates an axis-aligned rectangle with rounded corners (sharp if `corner_mm` is 0).
    ///
    /// ```
    /// use fabkit_geometry::Path;
    /// let plate = Path::rectangle([0.0, 0.0], [20.0, 10.0], 2.0);
    /// assert_eq!(plate.segments.len(), 8); // four edges, four corners
    /// let lost_mm2 = (4.0 - std::f64::consts::PI) * 2.0 * 2.0; // four squares less one disc
    /// assert!((plate.signed_area_mm2() - (200.0 - lost_mm2)).abs() < 1e-12);
    /// ```
    pub fn rectangle(centre: [f64; 2], size_mm: [f64; 2], corner_mm: f64) -> Self {
        let [cx, cy] = centre;
        let (hx, hy, r) = (size_mm[0] / 2.0, size_mm[1] / 2.0, corner_mm);
        let (l, b, t, rt) = (cx - hx, cy - hy, cy + hy, cx + hx);
        if r <= 0.0 {
            return Self::polygon(&[[l, b], [rt, b], [rt, t], [l, t]]);
        }
        let mut path = Self::from([l + r, b]);
        let corners = [
            ([rt - r, b], [rt, b + r], [rt - r, b + r]),
            ([rt, t - r], [rt - r, t], [rt - r, t - r]),
            ([l + r, t], [l, t - r], [l + r, t - r]),
            ([l, b + r], [l + r, b], [l + r, b + r]),
        ];
        for (from, to, centre) in corners {
            // Neighbouring corner arcs may touch, so that no straight line remains between them.
            if path.end() != from {
                path = path.line(from);
            }
            path = path.arc(to, centre, true);
        }
        path
    }

    /// Creates a slot with round ends: all points within `radius_mm` of the segment between two points.
    ///
    /// ```
    /// use fabkit_geometry::Path;
    /// let slot = Path::slot([0.0, 0.0], [3.0, 4.0], 1.5);
    /// // A rectangle of 5 mm by 3 mm and two half discs.
    /// let area_mm2 = 5.0 * 3.0 + std::f64::consts::PI * 1.5 * 1.5;
    /// assert!((slot.signed_area_mm2() - area_mm2).abs() < 1e-12);
    /// ```
    pub fn slot(from: [f64; 2], to: [f64; 2], radius_mm: f64) -> Self {
        let d = [to[0] - from[0], to[1] - from[1]];
        let scale = radius_mm / d[0].hypot(d[1]);
        let n = [-d[1] * scale, d[0] * scale];
        let left = |p: [f64; 2]| [p[0] + n[0], p[1] + n[1]];
        let right = |p: [f64; 2]| [p[0] - n[0], p[1] - n[1]];
        Self::from(right(from)).line(right(to)).arc(left(to), to, true).line(left(from)).arc(
            right(from),
            from,
            true,
        )
    }

    /// Returns the path translated by `by_mm`.
    #[must_use]
    pub fn shifted(&self, by_mm: [f64; 2]) -> Self {
        self.mapped(|[x, y]| [x + by_mm[0], y + by_mm[1]])
    }

    /// Returns the path after an exact quarter turn counter-clockwise about the origin.
    ///
    /// Arcs of ellipses keep their half axes along x and y, which are exchanged.
    ///
    /// ```
    /// use fabkit_geometry::Path;
    /// let slot = Path::slot([0.0, 2.0], [6.0, 2.0], 1.0);
    /// let turned = slot.quarter_turned();
    /// assert_eq!(turned.start, [-1.0, 0.0]); // was [0, 1]
    /// assert_eq!(turned.signed_area_mm2(), slot.signed_area_mm2());
    /// ```
    #[must_use]
    pub fn quarter_turned(&self) -> Self {
        let mut turned = self.mapped(|[x, y]| [-y, x]);
        for segment in &mut turned.segments {
            if let Segment::EllipticArc { semi_axes_mm, .. } = segment {
                semi_axes_mm.reverse();
            }
        }
        turned
    }

    /// Returns the path scaled about the origin by a factor above 0.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.mapped(|point| point.map(|x| x * factor));
        for segment in &mut scaled.segments {
            if let Segment::EllipticArc { semi_axes_mm, .. } = segment {
                *semi_axes_mm = semi_axes_mm.map(|axis| axis * factor);
            }
        }
        scaled
    }

    /// Returns the offset curve at a distance outside a convex path that runs counter-clockwise: corners become arcs,
    /// and the radii of arcs grow. Lines and circular arcs only; arcs of ellipses stay as they are.
    ///
    /// ```
    /// use fabkit_geometry::Path;
    /// let square = Path::rectangle([0.0, 0.0], [4.0, 4.0], 0.0).offset_outwards(1.0);
    /// let area_mm2 = 16.0 + 4.0 * 4.0 + std::f64::consts::PI; // Steiner's formula
    /// assert!((square.signed_area_mm2() - area_mm2).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn offset_outwards(&self, by_mm: f64) -> Self {
        let mut grown: Option<Self> = None;
        let mut from = self.start;
        for segment in &self.segments {
            let to = segment.to();
            let (start, moved) = segment.offset_right(from, by_mm);
            grown = Some(match grown {
                None => Self::from(start),
                Some(path) => path.around_corner(from, start),
            });
            if let Some(path) = &mut grown {
                path.segments.push(moved);
            }
            from = to;
        }
        match grown {
            None => self.clone(),
            Some(mut path) => {
                let start = path.start;
                path = path.around_corner(from, start);
                // The curve must close exactly, not just up to rounding.
                if let Some(last) = path.segments.last_mut() {
                    last.set_to(start);
                }
                path
            }
        }
    }

    /// Continues to `to` by an arc around a corner that has the same distance from both ends.
    fn around_corner(self, corner: [f64; 2], to: [f64; 2]) -> Self {
        let end = self.end();
        let gap_mm = (end[0] - to[0]).hypot(end[1] - to[1]);
        let far_mm = (to[0] - corner[0]).hypot(to[1] - corner[1]);
        if gap_mm <= SAME_POINT * far_mm { self } else { self.arc(to, corner, true) }
    }

    /// Maps every point; `to_new` must keep angles and must not mirror.
    fn mapped(&self, to_new: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        let mut path = self.clone();
        path.start = to_new(path.start);
        for segment in &mut path.segments {
            match segment {
                Segment::Line { to } => *to = to_new(*to),
                Segment::Arc { to, centre, .. } | Segment::EllipticArc { to, centre, .. } => {
                    (*to, *centre) = (to_new(*to), to_new(*centre));
                }
            }
        }
        path
    }

    /// Creates a sector of a ring around the origin, from `start` counter-clockwise to `end`.
    ///
    /// ```
    /// use fabkit_geometry::{Angle, Path};
    /// let [start, end] = [30.0, 120.0].map(|deg| Angle::from_deg(deg).unwrap());
    /// let sector = Path::ring_sector(3.0, 5.0, start, end);
    /// let quarter_mm2 = std::f64::consts::PI * (5.0 * 5.0 - 3.0 * 3.0) / 4.0;
    /// assert!((sector.signed_area_mm2() - quarter_mm2).abs() < 1e-12);
    /// ```
    pub fn ring_sector(inner_mm: f64, outer_mm: f64, start: Angle, end: Angle) -> Self {
        let at = |r: f64, a: Angle| [r * a.rad().cos(), r * a.rad().sin()];
        Self::from(at(inner_mm, start))
            .line(at(outer_mm, start))
            .arc(at(outer_mm, end), [0.0, 0.0], true)
            .line(at(inner_mm, end))
            .arc(at(inner_mm, start), [0.0, 0.0], false)
    }
}

/// Region of the plane: inside `outer` and outside all `holes`.
///
/// Paths must not cross themselves or each other, and holes lie inside the outer path and in no other hole; their
/// direction does not matter.
///
/// ```
/// use fabkit_geometry::{CompiledSolid, Path, Point3, Profile, Solid};
/// let washer = Profile::new(Path::circle([0.0, 0.0], 5.0)).with_hole(Path::circle([0.0, 0.0], 2.0));
/// let solid = CompiledSolid::new(&Solid::extrusion(washer, 1.0))?;
/// assert!(
///     solid.contains(&Point3::new(3.0, 0.0, 0.5)) && !solid.contains(&Point3::new(1.0, 0.0, 0.5))
/// );
/// // A hole outside of the outline is refused.
/// let wrong = Profile::new(Path::circle([0.0, 0.0], 5.0)).with_hole(Path::circle([9.0, 0.0], 2.0));
/// assert!(CompiledSolid::new(&Solid::extrusion(wrong, 1.0)).is_err());
/// # Ok::<(), fabkit_geometry::InvalidSolid>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Outer boundary.
    pub outer: Path,
    /// Boundaries of holes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holes: Vec<Path>,
}

impl Profile {
    /// Creates a region without holes.
    pub fn new(outer: Path) -> Self {
        Self { outer, holes: Vec::new() }
    }

    /// Adds a hole.
    #[must_use]
    pub fn with_hole(mut self, hole: Path) -> Self {
        self.holes.push(hole);
        self
    }

    /// Returns the outer boundary first, then the holes: the order in which faces are numbered.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        std::iter::once(&self.outer).chain(&self.holes)
    }

    /// Returns the region translated by `by_mm`.
    #[must_use]
    pub fn shifted(&self, by_mm: [f64; 2]) -> Self {
        self.mapped(|path| path.shifted(by_mm))
    }

    /// Returns the region scaled about the origin by a factor above 0.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        self.mapped(|path| path.scaled(factor))
    }

    /// Returns the region after an exact quarter turn counter-clockwise about the origin.
    #[must_use]
    pub fn quarter_turned(&self) -> Self {
        self.mapped(Path::quarter_turned)
    }

    fn mapped(&self, to_new: impl Fn(&Path) -> Path) -> Self {
        Self { outer: to_new(&self.outer), holes: self.holes.iter().map(to_new).collect() }
    }
}

impl From<Path> for Profile {
    fn from(outer: Path) -> Self {
        Self::new(outer)
    }
}
