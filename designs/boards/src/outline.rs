//! Geometry of a board: its exact outline, its holes and its thickness.

use fabkit_geometry::{Body, Path, Profile, Segment, Solid};

use crate::BoardError;
use crate::shapes::{Point, Shape};

/// Largest distance of flattened arcs from the exact ones, mm: a tenth of the accuracy that any reader needs.
const CHORD_MM: f64 = 0.0005;

/// Outline, holes and thickness of a board's body.
///
/// ```
/// use fabkit_boards::{BoardShape, Shape};
/// use fabkit_geometry::{Body, Path, Process, Profile, Solid};
/// let ring = Profile::new(Path::circle([0.0; 2], 12.0)).with_hole(Path::circle([0.0; 2], 5.0));
/// let ring = Body::made("led-board", "carries LEDs", Process::Pcb, Solid::extrusion(ring, 1.6));
/// let board = BoardShape::from_body(&ring)?;
/// assert_eq!((board.annulus_mm(), board.thickness_mm), (Some([5.0, 12.0]), 1.6));
/// // A pad of 1 mm in the middle of the ring is 3 mm away from either edge.
/// assert!((board.edge_distance_mm(&Shape::disc([8.5, 0.0], 1.0)) - 3.0).abs() < 1e-9);
/// # Ok::<(), fabkit_boards::BoardError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BoardShape {
    /// Name of the body.
    pub name: String,
    /// Outline and holes in the sensor's x and y, mm.
    pub profile: Profile,
    /// Thickness, mm.
    pub thickness_mm: f64,
    /// Outline as a closed loop of short lines.
    pub edge: Vec<Point>,
    /// Milled or drilled holes as closed loops of short lines, in the order of the profile.
    pub holes: Vec<Vec<Point>>,
    /// Radius of the outline if it is a circle about the axis, mm.
    circle_mm: Option<f64>,
    round_holes: Vec<Option<RoundHole>>,
}

/// Circular hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundHole {
    /// Centre, mm.
    pub at_mm: Point,
    /// Diameter, mm.
    pub diameter_mm: f64,
}

impl BoardShape {
    /// Reads the outline from the body of a horizontal plate.
    ///
    /// # Errors
    /// [`BoardError::NotAPlate`] for any other body.
    ///
    /// ```
    /// use fabkit_boards::{BoardError, BoardShape};
    /// use fabkit_geometry::{Body, Process, Solid};
    /// let ball = Body::made("ball", "is round", Process::Pcb, Solid::sphere(5.0));
    /// assert_eq!(
    ///     BoardShape::from_body(&ball),
    ///     Err(BoardError::NotAPlate { board: "ball".into() })
    /// );
    /// ```
    pub fn from_body(body: &Body) -> Result<Self, BoardError> {
        let mut solid = &body.solid;
        loop {
            match solid {
                Solid::Placed { pose, of } => {
                    let [x, y, _] = (*pose.translation_mm()).into();
                    // Only heights may change: no rotation and no shift in the plane.
                    let is_level = (pose.vector(fabkit_geometry::Vector3::x()).x - 1.0).abs()
                        < 1e-12
                        && (pose.vector(fabkit_geometry::Vector3::y()).y - 1.0).abs() < 1e-12;
                    if !is_level || x != 0.0 || y != 0.0 {
                        return Err(BoardError::NotAPlate { board: body.name.clone() });
                    }
                    solid = of;
                }
                Solid::Feature { of, .. } => solid = of,
                Solid::Extrusion(one) => {
                    let edge = flatten(&one.profile.outer);
                    let holes = one.profile.holes.iter().map(flatten).collect();
                    let outer =
                        as_circle(&one.profile.outer).filter(|circle| circle.at_mm == [0.0; 2]);
                    return Ok(Self {
                        circle_mm: outer.map(|circle| circle.diameter_mm / 2.0),
                        round_holes: one.profile.holes.iter().map(as_circle).collect(),
                        name: body.name.clone(),
                        profile: one.profile.clone(),
                        thickness_mm: one.height_mm,
                        edge,
                        holes,
                    });
                }
                _ => return Err(BoardError::NotAPlate { board: body.name.clone() }),
            }
        }
    }

    /// Returns the hole with this index if it is a circle.
    pub fn round_hole(&self, index: usize) -> Option<RoundHole> {
        *self.round_holes.get(index)?
    }

    /// Distance of a shape from the nearest edge, mm; negative if the shape is not wholly on the board.
    pub fn edge_distance_mm(&self, shape: &Shape) -> f64 {
        let to_lines = |points: &[Point]| {
            lines(points).map(|edge| shape.distance_to_segment(edge)).fold(f64::INFINITY, f64::min)
        };
        let corners = shape.corners();
        let outer = match self.circle_mm {
            Some(radius) => {
                // Exact for a circle, where the flattened outline would cost up to `CHORD_MM`.
                let far = corners.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
                radius - far - shape.radius_mm()
            }
            None if corners.iter().all(|p| is_within(&self.edge, *p)) => to_lines(&self.edge),
            // Off the board. `to_lines` is the distance less the radius, and the farthest point lies a radius beyond.
            None => -to_lines(&self.edge).abs() - 2.0 * shape.radius_mm(),
        };
        let hole = |(index, points): (usize, &Vec<Point>)| match self.round_hole(index) {
            Some(hole) => shape.distance_to_point(hole.at_mm) - hole.diameter_mm / 2.0,
            None if corners.iter().any(|p| is_within(points, *p)) => {
                -to_lines(points).abs() - 2.0 * shape.radius_mm()
            }
            None => to_lines(points),
        };
        self.holes.iter().enumerate().map(hole).fold(outer, f64::min)
    }

    /// Distance of a point from the nearest edge, mm; negative if the point is not on the board.
    ///
    /// ```
    /// use fabkit_boards::BoardShape;
    /// use fabkit_geometry::{Body, Path, Process, Solid};
    /// let plate = Solid::extrusion(Path::circle([0.0; 2], 10.0), 1.6);
    /// let board = BoardShape::from_body(&Body::made("disc", "a disc", Process::Pcb, plate))?;
    /// assert_eq!(board.point_edge_distance_mm([6.0, 0.0]), 4.0);
    /// assert_eq!(board.point_edge_distance_mm([0.0, 11.0]), -1.0);
    /// # Ok::<(), fabkit_boards::BoardError>(())
    /// ```
    pub fn point_edge_distance_mm(&self, p: Point) -> f64 {
        self.edge_distance_mm(&Shape::disc(p, 0.0))
    }

    /// Largest distance of the outline from the axis, mm.
    pub fn max_radius_mm(&self) -> f64 {
        self.edge.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max)
    }

    /// Inner and outer radius, mm, if the outline and its first hole are circles about the axis.
    pub fn annulus_mm(&self) -> Option<[f64; 2]> {
        let bore = self.round_hole(0)?;
        let outer = self.circle_mm?;
        (bore.at_mm == [0.0; 2]).then_some([bore.diameter_mm / 2.0, outer])
    }
}

/// Returns the circle that a closed path describes, if all its segments are arcs about one centre.
fn as_circle(path: &Path) -> Option<RoundHole> {
    let mut centres = path.segments.iter().map(|segment| match segment {
        Segment::Arc { centre, .. } => Some(*centre),
        _ => None,
    });
    let at_mm = centres.next()??;
    if !centres.all(|centre| centre == Some(at_mm)) {
        return None;
    }
    let [x, y] = path.start;
    Some(RoundHole { at_mm, diameter_mm: 2.0 * (x - at_mm[0]).hypot(y - at_mm[1]) })
}

/// Iterates over the lines of a closed loop.
pub fn lines(points: &[Point]) -> impl Iterator<Item = [Point; 2]> + '_ {
    (0..points.len()).map(|i| [points[i], points[(i + 1) % points.len()]])
}

/// Returns whether a point lies inside a closed loop: a ray from it crosses the loop an odd number of times.
fn is_within(points: &[Point], [x, y]: Point) -> bool {
    let crosses = |[a, b]: [Point; 2]| {
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    lines(points).filter(|line| crosses(*line)).count() % 2 == 1
}

/// Flattens a path to a closed loop of short lines.
fn flatten(path: &Path) -> Vec<Point> {
    let mut points = vec![path.start];
    for segment in &path.segments {
        let from = *points.last().expect("it has a start");
        if let Segment::Arc { to, centre, ccw } = *segment {
            let [start, end] = [from, to].map(|p| (p[1] - centre[1]).atan2(p[0] - centre[0]));
            let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
            let turn = std::f64::consts::TAU;
            let mut sweep = if ccw { end - start } else { start - end }.rem_euclid(turn);
            // A sweep of 0 means a full circle in one arc.
            if sweep < 1e-9 {
                sweep = turn;
            }
            // The chord of an angle `step` deviates from its arc by `CHORD_MM`.
            let step = 2.0 * (1.0 - (CHORD_MM / radius).min(1.0)).acos();
            let count = (sweep / step).ceil().max(1.0) as usize;
            for i in 1..count {
                let angle = start + if ccw { 1.0 } else { -1.0 } * sweep * i as f64 / count as f64;
                points.push([centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]);
            }
        }
        points.push(segment.to());
    }
    // The last point repeats the first one.
    points.pop();
    points
}
