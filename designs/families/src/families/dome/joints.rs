//! The screws of the sensor and of its tools: each joint is stated here, and nowhere else.

use fabkit_geometry::{CUT_OVERLAP_MM, Point3, Pose, Vector3};

use super::layout::Layout;
use super::parameters::Dome;
use super::tooling::cup;
use crate::blocks::mounting::{MountHold, MountRing, Mounting};
use crate::blocks::{Joint, corners, ring};
use crate::hardware::{HeatSetNut, Screw};

/// Plastic below the nuts of shell and base, mm.
const NUT_FLOOR_MM: f64 = 1.0;

/// Room behind a heat-set nut, mm.
const NUT_SPARE_MM: f64 = 0.6;

/// Floor left between a mounting hole and the camera pocket, mm.
const MOUNT_FLOOR_MM: f64 = 1.0;

/// All joints, in the sensor frame.
pub struct Joints {
    /// Through the shell, pointing at the axis, into nuts in the base.
    pub shell_base: Joint,
    /// Through the corners of the camera's board into the base.
    pub camera: Joint,
    /// In the base's bottom, for what the sensor is mounted on; a user's screws.
    pub mounting: Joint,
    /// Through the bridge into the cup of the form.
    pub form: Joint,
}

impl Joints {
    /// Where they are; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &Dome, layout: &Layout) -> Self {
        Self {
            shell_base: shell_base(p, layout),
            camera: camera(p, layout),
            mounting: mounting(p, layout).joint(layout.bottom_z_mm),
            form: cup(p, layout).joint(),
        }
    }

    /// The mounting holes, where nuts are melted into them.
    pub fn inserts(&self) -> Option<&Joint> {
        self.mounting.nut_name().map(|_| &self.mounting)
    }
}

fn shell_base(p: &Dome, layout: &Layout) -> Joint {
    let (screw, nut) = (Screw::M2X4, HeatSetNut::M2);
    // Below the camera's pocket, which has no wall to spare for nuts.
    let z = layout.bottom_z_mm + NUT_FLOOR_MM + nut.diameter_mm / 2.0;
    // A flat end lies flush with a round wall where its rim does.
    let flush = |radius: f64, width: f64| {
        let radius = (radius.powi(2) - (width / 2.0).powi(2)).sqrt();
        ring(p.shell.screws, 0.0, Pose::z_to(Vector3::x(), Point3::new(radius, 0.0, z)))
    };
    let heads = flush(layout.shell_radius_mm, screw.head_diameter_mm());
    let nuts = flush(layout.base_radius_mm, nut.diameter_mm);
    Joint::heat_set("screw", screw, heads, (nut, nuts, NUT_SPARE_MM))
}

fn camera(p: &Dome, layout: &Layout) -> Joint {
    let half =
        [p.camera.board.screw_spacing, p.camera.board.screw_spacing_y].map(|mm| mm.mm() / 2.0);
    let poses = corners(half).map(|[x, y]| Pose::translation(x, y, layout.camera_board_top_z_mm));
    // All the way through the base, so that a broken screw can be pushed out.
    let depth = layout.camera_board_top_z_mm - layout.bottom_z_mm + CUT_OVERLAP_MM;
    Joint::self_tapping("camera screw", Screw::M1_6X5, poses.to_vec(), depth)
}

/// Holes for what the sensor is mounted on.
pub(super) fn mounting<'a>(p: &'a Dome, layout: &Layout) -> Mounting<'a> {
    Mounting {
        mount: &p.mount,
        // Half a step off the nuts.
        ring: MountRing::Circle(p.base.mount_holes, p.base.mount_radius, 0.5),
        depth_mm: layout.camera_board_bottom_z_mm - MOUNT_FLOOR_MM - layout.bottom_z_mm,
        is_through: false,
        holds: (
            &[MountHold::Tapped, MountHold::Insert, MountHold::ShortInsert],
            "the camera and the LED board stand above the holes, where heads would be",
        ),
    }
}
