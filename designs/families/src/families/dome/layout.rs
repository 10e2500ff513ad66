//! Where things are: every radius and height that more than one part needs, derived once.

use fabkit_geometry::Process;

use super::bodies::SHELL;
use super::parameters::Dome;
use crate::fits::Fit;
use crate::layout;

layout! {
    /// Radii and heights in the sensor frame, mm.
    ///
    /// From the tip down the sensor is a stack without play: layers and tube stand on the diffuser
    /// at z = 0, ribs in the shell hold the diffuser and the LED board 10 mm apart, the base pushes
    /// the board against the ribs and ends flush with the shell.
    pub struct Layout from p: &Dome {
        /// Height of the straight wall, and of all domes' centres.
        wall_height_mm = p.surface.wall_height.mm();
        /// Outside of everything: the coat.
        surface_radius_mm = p.surface.radius.mm();
        /// Between translucent gel and coat.
        translucent_radius_mm = surface_radius_mm - p.coat.thickness.mm();
        /// Between transparent and translucent gel.
        transparent_radius_mm = surface_radius_mm - p.translucent_gel.thickness.mm();
        /// Outside of the tube.
        tube_radius_mm = p.tube.outer_diameter.mm() / 2.0;
        /// Inside of the tube.
        tube_bore_radius_mm = tube_radius_mm - p.tube.wall.mm();

        /// Outside of shell and base.
        shell_radius_mm = p.shell.outer_diameter.mm() / 2.0;
        /// Inside of the shell.
        shell_bore_radius_mm = shell_radius_mm - p.shell.wall.mm();
        let slide = p.making.gap_mm(SHELL, Process::Fdm, Fit::Slide);
        /// How far ribs reach inwards: their smallest radius.
        rib_radius_mm = shell_bore_radius_mm - p.shell.rib_depth.mm();
        /// Outside of the diffuser.
        diffuser_radius_mm =
            shell_bore_radius_mm - slide - p.shell.shoulder.mm();
        /// Outside of the LED board.
        board_radius_mm = shell_bore_radius_mm - p.making.gap_mm(SHELL, Process::Fdm, Fit::Press);
        /// Outside of the base's plug.
        base_radius_mm = shell_bore_radius_mm - slide;

        /// Bottom of the diffuser, top of the ribs.
        diffuser_bottom_z_mm = -p.diffuser.thickness.mm();
        /// Inside of the rim around the diffuser.
        seat_radius_mm = shell_bore_radius_mm - p.shell.shoulder.mm();
        /// Face of the gel that looks at the camera.
        gel_face_z_mm = match p.filling_gel.lock_depth.mm() {
            0.0 => 0.0,
            depth => diffuser_bottom_z_mm - depth,
        };
        /// Top of the LED board, bottom of the ribs.
        board_top_z_mm = diffuser_bottom_z_mm - p.diffuser.height_above_board.mm();
        /// Bottom of the LED board, top of the base.
        base_top_z_mm = board_top_z_mm - p.led_board.thickness.mm();
        /// Bottom of base and shell.
        bottom_z_mm = base_top_z_mm - p.base.height.mm();

        /// Front face of the camera's lens.
        lens_front_z_mm = -p.camera.depth.mm() + p.camera.board.pupil_behind_front.mm();
        /// Side of the camera board that carries the lens.
        camera_board_top_z_mm = lens_front_z_mm - p.camera.board.lens_height.mm();
        /// Side of the camera board that rests on the base.
        camera_board_bottom_z_mm = camera_board_top_z_mm - p.camera.board.board_thickness.mm();
        /// Floor of the pocket behind the camera board.
        relief_z_mm = camera_board_bottom_z_mm - p.camera.back_clearance.mm();
    }
}

/// Between a lens holder below the LED board and the board, mm.
const HOLDER_BELOW_MM: f64 = 0.5;

impl Layout {
    /// Whether the camera's lens holder ends below the LED board: only the barrel passes that.
    pub fn is_holder_below(&self, p: &Dome) -> bool {
        let barrel_mm = p.camera.board.lens_height.mm() - p.camera.board.holder_height.mm();
        self.lens_front_z_mm - barrel_mm <= self.base_top_z_mm - HOLDER_BELOW_MM + 1e-9
    }

    /// How far from the axis what passes the LED board reaches: the barrel, and its holder's corners if
    /// that is as high, mm.
    pub fn passing_mm(&self, p: &Dome) -> f64 {
        let barrel = p.camera.board.barrel_diameter.mm() / 2.0;
        match self.is_holder_below(p) {
            true => barrel,
            false => barrel.max(p.camera.board.holder_size.mm() / std::f64::consts::SQRT_2),
        }
    }

    /// Height of the shell, from the board's seat side to the sensing surface's foot.
    pub fn shell_height(&self) -> f64 {
        -self.bottom_z_mm
    }

    /// Height of the whole sensor.
    pub fn total_height(&self) -> f64 {
        self.wall_height_mm + self.surface_radius_mm - self.bottom_z_mm
    }

    /// Height of the apex above the foot.
    pub fn apex_z(&self) -> f64 {
        self.wall_height_mm + self.surface_radius_mm
    }
}
