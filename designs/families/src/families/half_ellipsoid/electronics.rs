//! Bought components, the LED circuit, and the wires.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{
    Angle, BoardPlacement, BoardSide, Body, Circuit, CircuitKind, CircuitPart, Color, Land, Order,
    Pose, Solid, Vector3,
};

use super::housing::{leds_by_kind, pocket_radii_mm, wire_positions, wire_slot};
use super::parameters::*;
use super::{HalfEllipsoidLayout, Joints};
use crate::blocks::cable::{GIVE_WAY_MM, wire_order};
use crate::blocks::circuit::{
    BoardWire, CHIP_0603, CircuitBuilder, Electric, GROUND, LedPackage, SUPPLY, along_y,
    camera_to_host, ring_region,
};
use crate::blocks::{INTO_MM, LED_YELLOW};
use crate::chain_builder::{Name, SENSOR};

// ------ Components ------
//
// Bought components: camera, LEDs, switch, resistors, wires, bolts.

const UV: Color = [170, 130, 230];
const CAMERA_GREY: Color = [60, 62, 70];

/// Displacement of the bolts in the exploded view, mm.
const BOLT_OUT_MM: f64 = 8.0;

/// Drawn length of cable and wires below the base, mm.
const CABLE_END_MM: f64 = 6.0;

/// Returns all bought components.
pub fn components(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Body> {
    let led = Solid::cylinder(p.leds.diameter.mm() / 2.0, p.leds.height.mm());
    let [white, uv] = leds_by_kind(p, layout);
    let leds = |name: Name, model: &str, color: Color, poses: Vec<Pose>| {
        let places = poses.into_iter().map(|pose| SENSOR.at(pose).lifted(-40.0));
        name.bought(model, led.clone(), places)
            .with_order(Order::new(model, ""))
            .colored(color)
            .as_light_source()
            .as_attached()
    };
    let c = &p.camera;
    let camera_text = format!(
        "{}, {}, {} deg lens, {} x {} mm",
        c.module.model,
        *c.images,
        // A tenth of a degree: no maker states a view more closely.
        (10.0 * c.field_of_view.deg()).round() / 10.0,
        c.diameter.mm(),
        c.length.mm()
    );
    let front = Pose::translation(0.0, 0.0, layout.camera_front_z_mm);
    let drawn_out = |pose: &Pose| SENSOR.at_exploded(pose, BOLT_OUT_MM).lifted(-14.0);
    let below = Pose::translation(0.0, 0.0, layout.base_top_z_mm);
    let wire = Solid::cylinder(p.led_board.wire_diameter.mm() / 2.0, drawn_wire_mm(layout))
        .at_z(-drawn_wire_mm(layout));
    let wires = wire_positions(p, layout)
        .into_iter()
        .map(|[x, y]| SENSOR.at(below.then_in(Pose::translation(x, y, 0.0))).lifted(-50.0));
    let wire_text =
        format!("stranded wire, {} mm over its insulation", p.led_board.wire_diameter.mm());
    [
        vec![
            CAMERA
                .bought(camera_text, camera(p, layout), [SENSOR.at(front).lifted(6.0)])
                .with_order(Order::new(&c.module.model, ""))
                .colored(CAMERA_GREY),
            leds(WHITE_LED, &p.leds.white_model, LED_YELLOW, white),
            leds(UV_LED, &p.leds.uv_model, UV, uv),
            LED_WIRE
                .bought(wire_text, wire, wires)
                .with_order(wire_order(p.led_board.wire_diameter))
                .colored(UV)
                .with_assembly_compliance(GIVE_WAY_MM),
        ],
        board_parts(p, layout),
        Joints::new(p, layout).holder.bought(drawn_out, drawn_out),
    ]
    .concat()
}

/// Length and width of the switch, mm: eight leads 0.5 mm apart (JEDEC MO-187 CA, as TI's DCU0008A).
pub const SWITCH_MM: [f64; 2] = [3.1, 2.0];

/// Length, width and height of a resistor, mm: size 0603 (IEC 60115-8: 1608).
const RESISTOR_MM: [f64; 3] = [1.6, 0.8, 0.45];

/// Returns whether switch and resistors are drawn on the board's lower side.
pub fn has_board_parts(p: &HalfEllipsoid) -> bool {
    p.led_board.parts_height.mm() > 0.0
}

/// Distance from the axis to the centre of the parts that hang into the pocket, mm.
fn parts_circle_mm(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> f64 {
    let [inner, outer] = pocket_radii_mm(p, layout);
    (inner + outer) / 2.0
}

/// Outer radius that the pocket needs for the switch, mm: that of the switch's outer corners. If the switch reaches
/// too far inwards, the excess is added to the pocket's outer radius instead.
pub fn switch_pocket_radius_mm(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> f64 {
    let [inner, outer] = pocket_radii_mm(p, layout);
    let circle = parts_circle_mm(p, layout);
    let out = (circle + SWITCH_MM[1] / 2.0).hypot(SWITCH_MM[0] / 2.0);
    out.max(outer + inner - (circle - SWITCH_MM[1] / 2.0))
}

/// Poses of the parts that hang into the pocket: origin on the board's lower side, x axis outwards.
pub struct BoardPartPoses {
    /// Pose of the switch.
    pub switch: Pose,
    /// Poses of the resistors of the white and of the UV LEDs.
    pub resistors: [Pose; 2],
}

/// Returns the poses: the switch opposite the wires, a resistor on each side.
pub fn board_part_poses(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> BoardPartPoses {
    let at = |quarters: f64| {
        let rad = p.base.cable_angle.rad() + quarters * FRAC_PI_2;
        let turn = Pose::rotation_z(Angle::from_rad(rad).expect("a sum of finite angles"));
        turn.then_in(Pose::translation(parts_circle_mm(p, layout), 0.0, layout.base_top_z_mm))
    };
    BoardPartPoses { switch: at(2.0), resistors: [at(1.0), at(3.0)] }
}

/// Returns the dual switch and the resistors under the board; empty if they are not drawn.
fn board_parts(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Vec<Body> {
    if !has_board_parts(p) {
        return Vec::new();
    }
    let poses = board_part_poses(p, layout);
    let at = |pose: Pose| SENSOR.at(pose).lifted(-50.0);
    // They lie lengthwise along the circle and hang from the board.
    let block =
        |[length, width]: [f64; 2], height: f64| Solid::cuboid(width, length, height).at_z(-height);
    let height = p.led_board.parts_height.mm();
    let [length, width, least] = RESISTOR_MM;
    vec![
        SWITCH
            .bought(p.led_board.switch_model.as_str(), block(SWITCH_MM, height), [at(poses.switch)])
            .with_order(Order::new(&p.led_board.switch_model, ""))
            .colored(CAMERA_GREY),
        RESISTOR
            .bought(
                "resistor 0603, for the current of one kind of LEDs",
                block([length, width], least.min(height)),
                poses.resistors.map(at),
            )
            .with_order(Order::new("resistor", "0603"))
            .colored(CAMERA_GREY),
    ]
}

/// Length of a wire from the board to its drawn end below the base, mm.
fn drawn_wire_mm(layout: &HalfEllipsoidLayout) -> f64 {
    layout.base_top_z_mm - layout.bottom_z_mm + CABLE_END_MM
}

/// Returns the camera and the beginning of its cable: origin at the lens's front, z forward.
fn camera(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Solid {
    let length = p.camera.length.mm();
    let head = Solid::cylinder(p.camera.diameter.mm() / 2.0, length).at_z(-length);
    // Ends at the same height as the wires, below the base.
    let end = layout.bottom_z_mm - layout.camera_front_z_mm - CABLE_END_MM;
    let cable = Solid::cylinder(p.camera.cable_diameter.mm() / 2.0, INTO_MM - length - end);
    Solid::union([head, cable.at_z(end).named("cable")])
}

// ------ Circuit ------
//
// Parts soldered to the LED board: two kinds of LEDs, and a resistor and a switch channel for each kind.

/// Length of a wire's pad, outwards from its hole, mm.
const PAD_LENGTH_MM: f64 = 1.1;
/// Gap between the pads of two wires, mm.
const BESIDE_PAD_MM: f64 = 0.25;

/// Pins by number of the TS5A23166 in its package DCU (TI, SCDS196G, table 2).
const SWITCH_PINS: [&str; 8] = ["1", "2", "3", "4", "5", "6", "7", "8"];

/// Electrical data of the white LEDs and of the UV LEDs.
pub fn electric_by_kind(p: &HalfEllipsoid) -> [Electric; 2] {
    [p.leds.white_forward_volts, p.leds.uv_forward_volts].map(|forward_volts| Electric {
        supply_volts: p.leds.supply_volts,
        forward_volts,
        current_ma: p.leds.current_ma,
        rated_ma: p.leds.rated_ma,
        supply_ma: p.leds.supply_ma,
        resistor_ohms: 0.0,
    })
}

/// Builds the circuit: white and UV LEDs in parallel, each kind behind one resistor. Two channels of a switch turn
/// them on.
pub fn circuit(p: &HalfEllipsoid, layout: &HalfEllipsoidLayout) -> Circuit {
    let kinds = electric_by_kind(p);
    let mut board = CircuitBuilder::new_on_board(LED_BOARD, &kinds[0]);
    let is_switched = has_board_parts(p) && p.led_board.wires >= 4;
    let poses = board_part_poses(p, layout);
    let below = |pose: &Pose| BoardPlacement::from_body_pose(pose, Vector3::y(), BoardSide::Bottom);
    let package = LedPackage::Round(p.leds.diameter.mm());
    let mut channels = Vec::new();
    for (kind, places) in leds_by_kind(p, layout).iter().enumerate() {
        let name = ["WHITE", "UV"][kind];
        let source = format!("leds.current_ma, leds.{}_forward_volts", name.to_lowercase());
        let mut calculation = board.calculate(&kinds[kind], p.leds.pairs, CHIP_0603, &source);
        let drawn = has_board_parts(p).then(|| (below(&poses.resistors[kind]), RESISTOR));
        let after = if is_switched { format!("{name}-R") } else { name.to_owned() };
        let resistor = board.resistor(calculation.ohms, CHIP_0603, drawn, [SUPPLY, &after]);
        calculation.designators.push(resistor);
        let all = calculation.current_a();
        let (body, model) = [(WHITE_LED, &p.leds.white_model), (UV_LED, &p.leds.uv_model)][kind];
        for place in along_y(places) {
            board.led(model, package, place, body, name);
        }
        for net in [name, SUPPLY, GROUND] {
            board.add_net_current(net, all);
        }
        if is_switched {
            board.add_net_current(&after, all);
        }
        board.add_current(all);
        board.add_calculation(calculation);
        channels.push((name, after));
    }
    let mut nets = vec![(SUPPLY, "red"), (GROUND, "black")];
    if is_switched {
        let switch = board.part(switch_part(p, below(&poses.switch)));
        let [(white, white_r), (uv, uv_r)] = &channels[..] else { unreachable!("two kinds") };
        // Nets in the order of the pins 1 to 8: NO1, COM1, IN2, GND, NO2, COM2, IN1, V+.
        let nets =
            [white, white_r.as_str(), "UV-ON", GROUND, uv, uv_r.as_str(), "WHITE-ON", SUPPLY];
        for (pin, net) in SWITCH_PINS.into_iter().zip(nets) {
            board.connect(net, &switch, pin);
        }
    }
    if is_switched {
        nets = vec![(SUPPLY, "red"), ("WHITE-ON", "white"), ("UV-ON", "violet"), (GROUND, "black")];
    }
    add_wires(p, layout, &mut board, &nets);
    let diffuser = ring_region([layout.diffuser_wall_radius_mm, layout.board_radius_mm + 1.0]);
    board.keep_out(BoardSide::Top, diffuser, "the diffusion ring's wall");
    board.test_points();
    board.connection(camera_to_host(
        "camera",
        None,
        None,
        "camera's own cable to its USB video board",
    ));
    board.note("strip each wire, push its strand into its hole from below and solder it to the pad beside it");
    if is_switched {
        board.note(
            "both inputs of the switch must be driven: high turns a kind of LEDs on, and an open input is neither",
        );
    }
    board.build()
}

/// Adds the wires with their pads to the board.
fn add_wires(
    p: &HalfEllipsoid,
    layout: &HalfEllipsoidLayout,
    board: &mut CircuitBuilder,
    nets: &[(&str, &str)],
) {
    let hole = p.led_board.wire_hole_diameter.mm();
    let places = wire_positions(p, layout);
    let pitch = match places[..] {
        [[x, y], [u, v], ..] => (u - x).hypot(v - y),
        _ => f64::INFINITY,
    };
    let pad_mm = [PAD_LENGTH_MM, (pitch - BESIDE_PAD_MM).min(1.0)];
    for (at_mm, (net, color)) in places.into_iter().zip(nets) {
        let to = match *net {
            SUPPLY => "5 V of the supply",
            GROUND => "ground of supply and controller",
            "WHITE-ON" => "digital pin of the controller, for white",
            _ => "digital pin of the controller, for UV",
        };
        let place = BoardPlacement {
            at_mm,
            turn_rad: wire_slot(p, layout).turn.rad(),
            side: BoardSide::Bottom,
        };
        let (hole_mm, by) = (Some(hole), Some(LED_WIRE));
        board.wire(net, BoardWire { place, hole_mm, pad_mm, by, to, length_mm: None, color });
    }
}

/// Lands of TI's DCU0008A: eight of 0.85 x 0.3 mm, 0.5 mm apart, in two rows 3.1 mm apart.
fn switch_part(p: &HalfEllipsoid, place: BoardPlacement) -> CircuitPart {
    let land = |(index, pin): (usize, &str)| {
        let row = (index % 4) as f64;
        // Pins are numbered down the left side and up the right side.
        let at_mm = if index < 4 { [-1.55, 0.75 - 0.5 * row] } else { [1.55, 0.5 * row - 0.75] };
        Land { pin: pin.to_owned(), at_mm, size_mm: [0.85, 0.3], is_round: false }
    };
    CircuitPart {
        designator: String::new(),
        kind: CircuitKind::Switch,
        value: p.led_board.switch_model.clone(),
        package: "VSSOP-8".into(),
        lands: SWITCH_PINS.into_iter().enumerate().map(land).collect(),
        size_mm: SWITCH_MM,
        place: Some(place),
        body: Some(SWITCH.name.to_owned()),
    }
}
