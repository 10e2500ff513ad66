//! Boards that are broken on purpose: `check` must report exactly the defect that was made.

use std::sync::OnceLock;

use fabkit_boards::{
    BoardError, BoardFlaw, BoardLayout, BoardShape, STANDARD_RULES, check, fabrication_files,
    lay_out,
};
use fabkit_geometry::{
    BoardPlacement, BoardSide, Body, Circuit, CircuitKind, CircuitPart, Land, Net, Path, Process,
    Profile, SeriesResistor, Solid,
};

fn part(
    name: &str,
    kind: CircuitKind,
    value: &str,
    pins: [&str; 2],
    at: Option<[f64; 2]>,
) -> CircuitPart {
    let land = |pin: &str, x: f64| Land {
        pin: pin.into(),
        at_mm: [x, 0.0],
        size_mm: [0.8, 0.8],
        is_round: false,
    };
    CircuitPart {
        designator: name.into(),
        kind,
        value: value.into(),
        package: "0603".into(),
        lands: vec![land(pins[0], -0.8), land(pins[1], 0.8)],
        size_mm: [1.6, 0.8],
        place: at.map(|at_mm| BoardPlacement { at_mm, turn_rad: 0.0, side: BoardSide::Top }),
        body: None,
    }
}

fn net(name: &str, pins: &[(&str, &str)]) -> Net {
    let pins = pins.iter().map(|(part, pin)| (part.to_string(), pin.to_string())).collect();
    Net { name: name.into(), pins, current_a: 0.01 }
}

/// Two LEDs with a resistor each, and two wires below.
fn circuit() -> Circuit {
    let (led, resistor) = (CircuitKind::Led, CircuitKind::Resistor);
    let wire = |name: &str, at_mm: [f64; 2]| CircuitPart {
        lands: vec![Land {
            pin: "1".into(),
            at_mm: [0.0; 2],
            size_mm: [1.0, 1.0],
            is_round: false,
        }],
        size_mm: [0.0; 2],
        place: Some(BoardPlacement { at_mm, turn_rad: 0.0, side: BoardSide::Bottom }),
        ..part(name, CircuitKind::WirePad, "wire", ["1", "2"], None)
    };
    Circuit {
        name: "board".into(),
        board: Some("board".into()),
        supply_v: 5.0,
        supply_a: Some(0.5),
        parts: vec![
            part("D1", led, "white", ["K", "A"], Some([-6.0, 4.0])),
            part("D2", led, "white", ["K", "A"], Some([6.0, 4.0])),
            part("R1", resistor, "200 ohm", ["1", "2"], None),
            part("R2", resistor, "200 ohm", ["1", "2"], None),
            wire("W1", [-2.0, -5.0]),
            wire("W2", [2.0, -5.0]),
        ],
        nets: vec![
            net("V+", &[("R1", "1"), ("R2", "1"), ("W1", "1")]),
            net("GND", &[("D1", "K"), ("D2", "K"), ("W2", "1")]),
            net("LED1", &[("R1", "2"), ("D1", "A")]),
            net("LED2", &[("R2", "2"), ("D2", "A")]),
        ],
        resistors: vec![SeriesResistor {
            designators: vec!["R1".into(), "R2".into()],
            supply_v: 5.0,
            forward_v: 3.1,
            leds: 1,
            led_rated_a: 0.02,
            target_current_a: Some(0.01),
            ohms: 200.0,
            rated_w: 0.1,
            source: "test".into(),
        }],
        current_a: 0.02,
        keep_outs: Vec::new(),
        connections: Vec::new(),
        notes: Vec::new(),
    }
}

fn board() -> BoardShape {
    let profile = Profile::new(Path::rectangle([0.0; 2], [22.0, 16.0], 2.0))
        .with_hole(Path::circle([0.0; 2], 2.5));
    BoardShape::from_body(&Body::made(
        "board",
        "test",
        Process::Pcb,
        Solid::extrusion(profile, 1.0),
    ))
    .unwrap()
}

fn intact_board() -> (BoardLayout, Circuit) {
    static LAYOUT: OnceLock<BoardLayout> = OnceLock::new();
    let laid = || lay_out(&circuit(), &board(), &STANDARD_RULES).unwrap();
    (LAYOUT.get_or_init(laid).clone(), circuit())
}

/// Kinds of the findings, each once.
fn flaws(layout: &BoardLayout, circuit: &Circuit) -> Vec<BoardFlaw> {
    let mut flaws: Vec<BoardFlaw> =
        check(layout, circuit, &STANDARD_RULES).into_iter().map(|finding| finding.flaw).collect();
    flaws.dedup();
    flaws
}

fn flaws_after(how: impl Fn(&mut BoardLayout, &mut Circuit)) -> Vec<BoardFlaw> {
    let (mut layout, mut circuit) = intact_board();
    how(&mut layout, &mut circuit);
    flaws(&layout, &circuit)
}

fn net_index(layout: &BoardLayout, name: &str) -> usize {
    layout.nets.iter().position(|net| net == name).unwrap()
}

#[test]
fn an_intact_board_has_no_findings_and_is_reproducible() {
    let (layout, circuit) = intact_board();
    assert_eq!(check(&layout, &circuit, &STANDARD_RULES), []);
    assert!(!layout.vias.is_empty(), "wires are below, all else is above");
    let again = lay_out(&circuit, &board(), &STANDARD_RULES).unwrap();
    assert_eq!(
        fabrication_files(&layout, &circuit, &STANDARD_RULES, "00"),
        fabrication_files(&again, &circuit, &STANDARD_RULES, "00")
    );
}

#[test]
fn an_open_net() {
    let open = flaws_after(|layout, _| {
        let net = net_index(layout, "LED1");
        layout.tracks.retain(|track| track.net != net);
    });
    assert_eq!(open, [BoardFlaw::Open]);
}

#[test]
fn a_missing_via() {
    let missing = flaws_after(|layout, _| {
        let net = layout.vias[0].net;
        layout.vias.retain(|via| via.net != net);
    });
    assert_eq!(missing, [BoardFlaw::Open]);
}

#[test]
fn a_short() {
    let short = flaws_after(|layout, _| {
        let [one, other] = ["LED1", "LED2"].map(|name| net_index(layout, name));
        // Laid for one net, touching the other: what it was laid for does not count.
        let at = |net| layout.pads.iter().find(|pad| pad.net == Some(net)).unwrap().shape.centre();
        let track = layout.tracks.iter().find(|track| track.net == one).unwrap().clone();
        let ends = [at(one), [at(one)[0], 7.0], [at(other)[0], 7.0], at(other)];
        for pair in ends.windows(2) {
            layout.tracks.push(fabkit_boards::Track { ends: [pair[0], pair[1]], ..track.clone() });
        }
    });
    assert!(short.contains(&BoardFlaw::Short), "{short:?}");
}

#[test]
fn copper_too_near_to_other_copper() {
    let near = flaws_after(|layout, _| {
        let led = net_index(layout, "LED1");
        let pad = layout.pads.iter().find(|pad| pad.part == "D1" && pad.pin == "K").unwrap();
        let [low, high] = pad.shape.bounds();
        let x = low[0] - 0.05 - 0.075;
        let ends = [[x, low[1]], [x, high[1]]];
        let side = BoardSide::Top;
        layout.tracks.push(fabkit_boards::Track { side, ends, width_mm: 0.15, net: led });
    });
    assert_eq!(near, [BoardFlaw::Clearance]);
}

#[test]
fn a_track_too_near_to_the_edge_and_a_pad_beyond_it() {
    let edge = flaws_after(|layout, _| {
        let net = net_index(layout, "GND");
        let ends = [[-5.0, 7.9], [5.0, 7.9]];
        let side = BoardSide::Bottom;
        layout.tracks.push(fabkit_boards::Track { side, ends, width_mm: 0.15, net });
    });
    assert_eq!(edge, [BoardFlaw::Edge]);
    let mut circuit = circuit();
    circuit.parts[4].place.as_mut().unwrap().at_mm = [-2.0, -7.9];
    let layout = lay_out(&circuit, &board(), &STANDARD_RULES);
    // Either no track reaches it, or it is found.
    match layout {
        Ok(layout) => assert_eq!(flaws(&layout, &circuit), [BoardFlaw::Edge]),
        Err(error) => assert!(matches!(error, BoardError::NoRoute { .. }), "{error}"),
    }
}

#[test]
fn copper_too_near_to_the_bore() {
    let bore = flaws_after(|layout, _| {
        let net = net_index(layout, "GND");
        let ends = [[2.6, -1.0], [2.6, 1.0]];
        let side = BoardSide::Bottom;
        layout.tracks.push(fabkit_boards::Track { side, ends, width_mm: 0.15, net });
    });
    assert_eq!(bore, [BoardFlaw::Edge]);
}

#[test]
fn an_led_turned_round() {
    let turned = flaws_after(|layout, _| {
        let of = |layout: &BoardLayout, pin: &str| {
            layout.pads.iter().position(|pad| pad.part == "D1" && pad.pin == pin).unwrap()
        };
        let (k, a) = (of(layout, "K"), of(layout, "A"));
        let shape = layout.pads[k].shape.clone();
        layout.pads[k].shape = layout.pads[a].shape.clone();
        layout.pads[a].shape = shape;
    });
    // Its cathode is on the resistor now, and its anode on ground.
    assert!(
        turned.contains(&BoardFlaw::SwappedPads) && turned.contains(&BoardFlaw::Short),
        "{turned:?}"
    );
}

#[test]
fn a_thin_track() {
    assert_eq!(flaws_after(|layout, _| layout.tracks[0].width_mm = 0.1), [BoardFlaw::Track]);
    // As wide as any, but not for ten amperes.
    let (layout, mut circuit) = intact_board();
    let net = layout.tracks[0].net;
    circuit.nets[net].current_a = 10.0;
    assert_eq!(flaws(&layout, &circuit), [BoardFlaw::Track]);
}

#[test]
fn a_drill_too_small_and_a_ring_too_narrow() {
    assert_eq!(flaws_after(|layout, _| layout.vias[0].drill_mm = 0.2), [BoardFlaw::Drill]);
    assert_eq!(flaws_after(|layout, _| layout.vias[0].drill_mm = 0.45), [BoardFlaw::Ring]);
}

#[test]
fn holes_too_near_to_each_other() {
    let near = flaws_after(|layout, _| {
        let via = layout.vias[0];
        let at_mm = [via.at_mm[0] + 0.45, via.at_mm[1]];
        layout.drills.push(fabkit_boards::Drill { at_mm, diameter_mm: 0.4 });
    });
    assert_eq!(near, [BoardFlaw::HoleSpacing]);
}

#[test]
fn a_missing_opening_of_the_mask() {
    assert_eq!(flaws_after(|layout, _| _ = layout.openings.remove(0)), [BoardFlaw::Mask]);
}

#[test]
fn silk_on_a_pad() {
    let silk = flaws_after(|layout, _| {
        let at = layout.pads[0].shape.centre();
        let side = layout.pads[0].side;
        let ends = [at, [at[0] + 0.3, at[1]]];
        layout.silk.push(fabkit_boards::SilkLine { side, ends, width_mm: 0.15 });
    });
    assert_eq!(silk, [BoardFlaw::Silk]);
}

#[test]
fn parts_that_overlap() {
    let overlap = flaws_after(|layout, _| {
        let outline = layout.parts[0].outline.clone();
        layout.parts[1].outline = outline;
    });
    assert_eq!(overlap, [BoardFlaw::Parts]);
}

#[test]
fn a_wrong_resistor() {
    assert_eq!(flaws_after(|_, circuit| circuit.resistors[0].ohms = 20.0), [BoardFlaw::Resistor]);
    assert_eq!(
        flaws_after(|_, circuit| circuit.parts[2].value = "47 ohm".into()),
        [BoardFlaw::Resistor]
    );
    assert_eq!(
        flaws_after(|_, circuit| circuit.resistors[0].rated_w = 0.01),
        [BoardFlaw::Resistor]
    );
}

#[test]
fn a_part_that_is_not_there() {
    assert!(flaws_after(|layout, _| _ = layout.parts.remove(0)).contains(&BoardFlaw::PadPosition));
}

#[test]
fn a_board_without_room_names_the_part_and_its_size() {
    let profile = Profile::new(Path::rectangle([0.0; 2], [17.0, 10.4], 0.0))
        .with_hole(Path::rectangle([0.0, -1.0], [16.0, 6.0], 0.0));
    let body = Body::made("board", "test", Process::Pcb, Solid::extrusion(profile, 1.0));
    let error =
        lay_out(&circuit(), &BoardShape::from_body(&body).unwrap(), &STANDARD_RULES).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("board: ") && text.contains("mm"), "{text}");
}
