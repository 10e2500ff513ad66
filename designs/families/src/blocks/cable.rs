//! Cables and wires as bodies: round, along a path of straight pieces and bends, with a plug at its end.
//!
//! A path is a list of corners; each inner corner is rounded by one bend radius. Pieces reach into each
//! other: a bend is thicker than the straight pieces by a hair, so that their faces cross and never coincide.

use fabkit_geometry::{Length, Order, Point3, Pose, Solid, Vector3};

use super::INTO_MM;
use crate::parameters::Report;

/// How far a cable is pushed aside by what passes it, mm: it is laid in, and laid out of the way.
pub const GIVES_MM: f64 = 3.0;

/// Length of a wire from a sensor's lamps to what feeds them, as it is ordered, mm; chosen: from a gripper to a
/// box beside it, and the ends that are cut off.
const WIRE_MM: f64 = 500.0;

/// A wire of the lamps as it is ordered, by its diameter over its insulation.
pub fn wire_order(diameter: Length) -> Order {
    let thick = format!("{} mm over its insulation", diameter.mm());
    Order::of("stranded wire", thick).cut_to(WIRE_MM)
}

/// How much thicker a bend is than its least, mm.
const SWELL_MM: f64 = 0.01;

/// Corners at which a path turns by less are none.
const STRAIGHT_RAD: f64 = 1e-6;

/// A cable along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Cable {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Radius of its bends, to its middle, mm.
    pub bend_mm: f64,
    /// Where it starts, where it turns and where it ends, mm.
    pub corners: Vec<Point3<f64>>,
}

/// One bend.
struct Bend {
    /// Which corner it rounds.
    corner: Point3<f64>,
    /// The unit vectors in which the path comes and goes.
    way: [Vector3<f64>; 2],
    /// How far before and behind the corner it begins and ends, mm.
    reach_mm: f64,
}

impl Cable {
    /// The cable as a solid; it has one straight piece at least.
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

    /// A box around the path's end, out along its last piece, for a plug: its edges across (along `up` and
    /// beside it) and its length, mm.
    pub fn plug(&self, up: Vector3<f64>, [height, width, length]: [f64; 3]) -> Solid {
        let last = &self.corners[self.corners.len() - 2..];
        let way = (last[1] - last[0]).normalize();
        let at = last[1] - INTO_MM * way;
        // The cuboid stands on its origin: z along the way, x along `up`.
        let pose = Pose::with_axes([up, way.cross(&up), way], at)
            .expect("a plug's up is a unit vector across its cable");
        Solid::cuboid(height, width, length + INTO_MM).placed(pose).named("plug")
    }

    /// The least length of a straight piece that its bends leave, mm; below 0 the path is too short for them.
    pub fn least_straight_mm(&self) -> f64 {
        let bends = self.bends();
        let reach =
            |i: Option<usize>| i.and_then(|i| bends.get(i)).map_or(0.0, |bend| bend.reach_mm);
        let pieces = self.corners.windows(2).enumerate();
        let left = pieces
            .map(|(i, ends)| (ends[1] - ends[0]).norm() - reach(i.checked_sub(1)) - reach(Some(i)));
        left.fold(f64::INFINITY, f64::min)
    }

    /// Reports a cable, the radius of whose bends is the parameter `path`, that is bent more than
    /// `times` its diameter allows.
    pub fn check(&self, path: &str, bend: Length, times: f64, report: &mut Report) {
        let least = times * self.diameter_mm;
        report.at_least(path, bend, least, "what is bent more breaks in the end");
    }

    /// How long it is along its middle, mm.
    pub fn length_mm(&self) -> f64 {
        let straight: f64 = self.corners.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        let shorter = self.bends().into_iter().map(|bend| {
            let turn = 2.0 * (bend.reach_mm / self.bend_mm).atan();
            2.0 * bend.reach_mm - self.bend_mm * turn
        });
        straight - shorter.sum::<f64>()
    }

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

    /// A sector of a torus.
    fn round(&self, bend: &Bend) -> Solid {
        let [come, go] = bend.way;
        let axis = come.cross(&go).normalize();
        let from = bend.corner - bend.reach_mm * come;
        let centre = from + self.bend_mm * axis.cross(&come);
        // A straight piece that goes on into the bend leaves its middle by this.
        let swell = INTO_MM.powi(2) / (2.0 * self.bend_mm) + SWELL_MM;
        Solid::torus(self.bend_mm, self.diameter_mm / 2.0 + swell)
            .placed(Pose::z_to(axis, centre))
            .and(Solid::behind(centre, -come))
            .and(Solid::behind(centre, go))
    }
}
