//! A printed plate between a sensor and what carries it: screwed to the sensor's own mounting holes from
//! below, and with the robot's pattern around or beside them.

mod plate;

use fabkit_geometry::{Angle, Body, Length, Placement, Point3, Pose, Sensor, in_order};

use super::mounting::MountThread;
use super::{Joint, hanging, merged, ring, upright};
use crate::assembling::{Name, SENSOR, assemble};
use crate::hardware::{Head, HeatSetNut, Screw, SocketScrew};
use crate::parameters::Report;
use crate::{choices, parameters};

choices! {
    /// What carries the sensor.
    pub enum AdapterPattern {
        /// Nothing that fabkit knows: the user's screws hold the sensor.
        None = "none",
        /// The flange of many robots' wrists, as UR and Franka have it: ISO 9409-1-50-4-M6.
        Iso50 = "iso-9409-1-50-4-m6",
        /// Nuts at the corners of a rectangle, or two in a row: fingers of grippers.
        Rectangle = "rectangle",
    }
}

parameters! {
    /// A printed plate between the sensor's mounting holes and a robot.
    pub struct Adapter {
        /// The robot's pattern: `none` for no plate.
        pattern: AdapterPattern,
        /// Plastic between the sensor and the heads of the screws that hold it, at least.
        thickness: Length = 2.0..=16.0,
        /// Rectangle: distance of the nuts along x.
        width: Length = 6.0..=120.0,
        /// Rectangle: distance of the nuts along y; 0 for two in a row.
        depth: Length = 0.0..=120.0,
        /// Rectangle: thread of the nuts.
        thread: MountThread,
        /// Turn of the robot's pattern around the sensor's axis.
        angle: Angle = -180.0..=180.0,
        /// Width of the groove that the cable lies in beside the mounting face; 0 for none.
        cable_width: Length = 0.0..=20.0,
        /// Where the groove leaves, around the sensor's axis.
        cable_angle: Angle = -180.0..=180.0,
    }
}

/// The key of the section in every family's files.
pub const KEY: &str = "adapter";

/// What it is for.
pub const SUMMARY: &str = "A printed plate between the sensor's mounting holes and a robot.";

/// Its values where no file says anything else, for messages, and their text.
pub const DEFAULTS: (&str, &str) =
    ("adapter.yaml (defaults)", include_str!("adapter/defaults.yaml"));

crate::bodies! {
    ADAPTER "robot-adapter" "plate between the sensor's mounting holes and the robot";
}

/// What a sensor is mounted by.
#[derive(Clone, Debug)]
pub struct MountFace {
    /// The body with the holes.
    pub holder: Name,
    /// The holes, whose screws a user brings where there is no adapter.
    pub mounting: Joint,
    /// Height of the face, mm.
    pub bottom_z_mm: f64,
    /// Half the sensor's width where it is narrowest: at the flats of a square one, mm.
    pub flat_mm: f64,
    /// Half its width where it is widest, mm.
    pub radius_mm: f64,
    /// Whether the cable leaves through the middle of the face, not beside it.
    pub is_cable_inside: bool,
}

/// ISO 9409-1, designation 50-4-M6: diameter of the circle of the threads, mm.
const CIRCLE_MM: f64 = 50.0;

/// The same: how many.
const BOLTS: u32 = 4;

/// The same: the recess that centres a tool, H7, mm. The boss is printed smaller by what printers swell.
const CENTRING_MM: f64 = 31.5;

/// Between boss and recess, mm per side: chosen, a snug printed fit.
const CENTRING_GAP_MM: f64 = 0.1;

/// Height of the boss, mm: chosen, less than the recesses of UR's and Franka's flanges are deep.
const BOSS_MM: f64 = 3.0;

/// The same standard: the dowel's hole on the circle, mm, half a step off the threads.
const DOWEL_MM: f64 = 6.0;

/// Between a dowel and its printed hole, mm per side.
const DOWEL_GAP_MM: f64 = 0.1;

/// Outer radius of the plate, mm: that of the flange, whose outside is 63 h8.
const FLANGE_MM: f64 = 31.5;

/// Thread that a flange takes, mm: as deep as UR says its threads are at least.
const BITE_MM: f64 = 6.0;

/// Thickness of the plate on a flange at least, mm: screws M6x16 then reach [`BITE_MM`].
const PLATE_MM: f64 = 10.0;

/// Between what is screwed and what stands beside it, mm.
const BESIDE_MM: f64 = 0.5;

/// Plastic around nuts and heads, mm.
const WALL_MM: f64 = 2.0;

/// Depth of the cable's groove, mm.
const GROOVE_MM: f64 = 3.0;

/// Room behind a nut, mm.
const SPARE_MM: f64 = 0.6;

/// Below the tip of a screw in a blind hole, mm.
const TIP_MM: f64 = 0.3;

/// Lengths of pan head screws that are sold everywhere, mm.
const LENGTHS_MM: [f64; 9] = [4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0];

/// Turns of thread that hold in plastic at least, as a part of the diameter.
const LEAST_BITE: f64 = 0.8;

struct Plan<'a> {
    adapter: &'a Adapter,
    face: &'a MountFace,
    /// Into the sensor, from below.
    screws: Joint,
    /// Plastic below their heads, mm.
    thickness_mm: f64,
    /// Height of the plate's underside, mm.
    bottom_z: f64,
    radius_mm: f64,
}

/// Puts an adapter below a sensor, or reports why there is none.
pub(crate) fn apply(
    adapter: &Adapter,
    face: Option<&MountFace>,
    sensor: &mut Sensor,
    report: &mut Report,
) {
    if adapter.pattern == AdapterPattern::None {
        return;
    }
    let Some(face) = face else {
        report.require(
            false,
            "adapter.pattern",
            || "adapter.pattern: this family has no mounting holes in a flat face below".into(),
            || "write `none`, and mount it as its own parts say".into(),
        );
        return;
    };
    let Some(plan) = Plan::new(adapter, face, report) else { return };
    plan.check(report);
    if !report.is_clean() {
        return;
    }
    let plate = plan.plate();
    let lowered = |pose: &Pose| SENSOR.at(*pose).lifted(-130.0);
    let mut bought = plan.screws.bought(lowered, lowered);
    bought.extend(plan.robot_hardware());
    let names: Vec<String> = bought.iter().map(|body| body.name.clone()).collect();
    sensor.press_fits.extend(plan.screws.press_fit(face.holder));
    sensor.press_fits.extend(plan.nuts().and_then(|nuts| nuts.press_fit(ADAPTER)));
    let bodies = std::mem::take(&mut sensor.bodies);
    sensor.bodies = in_order(merged(bodies.into_iter().chain([plate]).chain(bought)));
    let last = match adapter.pattern {
        AdapterPattern::Iso50 => {
            "then bolt the plate to the robot's flange with the M6 screws from the sensor's side, beside \
             it, with a ball-ended key"
        }
        _ => "then screw the gripper's finger to the nuts in the plate from its own side",
    };
    sensor.chain.push(
        assemble("mount-adapter", SENSOR, &[ADAPTER, face.holder])
            .told(format!(
                "screw the adapter to the sensor's mounting holes from below, the cable in its groove; \
                 {last}"
            ))
            .also(names)
            .source("chosen: the paper mounts it otherwise"),
    );
}

impl<'a> Plan<'a> {
    fn new(adapter: &'a Adapter, face: &'a MountFace, report: &mut Report) -> Option<Self> {
        let holes = face.mounting.holes();
        let thread_mm = face.mounting.screw.thread_mm;
        report.require(
            face.mounting.holds(),
            "adapter.pattern",
            || {
                "adapter.pattern: screws pass the sensor's mounting holes, and nothing holds them"
                    .into()
            },
            || "write `mount.hold: tapped` or `mount.hold: insert`".into(),
        );
        // The shortest screw that holds; its head lies deeper where it would reach the hole's end.
        let least_mm = adapter.thickness.mm();
        let seat = |length_mm: f64| least_mm.max(length_mm + TIP_MM - holes.depth_mm);
        let bites = |length_mm: &f64| length_mm - seat(*length_mm) >= LEAST_BITE * thread_mm;
        let length_mm = LENGTHS_MM.into_iter().find(bites);
        report.require(
            length_mm.is_some(),
            "adapter.thickness",
            || {
                format!(
                    "adapter.thickness is {}; no screw up to {} mm reaches {:.2} mm into the mounting \
                     holes, which are {:.2} mm deep",
                    adapter.thickness,
                    LENGTHS_MM[LENGTHS_MM.len() - 1],
                    LEAST_BITE * thread_mm,
                    holes.depth_mm
                )
            },
            || "write a smaller `adapter.thickness`, or deeper mounting holes".into(),
        );
        let length_mm = length_mm.filter(|_| report.is_clean())?;
        let thickness_mm = seat(length_mm);
        let reach_mm = thickness_mm + holes.depth_mm;
        let screw = Screw { thread_mm, length_mm, head: Head::Pan };
        let at = |pose: &Pose| {
            let at = pose.translation_mm();
            hanging([at.x, at.y], face.bottom_z_mm - thickness_mm)
        };
        let poses: Vec<Pose> = face.mounting.poses.iter().map(at).collect();
        let label = "adapter screw";
        let screws = match face.mounting.nut_name() {
            Some(_) => Joint::in_threads(label, screw, poses),
            None => Joint::self_tapping(label, screw, poses, reach_mm),
        };
        let sunk_mm = thickness_mm + screw.head_height_mm() + BESIDE_MM;
        let nut_mm = adapter.nut().length_mm + SPARE_MM + WALL_MM;
        let (plate_mm, radius_mm) = match adapter.pattern {
            AdapterPattern::Iso50 => (sunk_mm.max(PLATE_MM), FLANGE_MM),
            _ => {
                let [x, y] = adapter.half();
                let out = x.hypot(y) + adapter.nut().diameter_mm / 2.0 + WALL_MM;
                (sunk_mm.max(nut_mm), out.max(face.radius_mm))
            }
        };
        let bottom_z = face.bottom_z_mm - plate_mm;
        Some(Self { adapter, face, screws, thickness_mm, bottom_z, radius_mm })
    }

    fn is_iso(&self) -> bool {
        self.adapter.pattern == AdapterPattern::Iso50
    }

    /// Reports what does not go beside each other.
    fn check(&self, report: &mut Report) {
        let (adapter, face) = (self.adapter, self.face);
        let head = SocketScrew::M6.head_diameter_mm / 2.0;
        let free_mm = CIRCLE_MM / 2.0 - head - BESIDE_MM;
        report.require(
            !self.is_iso() || face.flat_mm <= free_mm,
            "adapter.pattern",
            || {
                format!(
                    "adapter.pattern: the sensor is {:.2} mm wide, and between the M6 heads on a circle \
                     of {CIRCLE_MM} mm are {:.2} mm",
                    2.0 * face.flat_mm,
                    2.0 * free_mm
                )
            },
            || "make the sensor narrower, or write `adapter.pattern: rectangle`".into(),
        );
        let hole = self.screws.screw.head_diameter_mm() / 2.0 + BESIDE_MM;
        let nut = adapter.nut().diameter_mm / 2.0;
        let apart = |pose: &Pose, at: &[f64; 2]| {
            let own = pose.translation_mm();
            (own.x - at[0]).hypot(own.y - at[1])
        };
        let nuts: Vec<[f64; 2]> = if self.is_iso() { Vec::new() } else { self.nut_places() };
        let pairs = nuts.iter().flat_map(|at| self.screws.poses.iter().map(|p| apart(p, at)));
        let least = pairs.fold(f64::INFINITY, f64::min) - hole - nut;
        report.require(
            least >= WALL_MM,
            "adapter.width",
            || {
                format!(
                    "adapter.width is {}; {least:.2} mm stay between a nut and a screw of the sensor, \
                     and {WALL_MM} mm are needed",
                    adapter.width
                )
            },
            || "change `adapter.width`, `adapter.depth` or `adapter.angle`".into(),
        );
        let own = if self.is_iso() { self.flange_places() } else { nuts.clone() };
        let width = adapter.cable_width.mm();
        let (sin, cos) = adapter.cable_angle.rad().sin_cos();
        let beside = |[x, y]: [f64; 2], radius: f64| match x * cos + y * sin {
            along if along > -radius => (x * sin - y * cos).abs() - width / 2.0 - radius,
            _ => f64::INFINITY,
        };
        let of_robot = own.iter().map(|at| beside(*at, head.max(nut)));
        let radius = self.screws.screw.clearance_hole_mm() / 2.0;
        let of_sensor = self.screws.poses.iter().filter(|_| face.is_cable_inside);
        let of_sensor = of_sensor.map(|p| beside(p.translation_mm().xy().into(), radius));
        let least = of_robot.chain(of_sensor).fold(f64::INFINITY, f64::min);
        report.require(
            width == 0.0 || least >= BESIDE_MM,
            "adapter.cable_angle",
            || {
                format!(
                    "adapter.cable_angle is {}; the cable's groove passes a screw at \
                     {least:.2} mm, and {BESIDE_MM} mm are needed",
                    adapter.cable_angle
                )
            },
            || "change `adapter.cable_angle`, `adapter.angle` or `adapter.cable_width`".into(),
        );
    }

    /// Of the robot's bolts: z axis up, origin where the heads bear.
    fn bolts(&self) -> Vec<Pose> {
        let first = upright([CIRCLE_MM / 2.0, 0.0], self.face.bottom_z_mm);
        let turn = Pose::rotation_z(self.adapter.angle);
        ring(BOLTS, 0.0, first).into_iter().map(|pose| turn.then_in(pose)).collect()
    }

    /// The dowel's hole, half a step off the first bolt.
    fn dowel(&self) -> Pose {
        let half_step = Angle::from_deg(45.0).expect("finite");
        Pose::rotation_z(half_step).then_in(self.bolts()[0])
    }

    /// Where bolts and dowel are, mm.
    fn flange_places(&self) -> Vec<[f64; 2]> {
        let all = self.bolts().into_iter().chain([self.dowel()]);
        all.map(|pose| pose.translation_mm().xy().into()).collect()
    }

    fn nut_places(&self) -> Vec<[f64; 2]> {
        let [x, y] = self.adapter.half();
        let places = match y > 0.0 {
            true => super::corners([x, y]).to_vec(),
            false => vec![[x, 0.0], [-x, 0.0]],
        };
        let turn = Pose::rotation_z(self.adapter.angle);
        places
            .into_iter()
            .map(|[x, y]| turn.point(Point3::new(x, y, 0.0)).xy().coords.into())
            .collect()
    }

    /// The nuts that a gripper's screws go into.
    fn nuts(&self) -> Option<Joint> {
        if self.is_iso() {
            return None;
        }
        let at = |at: [f64; 2]| hanging(at, self.bottom_z);
        let poses: Vec<Pose> = self.nut_places().into_iter().map(at).collect();
        let hold = (self.adapter.nut(), poses.clone(), SPARE_MM);
        let screw = Screw { thread_mm: self.adapter.nut().thread_mm, ..Screw::M3X4 };
        Some(Joint::heat_set("finger screw", screw, poses, hold))
    }

    fn robot_hardware(&self) -> Vec<Body> {
        let lowered = |pose: &Pose| -> Placement { SENSOR.at(*pose).lifted(-60.0) };
        if let Some(nuts) = self.nuts() {
            return nuts.bought_nuts(lowered).into_iter().collect();
        }
        let plate_mm = self.face.bottom_z_mm - self.bottom_z;
        let length = SocketScrew::length_near_mm(plate_mm + BITE_MM);
        let text = format!("socket head screw ISO 4762 M6x{length}");
        let bolts = self.bolts();
        let places = bolts.iter().map(lowered);
        let bolts = super::bought("bolt-m6", text, SocketScrew::M6.solid(length), places);
        vec![bolts.fastening()]
    }
}

impl Adapter {
    fn half(&self) -> [f64; 2] {
        [self.width.mm() / 2.0, self.depth.mm() / 2.0]
    }

    fn nut(&self) -> HeatSetNut {
        self.thread.nut(false)
    }
}
