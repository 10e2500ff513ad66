//! Wiring: circuits with calculated resistors, wires and cables.

use fabkit_geometry::{Circuit, CircuitKind, Connection, Sensor, SeriesResistor};
use serde::Serialize;

/// Circuit to solder and wire.
#[derive(Clone, Debug, Serialize)]
pub struct Wiring {
    /// Name of the board, or of the wired group.
    pub name: String,
    /// Part that is etched; `null` if everything is bought.
    pub board: Option<String>,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Current of all LEDs together, A; 0 if a data sheet has to state it.
    pub current_a: f64,
    /// Soldered parts.
    pub parts: Vec<WiredPart>,
    /// Nets.
    pub nets: Vec<WiredNet>,
    /// Resistors with their calculation.
    pub resistors: Vec<WiredResistor>,
    /// Wires and cables.
    pub connections: Vec<WiringConnection>,
    /// Notes.
    pub notes: Vec<String>,
}

/// Soldered part.
#[derive(Clone, Debug, Serialize)]
pub struct WiredPart {
    /// Designator: `D1`, `R1`.
    pub designator: String,
    /// Kind: `led`, `resistor`, `switch`, `wire` or `test point`.
    pub kind: &'static str,
    /// Value or type to order.
    pub value: String,
    /// Package.
    pub package: String,
    /// Pins with their nets.
    pub pins: Vec<WiredPin>,
    /// Name of the bought piece, if it is modelled.
    pub body: Option<String>,
}

/// Pin of a part.
#[derive(Clone, Debug, Serialize)]
pub struct WiredPin {
    /// Name of the pin: `A`, `K`, `1`.
    pub pin: String,
    /// Net; `null` for a free pin.
    pub net: Option<String>,
}

/// Net of a circuit.
#[derive(Clone, Debug, Serialize)]
pub struct WiredNet {
    /// Name of the net: `V+`, `GND`.
    pub name: String,
    /// Connected pins, for example `D1.A`.
    pub pins: Vec<String>,
    /// Largest current, A.
    pub current_a: f64,
}

/// Calculation of a resistor.
#[derive(Clone, Debug, Serialize)]
pub struct WiredResistor {
    /// Designators of the resistors with this value.
    pub designators: Vec<String>,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Forward voltage of an LED, V.
    pub forward_v: f64,
    /// Number of LEDs that share one resistor.
    pub leds: u32,
    /// Calculated resistance, ohm; `null` if the resistor itself is given.
    pub exact_ohm: Option<f64>,
    /// Resistance to order, ohm.
    pub ohm: f64,
    /// Current through one LED, mA.
    pub led_ma: f64,
    /// Power dissipated in the resistor, W.
    pub power_w: f64,
    /// Rated power, W.
    pub rated_w: f64,
    /// Calculation in one line.
    pub calculation: String,
    /// Source of the values.
    pub source: String,
}

/// Wire or cable.
#[derive(Clone, Debug, Serialize)]
pub struct WiringConnection {
    /// Start.
    pub from: String,
    /// End.
    pub to: String,
    /// Net or signal that it carries.
    pub carries: String,
    /// Name of the bought piece, if it is modelled.
    pub by: Option<String>,
    /// Modelled length inside the sensor, mm; the wire continues outside.
    pub drawn_mm: Option<f64>,
    /// Colour of the insulation, if stated.
    pub color: Option<String>,
}

/// Returns the wiring of all circuits of a sensor.
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

fn wire(connection: &Connection) -> WiringConnection {
    WiringConnection {
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
    // LEDs in parallel share the current of one resistor equally.
    let shared =
        if one.leds > 1 { format!(", for each of {} LEDs", one.leds) } else { String::new() };
    let calculation = match (one.exact_ohms(), one.target_current_a) {
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
