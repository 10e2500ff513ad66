//! Where things are: every radius and height that more than one part needs, derived once.

use fabkit_geometry::Process;

use super::parameters::{HalfEllipsoid, MeasuredTo};
use super::surface::Ellipsoid;
use crate::fits::{Fit, gap_mm};
use crate::hardware::Screw;

/// Room between the shell's foot and the step of its holder, mm: glue runs in there.
const FOOT_SPARE_MM: f64 = 0.8;

/// Gap between the holder's step and the diffuser, mm: the base stops on its flange, not here.
const STEP_GAP_MM: f64 = 0.1;

/// Plastic between a bolt's hole and the pocket above it, or the skirt's end below its head, mm.
const BOLT_WALL_MM: f64 = 0.6;

/// The bolts of the housing.
pub const BOLT: Screw = Screw::M1_2X3;

/// Radii and heights in the sensor frame, mm.
///
/// Downwards from the base circle: the holder's collar around the shell's foot, a step, and the
/// skirt around diffuser, LEDs, board and base, which stand on each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// What all layers are offset from.
    pub ellipsoid: Ellipsoid,
    /// Offset of the black gel's outside: the finished surface.
    pub black_offset: f64,
    /// Offset of the outer elastomer's outside.
    pub outer_offset: f64,
    /// Offset of the inner elastomer's outside.
    pub inner_offset: f64,
    /// Offset of the shell's outside.
    pub shell_offset: f64,
    /// Depth of the shell's inside below the ellipsoid.
    pub cavity_depth: f64,

    /// Outside of the shell's foot.
    pub foot_radius: f64,
    /// Lower end of the foot.
    pub foot_z: f64,
    /// Outside of holder and flange.
    pub holder_radius: f64,
    /// Inside of the holder's collar.
    pub collar_radius: f64,
    /// Step between collar and skirt.
    pub step_z: f64,
    /// Inside of the skirt.
    pub skirt_radius: f64,
    /// Outside of diffuser and board.
    pub board_radius: f64,
    /// Outside of the base's plug.
    pub base_radius: f64,

    /// Top of the diffuser.
    pub diffuser_top_z: f64,
    /// Underside of the diffuser's plate.
    pub diffuser_plate_z: f64,
    /// Inside of the diffuser's wall.
    pub diffuser_wall_radius: f64,
    /// Top of the board, where the LEDs stand.
    pub board_top_z: f64,
    /// Top of the base, where the board lies.
    pub base_top_z: f64,
    /// Floor of the pocket for the board's parts.
    pub pocket_z: f64,
    /// Axes of the bolts.
    pub bolt_z: f64,
    /// End of the skirt, top of the flange.
    pub flange_z: f64,
    /// Bottom of everything.
    pub bottom_z: f64,

    /// Outside of the post that carries the camera.
    pub post_radius: f64,
    /// Inside of it.
    pub post_bore_radius: f64,
    /// Front of camera and post.
    pub camera_front_z: f64,
    /// Lower end of the post, in the base.
    pub post_end_z: f64,
    /// Radius of the passage for the camera's cable.
    pub cable_radius: f64,

    /// Outside of the silicone molds.
    pub silicone_radius: f64,
    /// Far end of the silicone molds.
    pub silicone_top_z: f64,
    /// Far side of the core's flange.
    pub core_flange_z: f64,
}

impl Layout {
    /// Derives everything from the parameters.
    pub fn new(p: &HalfEllipsoid) -> Self {
        let ellipsoid =
            Ellipsoid { equatorial: p.surface.diameter.mm() / 2.0, polar: p.surface.height.mm() };
        let black_offset = match p.surface.measured_to {
            MeasuredTo::BlackGel => 0.0,
            MeasuredTo::OuterElastomer => p.black_gel.thickness.mm(),
        };
        let outer_offset = black_offset - p.black_gel.thickness.mm();
        let inner_offset = outer_offset - p.outer_elastomer.thickness.mm();
        let shell_offset = inner_offset - p.inner_elastomer.thickness.mm();

        let foot_radius = ellipsoid.equatorial + shell_offset - p.shell.shoulder.mm();
        let foot_z = -p.shell.foot_height.mm();
        let holder_radius = p.holder.outer_diameter.mm() / 2.0;
        let step_z = foot_z - FOOT_SPARE_MM;
        let skirt_radius = holder_radius - p.holder.skirt.mm();
        let board_radius = skirt_radius - gap_mm(Process::Sla, Fit::Free);

        let diffuser_top_z = step_z - STEP_GAP_MM;
        let diffuser_plate_z = diffuser_top_z - p.diffuser.thickness.mm();
        let board_top_z = diffuser_plate_z - p.diffuser.gap.mm() - p.leds.height.mm();
        let base_top_z = board_top_z - p.led_board.thickness.mm();
        let pocket_z = base_top_z - p.base.pocket_depth.mm();
        let bolt_z = pocket_z - BOLT_WALL_MM - BOLT.pilot_hole_mm() / 2.0;
        let flange_z =
            bolt_z - BOLT.sink_diameter_mm(gap_mm(Process::Sla, Fit::Snug)) / 2.0 - BOLT_WALL_MM;

        let post_bore_radius = p.camera.diameter.mm() / 2.0 + gap_mm(Process::Sla, Fit::Snug);
        Self {
            ellipsoid,
            black_offset,
            outer_offset,
            inner_offset,
            shell_offset,
            cavity_depth: p.shell.thickness.mm() - shell_offset,
            foot_radius,
            foot_z,
            holder_radius,
            collar_radius: foot_radius + gap_mm(Process::Sla, Fit::Snug),
            step_z,
            skirt_radius,
            board_radius,
            base_radius: skirt_radius - gap_mm(Process::Sla, Fit::Slide),
            diffuser_top_z,
            diffuser_plate_z,
            diffuser_wall_radius: board_radius - p.diffuser.wall.mm(),
            board_top_z,
            base_top_z,
            pocket_z,
            bolt_z,
            flange_z,
            bottom_z: flange_z - p.base.flange.mm(),
            post_radius: post_bore_radius + p.camera_holder.wall.mm(),
            post_bore_radius,
            camera_front_z: -p.camera.front_depth.mm(),
            post_end_z: base_top_z - p.camera_holder.socket_depth.mm(),
            cable_radius: p.camera.cable_diameter.mm() / 2.0 + gap_mm(Process::Sla, Fit::Free),
            silicone_radius: p.tooling.silicone_diameter.mm() / 2.0,
            silicone_top_z: ellipsoid.polar + black_offset + p.tooling.silicone_floor.mm(),
            core_flange_z: -p.tooling.core_flange.mm(),
        }
    }

    /// Radius of the base circle of the surface at an offset, mm.
    pub fn foot_of(&self, offset: f64) -> f64 {
        self.ellipsoid.equatorial + offset
    }

    /// Inside of the shell's foot, mm.
    pub fn bore_radius(&self) -> f64 {
        self.ellipsoid.equatorial - self.cavity_depth
    }
}
