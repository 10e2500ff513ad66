//! The screws of the sensor: each joint is stated here, and nowhere else.

use super::layout::Layout;
use super::parameters::PinTip;
use crate::blocks::mounting::Flange;
use crate::blocks::{Joint, corners, hanging};
use crate::hardware::{Head, Screw, SocketScrew};

/// Below the tip of a board screw, for chips, mm.
const PILOT_SPARE_MM: f64 = 1.5;

/// All joints, in the sensor frame.
pub struct Joints {
    /// Through the corners of the camera's board, from below, into the body's posts.
    pub camera: Joint,
    /// Through the mount's plate into the robot's flange.
    pub robot: Flange,
}

impl Joints {
    /// The camera's screws.
    pub const SCREW: Screw = Screw { thread_mm: 3.0, length_mm: 6.0, head: Head::Pan };

    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &PinTip, layout: &Layout) -> Self {
        let half = [p.camera.screw_spacing, p.camera.screw_spacing_y].map(|edge| edge.mm() / 2.0);
        let screw = Self::SCREW;
        let poses = corners(half).map(|at| hanging(at, layout.camera_board_bottom_z_mm));
        let thickness = p.camera.board_thickness.mm();
        let in_post = screw.length_mm - thickness + PILOT_SPARE_MM;
        Self {
            camera: Joint::self_tapping("camera screw", screw, poses.to_vec(), thickness + in_post),
            robot: Flange {
                bolt: SocketScrew::M5,
                bolts: p.mount.bolts,
                bolt_circle: p.mount.bolt_circle,
                top_z: layout.plate_top_z_mm,
                plate_mm: p.mount.plate.mm(),
            },
        }
    }
}
