//! Who is connected to whom: circuits with their resistors worked out, wires and cables.

use fabkit_geometry::{Circuit, CircuitKind, Connection, Sensor, SeriesResistor};
use serde::Serialize;

/// What is soldered and wired together.
#[derive(Clone, Debug, Serialize)]
pub struct Wiring {
    /// That of its board, or of what is wired.
    pub name: String,
    /// The part that is etched; nothing where all is bought.
    pub board: Option<String>,
    /// V.
    pub supply_v: f64,
    /// All lamps at once, A; 0 where a data sheet has to tell.
    pub current_a: f64,
    /// What is soldered.
    pub parts: Vec<WiredPart>,
    /// What is connected inside.
    pub nets: Vec<WiredNet>,
    /// Resistors and why they are what they are.
    pub resistors: Vec<WiredResistor>,
    /// Wires and cables.
    pub connections: Vec<Wire>,
    /// What to mind.
    pub notes: Vec<String>,
}

/// Something that is soldered.
#[derive(Clone, Debug, Serialize)]
pub struct WiredPart {
    /// `D1`, `R1`.
    pub designator: String,
    /// `led`, `resistor`, `switch`, `wire` or `test point`.
    pub kind: &'static str,
    /// What to order.
    pub value: String,
    /// Its package.
    pub package: String,
    /// Its pins, with their nets.
    pub pins: Vec<WiredPin>,
    /// The piece of the list of what to buy, where it is drawn.
    pub body: Option<String>,
}

/// A pin.
#[derive(Clone, Debug, Serialize)]
pub struct WiredPin {
    /// `A`, `K`, `1`.
    pub pin: String,
    /// Nothing for a pin that stays free.
    pub net: Option<String>,
}

/// What is connected.
#[derive(Clone, Debug, Serialize)]
pub struct WiredNet {
    /// `V+`, `GND`.
    pub name: String,
    /// `D1.A`.
    pub pins: Vec<String>,
    /// Largest current, A.
    pub current_a: f64,
}

/// A resistor's calculation.
#[derive(Clone, Debug, Serialize)]
pub struct WiredResistor {
    /// Which.
    pub designators: Vec<String>,
    /// V.
    pub supply_v: f64,
    /// V.
    pub forward_v: f64,
    /// LEDs that share one.
    pub leds: u32,
    /// What the formula gives, ohm; nothing where the resistor itself is given.
    pub exact_ohm: Option<f64>,
    /// What is ordered, ohm.
    pub ohm: f64,
    /// Through one LED, mA.
    pub led_ma: f64,
    /// Heat in the resistor, W.
    pub power_w: f64,
    /// What it bears, W.
    pub rated_w: f64,
    /// All of it in one line.
    pub calculation: String,
    /// Where the values are from.
    pub source: String,
}

/// A wire or a cable.
#[derive(Clone, Debug, Serialize)]
pub struct Wire {
    /// Where it begins.
    pub from: String,
    /// Where it ends.
    pub to: String,
    /// What it carries.
    pub carries: String,
    /// The piece of the list of what to buy, where it is drawn.
    pub by: Option<String>,
    /// How long it is drawn in the sensor, mm; it goes on outside.
    pub drawn_mm: Option<f64>,
    /// Of its insulation, where somebody says so.
    pub color: Option<String>,
}

/// All circuits of a sensor.
pub(crate) fn wirings(sensor: &Sensor) -> Vec<Wiring> {
    sensor.circuits.iter().map(wiring).collect()
}

fn wiring(circuit: &Circuit) -> Wiring {
    let part = |part: &fabkit_geometry::CircuitPart| {
        let pin = |land: &fabkit_geometry::Land| WiredPin {
            pin: land.pin.clone(),
            net: circuit.net_of(&part.designator, &land.pin).map(|net| net.name.clone()),
        };
        WiredPart {
            designator: part.designator.clone(),
            kind: match part.kind {
                CircuitKind::Led => "led",
                CircuitKind::Resistor => "resistor",
                CircuitKind::Switch => "switch",
                CircuitKind::WirePad => "wire",
                CircuitKind::TestPoint => "test point",
            },
            value: part.value.clone(),
            package: part.package.clone(),
            pins: part.lands.iter().map(pin).collect(),
            body: part.body.clone(),
        }
    };
    let net = |net: &fabkit_geometry::Net| WiredNet {
        name: net.name.clone(),
        pins: net.pins.iter().map(|(part, pin)| format!("{part}.{pin}")).collect(),
        current_a: net.current_a,
    };
    Wiring {
        name: circuit.name.clone(),
        board: circuit.board.clone(),
        supply_v: circuit.supply_v,
        current_a: circuit.current_a,
        parts: circuit.parts.iter().map(part).collect(),
        nets: circuit.nets.iter().map(net).collect(),
        resistors: circuit.resistors.iter().map(resistor).collect(),
        connections: circuit.connections.iter().map(wire).collect(),
        notes: circuit.notes.clone(),
    }
}

fn wire(connection: &Connection) -> Wire {
    Wire {
        from: connection.from.clone(),
        to: connection.to.clone(),
        carries: connection.carries.clone(),
        by: connection.by.clone(),
        drawn_mm: connection.length_mm,
        color: connection.color.clone(),
    }
}

fn resistor(one: &SeriesResistor) -> WiredResistor {
    let led_ma = one.led_a() * 1e3;
    let over = format!("({} V - {} V)", one.supply_v, one.forward_v);
    let shared =
        if one.leds > 1 { format!(", for each of {} LEDs", one.leds) } else { String::new() };
    let calculation = match (one.exact_ohms(), one.wanted_a) {
        (Some(exact), Some(wanted)) => {
            let each = format!("{:.1} mA", wanted * 1e3);
            let all = if one.leds > 1 { format!("({} x {each})", one.leds) } else { each };
            format!(
                "{over} / {all} = {exact:.1} ohm; next of E24: {} ohm; {over} / {} ohm = {led_ma:.1} mA{shared}",
                one.ohms,
                one.ohms * f64::from(one.leds.max(1))
            )
        }
        _ => format!(
            "{over} / {} ohm = {led_ma:.1} mA{shared}",
            one.ohms * f64::from(one.leds.max(1))
        ),
    };
    WiredResistor {
        designators: one.designators.clone(),
        supply_v: one.supply_v,
        forward_v: one.forward_v,
        leds: one.leds,
        exact_ohm: one.exact_ohms(),
        ohm: one.ohms,
        led_ma,
        power_w: one.power_w(),
        rated_w: one.rated_w,
        calculation,
        source: one.source.clone(),
    }
}
