//! Mounting of a sensor: by the user's screws in its floor, or by bolts through its plate into the flange of a robot.

use fabkit_geometry::{Angle, Body, CUT_OVERLAP_MM, CutFeature, Length, Placement, Pose, Solid};

use super::{ScrewJoint, around, copies, corners, hanging, landmarks_at, ring};
use crate::chain_builder::bought;
use crate::hardware::{HeatSetNut, Screw, SocketScrew};
use crate::parameters::{RuleReport, limits};
use crate::{choices, parameters};

/// Thread engagement in a robot's flange, mm.
const BOLT_BITE_MM: f64 = 6.0;

/// Smallest distance between the heads of two bolts, mm.
const HEADS_APART_MM: f64 = 1.0;

/// Smallest distance between a bolt's head and the wall around it, mm.
const HEAD_IN_WALL_MM: f64 = 0.5;

choices! {
    /// Pattern of the mounting holes.
    pub enum MountPattern {
        /// Holes on a circle.
        Ring = "ring",
        /// Holes at the corners of a rectangle.
        Rectangle = "rectangle",
        /// List of positions.
        List = "list",
    }
}

choices! {
    /// Threads of mounting screws.
    pub enum MountThread {
        /// M2.
        M2 = "M2",
        /// M2.5.
        M2_5 = "M2.5",
        /// M3.
        M3 = "M3",
        /// M4.
        M4 = "M4",
        /// M5.
        M5 = "M5",
    }
}

choices! {
    /// Features that hold the mounting screws.
    pub enum MountHold {
        /// Plastic into which the screws cut their threads.
        Tapped = "tapped",
        /// Threaded inserts that are melted in.
        Insert = "insert",
        /// Shorter threaded inserts, for a thin floor.
        ShortInsert = "short-insert",
        /// Holes through which the screws pass from inside, into what the sensor is mounted on.
        Through = "through",
    }
}

parameters! {
    /// Holes by which the sensor is mounted.
    pub struct Mount {
        /// Pattern of the holes: `ring` with the number that `base` gives, or two in a rectangular housing; `rectangle`
        /// with four corners; `list` of positions `x` and `y`.
        pattern: MountPattern,
        /// Angle by which the pattern is turned around the sensor's axis.
        angle: Angle = -180.0..=180.0,
        /// For a rectangle: distance between the holes along x.
        width: Length = 4.0..=120.0,
        /// For a rectangle: distance between the holes along y.
        depth: Length = 4.0..=120.0,
        /// For a list: x of each hole.
        x: Vec<Length> = (1..=12, -70.0..=70.0),
        /// For a list: y of each hole.
        y: Vec<Length> = (1..=12, -70.0..=70.0),
        /// Thread of the mounting screws.
        thread: MountThread,
        /// Feature that holds the screws: `tapped` plastic into which they cut their thread, an `insert` that is melted
        /// in, a `short-insert` (M3: 4 mm long), or none, so that the screws go `through` from inside.
        hold: MountHold,
    }
}

impl MountThread {
    /// Returns a screw of this thread. Its length does not matter, because the user provides the screw.
    fn screw(self) -> Screw {
        let thread_mm = match self {
            Self::M2 => 2.0,
            Self::M2_5 => 2.5,
            Self::M3 => 3.0,
            Self::M4 => 4.0,
            Self::M5 => 5.0,
        };
        // Length and head are placeholders.
        Screw { thread_mm, ..Screw::M3X4 }
    }

    /// Returns the usual nut, or a short one where that exists.
    pub(super) fn nut(self, is_short: bool) -> HeatSetNut {
        match self {
            Self::M2 => HeatSetNut::M2,
            Self::M2_5 => HeatSetNut::M2_5,
            Self::M3 if is_short => HeatSetNut::M3_SHORT,
            Self::M3 => HeatSetNut::M3,
            Self::M4 => HeatSetNut::M4,
            Self::M5 => HeatSetNut::M5,
        }
    }
}

/// Space behind an insert, mm.
const INSERT_SPARE_MM: f64 = 0.6;

/// Smallest thread engagement in plastic, as a fraction of the screw's diameter.
const LEAST_BITE: f64 = 2.5 / 3.0;

/// Positions of the holes for [`MountPattern::Ring`].
#[derive(Clone, Copy, Debug)]
pub enum MountRing {
    /// Number of holes, radius of their circle (both from the section `base`), and angle of the first hole from the x
    /// axis in steps.
    Circle(u32, Length, f64),
    /// Two holes: distance (mm) from the middle, and axis, 0 for x, 1 for y.
    Pair(f64, usize),
}

/// Holes in a floor for the user's screws.
#[derive(Clone, Copy, Debug)]
pub struct Mounting<'a> {
    /// Parameters of the section `mount`.
    pub mount: &'a Mount,
    /// Positions if they form a ring.
    pub ring: MountRing,
    /// Largest depth, mm.
    pub depth_mm: f64,
    /// True if that depth goes through the whole floor.
    pub is_through: bool,
    /// Allowed ways to hold the screws, and the reason why others are not.
    pub holds: (&'static [MountHold], &'static str),
}

impl Mounting<'_> {
    /// Returns the joint in a floor whose underside is at a height, mm.
    pub fn joint(&self, bottom_z: f64) -> ScrewJoint {
        let Mount { thread, hold, .. } = *self.mount;
        let (label, screw, poses) = ("mounting hole", thread.screw(), self.poses(bottom_z));
        match hold {
            MountHold::Tapped => ScrewJoint::self_tapping(label, screw, poses, self.depth_mm),
            MountHold::Through => ScrewJoint::through_holes(label, screw, poses, self.depth_mm),
            MountHold::Insert | MountHold::ShortInsert => {
                let nuts = poses.clone();
                let room_mm = self.depth_mm - self.nut().length_mm;
                // A through hole has no bottom: the rest of the floor lies behind the nut.
                let spare_mm = if self.is_through { room_mm } else { INSERT_SPARE_MM.min(room_mm) };
                ScrewJoint::heat_set(label, screw, poses, (self.nut(), nuts, spare_mm))
            }
        }
    }

    /// Returns the nut, where inserts hold the screws.
    fn nut(&self) -> HeatSetNut {
        self.mount.thread.nut(self.mount.hold == MountHold::ShortInsert)
    }

    /// Returns the poses of the holes in a face at a height, z axis out of the floor.
    fn poses(&self, bottom_z: f64) -> Vec<Pose> {
        let mount = self.mount;
        let hang = |at: Vec<[f64; 2]>| at.into_iter().map(|at| hanging(at, bottom_z)).collect();
        let poses: Vec<Pose> = match (mount.pattern, self.ring) {
            (MountPattern::Ring, MountRing::Circle(count, radius, offset)) => {
                ring(count, offset, hanging([radius.mm(), 0.0], bottom_z))
            }
            (MountPattern::Ring, MountRing::Pair(out, axis)) => hang(pair(out, axis).to_vec()),
            (MountPattern::Rectangle, _) => {
                hang(corners([mount.width.mm() / 2.0, mount.depth.mm() / 2.0]).to_vec())
            }
            (MountPattern::List, _) => {
                hang(mount.x.iter().zip(&mount.y).map(|(x, y)| [x.mm(), y.mm()]).collect())
            }
        };
        match mount.angle.rad() {
            // An exact identity: a rotation by 0 could change the last digits.
            0.0 => poses,
            _ => poses.into_iter().map(|p| Pose::rotation_z(mount.angle).then_in(p)).collect(),
        }
    }

    /// Returns the positions of the holes, mm.
    pub fn places(&self) -> Vec<[f64; 2]> {
        self.poses(0.0).iter().map(|pose| pose.translation_mm().xy().into()).collect()
    }

    /// Returns the path of the parameter that moves the holes outwards.
    pub fn radius_parameter(&self) -> &'static str {
        match (self.mount.pattern, self.ring) {
            (MountPattern::Ring, MountRing::Circle(..)) => "base.mount_radius",
            // The positions are derived from the room inside, so that only the thread can change them.
            (MountPattern::Ring, MountRing::Pair(..)) => "mount.thread",
            (MountPattern::Rectangle, _) => "mount.width",
            (MountPattern::List, _) => "mount.x",
        }
    }

    /// Returns that parameter with its value, for messages.
    pub fn parameter_text(&self) -> String {
        let value = match (self.mount.pattern, self.ring) {
            (MountPattern::Ring, MountRing::Circle(_, radius, _)) => radius.to_string(),
            (MountPattern::Ring, MountRing::Pair(..)) => self.mount.thread.word().into(),
            (MountPattern::Rectangle, _) => self.mount.width.to_string(),
            (MountPattern::List, _) => {
                let x: Vec<String> = self.mount.x.iter().map(ToString::to_string).collect();
                format!("[{}]", x.join(", "))
            }
        };
        format!("{} is {value}", self.radius_parameter())
    }

    /// Returns the path of the parameter that turns the holes or sets their number.
    pub fn turn_parameter(&self) -> &'static str {
        match (self.mount.pattern, self.ring) {
            (MountPattern::Ring, MountRing::Circle(..)) => "base.mount_holes",
            _ => "mount.angle",
        }
    }

    /// Returns whether the holes are in the default arrangement.
    pub fn is_ring(&self) -> bool {
        self.mount.pattern == MountPattern::Ring
    }

    /// Returns the smallest depth of a hole that holds its screw, mm.
    pub fn least_depth_mm(&self) -> f64 {
        let Mount { thread, hold, .. } = *self.mount;
        match hold {
            MountHold::Tapped => LEAST_BITE * thread.screw().thread_mm,
            MountHold::Insert | MountHold::ShortInsert => self.nut().length_mm,
            MountHold::Through => 0.0,
        }
    }

    /// Returns the radius of a hole, mm.
    pub fn hole_mm(&self) -> f64 {
        let Mount { thread, hold, .. } = *self.mount;
        match hold {
            MountHold::Tapped => thread.screw().pilot_hole_mm() / 2.0,
            MountHold::Insert | MountHold::ShortInsert => self.nut().hole_mm / 2.0,
            MountHold::Through => thread.screw().clearance_hole_mm() / 2.0,
        }
    }

    /// Returns the wall around a hole, mm, in a part whose walls have the given thickness.
    fn wall_mm(&self, wall_mm: f64) -> f64 {
        match self.mount.hold {
            MountHold::Insert | MountHold::ShortInsert => wall_mm.max(self.nut().wall_mm),
            _ => wall_mm,
        }
    }

    /// Reports a way of holding the screws that this floor does not allow, and coordinate lists of different length.
    /// The section must be called `mount`.
    fn check_hold(&self, report: &mut RuleReport) {
        let mount = self.mount;
        let words = |holds: &[MountHold]| {
            let words: Vec<String> =
                holds.iter().map(|hold| format!("`{}`", hold.word())).collect();
            words.join(" or ")
        };
        let (holds, because) = self.holds;
        report.require(
            holds.contains(&mount.hold),
            "mount.hold",
            || format!("mount.hold is `{}`: {because}", mount.hold.word()),
            || format!("write {}", words(holds)),
        );
        let (x, y) = (mount.x.len(), mount.y.len());
        report.require(
            mount.pattern != MountPattern::List || x == y,
            "mount.x",
            || format!("mount.x has {x} items and mount.y has {y}; each hole has one of both"),
            || "write as many of each".into(),
        );
    }

    /// Reports holes beyond a radius (mm), or with walls thinner than `wall_mm` between them. Counts and radii of rings
    /// are in the section `base`.
    pub fn check(&self, (within_mm, because): (f64, &str), wall_mm: f64, report: &mut RuleReport) {
        self.check_hold(report);
        let (hole, wall_mm) = (self.hole_mm(), self.wall_mm(wall_mm));
        if let (MountPattern::Ring, MountRing::Circle(count, radius, _)) =
            (self.mount.pattern, self.ring)
        {
            // Neighbours on the circle are 2 r sin(half step) apart; each hole gets a wall of its own.
            let half_step = std::f64::consts::PI / f64::from(count);
            report.at_most("base.mount_radius", radius, within_mm - hole, because);
            report.at_least(
                "base.mount_radius",
                radius,
                (hole + wall_mm) / half_step.sin(),
                "mounting holes need walls between them",
            );
            return;
        }
        let out = |[x, y]: &[f64; 2]| within_mm - hole - x.hypot(*y);
        self.require_all(out, &format!("which must keep inside ({because}), is outside"), report);
        self.check_apart(wall_mm, report);
    }

    /// Reports holes outside a rectangle of these half edges (mm), or with too thin walls between them.
    pub fn check_in(&self, within_mm: [f64; 2], wall_mm: f64, report: &mut RuleReport) {
        self.check_hold(report);
        if self.is_ring() && self.mount.angle.rad() == 0.0 {
            return; // These positions are derived from the rectangle.
        }
        let hole = self.hole_mm();
        let out = |at: &[f64; 2]| {
            (0..2).map(|i| within_mm[i] - hole - at[i].abs()).fold(f64::INFINITY, f64::min)
        };
        self.require_all(out, "which must open into the room inside, lies outside", report);
        self.check_apart(self.wall_mm(wall_mm), report);
    }

    /// Reports the hole with the smallest `spare`, mm, if that is negative. The message continues `what` with the
    /// missing length.
    pub fn require_all(
        &self,
        spare: impl Fn(&[f64; 2]) -> f64,
        what: &str,
        report: &mut RuleReport,
    ) {
        let places = self.places();
        let spares = places.iter().map(spare).zip(1..);
        let Some((least, number)) = spares.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        let path = self.radius_parameter();
        report.require(
            // Rounding must not refuse holes at exactly the limit.
            least >= -1e-9,
            path,
            || {
                let [x, y] = places[number - 1];
                let missing = -least;
                format!(
                    "{}; of mounting hole {number} at {x:.2} mm, {y:.2} mm, {what} {missing:.2} mm",
                    self.parameter_text()
                )
            },
            || self.move_hint(),
        );
    }

    /// Reports holes closer than `wall_mm` to other holes of a radius, described by `what`. Tapped holes in the default
    /// arrangement are not checked.
    pub fn check_clear(
        &self,
        others: &[[f64; 2]],
        (radius_mm, what): (f64, &str),
        wall_mm: f64,
        report: &mut RuleReport,
    ) {
        if self.is_ring() && self.mount.hold == MountHold::Tapped {
            return;
        }
        let spare = |[x, y]: &[f64; 2]| {
            let apart = others.iter().map(|[u, v]| (x - u).hypot(y - v));
            apart.fold(f64::INFINITY, f64::min) - self.hole_mm() - radius_mm - wall_mm
        };
        self.require_all(spare, &format!("the wall to {what} lacks"), report);
    }

    /// Reports holes with too thin walls between them.
    fn check_apart(&self, wall_mm: f64, report: &mut RuleReport) {
        let (places, hole, path) = (self.places(), self.hole_mm(), self.radius_parameter());
        let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) - 2.0 * hole;
        let pairs = (0..places.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        let apart = pairs.map(|(j, i)| (apart(&places[j], &places[i]), j + 1, i + 1));
        let Some((least, first, second)) = apart.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        report.require(
            least >= wall_mm - 1e-9,
            path,
            || {
                format!(
                    "{}; {least:.2} mm stay between mounting holes {first} and {second}, and {wall_mm} \
                     mm are needed",
                    self.parameter_text()
                )
            },
            || self.move_hint(),
        );
    }

    /// Returns a hint which parameters move the holes.
    pub fn move_hint(&self) -> String {
        match (self.mount.pattern, self.ring) {
            (MountPattern::Ring, MountRing::Circle(..)) => {
                "change `base.mount_radius`, `base.mount_holes` or `mount.angle`".into()
            }
            (MountPattern::Ring, MountRing::Pair(..)) => {
                "write a smaller `mount.thread`, or `mount.pattern: rectangle`".into()
            }
            (MountPattern::Rectangle, _) => {
                "change `mount.width`, `mount.depth` or `mount.angle`".into()
            }
            (MountPattern::List, _) => "change `mount.x`, `mount.y` or `mount.angle`".into(),
        }
    }
}

/// Returns two positions at a distance from the middle along an axis.
fn pair(out: f64, axis: usize) -> [[f64; 2]; 2] {
    [-out, out].map(|out| {
        let mut at = [0.0; 2];
        at[axis] = out;
        at
    })
}

/// Returns the distance of a point from a rectangle with these half edges around the middle; 0 inside.
///
/// ```
/// use fabkit_designs::blocks::mounting::outside;
/// assert_eq!(outside([13.0, 12.0], [10.0, 8.0]), 5.0);
/// assert_eq!(outside([9.0, -7.0], [10.0, 8.0]), 0.0);
/// ```
pub fn outside([x, y]: [f64; 2], half_mm: [f64; 2]) -> f64 {
    (x.abs() - half_mm[0]).max(0.0).hypot((y.abs() - half_mm[1]).max(0.0))
}

/// Socket head bolts through a plate into a robot's flange.
pub struct Flange {
    /// Type of the bolts.
    pub bolt: SocketScrew,
    /// Number of bolts.
    pub bolts: u32,
    /// Diameter of the bolt circle.
    pub bolt_circle: Length,
    /// Height at which the heads bear: the top of the plate, mm.
    pub top_z: f64,
    /// Thickness of the plate under the heads, mm.
    pub plate_mm: f64,
}

impl Flange {
    /// Returns the poses of the bolts: z axis up, origin where the head bears.
    fn poses(&self) -> Vec<Pose> {
        ring(self.bolts, 0.5, Pose::translation(self.bolt_circle.mm() / 2.0, 0.0, self.top_z))
    }

    /// Returns the bolt's name among a sensor's bodies.
    pub fn name(&self) -> String {
        format!("bolt-m{}", self.bolt.thread_mm)
    }

    /// Returns the cut of the plate.
    pub fn clearance_cut(&self) -> CutFeature {
        let (poses, depth) = (self.poses(), self.plate_mm + CUT_OVERLAP_MM);
        let hole = Solid::cylinder(self.bolt.clearance_hole_mm / 2.0, depth + CUT_OVERLAP_MM);
        CutFeature {
            tools: copies("bolt hole", &poses, &hole.at_z(-depth)),
            landmarks: landmarks_at("bolt", &poses),
            handles: poses.len() as i32,
        }
    }

    /// Returns the bolts as bought bodies: long enough for the plate and the flange, to the nearest standard length.
    pub fn bought(&self, place: impl Fn(&Pose) -> Placement) -> Body {
        let length = SocketScrew::length_near_mm(self.plate_mm + BOLT_BITE_MM);
        let ordered = format!("socket head screw ISO 4762 M{}x{length}", self.bolt.thread_mm);
        let text = format!("{ordered}, and what the robot's maker demands");
        bought(&self.name(), text, self.bolt.solid(length), self.poses().iter().map(place))
            .with_order(self.bolt.order(length))
            .with_tool_access(self.bolt.driver())
            .as_fastener()
    }

    /// Reports heads that collide with each other, or with a wall around them of a radius (mm). The section must be
    /// called `mount`.
    pub fn check(&self, (within_mm, what): (f64, &str), report: &mut RuleReport) {
        let (mount, head) = (self, self.bolt.head_diameter_mm / 2.0);
        limits! { report:
            mount.bolt_circle <= 2.0 * (within_mm - head - HEAD_IN_WALL_MM),
                format!("the bolts' heads lie inside {what}");
            mount.bolts <= around(self.bolt_circle.mm() / 2.0, 2.0 * head + HEADS_APART_MM),
                format!("the M{} heads stand side by side on their circle", self.bolt.thread_mm);
        }
    }
}
