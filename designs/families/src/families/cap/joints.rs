//! The screws of the sensor and of its mold: each joint is stated here, and nowhere else.

use fabkit_geometry::{CUT_OVERLAP_MM, Pose, Process};

use super::bodies::BLOCK;
use super::layout::Layout;
use super::parameters::Cap;
use crate::blocks::mounting::{MountHold, MountRing, Mounting};
use crate::blocks::{Joint, corners, hanging, ring};
use crate::fits::Fit;
use crate::hardware::{HexNut, Screw};

/// How far a casing's screw bites into the holder, mm: two and a half times its diameter.
pub const BITE_MM: f64 = 5.0;

/// Depth of a screw's hole beyond its tip, mm.
const PILOT_SPARE_MM: f64 = 1.0;

/// The screws that join holder and base.
pub const CASING_SCREW: Screw = Screw::M2X16;

/// The bolts of the mold, and their nuts.
pub const MOLD_BOLT: (Screw, HexNut) = (Screw::M3X16, HexNut::M3);

/// All joints, in the sensor frame.
pub struct Joints {
    /// Through the base's corners into the holder.
    pub casing: Joint,
    /// In the base's floor, for a gripper; a user's screws.
    pub mounting: Joint,
    /// Through lid, spacer and block of the mold.
    pub mold: Joint,
}

impl Joints {
    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &Cap, layout: &Layout) -> Self {
        let half = p.holder.screw_spacing.mm() / 2.0;
        let head_z = casing_head_z(layout);
        let casing = corners([half, half]).map(|at| hanging(at, head_z)).to_vec();

        let slide = p.making.gap_mm(BLOCK, Process::Sla, Fit::Slide);
        let (bolt, nut) = MOLD_BOLT;
        let (circle, bolts) = (p.mold.bolt_circle.mm() / 2.0, p.mold.bolts);
        let down = hanging([circle, 0.0], layout.lid_z_mm);
        let nuts = ring(bolts, 0.0, Pose::translation(circle, 0.0, layout.nut_z_mm));
        Self {
            casing: Joint::self_tapping(
                "screw",
                CASING_SCREW,
                casing,
                CASING_SCREW.length_mm + PILOT_SPARE_MM,
            ),
            mounting: mounting(p).joint(layout.bottom_z_mm),
            mold: Joint::nutted("bolt", bolt, ring(bolts, 0.0, down), (nut, nuts))
                .in_pockets(slide, p.mold.height.mm() - layout.nut_z_mm)
                .of_bolts(),
        }
    }

    /// The mounting holes, where nuts are melted into them.
    pub fn inserts(&self) -> Option<&Joint> {
        self.mounting.nut_name().map(|_| &self.mounting)
    }
}

/// Holes for a gripper's screws.
pub(super) fn mounting(p: &Cap) -> Mounting<'_> {
    Mounting {
        mount: &p.mount,
        ring: MountRing::Circle(p.base.mount_holes, p.base.mount_radius, 0.0),
        depth_mm: p.base.floor.mm() + CUT_OVERLAP_MM,
        is_through: true,
        holds: (&[MountHold::Tapped, MountHold::Insert, MountHold::Through], ""),
    }
}

/// Height at which the holes of the casing's screws end.
pub fn casing_tip_z(layout: &Layout) -> f64 {
    casing_head_z(layout) + CASING_SCREW.length_mm + PILOT_SPARE_MM
}

/// Height at which the heads of the casing's screws bear.
pub fn casing_head_z(layout: &Layout) -> f64 {
    layout.joint_z_mm + BITE_MM - CASING_SCREW.length_mm
}
