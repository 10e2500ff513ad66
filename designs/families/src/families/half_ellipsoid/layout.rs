//! Where things are: every radius and height that more than one part needs, derived once.

use fabkit_geometry::Process;

use super::bodies::{BASE, HOLDER, POST};
use super::parameters::{HalfEllipsoid, MeasuredTo};
use super::surface::Ellipsoid;
use crate::fits::Fit;
use crate::hardware::Screw;
use crate::layout;

/// Room between the shell's foot and the step of its holder, mm: glue runs in there.
const FOOT_SPARE_MM: f64 = 0.8;

/// Gap between the holder's step and the diffuser, mm: the base stops on its flange, not here.
const STEP_GAP_MM: f64 = 0.1;

/// Plastic between a bolt's hole and the pocket above it, or the skirt's end below its head, mm.
const BOLT_WALL_MM: f64 = 0.6;

/// The bolts of the housing.
pub const BOLT: Screw = Screw::M1_2X3;

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// Downwards from the base circle: the holder's collar around the shell's foot, a step, and the
    /// skirt around diffuser, LEDs, board and base, which stand on each other.
    pub struct Layout from p: &HalfEllipsoid {
        /// What all layers are offset from.
        ellipsoid: Ellipsoid =
            Ellipsoid { equatorial: p.surface.diameter.mm() / 2.0, polar: p.surface.height.mm() };
        /// Offset of the black gel's outside: the finished surface.
        black_offset_mm = match p.surface.measured_to {
            MeasuredTo::BlackGel => 0.0,
            MeasuredTo::OuterElastomer => p.black_gel.thickness.mm(),
        };
        /// Offset of the outer elastomer's outside.
        outer_offset_mm = black_offset_mm - p.black_gel.thickness.mm();
        let without_outer = outer_offset_mm - p.outer_elastomer.thickness.mm();
        /// Offset of the inner elastomer's outside: without markers it is cast as thick as both together.
        inner_offset_mm = match p.markers.is_plain() {
            true => outer_offset_mm,
            false => without_outer,
        };
        /// Offset of the shell's outside.
        shell_offset_mm = without_outer - p.inner_elastomer.thickness.mm();
        /// Depth of the shell's inside below the ellipsoid.
        cavity_depth_mm = p.shell.thickness.mm() - shell_offset_mm;

        /// Outside of the shell's foot.
        foot_radius_mm = ellipsoid.equatorial + shell_offset_mm - p.shell.shoulder.mm();
        /// Lower end of the foot.
        foot_z_mm = -p.shell.foot_height.mm();
        /// Outside of holder and flange.
        holder_radius_mm = p.holder.outer_diameter.mm() / 2.0;
        let snug = p.making.gap_mm(HOLDER, Process::Sla, Fit::Snug);
        /// Inside of the holder's collar.
        collar_radius_mm = foot_radius_mm + snug;
        /// Step between collar and skirt.
        step_z_mm = foot_z_mm - FOOT_SPARE_MM;
        /// Inside of the skirt.
        skirt_radius_mm = holder_radius_mm - p.holder.skirt.mm();
        /// Outside of diffuser and board.
        board_radius_mm = skirt_radius_mm - p.making.gap_mm(HOLDER, Process::Sla, Fit::Free);
        /// Outside of the base's plug.
        base_radius_mm = skirt_radius_mm - p.making.gap_mm(HOLDER, Process::Sla, Fit::Slide);

        /// Top of the diffuser.
        diffuser_top_z_mm = step_z_mm - STEP_GAP_MM;
        /// Underside of the diffuser's plate.
        diffuser_plate_z_mm = diffuser_top_z_mm - p.diffuser.thickness.mm();
        /// Inside of the diffuser's wall.
        diffuser_wall_radius_mm = board_radius_mm - p.diffuser.wall.mm();
        /// Top of the board, where the LEDs stand.
        board_top_z_mm = diffuser_plate_z_mm - p.diffuser.gap.mm() - p.leds.height.mm();
        /// Top of the base, where the board lies.
        base_top_z_mm = board_top_z_mm - p.led_board.thickness.mm();
        /// Floor of the pocket for the board's parts.
        pocket_z_mm = base_top_z_mm - p.base.pocket_depth.mm();
        /// Axes of the bolts.
        bolt_z_mm = pocket_z_mm - BOLT_WALL_MM - BOLT.pilot_hole_mm() / 2.0;
        /// End of the skirt, top of the flange.
        flange_z_mm = bolt_z_mm - BOLT.sink_diameter_mm(snug) / 2.0 - BOLT_WALL_MM;
        /// Bottom of everything.
        bottom_z_mm = flange_z_mm - p.base.flange.mm();

        /// Inside of it.
        post_bore_radius_mm = p.camera.diameter.mm() / 2.0
            + p.making.gap_mm(POST, Process::Sla, Fit::Snug);
        /// Outside of the post that carries the camera.
        post_radius_mm = post_bore_radius_mm + p.camera_holder.wall.mm();
        /// Front of camera and post.
        camera_front_z_mm = -p.camera.front_depth.mm();
        /// Lower end of the post, in the base.
        post_end_z_mm = base_top_z_mm - p.camera_holder.socket_depth.mm();
        // One passage through both: the larger gap.
        let passed = [POST, BASE].map(|part| (part, Process::Sla));
        /// Radius of the passage for the camera's cable.
        cable_radius_mm =
            p.camera.cable_diameter.mm() / 2.0 + p.making.widest_mm(passed, Fit::Free);

        /// Outside of the silicone molds.
        silicone_radius_mm = p.tooling.silicone_diameter.mm() / 2.0;
        /// Far end of the silicone molds.
        silicone_top_z_mm = ellipsoid.polar + black_offset_mm + p.tooling.silicone_floor.mm();
        /// Far side of the core's flange.
        core_flange_z_mm = -p.tooling.core_flange.mm();
    }
}

impl Layout {
    /// Radius of the base circle of the surface at an offset, mm.
    pub fn foot_of(&self, offset: f64) -> f64 {
        self.ellipsoid.equatorial + offset
    }

    /// Inside of the shell's foot, mm.
    pub fn bore_radius(&self) -> f64 {
        self.ellipsoid.equatorial - self.cavity_depth_mm
    }
}
