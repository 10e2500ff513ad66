//! Printed adapter plate between a sensor and a robot: screwed to the sensor's own mounting holes from below, with the
//! robot's bolt pattern around, below or beside them.

mod cable_passages;
mod conflicts;
mod pattern;
mod plate;

use fabkit_geometry::{Angle, Body, Length, Pose, PressFit, Sensor, sort_by_kind};

use super::mounting::MountThread;
use super::{Rect, ScrewJoint, hanging, merged};
use crate::chain_builder::{AssemblyName, Name, SENSOR, assemble};
use crate::hardware::{Head, HeatSetNut, Screw};
use crate::parameters::RuleReport;
use crate::{choices, parameters};
pub use cable_passages::CableOutlet;

choices! {
    /// Part of a robot that carries the sensor.
    pub enum AdapterPattern {
        /// No part that fabkit knows: the user's screws hold the sensor.
        None = "none",
        /// Flange of many robots' wrists, such as UR's and Franka's: ISO 9409-1-50-4-M6.
        Iso50 = "iso-9409-1-50-4-m6",
        /// Finger of Robotiq's 2F-85, in place of its pad.
        Robotiq85 = "robotiq-2f-85",
        /// Carriage of Franka's hand, in place of its finger.
        FrankaHand = "franka-hand",
        /// Nuts at the corners of a rectangle, or two in a row, for fingers of other grippers.
        Rectangle = "rectangle",
    }
}

parameters! {
    /// Printed plate between the sensor's mounting holes and a robot.
    pub struct Adapter {
        /// Mounting pattern of the robot, or `none` for no plate.
        pattern: AdapterPattern,
        /// Minimum thickness of plastic between the sensor and the heads of the screws that hold it.
        thickness: Length = 2.0..=16.0,
        /// For a rectangle: distance between the nuts along x.
        width: Length = 6.0..=120.0,
        /// For a rectangle: distance between the nuts along y; 0 for two nuts in a row.
        depth: Length = 0.0..=120.0,
        /// For a rectangle: thread of the nuts.
        thread: MountThread,
        /// For fingers of Robotiq and Franka: minimum distance from the sensor's axis to the middle of the pattern. It
        /// is larger where the sensor's own screws, or the carriage beside the sensor, need it.
        offset: Length = 0.0..=120.0,
        /// Angle by which the rectangle or the finger is turned around the sensor's axis.
        angle: Angle = -180.0..=180.0,
        /// For a flange: angle by which its bolts are turned around the sensor's axis.
        flange_angle: Angle = -180.0..=180.0,
        /// Width of the slot for cables that leave through the mounting face.
        cable_width: Length = 0.0..=20.0,
        /// Direction around the sensor's axis in which that slot leaves the plate.
        cable_angle: Angle = -180.0..=180.0,
    }
}

/// Key of the section in the files of every family.
pub const KEY: &str = "adapter";

/// Summary of the section.
pub const SUMMARY: &str = "Printed plate between the sensor's mounting holes and a robot.";

/// Default values: file name for messages, and YAML text.
pub const DEFAULTS: (&str, &str) =
    ("adapter.yaml (defaults)", include_str!("adapter/defaults.yaml"));

crate::bodies! {
    ADAPTER "robot-adapter" "plate between the sensor's mounting holes and the robot";
}

/// Assembly of the plate alone, with the pieces that have to be in it before the sensor is.
const ALONE: AssemblyName = AssemblyName("robot-adapter");

/// Face that a sensor is mounted by.
#[derive(Clone, Debug)]
pub struct MountFace {
    /// Body with the holes.
    pub holder: Name,
    /// Mounting holes of the sensor, whose screws the user provides if there is no adapter; or screws of the sensor
    /// that the adapter's screws replace.
    pub mounting: ScrewJoint,
    /// If the adapter's screws replace the sensor's own: the thickness that they pass and the depth that they may
    /// reach, mm.
    pub replaced_screw_mm: Option<[f64; 2]>,
    /// Height of the face, mm.
    pub bottom_z_mm: f64,
    /// Outline of the sensor, seen along z.
    pub outline: Rect,
    /// Cables that leave the sensor where a plate could be in the way.
    pub exits: Vec<CableOutlet>,
    /// Screw heads below the face: position, and radius and height, mm.
    pub heads: Vec<([f64; 2], [f64; 2])>,
}

/// Clearance between screws and whatever is beside them, mm.
const BESIDE_MM: f64 = 0.5;

/// Clearance around heads that are sunk in the plate, mm: printed holes come out smaller.
const SINK_MM: f64 = 0.4;

/// Plastic around nuts and heads, mm.
const WALL_MM: f64 = 2.0;

/// Space behind a nut, mm.
const SPARE_MM: f64 = 0.6;

/// Clearance below the tip of a screw in a blind hole, mm.
const TIP_MM: f64 = 0.3;

/// Lengths of pan head screws that are widely available, mm.
const LENGTHS_MM: [f64; 9] = [4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0];

/// Smallest thread engagement in plastic, as a fraction of the diameter.
const LEAST_BITE: f64 = 0.8;

/// Geometry of one adapter, from its parameters and the sensor's face.
struct AdapterPlan<'a> {
    adapter: Adapter,
    face: &'a MountFace,
    /// Screws into the sensor, from below.
    screws: ScrewJoint,
    /// Plastic between the sensor and the heads of these screws, mm.
    thickness_mm: f64,
    /// Height of the plate's underside, mm.
    bottom_z: f64,
}

/// Adds an adapter below a sensor, or reports why that is impossible.
pub(crate) fn apply(
    adapter: &Adapter,
    face: Option<&MountFace>,
    sensor: &mut Sensor,
    report: &mut RuleReport,
) {
    // A family without such a face keeps the mount pose that it has set itself.
    sensor.mount = face.map(|face| Pose::translation(0.0, 0.0, face.bottom_z_mm)).or(sensor.mount);
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
    let Some(plan) = AdapterPlan::new(adapter, face, report) else { return };
    plan.check(report);
    if report.is_clean() {
        plan.add_to(sensor);
    }
}

impl<'a> AdapterPlan<'a> {
    /// Plans the adapter; returns `None` after reporting why no screw holds it.
    fn new(adapter: &Adapter, face: &'a MountFace, report: &mut RuleReport) -> Option<Self> {
        let thread_mm = face.mounting.screw.thread_mm;
        report.require(
            face.mounting.has_thread() || face.replaced_screw_mm.is_some(),
            "adapter.pattern",
            || {
                "adapter.pattern: screws pass the sensor's mounting holes, and nothing holds them"
                    .into()
            },
            || "write `mount.hold: tapped` or `mount.hold: insert`".into(),
        );
        // Selects the shortest screw that holds; where it would reach the end of the hole, its head is seated deeper.
        let [passed_mm, deep_mm] =
            face.replaced_screw_mm.unwrap_or([0.0, face.mounting.holes().depth_mm]);
        let least_mm = adapter.thickness.mm();
        let seat = |length_mm: f64| least_mm.max(length_mm + TIP_MM - deep_mm);
        let bites =
            |length_mm: &f64| length_mm - seat(*length_mm) - passed_mm >= LEAST_BITE * thread_mm;
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
                    deep_mm - passed_mm
                )
            },
            || "write a smaller `adapter.thickness`, or deeper mounting holes".into(),
        );
        let length_mm = length_mm.filter(|_| report.is_clean())?;
        let thickness_mm = seat(length_mm);
        let screw = Screw { thread_mm, length_mm, head: Head::Pan };
        let at = |pose: &Pose| {
            let at = pose.translation_mm();
            hanging([at.x, at.y], face.bottom_z_mm - thickness_mm)
        };
        let poses: Vec<Pose> = face.mounting.poses.iter().map(at).collect();
        let label = "adapter screw";
        let screws = if face.mounting.nut_name().is_some() || face.replaced_screw_mm.is_some() {
            ScrewJoint::in_threads(label, screw, poses)
        } else {
            ScrewJoint::self_tapping(label, screw, poses, thickness_mm + deep_mm)
        };
        let adapter = Adapter { ..*adapter };
        // The height depends on the screws, so the underside is set in a second step.
        let plan = Self { adapter, face, screws, thickness_mm, bottom_z: face.bottom_z_mm };
        Some(Self { bottom_z: face.bottom_z_mm - plan.height_mm(), ..plan })
    }

    /// Returns the plan with the robot's pattern and the cable slot turned to other angles.
    fn with_angles(&self, angle: Angle, cable_angle: Angle) -> Self {
        let adapter = if self.is_iso() {
            Adapter { flange_angle: angle, cable_angle, ..self.adapter }
        } else {
            Adapter { angle, cable_angle, ..self.adapter }
        };
        Self { adapter, screws: self.screws.clone(), ..*self }
    }

    /// Returns the height of the plate between the sensor and the robot, mm.
    fn height_mm(&self) -> f64 {
        let sunk_mm = self.thickness_mm + self.screws.screw.head_height_mm() + BESIDE_MM;
        let nut_mm = self.nut().map_or(0.0, |nut| nut.length_mm + SPARE_MM + WALL_MM);
        sunk_mm.max(nut_mm).max(self.least_height_mm())
    }

    /// Returns the turn of the robot's pattern, and the parameter that sets it.
    fn angle(&self) -> (Angle, &'static str) {
        if self.is_iso() {
            (self.adapter.flange_angle, "adapter.flange_angle")
        } else {
            (self.adapter.angle, "adapter.angle")
        }
    }

    /// Returns whether the robot has an ISO 9409-1 flange.
    fn is_iso(&self) -> bool {
        self.adapter.pattern == AdapterPattern::Iso50
    }

    /// Returns the type of nut that the finger's own screws go into.
    fn nut(&self) -> Option<HeatSetNut> {
        match self.adapter.pattern {
            AdapterPattern::Rectangle => Some(self.adapter.thread.nut(false)),
            AdapterPattern::Robotiq85 => Some(HeatSetNut::M3),
            _ => None,
        }
    }

    /// Adds the plate, its hardware, and the steps that mount it.
    fn add_to(&self, sensor: &mut Sensor) {
        let lowered = |pose: &Pose| SENSOR.at(*pose).lifted(-130.0);
        sensor.mount = Some(self.mount());
        let mut bought = self.screws.bought(lowered, lowered);
        let (inside, beside) = self.robot_hardware();
        let names =
            |bodies: &[Body]| bodies.iter().map(|body| body.name.clone()).collect::<Vec<_>>();
        let mut mounted = names(&bought);
        mounted.extend(names(&beside));
        let fitted = names(&inside);
        bought.extend(inside.into_iter().chain(beside));
        sensor.press_fits.extend(self.screws.press_fit(self.face.holder));
        for (nuts, own) in self.nuts().and_then(|nuts| nuts.press_fit(ADAPTER)).iter().zip(&fitted)
        {
            sensor.press_fits.push(PressFit { inner: own.clone(), ..nuts.clone() });
        }
        if self.face.replaced_screw_mm.is_some() {
            self.remove_replaced_screws(sensor);
        }
        let bodies = std::mem::take(&mut sensor.bodies);
        let added = [vec![self.plate()], bought].concat();
        sensor.bodies = sort_by_kind(merged(bodies.into_iter().chain(added)));
        if !fitted.is_empty() {
            // First step of the chain: these pieces have to be in the plate before the sensor is.
            let step = assemble("fit-adapter", ALONE, &[ADAPTER])
                .with_instruction(self.preparation_instruction())
                .also(fitted);
            sensor.chain.insert(0, step.source("chosen: the paper mounts it otherwise"));
        }
        sensor.chain.push(
            assemble("mount-adapter", SENSOR, &[ADAPTER, self.face.holder])
                .with_instruction(self.mount_instruction())
                .also(mounted)
                .source("chosen: the paper mounts it otherwise"),
        );
    }

    /// Removes the sensor's own screws at the positions that the adapter's screws take.
    fn remove_replaced_screws(&self, sensor: &mut Sensor) {
        let name = self.face.mounting.name();
        for body in sensor.bodies.iter_mut().filter(|body| body.name == name) {
            let before = body.placements.len();
            body.placements.retain(|place| {
                let here = place.assembly_from_body.translation_mm();
                let is_taken = self
                    .face
                    .mounting
                    .poses
                    .iter()
                    .any(|pose| (pose.translation_mm() - here).norm() < 1e-6);
                place.assembly != SENSOR.assembly() || !is_taken
            });
            body.quantity -= (before - body.placements.len()) as u32;
        }
    }
}
