//! LED circuits: LEDs with their resistors, wires to them, and the solder pads of their packages.

use fabkit_geometry::{
    BoardPlacement, BoardSide, Circuit, CircuitKind, CircuitPart, Connection, KeepOut,
    KeepOutRegion, Land, Net, Pose, SeriesResistor, Vector3,
};

use crate::chain_builder::Name;
use crate::parameters;
use crate::parameters::RuleReport;

/// Name of the supply net.
pub const SUPPLY: &str = "V+";
/// Name of the ground net.
pub const GROUND: &str = "GND";

/// Two supply wires of LEDs: net, colour of the insulation, and the other end.
pub const TO_SUPPLY: [(&str, &str, &str); 2] =
    [(SUPPLY, "red", "supply"), (GROUND, "black", "ground of the supply")];

/// Package of a chip resistor: rated power, W, of thick film at 70 degrees Celsius (Yageo RC and Vishay CRCW alike),
/// and length and width, mm (IEC 60115-8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chip {
    /// Size code in hundredths of an inch.
    pub name: &'static str,
    /// Length and width, mm.
    pub size_mm: [f64; 2],
    /// Rated power, W.
    pub rated_w: f64,
}

/// Chip resistor of 1.0 x 0.5 mm.
pub const CHIP_0402: Chip = Chip { name: "0402", size_mm: [1.0, 0.5], rated_w: 0.063 };
/// Chip resistor of 1.6 x 0.8 mm.
pub const CHIP_0603: Chip = Chip { name: "0603", size_mm: [1.6, 0.8], rated_w: 0.1 };

/// Returns the lands of a part with two ends along x: inner edges a quarter of the length from the middle, outer ones a
/// quarter of it, at most 0.4 mm, beyond its ends. That is within 0.1 mm of IPC-7351's nominal lands of 0402, 0603 and
/// 0805. Lands of LEDs that are wider than 2 mm are three quarters as wide as these.
fn two_lands([length, width]: [f64; 2], [first, second]: [&str; 2]) -> Vec<Land> {
    let (inner, outer) = (length / 4.0, length / 2.0 + (length / 4.0).min(0.4));
    let across = if width > 2.0 { 0.75 * width } else { width };
    let land = |pin: &str, sign: f64| Land {
        pin: pin.to_owned(),
        at_mm: [sign * (inner + outer) / 2.0, 0.0],
        size_mm: [outer - inner, across],
        is_round: false,
    };
    vec![land(first, -1.0), land(second, 1.0)]
}

/// Footprint of an LED's package.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LedPackage {
    /// Rectangular package: length, with the terminals at its ends, and width, mm.
    Chip([f64; 2]),
    /// Round package: diameter, mm, with two lands below it.
    Round(f64),
}

impl LedPackage {
    /// Returns the name of the package.
    fn name(self) -> String {
        match self {
            Self::Chip([length, width]) => format!("{length:.1} x {width:.1} mm"),
            Self::Round(diameter) => format!("round {diameter:.1} mm"),
        }
    }

    /// Returns the edges of the package, mm.
    fn size_mm(self) -> [f64; 2] {
        match self {
            Self::Chip(size) => size,
            // Edges of the square inscribed in the circle.
            Self::Round(diameter) => [diameter * std::f64::consts::FRAC_1_SQRT_2; 2],
        }
    }

    /// Returns the lands, with the cathode at -x.
    fn lands(self) -> Vec<Land> {
        match self {
            Self::Chip(size) => two_lands(size, ["K", "A"]),
            Self::Round(diameter) => {
                // Both lands lie within the circle, a tenth of the diameter from the middle.
                let size_mm = [0.286 * diameter, 0.514 * diameter];
                let land = |pin: &str, sign: f64| Land {
                    pin: pin.to_owned(),
                    at_mm: [sign * 0.243 * diameter, 0.0],
                    size_mm,
                    is_round: false,
                };
                vec![land("K", -1.0), land("A", 1.0)]
            }
        }
    }
}

parameters! {
    /// Electrical data of LEDs, in the section `leds`.
    pub struct Electric {
        /// Supply voltage, V.
        supply_volts: f64 = 3.0..=24.0,
        /// Forward voltage of an LED at its current, V.
        forward_volts: f64 = 1.5..=24.0,
        /// Current of an LED, mA, for which its resistor is calculated.
        current_ma: f64 = 0.5..=60.0,
        /// Largest current that an LED withstands permanently, mA.
        rated_ma: f64 = 1.0..=3000.0,
        /// Largest current that the supply delivers, mA.
        supply_ma: f64 = 1.0..=20000.0,
        /// Resistance of an LED's resistor, ohm, whatever current results; 0 to calculate it from the current.
        resistor_ohms: f64 = 0.0..=100000.0,
    }
}

/// Smallest voltage across a resistor, V, for it to determine the current: forward voltages of one type of LED, and the
/// voltage of USB supplies, scatter by as much; chosen.
const LEAST_DROP_V: f64 = 0.2;

impl Electric {
    /// Returns the current of an LED that its resistor is calculated for, A.
    pub fn current_a(&self) -> f64 {
        self.current_ma / 1e3
    }

    /// Returns the largest current of the supply, A.
    fn supply_a(&self) -> f64 {
        self.supply_ma / 1e3
    }

    /// Reports LEDs that stay dark on this supply, or currents that overload the LEDs, their resistors or the supply.
    ///
    /// `forward` is the path of the forward voltage, `sharing` the number of LEDs per resistor, `all` the total number.
    pub fn check(
        &self,
        forward: &str,
        [sharing, all]: [u32; 2],
        chip: Chip,
        report: &mut RuleReport,
    ) {
        let supply_v = self.supply_volts;
        let drop_v = supply_v - self.forward_volts;
        report.at_most(
            forward,
            self.forward_volts,
            supply_v - LEAST_DROP_V,
            format!("the resistor needs {LEAST_DROP_V} V of the supply's {supply_v} V to set the current"),
        );
        if drop_v < LEAST_DROP_V {
            return; // The limits below hold only for a positive voltage across the resistor.
        }
        let (sharing, all) = (f64::from(sharing), f64::from(all));
        let bears = format!("a resistor {} bears {} W", chip.name, chip.rated_w);
        let (ohms, rated_a, supply_a) = (self.resistor_ohms, self.rated_ma / 1e3, self.supply_a());
        let most_a = supply_a / all;
        let gives = format!("the supply gives {} mA for {all} LEDs", supply_a * 1e3);
        if ohms > 0.0 {
            // Smallest resistance that limits each of the sharing LEDs to `most_a`.
            let least = |most_a: f64| drop_v / (sharing * most_a);
            let rated = format!("an LED bears {} mA", rated_a * 1e3);
            report.at_least("leds.resistor_ohms", ohms, least(rated_a), rated);
            // Heat of the resistor: U^2 / R.
            report.at_least("leds.resistor_ohms", ohms, drop_v.powi(2) / chip.rated_w, bears);
            report.at_least("leds.resistor_ohms", ohms, least(most_a), gives);
        } else {
            // The resistor is rounded up to the next value of the series, so the current is never larger than this.
            let ma = self.current_a() * 1e3;
            report.at_most("leds.current_ma", ma, rated_a * 1e3, "an LED bears no more");
            // Heat of the resistor: U I, with the current of all LEDs that share it.
            report.at_most("leds.current_ma", ma, chip.rated_w / (drop_v * sharing) * 1e3, bears);
            report.at_most("leds.current_ma", ma, most_a * 1e3, gives);
        }
    }
}

/// Builder of a circuit.
///
/// ```
/// use fabkit_designs::blocks::circuit::{CHIP_0603, CircuitBuilder, Electric};
/// let electric = Electric {
///     supply_volts: 5.0,
///     forward_volts: 3.0,
///     current_ma: 20.0,
///     rated_ma: 30.0,
///     supply_ma: 500.0,
///     resistor_ohms: 0.0,
/// };
/// // 2 V remain for the resistor: 100 ohm at 20 mA, a value of the series.
/// let resistor = CircuitBuilder::new_wired("lamp", 5.0).calculate(&electric, 1, CHIP_0603, "");
/// assert_eq!(resistor.ohms, 100.0);
/// assert!((resistor.current_a() - 0.02).abs() < 1e-12);
/// ```
pub struct CircuitBuilder {
    circuit: Circuit,
    counts: [u32; 5],
}

impl CircuitBuilder {
    /// Starts a circuit on a board.
    pub fn new_on_board(board: Name, electric: &Electric) -> Self {
        let (supply_v, supply_a) = (electric.supply_volts, electric.supply_a());
        Self::new(board.name, Some(board.name), supply_v, Some(supply_a))
    }

    /// Starts a circuit without a board of its own, whose supply is bought for it.
    pub fn new_wired(name: &str, supply_v: f64) -> Self {
        Self::new(name, None, supply_v, None)
    }

    fn new(name: &str, board: Option<&str>, supply_v: f64, supply_a: Option<f64>) -> Self {
        let circuit = Circuit {
            name: name.to_owned(),
            board: board.map(str::to_owned),
            supply_v,
            supply_a,
            parts: Vec::new(),
            nets: Vec::new(),
            resistors: Vec::new(),
            current_a: 0.0,
            keep_outs: Vec::new(),
            connections: Vec::new(),
            notes: Vec::new(),
        };
        Self { circuit, counts: [0; 5] }
    }

    /// Returns the next designator of a kind.
    fn next(&mut self, kind: CircuitKind) -> String {
        let (index, letters) = match kind {
            CircuitKind::Led => (0, "D"),
            CircuitKind::Resistor => (1, "R"),
            CircuitKind::Switch => (2, "U"),
            CircuitKind::WirePad => (3, "W"),
            CircuitKind::TestPoint => (4, "TP"),
        };
        self.counts[index] += 1;
        format!("{letters}{}", self.counts[index])
    }

    /// Connects a pin of a part to a net.
    pub fn connect(&mut self, net: &str, part: &str, pin: &str) {
        let pin = (part.to_owned(), pin.to_owned());
        match self.circuit.nets.iter_mut().find(|known| known.name == net) {
            Some(known) => known.pins.push(pin),
            None => {
                let net = Net { name: net.to_owned(), pins: vec![pin], current_a: 0.0 };
                self.circuit.nets.push(net);
            }
        }
    }

    /// Adds to the largest current of a net, A.
    pub fn add_net_current(&mut self, net: &str, current_a: f64) {
        let mut nets = self.circuit.nets.iter_mut();
        if let Some(net) = nets.find(|known| known.name == net) {
            net.current_a += current_a;
        }
    }

    /// Adds an LED between a net and ground. Returns its designator.
    pub fn led(
        &mut self,
        model: &str,
        package: LedPackage,
        place: BoardPlacement,
        body: Name,
        from: &str,
    ) -> String {
        let name = self.next(CircuitKind::Led);
        self.circuit.parts.push(CircuitPart {
            designator: name.clone(),
            kind: CircuitKind::Led,
            value: model.to_owned(),
            package: package.name(),
            lands: package.lands(),
            size_mm: package.size_mm(),
            place: Some(place),
            body: Some(body.name.to_owned()),
        });
        self.connect(from, &name, "A");
        self.connect(GROUND, &name, "K");
        name
    }

    /// Adds a resistor between two nets. Returns its designator.
    pub fn resistor(
        &mut self,
        ohms: f64,
        chip: Chip,
        drawn: Option<(BoardPlacement, Name)>,
        [from, to]: [&str; 2],
    ) -> String {
        let name = self.next(CircuitKind::Resistor);
        self.circuit.parts.push(CircuitPart {
            designator: name.clone(),
            kind: CircuitKind::Resistor,
            value: ohms_text(ohms),
            package: chip.name.to_owned(),
            lands: two_lands(chip.size_mm, ["1", "2"]),
            size_mm: chip.size_mm,
            place: drawn.map(|(place, _)| place),
            body: drawn.map(|(_, body)| body.name.to_owned()),
        });
        self.connect(from, &name, "1");
        self.connect(to, &name, "2");
        name
    }

    /// Adds any other part. Returns its designator.
    pub fn part(&mut self, part: CircuitPart) -> String {
        let designator = self.next(part.kind);
        self.circuit.parts.push(CircuitPart { designator: designator.clone(), ..part });
        designator
    }

    /// Calculates the resistor for a number of LEDs that share it: the given value, or the next larger one of the E24
    /// series.
    pub fn calculate(
        &mut self,
        electric: &Electric,
        leds: u32,
        chip: Chip,
        source: &str,
    ) -> SeriesResistor {
        let ohms = electric.resistor_ohms;
        let mut one = SeriesResistor {
            designators: Vec::new(),
            supply_v: electric.supply_volts,
            forward_v: electric.forward_volts,
            leds,
            led_rated_a: electric.rated_ma / 1e3,
            // A given resistor determines the current instead.
            target_current_a: (ohms == 0.0).then_some(electric.current_a()),
            ohms,
            rated_w: chip.rated_w,
            source: source.to_owned(),
        };
        if let Some(exact) = one.exact_ohms() {
            one.ohms = SeriesResistor::e24_not_below(exact);
        }
        one
    }

    /// Adds the calculation of a resistor to the circuit.
    pub fn add_calculation(&mut self, calculation: SeriesResistor) {
        self.circuit.resistors.push(calculation);
    }

    /// Adds LEDs between supply and ground, each with its own resistor.
    pub fn add_leds_with_resistors(
        &mut self,
        electric: &Electric,
        (model, package, body): (&str, LedPackage, Name),
        places: Vec<BoardPlacement>,
        chip: Chip,
        source: &str,
    ) {
        let mut calculation = self.calculate(electric, 1, chip, source);
        let each = calculation.current_a();
        for (place, number) in places.into_iter().zip(1..) {
            let net = format!("LED{number}");
            let resistor = self.resistor(calculation.ohms, chip, None, [SUPPLY, &net]);
            calculation.designators.push(resistor);
            self.led(model, package, place, body, &net);
            self.add_net_current(&net, each);
        }
        let all = each * calculation.designators.len() as f64;
        self.add_net_current(SUPPLY, all);
        self.add_net_current(GROUND, all);
        self.circuit.current_a += all;
        self.add_calculation(calculation);
    }

    /// Adds a pad for a wire, beside a hole that the wire passes or alone. Returns its designator.
    pub fn wire(&mut self, net: &str, wire: BoardWire<'_>) -> String {
        let BoardWire { place, hole_mm, pad_mm, by, to, length_mm, color } = wire;
        // The pad stays off the hole's edge, because copper keeps a distance from unplated holes.
        let out = hole_mm.map_or(0.0, |hole| hole / 2.0 + HOLE_TO_PAD_MM + pad_mm[0] / 2.0);
        let name = self.part(CircuitPart {
            designator: String::new(),
            kind: CircuitKind::WirePad,
            value: format!("wire {net}"),
            package: format!("pad {:.2} x {:.2} mm", pad_mm[0], pad_mm[1]),
            lands: vec![Land {
                pin: "1".into(),
                at_mm: [out, 0.0],
                size_mm: pad_mm,
                is_round: false,
            }],
            size_mm: [0.0; 2],
            place: Some(place),
            body: by.map(|by| by.name.to_owned()),
        });
        self.connect(net, &name, "1");
        self.circuit.connections.push(Connection {
            from: format!("{} {name}", self.circuit.name),
            to: to.to_owned(),
            carries: net.to_owned(),
            by: by.map(|by| by.name.to_owned()),
            length_mm,
            color: Some(color.to_owned()),
        });
        name
    }

    /// Adds test points for a probe: supply and ground.
    pub fn test_points(&mut self) {
        for net in [SUPPLY, GROUND] {
            let name = self.part(CircuitPart {
                designator: String::new(),
                kind: CircuitKind::TestPoint,
                value: format!("test point {net}"),
                package: "disc 1.0 mm".into(),
                lands: vec![Land {
                    pin: "1".into(),
                    at_mm: [0.0; 2],
                    size_mm: [1.0; 2],
                    is_round: true,
                }],
                size_mm: [0.0; 2],
                place: None,
                body: None,
            });
            self.connect(net, &name, "1");
        }
    }

    /// Adds a region of the board that other bodies occupy.
    pub fn keep_out(&mut self, side: BoardSide, region: KeepOutRegion, what: &str) {
        self.circuit.keep_outs.push(KeepOut { side, region, description: what.to_owned() });
    }

    /// Adds a cable or wire that ends at no pad of a board.
    pub fn connection(&mut self, connection: Connection) {
        self.circuit.connections.push(connection);
    }

    /// Adds the supply and ground wires of LED strips, which are named `called` and numbered.
    pub fn strips(&mut self, count: u32, called: &str, supply: &str) {
        let numbers = (1..=count).flat_map(|number| TO_SUPPLY.map(|wire| (number, wire)));
        self.circuit.connections.extend(numbers.map(|(number, (net, color, to))| Connection {
            from: format!("{called} {number}, {net}"),
            to: if net == SUPPLY { supply } else { to }.to_owned(),
            carries: net.to_owned(),
            by: None,
            length_mm: None,
            color: Some(color.to_owned()),
        }));
    }

    /// Adds a note.
    pub fn note(&mut self, text: impl Into<String>) {
        self.circuit.notes.push(text.into());
    }

    /// Adds to the total current, A, besides the LEDs that [`CircuitBuilder::add_leds_with_resistors`] counts.
    pub fn add_current(&mut self, current_a: f64) {
        self.circuit.current_a += current_a;
    }

    /// Returns the circuit.
    pub fn build(self) -> Circuit {
        self.circuit
    }
}

/// Distance from the edge of an unplated hole to a wire's pad, mm: the clearance that fabs require, plus the error of
/// arcs that outlines approximate by short lines.
const HOLE_TO_PAD_MM: f64 = 0.201;

/// Wire at its board.
#[derive(Clone, Copy, Debug)]
pub struct BoardWire<'a> {
    /// Position of the hole, or of the pad if there is no hole; the pad lies along the place's x.
    pub place: BoardPlacement,
    /// Diameter of the hole, mm.
    pub hole_mm: Option<f64>,
    /// Size of the pad along and across the wire, mm.
    pub pad_mm: [f64; 2],
    /// Body that models the wire.
    pub by: Option<Name>,
    /// Other end of the wire.
    pub to: &'a str,
    /// Length of the modelled wire, mm.
    pub length_mm: Option<f64>,
    /// Colour of the insulation.
    pub color: &'a str,
}

impl<'a> BoardWire<'a> {
    /// Creates one of the wires [`TO_SUPPLY`] on a pad alone, without a body.
    pub fn without_body(
        place: BoardPlacement,
        pad_mm: [f64; 2],
        (_, color, to): (&str, &'a str, &'a str),
    ) -> Self {
        Self { place, hole_mm: None, pad_mm, by: None, to, length_mm: None, color }
    }
}

/// Returns the ring around the board's middle between two radii, mm.
pub fn ring_region([inner_mm, outer_mm]: [f64; 2]) -> KeepOutRegion {
    KeepOutRegion::Sector { inner_mm, outer_mm, middle_rad: 0.0, half_rad: std::f64::consts::PI }
}

/// Returns the board places of LEDs whose length lies along x.
pub fn along_x(poses: &[Pose]) -> Vec<BoardPlacement> {
    let place = |pose: &Pose| BoardPlacement::from_body_pose(pose, Vector3::x(), BoardSide::Top);
    poses.iter().map(place).collect()
}

/// Returns the board places of LEDs whose length lies along y.
pub fn along_y(poses: &[Pose]) -> Vec<BoardPlacement> {
    let place = |pose: &Pose| BoardPlacement::from_body_pose(pose, Vector3::y(), BoardSide::Top);
    poses.iter().map(place).collect()
}

/// Returns the connection of a camera to the computer.
pub fn camera_to_host(
    camera: &str,
    by: Option<Name>,
    length_mm: Option<f64>,
    carries: &str,
) -> Connection {
    Connection {
        from: camera.to_owned(),
        to: "computer".to_owned(),
        carries: carries.to_owned(),
        by: by.map(|by| by.name.to_owned()),
        length_mm,
        color: None,
    }
}

/// Formats a resistance as it is ordered.
///
/// ```
/// use fabkit_designs::blocks::circuit::ohms_text;
/// assert_eq!(ohms_text(470.0), "470 ohm");
/// assert_eq!(ohms_text(2200.0), "2.2 kohm");
/// ```
pub fn ohms_text(ohms: f64) -> String {
    if ohms >= 1e3 { format!("{} kohm", ohms / 1e3) } else { format!("{ohms} ohm") }
}
