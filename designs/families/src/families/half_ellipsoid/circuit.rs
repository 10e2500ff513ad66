//! What is soldered to the LED board: two kinds of LEDs, a resistor and a switch for each kind.

use fabkit_geometry::{
    BoardPlace, BoardSide, Circuit, CircuitKind, CircuitPart, Land, Pose, Vector3,
};

use super::bodies::*;
use super::components::{SWITCH_MM, board_part_poses, has_parts};
use super::housing::{leds_by_kind, wire_places, wire_slot};
use super::layout::Layout;
use super::parameters::HalfEllipsoid;
use crate::blocks::circuit::{
    Builder, CHIP_0603, Electric, GROUND, LedPackage, SUPPLY, Wire, all_around, along_y,
    camera_to_host,
};

/// A wire's pad outwards from its hole, mm.
const PAD_LENGTH_MM: f64 = 1.1;
/// Between the pads of two wires, mm.
const BESIDE_PAD_MM: f64 = 0.25;

/// Pins of the TS5A23166 in its package DCU (TI, SCDS196G, table 2), by number.
const SWITCH_PINS: [&str; 8] = ["1", "2", "3", "4", "5", "6", "7", "8"];

/// Of the white LEDs and of the UV ones.
pub fn electric(p: &HalfEllipsoid) -> [Electric; 2] {
    [p.leds.white_forward_volts, p.leds.uv_forward_volts].map(|forward_volts| Electric {
        supply_volts: p.leds.supply_volts,
        forward_volts,
        current_ma: p.leds.current_ma,
        rated_ma: p.leds.rated_ma,
        supply_ma: p.leds.supply_ma,
        resistor_ohms: 0.0,
    })
}

/// White and UV LEDs parallel, each kind behind one resistor; two channels of a switch turn them on.
pub fn circuit(p: &HalfEllipsoid, layout: &Layout) -> Circuit {
    let kinds = electric(p);
    let mut board = Builder::on(LED_BOARD, &kinds[0]);
    let is_switched = has_parts(p) && p.led_board.wires >= 4;
    let poses = board_part_poses(p, layout);
    let below = |pose: &Pose| BoardPlace::of_body(pose, Vector3::y(), BoardSide::Bottom);
    let package = LedPackage::Round(p.leds.diameter.mm());
    let mut channels = Vec::new();
    for (kind, places) in leds_by_kind(p, layout).iter().enumerate() {
        let name = ["WHITE", "UV"][kind];
        let source = format!("leds.current_ma, leds.{}_forward_volts", name.to_lowercase());
        let mut calculation = board.calculate(&kinds[kind], p.leds.pairs, CHIP_0603, &source);
        let drawn = has_parts(p).then(|| (below(&poses.resistors[kind]), RESISTOR));
        let after = if is_switched { format!("{name}-R") } else { name.to_owned() };
        let resistor = board.resistor(calculation.ohms, CHIP_0603, drawn, [SUPPLY, &after]);
        calculation.designators.push(resistor);
        let all = calculation.current_a();
        let (body, model) = [(WHITE_LED, &p.leds.white_model), (UV_LED, &p.leds.uv_model)][kind];
        for place in along_y(places) {
            board.led(model, package, place, body, name);
        }
        for net in [name, SUPPLY, GROUND] {
            board.carries(net, all);
        }
        if is_switched {
            board.carries(&after, all);
        }
        board.draws(all);
        board.calculated(calculation);
        channels.push((name, after));
    }
    let mut nets = vec![(SUPPLY, "red"), (GROUND, "black")];
    if is_switched {
        let switch = board.part(switch(p, below(&poses.switch)));
        let [(white, white_r), (uv, uv_r)] = &channels[..] else { unreachable!("two kinds") };
        // By number: NO1, COM1, IN2, GND, NO2, COM2, IN1, V+.
        let nets =
            [white, white_r.as_str(), "UV-ON", GROUND, uv, uv_r.as_str(), "WHITE-ON", SUPPLY];
        for (pin, net) in SWITCH_PINS.into_iter().zip(nets) {
            board.connect(net, &switch, pin);
        }
    }
    if is_switched {
        nets = vec![(SUPPLY, "red"), ("WHITE-ON", "white"), ("UV-ON", "violet"), (GROUND, "black")];
    }
    wires(p, layout, &mut board, &nets);
    let diffuser = all_around([layout.diffuser_wall_radius_mm, layout.board_radius_mm + 1.0]);
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
    board.done()
}

fn wires(p: &HalfEllipsoid, layout: &Layout, board: &mut Builder, nets: &[(&str, &str)]) {
    let hole = p.led_board.wire_hole_diameter.mm();
    let places = wire_places(p, layout);
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
        let place = BoardPlace {
            at_mm,
            turn_rad: wire_slot(p, layout).turn.rad(),
            side: BoardSide::Bottom,
        };
        let (hole_mm, by) = (Some(hole), Some(LED_WIRE));
        board.wire(net, Wire { place, hole_mm, pad_mm, by, to, length_mm: None, color });
    }
}

/// Lands of TI's DCU0008A: eight of 0.85 x 0.3 mm, 0.5 mm apart, in two rows 3.1 mm apart.
fn switch(p: &HalfEllipsoid, place: BoardPlace) -> CircuitPart {
    let land = |(index, pin): (usize, &str)| {
        let row = (index % 4) as f64;
        // Down the left side, and up the right one.
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
