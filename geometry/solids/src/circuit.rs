//! Circuits as data: what is soldered, what is connected to what, and what each resistor is.
//!
//! A circuit knows neither copper nor files. Its board is a body of the sensor, and a place on it is given in
//! the sensor's x and y, seen from above; what stands on the lower side is turned about its own x axis.

use crate::{Point3, Pose, Vector3};

/// What a part of a circuit is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CircuitKind {
    /// A light-emitting diode: pin `A` is its anode, pin `K` its cathode.
    Led,
    /// A resistor, whose two pins may be exchanged.
    Resistor,
    /// A switch in a package with numbered pins.
    Switch,
    /// Where a wire is soldered to the board.
    WirePad,
    /// Where a probe is held against.
    TestPoint,
}

/// Which side of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BoardSide {
    /// The upper one, towards +z.
    Top,
    /// The lower one.
    Bottom,
}

/// Copper that a pin is soldered to, in the frame of its part, seen from the side it is on.
#[derive(Clone, Debug, PartialEq)]
pub struct Land {
    /// The pin: `A`, `K`, `1`.
    pub pin: String,
    /// Its middle, mm.
    pub at_mm: [f64; 2],
    /// Along x and along y of the part, mm.
    pub size_mm: [f64; 2],
    /// A disc of `size_mm[0]`, not a rectangle.
    pub is_round: bool,
}

/// Where a part stands on its board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardPlace {
    /// Its middle in the sensor's x and y, mm.
    pub at_mm: [f64; 2],
    /// From the sensor's x axis to the part's, counter-clockwise seen from above, rad.
    pub turn_rad: f64,
    /// Its side.
    pub side: BoardSide,
}

impl BoardPlace {
    /// Where a body stands that was drawn with its pins along x or along y.
    pub fn of_body(sensor_from_body: &Pose, along: Vector3<f64>, side: BoardSide) -> Self {
        let at = sensor_from_body.point(Point3::origin());
        let along = sensor_from_body.vector(along);
        Self { at_mm: [at.x, at.y], turn_rad: along.y.atan2(along.x), side }
    }

    /// A point of the part in the sensor's x and y, mm.
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turn_rad.sin_cos();
        let y = if self.side == BoardSide::Top { y } else { -y };
        [self.at_mm[0] + cos * x - sin * y, self.at_mm[1] + sin * x + cos * y]
    }
}

/// What is soldered to a board, or connected by wires.
#[derive(Clone, Debug, PartialEq)]
pub struct CircuitPart {
    /// `D1`, `R1`, `U1`; unique in its circuit.
    pub designator: String,
    /// What it is.
    pub kind: CircuitKind,
    /// What to order: a type, a value.
    pub value: String,
    /// The package: `0603`, `VSSOP-8`, `2835`.
    pub package: String,
    /// Its lands.
    pub lands: Vec<Land>,
    /// What it takes of the board, lands apart: along x and y of the part, mm.
    pub size_mm: [f64; 2],
    /// Where it is; `None` where the board's layout is to find a place beside what it is connected to.
    pub place: Option<BoardPlace>,
    /// The bought body that it is, by name, where it is drawn.
    pub body: Option<String>,
}

/// What is connected.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    /// `+5V`, `GND`, `LED1`.
    pub name: String,
    /// Part and pin.
    pub pins: Vec<(String, String)>,
    /// Largest current in any piece of it, A.
    pub current_a: f64,
}

/// A region of one side of a board where something else stands: no parts, no bare copper.
#[derive(Clone, Debug, PartialEq)]
pub struct KeepOut {
    /// Which side.
    pub side: BoardSide,
    /// The region in the sensor's x and y, mm.
    pub region: KeepOutRegion,
    /// What stands there.
    pub what: String,
}

/// The shape of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeepOutRegion {
    /// Between two radii about the axis, over an angle, rad; all around where `half_rad` is pi.
    Sector {
        /// mm.
        inner_mm: f64,
        /// mm.
        outer_mm: f64,
        /// Its middle.
        middle_rad: f64,
        /// Half of its angle.
        half_rad: f64,
    },
    /// All that is farther than this from the axis along x or along y, mm.
    BeyondRect {
        /// Half edges, mm.
        half_mm: [f64; 2],
    },
}

/// The calculation of equal resistors, each in series with LEDs that are parallel to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesResistor {
    /// Which.
    pub designators: Vec<String>,
    /// Supply, V.
    pub supply_v: f64,
    /// Of the LEDs, V.
    pub forward_v: f64,
    /// LEDs that share one resistor.
    pub leds: u32,
    /// What each LED bears for long, A.
    pub led_rated_a: f64,
    /// Current of each LED that is asked for, A; `None` where the resistor itself is given.
    pub wanted_a: Option<f64>,
    /// What is ordered, ohm.
    pub ohms: f64,
    /// What the package bears, W.
    pub rated_w: f64,
    /// Where the values are from.
    pub source: String,
}

/// Values of the series E24 in one decade (IEC 60063).
pub const E24: [f64; 24] = [
    1.0, 1.1, 1.2, 1.3, 1.5, 1.6, 1.8, 2.0, 2.2, 2.4, 2.7, 3.0, 3.3, 3.6, 3.9, 4.3, 4.7, 5.1, 5.6,
    6.2, 6.8, 7.5, 8.2, 9.1,
];

impl SeriesResistor {
    /// The next value of E24 that lets no more current through than is wanted, ohm.
    ///
    /// ```
    /// use fabkit_geometry::SeriesResistor;
    /// // (5 V - 3.1 V) / 10 mA = 190 ohm.
    /// assert_eq!(SeriesResistor::e24_not_below((5.0 - 3.1) / 0.010), 200.0);
    /// ```
    pub fn e24_not_below(ohms: f64) -> f64 {
        let least = ohms.max(1.0) * (1.0 - 1e-9);
        let decades = (0..8).flat_map(|decade| E24.map(|value| value * 10f64.powi(decade)));
        // To the digits that are printed on it.
        let rounded = decades.map(|value| (value * 10.0).round() / 10.0);
        rounded.into_iter().find(|value| *value >= least).unwrap_or(least)
    }

    /// What the formula gives for the wanted current, ohm.
    pub fn exact_ohms(&self) -> Option<f64> {
        let wanted = self.wanted_a? * f64::from(self.leds);
        Some((self.supply_v - self.forward_v) / wanted)
    }

    /// Through the resistor, A.
    pub fn current_a(&self) -> f64 {
        ((self.supply_v - self.forward_v) / self.ohms).max(0.0)
    }

    /// Through each LED, A.
    pub fn led_a(&self) -> f64 {
        self.current_a() / f64::from(self.leds.max(1))
    }

    /// Turned to heat in it, W.
    pub fn power_w(&self) -> f64 {
        self.current_a().powi(2) * self.ohms
    }
}

/// Two ends and what leads from one to the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Where it begins: `led-board W1`.
    pub from: String,
    /// Where it ends: `5 V of the camera's host`.
    pub to: String,
    /// What it carries: `+5V`, `USB`.
    pub carries: String,
    /// The bought body that it is, by name, where it is drawn.
    pub by: Option<String>,
    /// How long it is drawn, mm.
    pub length_mm: Option<f64>,
    /// Color of the insulation, where somebody says so.
    pub color: Option<String>,
}

/// What is soldered and wired.
#[derive(Clone, Debug, PartialEq)]
pub struct Circuit {
    /// `[a-z0-9-]{1,64}`: that of its board, or of what is wired.
    pub name: String,
    /// The body that is etched, by name; `None` where parts are wired without a board of our own.
    pub board: Option<String>,
    /// Supply, V.
    pub supply_v: f64,
    /// What the supply gives at most, A; `None` where a data sheet has to tell.
    pub supply_a: Option<f64>,
    /// What is soldered.
    pub parts: Vec<CircuitPart>,
    /// What is connected.
    pub nets: Vec<Net>,
    /// How resistors are calculated.
    pub resistors: Vec<SeriesResistor>,
    /// Everything at once, A.
    pub current_a: f64,
    /// Where others stand on the board.
    pub keep_outs: Vec<KeepOut>,
    /// What leads to it and away from it.
    pub connections: Vec<Connection>,
    /// What to mind.
    pub notes: Vec<String>,
}

impl Circuit {
    /// The part of that designator.
    pub fn part(&self, designator: &str) -> Option<&CircuitPart> {
        self.parts.iter().find(|part| part.designator == designator)
    }

    /// The net of a pin.
    pub fn net_of(&self, designator: &str, pin: &str) -> Option<&Net> {
        self.nets.iter().find(|net| net.pins.iter().any(|(part, p)| part == designator && p == pin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_below_is_seen_through_the_board() {
        let place = |side| BoardPlace { at_mm: [1.0, 2.0], turn_rad: 0.0, side };
        assert_eq!(place(BoardSide::Top).point([3.0, 0.5]), [4.0, 2.5]);
        assert_eq!(place(BoardSide::Bottom).point([3.0, 0.5]), [4.0, 1.5]);
    }

    #[test]
    fn values_are_those_of_the_series() {
        for (exact, bought) in
            [(190.0, 200.0), (47.0, 47.0), (47.1, 51.0), (9.2e3, 10e3), (0.2, 1.0)]
        {
            assert_eq!(SeriesResistor::e24_not_below(exact), bought, "{exact}");
        }
    }

    #[test]
    fn a_resistor_lets_no_more_through_than_is_wanted() {
        let mut one = SeriesResistor {
            designators: vec!["R1".into()],
            supply_v: 5.0,
            forward_v: 3.1,
            leds: 4,
            led_rated_a: 0.020,
            wanted_a: Some(0.010),
            ohms: 0.0,
            rated_w: 0.1,
            source: String::new(),
        };
        one.ohms = SeriesResistor::e24_not_below(one.exact_ohms().unwrap());
        assert_eq!(one.ohms, 51.0);
        assert!(one.led_a() <= 0.010 && one.power_w() < one.rated_w);
    }
}
