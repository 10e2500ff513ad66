//! Circuits that light up, and every way in which one does not.

use fabkit_checks::{Memo, Rule, check_rules, example};
use fabkit_geometry::{
    BoardPlacement, BoardSide, Body, Circuit, CircuitKind, CircuitPart, Land, Net, Process, Sensor,
    SeriesResistor, Solid,
};

const BOARD: &str = "board";

fn part(name: &str, kind: CircuitKind, pins: [&str; 2], at_mm: [f64; 2]) -> CircuitPart {
    let land = |(pin, x): (&str, f64)| Land {
        pin: pin.into(),
        at_mm: [x, 0.0],
        size_mm: [1.0, 1.0],
        is_round: false,
    };
    CircuitPart {
        designator: name.into(),
        kind,
        value: String::new(),
        package: String::new(),
        lands: pins.into_iter().zip([-1.0, 1.0]).map(land).collect(),
        size_mm: [3.0, 1.0],
        place: Some(BoardPlacement { at_mm, turn_rad: 0.3, side: BoardSide::Top }),
        body: None,
    }
}

fn net(name: &str, pins: &[(&str, &str)]) -> Net {
    let pins = pins.iter().map(|(part, pin)| (part.to_string(), pin.to_string())).collect();
    Net { name: name.into(), pins, current_a: 0.0 }
}

/// Three lamps behind one resistor, (5 V - 3 V) / 100 ohm = 20 mA, on a board of 20 x 10 mm.
fn sensor() -> Sensor {
    let (led, ends) = (CircuitKind::Led, ["K", "A"]);
    let circuit = Circuit {
        name: BOARD.into(),
        board: Some(BOARD.into()),
        supply_v: 5.0,
        supply_a: Some(0.5),
        parts: vec![
            part("D1", led, ends, [-6.0, 0.0]),
            part("D2", led, ends, [0.0, 3.0]),
            part("D3", led, ends, [0.0, -3.0]),
            part("R1", CircuitKind::Resistor, ["1", "2"], [6.0, 0.0]),
            part("W1", CircuitKind::WirePad, ["1", "2"], [3.0, 0.0]),
        ],
        nets: vec![
            net("V+", &[("R1", "1"), ("W1", "1")]),
            net("LED", &[("R1", "2"), ("D1", "A"), ("D2", "A"), ("D3", "A")]),
            net("GND", &[("D1", "K"), ("D2", "K"), ("D3", "K"), ("W1", "2")]),
        ],
        resistors: vec![SeriesResistor {
            designators: vec!["R1".into()],
            supply_v: 5.0,
            forward_v: 3.0,
            leds: 3,
            led_rated_a: 0.020,
            target_current_a: None,
            ohms: 100.0,
            rated_w: 0.1,
            source: String::new(),
        }],
        current_a: 0.020,
        keep_outs: Vec::new(),
        connections: Vec::new(),
        notes: Vec::new(),
    };
    let mut sensor = example::puck();
    let plate = Solid::cuboid(20.0, 10.0, 1.0);
    sensor.bodies.push(Body::made(BOARD, String::new(), Process::Pcb, plate));
    sensor.circuits.push(circuit);
    sensor
}

fn messages(sensor: &Sensor) -> Vec<String> {
    let findings = check_rules(sensor, &[Rule::Circuit], &Memo::default()).unwrap().findings;
    assert!(findings.iter().all(|f| f.rule == Rule::Circuit && !f.fix.is_empty()));
    findings.into_iter().map(|finding| finding.message).collect()
}

#[test]
fn a_right_circuit_has_no_findings() {
    assert_eq!(messages(&sensor()), [""; 0]);
    // 20 mA through a resistor that bears just that, with the ratings at what flows.
    let mut tight = sensor();
    let one = &mut tight.circuits[0].resistors[0];
    (one.led_rated_a, one.rated_w) = (one.led_a(), one.power_w());
    tight.circuits[0].supply_a = Some(0.020);
    assert_eq!(messages(&tight), [""; 0]);
}

#[test]
fn a_circuit_without_a_board_is_looked_at_too() {
    let mut sensor = sensor();
    sensor.circuits[0].board = None;
    sensor.circuits[0].resistors[0].forward_v = 6.0;
    assert!(messages(&sensor)[0].contains("need 6 V to shine, but the supply has 5 V"));
}

/// Cases of a wrong circuit with the expected messages.
type Wrong = (fn(&mut Sensor), &'static str);

#[test]
fn every_mistake_is_found_and_told_with_its_numbers() {
    let wrong: [Wrong; 17] = [
        (|s| one(s).forward_v = 6.0, "need 6 V to shine, but the supply has 5 V"),
        (|s| one(s).forward_v = 5.0, "need 5 V to shine, but the supply has 5 V"),
        (|s| one(s).ohms = 0.0, "R1 is calculated with 0; this value must be above 0"),
        (|s| one(s).ohms = f64::NAN, "calculated with NaN"),
        // 2 V / 20 ohm / 3 = 33.3 mA, 0.2 W.
        (|s| one(s).ohms = 20.0, "each LED behind R1 takes 33.3 mA, but withstands only 20 mA"),
        (|s| one(s).ohms = 20.0, "R1 turns 0.200 W to heat, but withstands only 0.1 W"),
        (|s| one(s).supply_v = 12.0, "is calculated for 12 V, but the circuit's supply has 5 V"),
        (|s| one(s).leds = 2, "the circuit has 3 LEDs, but resistors for 2 of them"),
        (
            |s| one(s).designators = vec!["D1".into()],
            "D1 is calculated, but the circuit has no resistor",
        ),
        (
            |s| s.circuits[0].current_a = 0.1,
            "stated to take 100.0 mA, but its resistors let 20.0 mA",
        ),
        (|s| s.circuits[0].supply_a = Some(0.015), "take 20 mA, but the supply delivers 15 mA"),
        (turn_d2, "D2 meets net LED with its cathode, and other LEDs do not"),
        (|s| drop(s.circuits[0].nets[0].pins.pop()), "net V+ has 1 of the 2 ends"),
        (
            |s| s.circuits[0].nets[2].pins.retain(|(part, _)| part != "D3"),
            "D3.K is connected to nothing",
        ),
        (
            |s| s.circuits[0].nets[0].pins.push(("D9".into(), "A".into())),
            "D9.A, which is no pin of a part",
        ),
        (|s| s.circuits[0].board = Some("plank".into()), "on `plank`, but the sensor has no body"),
        (|s| s.circuits[0].parts[0].place = place([-9.0, 0.0]), "the pad D1.K reaches to (-10."),
    ];
    for (spoil, said) in wrong {
        let mut sensor = sensor();
        spoil(&mut sensor);
        let found = messages(&sensor);
        assert!(found.iter().any(|message| message.contains(said)), "{said}: {found:?}");
    }
    let mut short = sensor();
    short.circuits[0].nets[0].pins.push(("D1".into(), "A".into()));
    let said = "D1.A is on two nets, V+ and LED";
    assert!(messages(&short).iter().any(|message| message.contains(said)));
}

fn one(sensor: &mut Sensor) -> &mut SeriesResistor {
    &mut sensor.circuits[0].resistors[0]
}

fn place(at_mm: [f64; 2]) -> Option<BoardPlacement> {
    Some(BoardPlacement { at_mm, turn_rad: 0.3, side: BoardSide::Top })
}

fn turn_d2(sensor: &mut Sensor) {
    for (_, pin) in sensor.circuits[0]
        .nets
        .iter_mut()
        .flat_map(|net| &mut net.pins)
        .filter(|(part, _)| part == "D2")
    {
        *pin = if pin == "A" { "K".into() } else { "A".into() };
    }
}

/// Lamps in a row meet with both ends, and none is turned round.
#[test]
fn lamps_in_a_row_are_not_turned_round() {
    let mut sensor = sensor();
    let circuit = &mut sensor.circuits[0];
    circuit.parts.retain(|part| part.designator != "D3");
    circuit.nets = vec![
        net("V+", &[("R1", "1"), ("W1", "1")]),
        net("LED", &[("R1", "2"), ("D1", "A")]),
        net("BETWEEN", &[("D1", "K"), ("D2", "A")]),
        net("GND", &[("D2", "K"), ("W1", "2")]),
    ];
    circuit.resistors[0].leds = 2;
    assert_eq!(messages(&sensor), [""; 0]);
}

/// A pad over a hole of its board has nothing below it.
#[test]
fn a_pad_over_a_hole_is_found() {
    let mut sensor = sensor();
    let board = sensor.body_mut(BOARD).unwrap();
    let hole = Solid::cylinder(1.5, 3.0).at(6.0, 0.0, -1.0);
    board.solid = board.solid.clone().minus(hole);
    assert!(messages(&sensor)[0].contains("the pad R1.1 reaches to"));
}
