//! The screws: each joint is stated here, and nowhere else.

use fabkit_geometry::CUT_OVERLAP_MM;

use super::layout::Layout;
use super::parameters::FlatGel;
use crate::blocks::{Joint, corners, hanging, upright};
use crate::hardware::Screw;

/// What joins base and shell.
pub const CASING_SCREW: Screw = Screw::M1_6X6;

/// What holds the camera's board.
pub const CAMERA_SCREW: Screw = Screw::M1_6X5;

/// What a user screws the sensor to a gripper with; half its length stays in the base.
pub const MOUNT_SCREW: Screw = Screw::M3X4;

/// Base under the head of a casing's screw, mm.
pub const SHELF_MM: f64 = 1.2;

/// Depth of a hole beyond its screw's tip, mm.
pub const PILOT_SPARE_MM: f64 = 0.5;

/// All joints, in the sensor frame.
pub struct Joints {
    /// From below through the base's corners into the shell.
    pub casing: Joint,
    /// Through the camera's board into the base.
    pub camera: Joint,
    /// In the base's floor, for a gripper; a user's screws.
    pub mounting: Joint,
}

impl Joints {
    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &FlatGel, layout: &Layout) -> Self {
        let heads = corners(layout.screw).map(|at| hanging(at, layout.joint_z - SHELF_MM));
        let half = p.camera.screw_spacing.mm() / 2.0;
        let board = corners([half, half]).map(|at| upright(at, layout.board_top_z));
        let out = mount_out_mm(layout);
        let mounts = [-out, out].map(|out| {
            let at = if layout.longer() == 0 { [out, 0.0] } else { [0.0, out] };
            hanging(at, layout.bottom_z)
        });
        let through = p.base.thickness.mm() + CUT_OVERLAP_MM;
        let hole = |screw: Screw| screw.length_mm + PILOT_SPARE_MM;
        Self {
            casing: Joint::self_tapping("screw", CASING_SCREW, heads.to_vec(), hole(CASING_SCREW)),
            camera: Joint::self_tapping(
                "camera screw",
                CAMERA_SCREW,
                board.to_vec(),
                hole(CAMERA_SCREW),
            ),
            mounting: Joint::self_tapping("mounting hole", MOUNT_SCREW, mounts.to_vec(), through),
        }
    }
}

/// Width and height of the lip that centres the base in the shell, mm.
pub const LIP_MM: [f64; 2] = [1.0, 1.5];

/// Distance of the mounting holes from the axis, mm: just inside the lip, beside the camera's screws.
pub fn mount_out_mm(layout: &Layout) -> f64 {
    let lip = layout.lower.half[layout.longer()] - 0.2 - LIP_MM[0];
    lip - MOUNT_SCREW.pilot_hole_mm() / 2.0 - 0.2
}
