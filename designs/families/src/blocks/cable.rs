//! Cables and wires as solids: round, along a path of straight pieces and bends, with a plug at the end.
//!
//! A path is a list of corners; each inner corner is rounded by the same bend radius. Pieces overlap, and a bend is
//! slightly thicker than the straight pieces, so that their faces intersect and never coincide.

use fabkit_geometry::{Length, Order, Point3, Pose, Solid, Vector3};

use super::INTO_MM;
use crate::parameters::RuleReport;

/// Distance by which a cable gives way to a body that passes it, mm: it is laid in last and can be pushed aside.
pub const GIVE_WAY_MM: f64 = 3.0;

/// Ordered length of a wire from a sensor's LEDs to their supply, mm; chosen: from a gripper to a box beside it, plus
/// offcuts.
const WIRE_MM: f64 = 500.0;

/// Returns the order of a wire for the LEDs, by its diameter over the insulation.
pub fn wire_order(diameter: Length) -> Order {
    let thick = format!("{} mm over its insulation", diameter.mm());
    Order::new("stranded wire", thick).cut_to(WIRE_MM)
}

/// Smallest excess of a bend's radius over that of the straight pieces, mm.
const SWELL_MM: f64 = 0.01;

/// Turns below this angle are treated as straight.
const STRAIGHT_RAD: f64 = 1e-6;

/// Cable along a path.
///
/// ```
/// use fabkit_designs::blocks::cable::Cable;
/// use fabkit_geometry::Point3;
/// use std::f64::consts::FRAC_PI_2;
/// // Down 20 mm, then 30 mm to the side, with a quarter circle of 5 mm in between.
/// let corners = [[0.0, 0.0, 20.0], [0.0; 3], [30.0, 0.0, 0.0]].map(Point3::from);
/// let cable = Cable { diameter_mm: 3.0, bend_mm: 5.0, corners: corners.to_vec() };
/// assert!((cable.length_mm() - (15.0 + 25.0 + 5.0 * FRAC_PI_2)).abs() < 1e-9);
/// assert!((cable.least_straight_mm() - 15.0).abs() < 1e-9);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Cable {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Bend radius to the cable's centre line, mm.
    pub bend_mm: f64,
    /// Start, corners and end of the path, mm.
    pub corners: Vec<Point3<f64>>,
}

/// One bend.
struct Bend {
    /// Corner that it rounds.
    corner: Point3<f64>,
    /// Unit vectors of the path before and behind the corner.
    way: [Vector3<f64>; 2],
    /// Distance from the corner at which the bend begins and ends, mm.
    reach_mm: f64,
}

impl Cable {
    /// Returns the solid of the cable, which has at least one straight piece.
    pub fn solid(&self) -> Solid {
        let bends = self.bends();
        let count = bends.len();
        let reach = |i: usize| bends[i].reach_mm;
        let ends = self.corners.windows(2).enumerate().map(|(i, ends)| {
            let before = if i == 0 { 0.0 } else { reach(i - 1) - INTO_MM };
            let behind = if i == count { 0.0 } else { reach(i) - INTO_MM };
            let way = (ends[1] - ends[0]).normalize();
            let length = (ends[1] - ends[0]).norm() - before - behind;
            Solid::cylinder(self.diameter_mm / 2.0, length)
                .placed(Pose::z_to(way, ends[0] + before * way))
                .named(format!("straight piece {}", i + 1))
        });
        let round = bends
            .iter()
            .zip(1..)
            .filter(|(bend, _)| bend.reach_mm > 0.0)
            .map(|(bend, number)| self.round(bend).named(format!("bend {number}")));
        let mut pieces: Vec<Solid> = ends.chain(round).collect();
        if pieces.len() == 1 { pieces.remove(0) } else { Solid::union(pieces) }
    }

    /// Returns a box for a plug at the path's end, aligned with its last piece: edges across (along `up` and
    /// perpendicular to it) and length, mm.
    pub fn plug(&self, up: Vector3<f64>, [height, width, length]: [f64; 3]) -> Solid {
        let last = &self.corners[self.corners.len() - 2..];
        let way = (last[1] - last[0]).normalize();
        let at = last[1] - INTO_MM * way;
        // The cuboid stands on its origin: z points along the cable, x along `up`.
        let pose = Pose::with_axes([up, way.cross(&up), way], at)
            .expect("a plug's up is a unit vector across its cable");
        Solid::cuboid(height, width, length + INTO_MM).placed(pose).named("plug")
    }

    /// Returns the length of the shortest straight piece that the bends leave, mm; negative if the path is too short
    /// for them.
    pub fn least_straight_mm(&self) -> f64 {
        let bends = self.bends();
        let reach =
            |i: Option<usize>| i.and_then(|i| bends.get(i)).map_or(0.0, |bend| bend.reach_mm);
        let pieces = self.corners.windows(2).enumerate();
        let left = pieces
            .map(|(i, ends)| (ends[1] - ends[0]).norm() - reach(i.checked_sub(1)) - reach(Some(i)));
        left.fold(f64::INFINITY, f64::min)
    }

    /// Reports a bend radius, the value `bend` of the parameter `path`, that is smaller than `times` the cable's
    /// diameter.
    pub fn check(&self, path: &str, bend: Length, times: f64, report: &mut RuleReport) {
        let least = times * self.diameter_mm;
        report.at_least(path, bend, least, "what is bent more breaks in the end");
    }

    /// Returns the length along the centre line, mm.
    pub fn length_mm(&self) -> f64 {
        let straight: f64 = self.corners.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        // Each bend replaces two straight reaches by an arc.
        let shorter = self.bends().into_iter().map(|bend| {
            let turn = 2.0 * (bend.reach_mm / self.bend_mm).atan();
            2.0 * bend.reach_mm - self.bend_mm * turn
        });
        straight - shorter.sum::<f64>()
    }

    /// Returns the bends at all inner corners.
    fn bends(&self) -> Vec<Bend> {
        let corners = self.corners.windows(3);
        let bends = corners.map(|at| {
            let way = [(at[1] - at[0]).normalize(), (at[2] - at[1]).normalize()];
            let turn = way[0].dot(&way[1]).clamp(-1.0, 1.0).acos();
            let reach_mm =
                if turn < STRAIGHT_RAD { 0.0 } else { self.bend_mm * (turn / 2.0).tan() };
            Bend { corner: at[1], way, reach_mm }
        });
        bends.collect()
    }

    /// Returns a sector of a torus.
    fn round(&self, bend: &Bend) -> Solid {
        let [come, go] = bend.way;
        let axis = come.cross(&go).normalize();
        let from = bend.corner - bend.reach_mm * come;
        let centre = from + self.bend_mm * axis.cross(&come);
        // A straight piece continues tangentially into the bend, and departs from its centre line by the first term.
        let swell = INTO_MM.powi(2) / (2.0 * self.bend_mm) + SWELL_MM;
        Solid::torus(self.bend_mm, self.diameter_mm / 2.0 + swell)
            .placed(Pose::z_to(axis, centre))
            .and(Solid::behind(centre, -come))
            .and(Solid::behind(centre, go))
    }
}
