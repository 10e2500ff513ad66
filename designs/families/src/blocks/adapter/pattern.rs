//! Bolt patterns of robots: positions of their holes, and the hardware that goes into them.
//!
//! ISO 9409-1-50-4-M6: the standard itself is not free; its figures are those of makers and sellers of grippers and
//! robots, which agree: a circle of 50 mm with four M6, a recess of 31.5 mm, 3.5 mm deep, in a flange of 63 mm
//! (graspmonkey.de, "ISO 9409-1", table), a dowel of 6 mm on the same circle (UR's flange, as modelled in
//! TAMS-Group/tams_openscad, robots/ur5_flange.scad).
//!
//! Robotiq 2F-85 and Franka's hand: measured in public meshes, see [`ROBOTIQ`] and [`FRANKA`].

use fabkit_geometry::{Angle, Body, Placement, Point3, Pose};

use super::{
    ADAPTER, ALONE, Adapter, AdapterPattern, AdapterPlan, BESIDE_MM, SINK_MM, SPARE_MM, WALL_MM,
};
use crate::blocks::{ScrewJoint, corners, hanging, ring, upright};
use crate::chain_builder::{SENSOR, bought};
use crate::hardware::{Screw, SocketScrew};

/// Diameter of the bolt circle, mm; ISO 9409-1, designation 50-4-M6.
pub const CIRCLE_MM: f64 = 50.0;

/// Number of bolts; ISO 9409-1, designation 50-4-M6.
const BOLTS: u32 = 4;

/// Diameter of the centring recess, H7, mm; ISO 9409-1, designation 50-4-M6. The boss is smaller by
/// [`CENTRING_GAP_MM`], because printed bosses come out larger.
pub const CENTRING_MM: f64 = 31.5;

/// Gap between boss and recess, mm per side: chosen, a snug printed fit.
pub const CENTRING_GAP_MM: f64 = 0.1;

/// Height of the boss, mm: chosen, less than the recess's depth of 3.5 mm.
pub const BOSS_MM: f64 = 3.0;

/// Diameter of the dowel on the bolt circle, mm; it lies half a step from the bolts.
pub const DOWEL_MM: f64 = 6.0;

/// Gap between a dowel and its printed hole, mm per side: chosen.
pub const DOWEL_GAP_MM: f64 = 0.1;

/// Outer radius of the plate, mm: that of the flange, whose diameter is 63 mm.
pub const FLANGE_MM: f64 = 31.5;

/// Thread engagement in a flange, mm: the thread depth of UR's.
const BITE_MM: f64 = 6.0;

/// Smallest thickness of the plate on a flange, mm: M6x16 screws then engage by [`BITE_MM`].
const PLATE_MM: f64 = 10.0;

/// Plastic below heads that are sunk in the plate, mm: chosen, as much as a printed wall beside them.
const BELOW_HEADS_MM: f64 = 5.0;

/// Screw holes of a finger, and the part of the plate around them.
pub struct FingerPattern {
    /// Distance of its two holes, mm.
    pub apart_mm: f64,
    /// Half the width of the plate beside the sensor, mm.
    pub half_mm: f64,
    /// Extent of the plate beyond the outer hole, mm.
    pub beyond_mm: f64,
}

/// Robotiq 2F-85: two holes of 3.4 mm with counterbores of 6.5 mm, on the finger's middle line at 20.0 and 36.0 mm from
/// its joint, behind a pad 20 mm wide. Measured in the finger and the pad of ROS-Industrial's model
/// (ros-industrial-attic/robotiq 45196f6, robotiq_2f_85_gripper_visualization, meshes/visual,
/// robotiq_arg2f_85_inner_finger.dae, robotiq_arg2f_85_pad.dae): to 0.1 mm, as its circles have 50 corners. The third
/// hole between them, 3.0 mm, is not used.
pub const ROBOTIQ: FingerPattern = FingerPattern { apart_mm: 16.0, half_mm: 10.0, beyond_mm: 5.0 };

/// Franka's hand: two holes of 4.5 mm, side by side, 12.0 mm apart, 7.8 mm above the lower edge of the part that
/// replaces the finger, which is 21 mm wide. Measured in a printed holder for this hand (mihdalal/manipgen 671648f,
/// manipgen/assets/umi/franka_finger_holder.stl: holes at y = -6.00 and 6.00 mm), and in the maker's finger
/// (frankaemika/franka_description, meshes/robot_ee/franka_hand_white/visual/finger.dae: round recesses at x = -6 and 6
/// mm, to 0.3 mm, as they have 10 corners).
pub const FRANKA: FingerPattern = FingerPattern { apart_mm: 12.0, half_mm: 10.5, beyond_mm: 7.5 };

/// Tongue of the carriage, which the finger lies against, in the same mesh: extent from the holes to the fingertip, and
/// thickness, mm, to 0.2 mm.
pub const TONGUE_MM: [f64; 2] = [6.9, 6.0];

/// Thread engagement in the tongue, mm: chosen, less than its thickness.
const TONGUE_BITE_MM: f64 = 5.0;

/// Largest distance of a sensor's screws from the axis for it to be carried by a finger, mm: chosen, as at a flange.
const LARGEST_MM: f64 = FLANGE_MM;

impl AdapterPlan<'_> {
    /// Returns the thickness that the robot's pattern requires, mm.
    pub(super) fn least_height_mm(&self) -> f64 {
        match (self.is_iso(), self.is_above_flange()) {
            (true, true) => SocketScrew::M6.head_height_mm + BESIDE_MM + BELOW_HEADS_MM,
            (true, false) => PLATE_MM,
            _ => 0.0,
        }
    }

    /// Returns whether the sensor covers the flange's bolts while its own screws are reached beside the flange.
    pub(super) fn is_above_flange(&self) -> bool {
        let head = self.screws.screw.head_diameter_mm() / 2.0;
        self.is_iso() && self.screw_radii().all(|radius| radius >= FLANGE_MM + head + BESIDE_MM)
    }

    /// Returns the distances of the sensor's own screws from the axis, mm.
    pub(super) fn screw_radii(&self) -> impl Iterator<Item = f64> {
        self.screws.poses.iter().map(|pose| pose.translation_mm().xy().norm())
    }

    /// Returns the height at which the robot's bolts bear, mm: sunk below the sensor where it covers them.
    fn seat_z(&self) -> f64 {
        if self.is_above_flange() {
            self.face.bottom_z_mm - SocketScrew::M6.head_height_mm - BESIDE_MM
        } else {
            self.face.bottom_z_mm
        }
    }

    /// Returns the middle of the robot's pattern in the plate's underside, x along it, z towards the sensor.
    pub(super) fn mount(&self) -> Pose {
        self.turn().then_in(upright([self.middle_mm(), 0.0], self.bottom_z))
    }

    /// Returns the turn of the robot's pattern as a pose.
    fn turn(&self) -> Pose {
        Pose::rotation_z(self.angle().0)
    }

    /// Returns the poses of the robot's bolts: z axis towards the head, origin where the heads bear.
    pub(super) fn bolts(&self) -> Vec<Pose> {
        let turn = self.turn();
        let bolts = match self.adapter.pattern {
            AdapterPattern::Iso50 => {
                ring(BOLTS, 0.0, upright([CIRCLE_MM / 2.0, 0.0], self.seat_z()))
            }
            AdapterPattern::FrankaHand => {
                let half = FRANKA.apart_mm / 2.0;
                [-half, half].map(|y| hanging([self.middle_mm(), y], self.bottom_z)).to_vec()
            }
            _ => Vec::new(),
        };
        bolts.into_iter().map(|pose| turn.then_in(pose)).collect()
    }

    /// Returns the type of the robot's bolts.
    pub(super) fn bolt(&self) -> SocketScrew {
        if self.is_iso() { SocketScrew::M6 } else { SocketScrew::M4 }
    }

    /// Returns the pose of the dowel's hole, half a step from the first bolt.
    pub(super) fn dowel(&self) -> Option<Pose> {
        let half_step = Angle::from_deg(45.0).expect("finite");
        let dowel = upright([CIRCLE_MM / 2.0, 0.0], self.face.bottom_z_mm);
        let turn = Pose::rotation_z(half_step);
        self.is_iso().then(|| turn.then_in(self.turn()).then_in(dowel))
    }

    /// Returns the distance of the middle of a finger's pattern from the axis, mm.
    pub(super) fn middle_mm(&self) -> f64 {
        let least_mm = match self.adapter.pattern {
            AdapterPattern::Robotiq85 => {
                let screws = self.screw_radii().fold(0.0, f64::max) + self.sink_mm() + WALL_MM;
                let nut = self.nut().map_or(0.0, |nut| nut.diameter_mm) / 2.0;
                screws + nut + ROBOTIQ.apart_mm / 2.0
            }
            // The tongue ends beside the sensor.
            AdapterPattern::FrankaHand => self.face.radius_mm() + BESIDE_MM + TONGUE_MM[0],
            _ => 0.0,
        };
        least_mm.max(self.adapter.offset.mm())
    }

    /// Returns the pattern of the finger, if a finger carries the sensor.
    pub(super) fn finger(&self) -> Option<&'static FingerPattern> {
        match self.adapter.pattern {
            AdapterPattern::Robotiq85 => Some(&ROBOTIQ),
            AdapterPattern::FrankaHand => Some(&FRANKA),
            _ => None,
        }
    }

    /// Returns whether the sensor is small enough for a finger.
    pub(super) fn is_for_finger(&self) -> bool {
        self.screw_radii().all(|radius| radius < LARGEST_MM)
    }

    /// Returns the radius of the counterbores for the sensor's own screws, mm.
    pub(super) fn sink_mm(&self) -> f64 {
        self.screws.screw.head_diameter_mm() / 2.0 + SINK_MM
    }

    /// Returns the positions of the nuts, mm.
    pub(super) fn nut_places(&self) -> Vec<[f64; 2]> {
        let places = match self.adapter.pattern {
            AdapterPattern::Rectangle => self.adapter.rectangle(),
            AdapterPattern::Robotiq85 => {
                let half = ROBOTIQ.apart_mm / 2.0;
                [-half, half].map(|along| [self.middle_mm() + along, 0.0]).to_vec()
            }
            _ => Vec::new(),
        };
        let turn = self.turn();
        let turned = |[x, y]: [f64; 2]| turn.point(Point3::new(x, y, 0.0)).xy().coords.into();
        places.into_iter().map(turned).collect()
    }

    /// Returns the nuts that a gripper's screws go into.
    pub(super) fn nuts(&self) -> Option<ScrewJoint> {
        let nut = self.nut()?;
        let at = |at: [f64; 2]| hanging(at, self.bottom_z);
        let poses: Vec<Pose> = self.nut_places().into_iter().map(at).collect();
        let hold = (nut, poses.clone(), SPARE_MM);
        let screw = Screw { thread_mm: nut.thread_mm, ..Screw::M3X4 };
        Some(ScrewJoint::heat_set("finger screw", screw, poses, hold))
    }

    /// Returns the bought pieces: those that are put into the plate before the sensor is mounted, and those that
    /// follow.
    pub(super) fn robot_hardware(&self) -> (Vec<Body>, Vec<Body>) {
        let lowered = |pose: &Pose| -> Placement { SENSOR.at(*pose).lifted(-60.0) };
        let alone = |mut body: Body, poses: &[Pose]| {
            body.placements.extend(poses.iter().map(|pose| ALONE.at(*pose)));
            body
        };
        if let Some(nuts) = self.nuts() {
            let poses = nuts.holes().poses.to_vec();
            // Prefixed names: the sensor may use the same nuts, which belong to other steps.
            let named =
                |body: Body| Body { name: format!("{}-{}", ADAPTER.name, body.name), ..body };
            let bodies = nuts.bought_nuts(lowered).into_iter().map(named);
            return (bodies.map(|body| alone(body, &poses)).collect(), Vec::new());
        }
        let (bolt, bolts) = (self.bolt(), self.bolts());
        let bite_mm = if self.is_iso() { BITE_MM } else { TONGUE_BITE_MM };
        let held_mm = if self.is_iso() { self.seat_z() } else { self.face.bottom_z_mm };
        let length = SocketScrew::length_near_mm(held_mm - self.bottom_z + bite_mm);
        let text = format!("socket head screw ISO 4762 M{}x{length}", bolt.thread_mm);
        let name = format!("bolt-m{}", bolt.thread_mm);
        let body = bought(&name, text, bolt.solid(length), bolts.iter().map(lowered))
            .with_order(bolt.order(length))
            .with_tool_access(bolt.driver())
            .as_fastener();
        if self.is_above_flange() {
            (vec![alone(body, &bolts)], Vec::new())
        } else {
            (Vec::new(), vec![body])
        }
    }

    /// Returns the instruction for the pieces that are put into the plate before the sensor is mounted.
    pub(super) fn preparation_instruction(&self) -> &'static str {
        if self.is_iso() {
            "bolt the plate to the robot's flange with the M6 screws, their heads sunk"
        } else {
            "melt the nuts into the plate from below"
        }
    }

    /// Returns the instruction for mounting the plate.
    pub(super) fn mount_instruction(&self) -> String {
        let cables = if self.is_slotted() { ", cable and wires in its slot" } else { "" };
        let screwed =
            format!("screw the adapter to the sensor's mounting holes from below{cables}");
        match self.adapter.pattern {
            AdapterPattern::Iso50 if self.is_above_flange() => format!(
                "take the {} screws out of the floor's corners, put the sensor on the plate, and drive \
                 them again from below, through the plate{cables}",
                self.screws.poses.len()
            ),
            AdapterPattern::Iso50 => format!(
                "{screwed}; then bolt the plate to the robot's flange with the M6 screws from the sensor's \
                 side, beside it, with a ball-ended key"
            ),
            AdapterPattern::FrankaHand => format!(
                "{screwed}; take the finger off its carriage, and screw the plate there with two M4 from \
                 behind"
            ),
            AdapterPattern::Robotiq85 => format!(
                "{screwed}; take the pad off the finger, and screw the plate there with the pad's M3 screws \
                 from behind"
            ),
            _ => format!(
                "{screwed}; then screw the gripper's finger to the nuts in the plate from its own side"
            ),
        }
    }
}

impl Adapter {
    /// Returns the corners of the rectangle, or two positions in a row, mm.
    fn rectangle(&self) -> Vec<[f64; 2]> {
        let [x, y] = [self.width.mm() / 2.0, self.depth.mm() / 2.0];
        if y > 0.0 { corners([x, y]).to_vec() } else { vec![[x, 0.0], [-x, 0.0]] }
    }
}
