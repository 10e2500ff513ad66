//! What is bought: camera, LEDs, bolts.

use fabkit_geometry::{Body, Color, Placement, Pose, Solid, Vector3};

use super::SENSOR;
use super::housing::{bolt_pose, led_pose, uv_leds};
use super::layout::{BOLT, Layout};
use super::parameters::HalfEllipsoid;

const STEEL: Color = [176, 180, 186];
const WHITE_LED: Color = [250, 240, 170];
const UV_LED: Color = [170, 130, 230];
const CAMERA: Color = [60, 62, 70];

/// How far bolts are drawn out in the exploded picture, mm.
const BOLT_OUT_MM: f64 = 8.0;

/// Everything bought.
pub fn components(p: &HalfEllipsoid, layout: &Layout) -> Vec<Body> {
    let led = Solid::cylinder(p.leds.diameter.mm() / 2.0, p.leds.height.mm());
    let leds = |name: &str, model: &str, color: Color, indices: Vec<u32>| {
        Body::bought(name, model, led.clone())
            .placed(indices.into_iter().map(|i| SENSOR.at(led_pose(p, layout, i)).lifted(-40.0)))
            .one_per_place()
            .colored(color)
    };
    let bolts = (0..p.base.bolts).map(|i| {
        let pose = bolt_pose(p, layout, i);
        let out = pose.vector(Vector3::new(0.0, 0.0, BOLT_OUT_MM));
        SENSOR.at(pose).moved_apart(out).lifted(-14.0)
    });
    vec![
        Body::bought(
            "camera",
            format!(
                "{}, {} x {} px at {} fps, {} lens, {} x {} mm",
                p.camera.model,
                p.camera.width_px,
                p.camera.height_px,
                p.camera.frame_rate,
                p.camera.field_of_view,
                p.camera.diameter.mm(),
                p.camera.length.mm()
            ),
            camera(p, layout),
        )
        .placed([Placement {
            assembly_from_body: Pose::translation(0.0, 0.0, layout.camera_front_z),
            ..SENSOR.in_place()
        }
        .lifted(6.0)])
        .colored(CAMERA),
        leds(
            "white-led",
            &p.leds.white_model,
            WHITE_LED,
            (0..p.leds.pairs).map(|i| 2 * i).collect(),
        ),
        leds("uv-led", &p.leds.uv_model, UV_LED, uv_leds(p).collect()),
        Body::bought(
            "bolt-m1-2x3",
            format!("countersunk screw {} M1.2x3", BOLT.standard()),
            BOLT.solid(),
        )
        .placed(bolts)
        .times(p.base.bolts)
        .colored(STEEL),
    ]
}

/// The camera and the beginning of its cable: origin at the lens's front, z forward.
fn camera(p: &HalfEllipsoid, layout: &Layout) -> Solid {
    // Pieces of one body reach into each other, so that no faces coincide.
    let into = 0.2;
    let length = p.camera.length.mm();
    let head = Solid::cylinder(p.camera.diameter.mm() / 2.0, length).at(0.0, 0.0, -length);
    // To the bottom of the base and a little further.
    let end = layout.bottom_z - layout.camera_front_z - 6.0;
    let cable =
        Solid::cylinder(p.camera.cable_diameter.mm() / 2.0, into - length - end).at(0.0, 0.0, end);
    Solid::union([head, cable.named("cable")])
}
