//! What is bought: camera, LEDs, bolts.

use fabkit_geometry::{Body, Color, Pose, Solid};

use super::bodies::*;
use super::housing::leds_by_kind;
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::HalfEllipsoid;
use crate::assembling::{Name, SENSOR};
use crate::blocks::{INTO_MM, LED_YELLOW};

const UV: Color = [170, 130, 230];
const CAMERA_GREY: Color = [60, 62, 70];

/// How far bolts are drawn out in the exploded picture, mm.
const BOLT_OUT_MM: f64 = 8.0;

/// Everything bought.
pub fn components(p: &HalfEllipsoid, layout: &Layout) -> Vec<Body> {
    let led = Solid::cylinder(p.leds.diameter.mm() / 2.0, p.leds.height.mm());
    let [white, uv] = leds_by_kind(p, layout);
    let leds = |name: Name, model: &str, color: Color, poses: Vec<Pose>| {
        let places = poses.into_iter().map(|pose| SENSOR.at(pose).lifted(-40.0));
        name.bought(model, led.clone(), places).colored(color).shining()
    };
    let c = &p.camera;
    let camera_text = format!(
        "{}, {} x {} px at {} fps, {} lens, {} x {} mm",
        c.model,
        c.width_px,
        c.height_px,
        c.frame_rate,
        c.field_of_view,
        c.diameter.mm(),
        c.length.mm()
    );
    let front = Pose::translation(0.0, 0.0, layout.camera_front_z_mm);
    let drawn_out = |pose: &Pose| SENSOR.drawn_out(pose, BOLT_OUT_MM).lifted(-14.0);
    [
        vec![
            CAMERA
                .bought(camera_text, camera(p, layout), [SENSOR.at(front).lifted(6.0)])
                .colored(CAMERA_GREY),
            leds(WHITE_LED, &p.leds.white_model, LED_YELLOW, white),
            leds(UV_LED, &p.leds.uv_model, UV, uv),
        ],
        Joints::new(p, layout).holder.bought(drawn_out, drawn_out),
    ]
    .concat()
}

/// The camera and the beginning of its cable: origin at the lens's front, z forward.
fn camera(p: &HalfEllipsoid, layout: &Layout) -> Solid {
    let length = p.camera.length.mm();
    let head = Solid::cylinder(p.camera.diameter.mm() / 2.0, length).at_z(-length);
    // To the bottom of the base and a little further.
    let end = layout.bottom_z_mm - layout.camera_front_z_mm - 6.0;
    let cable = Solid::cylinder(p.camera.cable_diameter.mm() / 2.0, INTO_MM - length - end);
    Solid::union([head, cable.at_z(end).named("cable")])
}
