//! Exact plane shapes and the distances between them: convex polygons, widened by a radius.

/// A point in the sensor's x and y, mm.
pub type Point = [f64; 2];

/// All points within a radius of a convex polygon with one (disc), two (track) or more (pad) corners.
///
/// ```
/// use fabkit_boards::Shape;
/// let track = Shape::track([0.0, 0.0], [10.0, 0.0], 0.2);
/// let via = Shape::disc([5.0, 1.0], 0.5);
/// // 1 mm between their middles, less half of either width.
/// assert!((track.distance(&via) - 0.65).abs() < 1e-12);
/// assert!(track.contains([10.1, 0.0]) && !track.contains([10.0, 0.2]));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    corners: Vec<Point>,
    radius_mm: f64,
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Distance between a point and a line segment, mm.
pub fn point_segment_distance(p: Point, [a, b]: [Point; 2]) -> f64 {
    let along = sub(b, a);
    let length2 = dot(along, along);
    let t = if length2 > 0.0 { (dot(sub(p, a), along) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let foot = [a[0] + t * along[0], a[1] + t * along[1]];
    (p[0] - foot[0]).hypot(p[1] - foot[1])
}

/// Distance between two line segments, mm; 0 if they cross.
pub fn segment_distance(one: [Point; 2], other: [Point; 2]) -> f64 {
    // Each segment has the ends of the other on different sides: they cross.
    let side = |[a, b]: [Point; 2], p: Point| cross(sub(b, a), sub(p, a));
    let (s0, s1) = (side(one, other[0]), side(one, other[1]));
    let (t0, t1) = (side(other, one[0]), side(other, one[1]));
    if s0 * s1 < 0.0 && t0 * t1 < 0.0 {
        return 0.0;
    }
    let ends = [
        point_segment_distance(one[0], other),
        point_segment_distance(one[1], other),
        point_segment_distance(other[0], one),
        point_segment_distance(other[1], one),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

impl Shape {
    /// Returns a disc.
    pub fn disc(centre: Point, diameter_mm: f64) -> Self {
        Self { corners: vec![centre], radius_mm: diameter_mm / 2.0 }
    }

    /// Returns a straight track with round ends.
    pub fn track(a: Point, b: Point, width_mm: f64) -> Self {
        Self { corners: vec![a, b], radius_mm: width_mm / 2.0 }
    }

    /// Returns a convex polygon with these corners, counter-clockwise or clockwise. Its bounds are right for any
    /// polygon.
    pub fn polygon(corners: Vec<Point>) -> Self {
        Self { corners, radius_mm: 0.0 }
    }

    /// Corners of the polygon: one of a disc, two of a track.
    pub fn corners(&self) -> &[Point] {
        &self.corners
    }

    /// Distance by which the shape extends beyond its polygon, mm.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Width of a track, diameter of a disc, or shorter edge of a rectangle, mm.
    pub fn width_mm(&self) -> f64 {
        match self.corners[..] {
            [a, b, c, ..] => {
                let edge = |p: Point, q: Point| (p[0] - q[0]).hypot(p[1] - q[1]);
                edge(a, b).min(edge(b, c)) + 2.0 * self.radius_mm
            }
            _ => 2.0 * self.radius_mm,
        }
    }

    /// Centre: the mean of the corners, mm.
    pub fn centre(&self) -> Point {
        let n = self.corners.len() as f64;
        let sum = self.corners.iter().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        [sum[0] / n, sum[1] / n]
    }

    /// Returns the shape enlarged on all sides. The corners of a rectangle stay sharp.
    ///
    /// ```
    /// use fabkit_boards::Shape;
    /// let pad = Shape::polygon(vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
    /// // The opening of the mask: 0.05 mm more on each side.
    /// let opening = pad.enlarged_by(0.05);
    /// assert_eq!(opening.bounds(), [[-0.05, -0.05], [2.05, 1.05]]);
    /// assert!((opening.width_mm() - 1.1).abs() < 1e-12);
    /// ```
    #[must_use]
    pub fn enlarged_by(&self, by_mm: f64) -> Self {
        let [a, b, c, d] = self.corners[..] else {
            return Self { radius_mm: self.radius_mm + by_mm, ..self.clone() };
        };
        let unit = |p: Point, q: Point| {
            let length = (q[0] - p[0]).hypot(q[1] - p[1]);
            [(q[0] - p[0]) / length * by_mm, (q[1] - p[1]) / length * by_mm]
        };
        // Edges of the rectangle, scaled to the margin.
        let (u, v) = (unit(a, b), unit(b, c));
        let at =
            |p: Point, s: f64, t: f64| [p[0] + s * u[0] + t * v[0], p[1] + s * u[1] + t * v[1]];
        Self {
            corners: vec![at(a, -1.0, -1.0), at(b, 1.0, -1.0), at(c, 1.0, 1.0), at(d, -1.0, 1.0)],
            radius_mm: self.radius_mm,
        }
    }

    fn edges(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        let n = self.corners.len();
        // A track has one edge, not one there and one back. A disc has one of length 0.
        let count = if n == 2 { 1 } else { n };
        (0..count).map(move |i| [self.corners[i], self.corners[(i + 1) % n]])
    }

    /// Returns whether a point lies inside the shape or on its edge.
    pub fn contains(&self, p: Point) -> bool {
        self.distance_to_point(p) <= 0.0
    }

    fn polygon_contains(&self, p: Point) -> bool {
        if self.corners.len() < 3 {
            return false;
        }
        let sides: Vec<f64> = self.edges().map(|[a, b]| cross(sub(b, a), sub(p, a))).collect();
        // On the same side of all edges, whichever way round the corners are.
        sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
    }

    /// Distance of a point from the shape, mm; 0 or negative inside.
    pub fn distance_to_point(&self, p: Point) -> f64 {
        if self.polygon_contains(p) {
            return -self.radius_mm;
        }
        let lines = self.edges().map(|edge| point_segment_distance(p, edge));
        lines.fold(f64::INFINITY, f64::min) - self.radius_mm
    }

    /// Distance of a line segment from the shape, mm; 0 or negative if they touch.
    pub fn distance_to_segment(&self, line: [Point; 2]) -> f64 {
        if self.polygon_contains(line[0]) {
            return -self.radius_mm;
        }
        let lines = self.edges().map(|edge| segment_distance(edge, line));
        lines.fold(f64::INFINITY, f64::min) - self.radius_mm
    }

    /// Clear distance between two shapes, mm; 0 or negative if they touch.
    pub fn distance(&self, other: &Self) -> f64 {
        // One within the other: their edges may be far apart.
        if self.polygon_contains(other.corners[0]) || other.polygon_contains(self.corners[0]) {
            return -self.radius_mm - other.radius_mm;
        }
        let lines = self.edges().map(|edge| other.distance_to_segment(edge));
        lines.fold(f64::INFINITY, f64::min) - self.radius_mm
    }

    /// Bounding box: smallest and largest x and y, mm.
    pub fn bounds(&self) -> [Point; 2] {
        let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let [low, high] = self.corners.iter().fold(start, |[low, high], p| {
            [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
        });
        let r = self.radius_mm;
        [[low[0] - r, low[1] - r], [high[0] + r, high[1] + r]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64) -> Shape {
        Shape::polygon(vec![[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]])
    }

    #[test]
    fn distances_between_shapes_are_exact() {
        assert_eq!(square(0.0).distance(&square(1.5)), 0.5);
        assert_eq!(square(0.0).distance(&Shape::disc([3.0, 0.5], 1.0)), 1.5);
        assert_eq!(Shape::disc([3.0, 0.5], 1.0).distance(&square(0.0)), 1.5);
        let (a, b) = ([0.0, 2.0], [5.0, 2.0]);
        assert_eq!(square(0.0).distance(&Shape::track(a, b, 0.5)), 0.75);
        assert!(square(0.0).distance(&Shape::track([0.5, 0.5], [9.0, 9.0], 0.2)) <= 0.0);
    }

    #[test]
    fn crossing_segments_have_distance_zero() {
        let (one, other) = ([[0.0, 0.0], [2.0, 2.0]], [[0.0, 2.0], [2.0, 0.0]]);
        assert_eq!(segment_distance(one, other), 0.0);
        assert_eq!(segment_distance(one, [[3.0, 0.0], [3.0, 5.0]]), 1.0);
    }

    #[test]
    fn an_enlarged_rectangle_stays_a_rectangle() {
        let grown = square(0.0).enlarged_by(0.5);
        assert_eq!(grown.bounds(), [[-0.5, -0.5], [1.5, 1.5]]);
        assert!(grown.contains([1.4, 1.4]) && !square(0.0).contains([1.4, 1.4]));
    }
}
