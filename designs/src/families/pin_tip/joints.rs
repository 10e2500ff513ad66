//! The screws of the sensor: each joint is stated here, and nowhere else.

use fabkit_geometry::{Body, CUT_OVERLAP_MM, Cut, Placement, Pose, Solid};

use super::layout::Layout;
use super::parameters::PinTip;
use crate::blocks::{Joint, bought, copies, corners, hanging, marks, ring};
use crate::hardware::{Head, Screw, SocketScrew};

/// Below the tip of a board screw, for chips, mm.
const PILOT_SPARE_MM: f64 = 1.5;

/// Length of thread that the robot's flange takes, mm.
const BOLT_BITE_MM: f64 = 6.0;

/// All joints, in the sensor frame.
pub struct Joints {
    /// Through the corners of the camera's board, from below, into the body's posts.
    pub camera: Joint,
    /// Through the mount's plate into the robot's flange.
    pub robot: RobotJoint,
}

/// Socket head bolts into a robot's flange.
pub struct RobotJoint {
    /// Which.
    pub bolt: SocketScrew,
    /// Of each: z axis up, origin where the head bears.
    pub poses: Vec<Pose>,
    /// Thickness of the plate that they hold, mm.
    plate_mm: f64,
}

impl Joints {
    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &PinTip, layout: &Layout) -> Self {
        let half = p.camera.screw_spacing.mm() / 2.0;
        let screw = Screw { thread_mm: 3.0, length_mm: 6.0, head: Head::Pan };
        let poses = corners([half, half]).map(|at| hanging(at, layout.camera_board_bottom_z_mm));
        let thickness = p.camera.board_thickness.mm();
        let in_post = screw.length_mm - thickness + PILOT_SPARE_MM;
        let out = Pose::translation(p.mount.bolt_circle.mm() / 2.0, 0.0, layout.plate_top_z_mm);
        Self {
            camera: Joint::self_tapping("camera screw", screw, poses.to_vec(), thickness + in_post),
            robot: RobotJoint {
                bolt: SocketScrew::M5,
                poses: ring(p.mount.bolts, 0.5, out),
                plate_mm: p.mount.plate.mm(),
            },
        }
    }
}

impl RobotJoint {
    /// Its name among the sensor's bodies.
    pub fn name(&self) -> String {
        format!("bolt-m{}", self.bolt.thread_mm)
    }

    /// What the plate gets.
    pub fn passed(&self) -> Cut {
        let depth = self.plate_mm + CUT_OVERLAP_MM;
        let hole = Solid::cylinder(self.bolt.clearance_hole_mm / 2.0, depth + CUT_OVERLAP_MM);
        Cut {
            tools: copies("bolt hole", &self.poses, &hole.at_z(-depth)),
            landmarks: marks("bolt", &self.poses),
            handles: self.poses.len() as i32,
        }
    }

    /// What is bought: through the plate and into the flange, as near as the standard's lengths
    /// come.
    pub fn bought(&self, place: impl Fn(&Pose) -> Placement) -> Body {
        let length = SocketScrew::length_near_mm(self.plate_mm + BOLT_BITE_MM);
        let ordered = format!("socket head screw ISO 4762 M{}x{length}", self.bolt.thread_mm);
        let text = format!("{ordered}, and what the robot's maker demands");
        bought(&self.name(), text, self.bolt.solid(length), self.poses.iter().map(place))
    }
}
