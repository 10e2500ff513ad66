//! What is bought: camera, LEDs, screws, dowels.

use fabkit_geometry::{Body, Pose, Process, Solid};

use super::housing::{led_poses, post_mm};
use super::joints::Joints;
use super::layout::Layout;
use super::pad::{frames, molds};
use super::parameters::{FlatGel, LightFrom};
use super::{INTO_MM, in_sensor};
use crate::assembling::SENSOR;
use crate::blocks::{CAMERA_GREEN, LED_YELLOW, board_camera, bought, merged};
use crate::fits::{Fit, gap_mm};

/// Room between the camera's connector and the base, mm.
const CONNECTOR_ABOVE_MM: f64 = 0.5;

/// Edge of the connector behind the camera's board, mm: it lies between the posts.
pub fn connector_mm(p: &FlatGel) -> f64 {
    p.camera.screw_spacing.mm() - 2.0 * (post_mm() + gap_mm(Process::Fdm, Fit::Slide))
}

/// Everything bought.
pub fn components(p: &FlatGel, layout: &Layout) -> Vec<Body> {
    let c = &p.camera;
    let camera = format!(
        "{}, {} x {} px at {} fps, {} lens, board {} x {} mm",
        c.model,
        c.width_px,
        c.height_px,
        c.frame_rate,
        c.field_of_view,
        c.board_size.mm(),
        c.board_size.mm()
    );
    let joints = Joints::new(p, layout);
    let leds = led_poses(p, layout);
    let leds = leds.iter().map(|pose| SENSOR.drawn_out(pose, 2.0).lifted(-12.0));
    let lifted = |z_mm: f64| move |pose: &Pose| SENSOR.at(*pose).lifted(z_mm);
    let screws = [
        joints.camera.bought(lifted(-18.0), lifted(0.0)),
        joints.casing.bought(lifted(-52.0), lifted(0.0)),
    ];
    let rest = vec![
        bought("camera", camera, camera_solid(p, layout), [in_sensor().lifted(-28.0)])
            .colored(CAMERA_GREEN),
        bought("led", p.leds.model.clone(), led(p), leds).colored(LED_YELLOW),
        frames(p, layout).dowels(molds(p)),
    ];
    merged(rest.into_iter().chain(screws.into_iter().flatten()))
}

fn camera_solid(p: &FlatGel, layout: &Layout) -> Solid {
    let thickness = p.camera.board_thickness.mm();
    let holes = Joints::new(p, layout).camera.passed(thickness, gap_mm(Process::Pcb, Fit::Snug));
    let (edge, bottom) = (connector_mm(p), layout.joint_z + CONNECTOR_ABOVE_MM);
    let connector = Solid::cuboid(edge, edge / 2.0, layout.board_bottom_z + INTO_MM - bottom)
        .at_z(bottom)
        .named("connector");
    board_camera!(p.camera).solid(
        [layout.board_bottom_z, layout.board_top_z],
        holes.tools,
        connector,
    )
}

/// A package; at the walls on its piece of strip, whose back is z = 0 and whose width lies along y.
fn led(p: &FlatGel) -> Solid {
    let leds = &p.leds;
    let (length, width, height) = (leds.pitch.mm(), leds.width.mm(), leds.package_height.mm());
    match leds.from {
        LightFrom::Below => Solid::cuboid(length, width, height),
        LightFrom::Sides => {
            let thickness = leds.board_thickness.mm();
            let size = 0.7 * length.min(width);
            let into = thickness / 2.0;
            let package = Solid::cuboid(size, size, height + into).at_z(thickness - into);
            Solid::union([Solid::cuboid(length, width, thickness), package])
        }
    }
}
