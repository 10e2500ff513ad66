//! What is bought: camera, LEDs, bolts.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{Angle, Body, Color, Order, Pose, Solid};

use super::bodies::*;
use super::housing::{leds_by_kind, pocket_radii_mm, wire_places};
use super::joints::Joints;
use super::layout::Layout;
use super::parameters::HalfEllipsoid;
use crate::assembling::{Name, SENSOR};
use crate::blocks::cable::{GIVES_MM, wire_order};
use crate::blocks::{INTO_MM, LED_YELLOW};

const UV: Color = [170, 130, 230];
const CAMERA_GREY: Color = [60, 62, 70];

/// How far bolts are drawn out in the exploded picture, mm.
const BOLT_OUT_MM: f64 = 8.0;

/// How far cable and wires are drawn below the base, mm.
const CABLE_END_MM: f64 = 6.0;

/// Everything bought.
pub fn components(p: &HalfEllipsoid, layout: &Layout) -> Vec<Body> {
    let led = Solid::cylinder(p.leds.diameter.mm() / 2.0, p.leds.height.mm());
    let [white, uv] = leds_by_kind(p, layout);
    let leds = |name: Name, model: &str, color: Color, poses: Vec<Pose>| {
        let places = poses.into_iter().map(|pose| SENSOR.at(pose).lifted(-40.0));
        name.bought(model, led.clone(), places)
            .ordered(Order::of(model, ""))
            .colored(color)
            .shining()
            .sticking()
    };
    let c = &p.camera;
    let camera_text = format!(
        "{}, {}, {} lens, {} x {} mm",
        c.module.model,
        *c.pictures,
        c.field_of_view,
        c.diameter.mm(),
        c.length.mm()
    );
    let front = Pose::translation(0.0, 0.0, layout.camera_front_z_mm);
    let drawn_out = |pose: &Pose| SENSOR.drawn_out(pose, BOLT_OUT_MM).lifted(-14.0);
    let below = Pose::translation(0.0, 0.0, layout.base_top_z_mm);
    let wire = Solid::cylinder(p.led_board.wire_diameter.mm() / 2.0, below_base_mm(layout))
        .at_z(-below_base_mm(layout));
    let wires = wire_places(p, layout)
        .into_iter()
        .map(|[x, y]| SENSOR.at(below.then_in(Pose::translation(x, y, 0.0))).lifted(-50.0));
    let wire_text =
        format!("stranded wire, {} mm over its insulation", p.led_board.wire_diameter.mm());
    [
        vec![
            CAMERA
                .bought(camera_text, camera(p, layout), [SENSOR.at(front).lifted(6.0)])
                .ordered(Order::of(&c.module.model, ""))
                .colored(CAMERA_GREY),
            leds(WHITE_LED, &p.leds.white_model, LED_YELLOW, white),
            leds(UV_LED, &p.leds.uv_model, UV, uv),
            LED_WIRE
                .bought(wire_text, wire, wires)
                .ordered(wire_order(p.led_board.wire_diameter))
                .colored(UV)
                .giving(GIVES_MM),
        ],
        board_parts(p, layout),
        Joints::new(p, layout).holder.bought(drawn_out, drawn_out),
    ]
    .concat()
}

/// Length, width and height of the switch, mm: eight leads 0.5 mm apart (JEDEC MO-187 CA, as TI's DCU0008A).
pub const SWITCH_MM: [f64; 2] = [3.1, 2.0];

/// Length, width and height of a resistor, mm: size 0603 (IEC 60115-8: 1608).
const RESISTOR_MM: [f64; 3] = [1.6, 0.8, 0.45];

/// Whether switch and resistors are drawn.
pub fn has_parts(p: &HalfEllipsoid) -> bool {
    p.led_board.parts_height.mm() > 0.0
}

/// Distance from the axis to the middle of what hangs into the pocket, mm.
fn parts_circle_mm(p: &HalfEllipsoid, layout: &Layout) -> f64 {
    let [inner, outer] = pocket_radii_mm(p, layout);
    (inner + outer) / 2.0
}

/// How far out the switch's corners reach, mm; as far as it reaches inwards, if that is too far.
pub fn switch_reach_mm(p: &HalfEllipsoid, layout: &Layout) -> f64 {
    let [inner, outer] = pocket_radii_mm(p, layout);
    let circle = parts_circle_mm(p, layout);
    let out = (circle + SWITCH_MM[1] / 2.0).hypot(SWITCH_MM[0] / 2.0);
    out.max(outer + inner - (circle - SWITCH_MM[1] / 2.0))
}

/// Where what hangs into the pocket is: origin on the board's lower side, x axis outwards.
pub struct BoardPartPoses {
    /// The switch.
    pub switch: Pose,
    /// The resistors of the white and of the UV LEDs.
    pub resistors: [Pose; 2],
}

/// The switch opposite to the wires, a resistor on each side.
pub fn board_part_poses(p: &HalfEllipsoid, layout: &Layout) -> BoardPartPoses {
    let at = |quarters: f64| {
        let rad = p.base.cable_angle.rad() + quarters * FRAC_PI_2;
        let turn = Pose::rotation_z(Angle::from_rad(rad).expect("a sum of finite angles"));
        turn.then_in(Pose::translation(parts_circle_mm(p, layout), 0.0, layout.base_top_z_mm))
    };
    BoardPartPoses { switch: at(2.0), resistors: [at(1.0), at(3.0)] }
}

/// Dual switch and resistors under the board: the switch opposite to the wires, a resistor on each side.
fn board_parts(p: &HalfEllipsoid, layout: &Layout) -> Vec<Body> {
    if !has_parts(p) {
        return Vec::new();
    }
    let poses = board_part_poses(p, layout);
    let at = |pose: Pose| SENSOR.at(pose).lifted(-50.0);
    // Lengthwise along the circle, hanging from the board.
    let block =
        |[length, width]: [f64; 2], height: f64| Solid::cuboid(width, length, height).at_z(-height);
    let height = p.led_board.parts_height.mm();
    let [length, width, least] = RESISTOR_MM;
    vec![
        SWITCH
            .bought(p.led_board.switch_model.as_str(), block(SWITCH_MM, height), [at(poses.switch)])
            .ordered(Order::of(&p.led_board.switch_model, ""))
            .colored(CAMERA_GREY),
        RESISTOR
            .bought(
                "resistor 0603, for the current of one kind of LEDs",
                block([length, width], least.min(height)),
                poses.resistors.map(at),
            )
            .ordered(Order::of("resistor", "0603"))
            .colored(CAMERA_GREY),
    ]
}

/// Length of a wire from the board to below the base, mm.
fn below_base_mm(layout: &Layout) -> f64 {
    layout.base_top_z_mm - layout.bottom_z_mm + CABLE_END_MM
}

/// The camera and the beginning of its cable: origin at the lens's front, z forward.
fn camera(p: &HalfEllipsoid, layout: &Layout) -> Solid {
    let length = p.camera.length.mm();
    let head = Solid::cylinder(p.camera.diameter.mm() / 2.0, length).at_z(-length);
    // To the bottom of the base and a little further.
    let end = layout.bottom_z_mm - layout.camera_front_z_mm - CABLE_END_MM;
    let cable = Solid::cylinder(p.camera.cable_diameter.mm() / 2.0, INTO_MM - length - end);
    Solid::union([head, cable.at_z(end).named("cable")])
}
