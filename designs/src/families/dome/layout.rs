//! Where things are: every radius and height that more than one part needs, derived once.

use fabkit_geometry::Process;

use super::parameters::Dome;
use crate::fits::{Fit, gap_mm};

/// Radii and heights in the sensor frame, mm.
///
/// From the tip down the sensor is a stack without play: layers and tube stand on the diffuser at
/// z = 0, ribs in the shell hold the diffuser and the LED board 10 mm apart, the base pushes the
/// board against the ribs and ends flush with the shell.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Height of the straight wall, and of all domes' centres.
    pub wall_height: f64,
    /// Outside of everything: the coat.
    pub surface_radius: f64,
    /// Between translucent gel and coat.
    pub translucent_radius: f64,
    /// Between transparent and translucent gel.
    pub transparent_radius: f64,
    /// Outside of the tube.
    pub tube_radius: f64,
    /// Inside of the tube.
    pub tube_bore_radius: f64,

    /// Outside of shell and base.
    pub shell_radius: f64,
    /// Inside of the shell.
    pub shell_bore_radius: f64,
    /// How far ribs reach inwards: their smallest radius.
    pub rib_radius: f64,
    /// Outside of the diffuser.
    pub diffuser_radius: f64,
    /// Outside of the LED board.
    pub board_radius: f64,
    /// Outside of the base's plug.
    pub base_radius: f64,

    /// Bottom of the diffuser, top of the ribs.
    pub diffuser_bottom_z: f64,
    /// Top of the LED board, bottom of the ribs.
    pub board_top_z: f64,
    /// Bottom of the LED board, top of the base.
    pub base_top_z: f64,
    /// Bottom of base and shell.
    pub bottom_z: f64,

    /// Front face of the camera's lens.
    pub lens_front_z: f64,
    /// Side of the camera board that carries the lens.
    pub camera_board_top_z: f64,
    /// Side of the camera board that rests on the base.
    pub camera_board_bottom_z: f64,
    /// Floor of the pocket behind the camera board.
    pub relief_z: f64,
}

impl Layout {
    /// Derives the layout; meaningful only for parameters that satisfy the family's constraints.
    pub fn new(p: &Dome) -> Self {
        let surface_radius = p.surface.radius.mm();
        let transparent_radius = surface_radius - p.translucent_gel.thickness.mm();
        let tube_radius = p.tube.outer_diameter.mm() / 2.0;
        let shell_radius = p.shell.outer_diameter.mm() / 2.0;
        let shell_bore_radius = shell_radius - p.shell.wall.mm();

        let diffuser_bottom_z = -p.diffuser.thickness.mm();
        let board_top_z = diffuser_bottom_z - p.diffuser.height_above_board.mm();
        let base_top_z = board_top_z - p.led_board.thickness.mm();
        let bottom_z = base_top_z - p.base.height.mm();

        let lens_front_z = -p.camera.depth.mm() + p.camera.pupil_behind_front.mm();
        let camera_board_top_z = lens_front_z - p.camera.lens_height.mm();
        let camera_board_bottom_z = camera_board_top_z - p.camera.board_thickness.mm();
        Self {
            wall_height: p.surface.wall_height.mm(),
            surface_radius,
            translucent_radius: surface_radius - p.coat.thickness.mm(),
            transparent_radius,
            tube_radius,
            tube_bore_radius: tube_radius - p.tube.wall.mm(),
            shell_radius,
            shell_bore_radius,
            rib_radius: shell_bore_radius - p.shell.rib_depth.mm(),
            diffuser_radius: shell_bore_radius - gap_mm(Process::Fdm, Fit::Slide),
            board_radius: shell_bore_radius - gap_mm(Process::Pcb, Fit::Press),
            base_radius: shell_bore_radius - gap_mm(Process::Fdm, Fit::Slide),
            diffuser_bottom_z,
            board_top_z,
            base_top_z,
            bottom_z,
            lens_front_z,
            camera_board_top_z,
            camera_board_bottom_z,
            relief_z: camera_board_bottom_z - p.camera.back_clearance.mm(),
        }
    }

    /// Height of the shell, from the board's seat side to the sensing surface's foot.
    pub fn shell_height(&self) -> f64 {
        -self.bottom_z
    }

    /// Height of the whole sensor.
    pub fn total_height(&self) -> f64 {
        self.wall_height + self.surface_radius - self.bottom_z
    }

    /// Height of the apex above the foot.
    pub fn apex_z(&self) -> f64 {
        self.wall_height + self.surface_radius
    }
}
