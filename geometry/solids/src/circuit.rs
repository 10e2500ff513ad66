//! Electric circuits as data: soldered parts, nets and the calculation of each resistor.
//!
//! A circuit knows neither copper tracks nor files. Its board is a body of the sensor. Places on the board are given in
//! the sensor's x and y, seen from above; parts on the lower side are turned by half a turn about their own x axis.

use crate::{Point3, Pose, Vector3};

/// Kind of a part of a circuit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CircuitKind {
    /// A light-emitting diode: pin `A` is its anode, pin `K` its cathode.
    Led,
    /// A resistor, whose two pins may be exchanged.
    Resistor,
    /// A switch in a package with numbered pins.
    Switch,
    /// Land to which a wire is soldered.
    WirePad,
    /// Land for a test probe.
    TestPoint,
}

/// Side of a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BoardSide {
    /// Upper side, towards +z.
    Top,
    /// Lower side.
    Bottom,
}

/// Copper land that a pin is soldered to, in the frame of its part, seen from the side of the board it is on.
#[derive(Clone, Debug, PartialEq)]
pub struct Land {
    /// Pin name: `A`, `K`, `1`.
    pub pin: String,
    /// Centre, mm.
    pub at_mm: [f64; 2],
    /// Size along x and along y of the part, mm.
    pub size_mm: [f64; 2],
    /// True if the land is a disc of diameter `size_mm[0]` instead of a rectangle.
    pub is_round: bool,
}

/// Placement of a part on its board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardPlacement {
    /// Centre in the sensor's x and y, mm.
    pub at_mm: [f64; 2],
    /// Angle from the sensor's x axis to the part's, counter-clockwise seen from above, rad.
    pub turn_rad: f64,
    /// Side of the board.
    pub side: BoardSide,
}

impl BoardPlacement {
    /// Returns the placement of a body; `along` is the direction in the body's frame that becomes the part's x axis
    /// (bodies are drawn with their pins along x or along y).
    ///
    /// ```
    /// use fabkit_geometry::{Angle, BoardPlacement, BoardSide, Pose, Vector3};
    /// let quarter = Pose::rotation_z(Angle::from_deg(90.0).unwrap());
    /// let sensor_from_led = Pose::translation(7.0, 0.0, -2.0).then_in(quarter);
    /// let place = BoardPlacement::from_body_pose(&sensor_from_led, Vector3::x(), BoardSide::Top);
    /// assert_eq!((place.at_mm, place.turn_rad), ([7.0, 0.0], std::f64::consts::FRAC_PI_2));
    /// ```
    pub fn from_body_pose(sensor_from_body: &Pose, along: Vector3<f64>, side: BoardSide) -> Self {
        let at = sensor_from_body.point(Point3::origin());
        let along = sensor_from_body.vector(along);
        Self { at_mm: [at.x, at.y], turn_rad: along.y.atan2(along.x), side }
    }

    /// Converts a point of the part to the sensor's x and y, mm.
    ///
    /// ```
    /// use fabkit_geometry::{BoardPlacement, BoardSide};
    /// let pin = |side| BoardPlacement { at_mm: [10.0, 0.0], turn_rad: 0.0, side }.point([1.0, 0.5]);
    /// assert_eq!(pin(BoardSide::Top), [11.0, 0.5]);
    /// assert_eq!(pin(BoardSide::Bottom), [11.0, -0.5]); // seen through the board
    /// ```
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.turn_rad.sin_cos();
        // Parts on the lower side are seen through the board: y is mirrored before the turn.
        let y = if self.side == BoardSide::Top { y } else { -y };
        [self.at_mm[0] + cos * x - sin * y, self.at_mm[1] + sin * x + cos * y]
    }
}

/// Part that is soldered to a board or connected by wires.
#[derive(Clone, Debug, PartialEq)]
pub struct CircuitPart {
    /// Designator: `D1`, `R1`, `U1`; unique in its circuit.
    pub designator: String,
    /// Kind of the part.
    pub kind: CircuitKind,
    /// Type or value to order.
    pub value: String,
    /// Package: `0603`, `VSSOP-8`, `2835`.
    pub package: String,
    /// Copper lands of the pins.
    pub lands: Vec<Land>,
    /// Area taken on the board without the lands: extent along x and y of the part, mm.
    pub size_mm: [f64; 2],
    /// Placement; `None` if the board layout is to find a place beside the parts it is connected to.
    pub place: Option<BoardPlacement>,
    /// Name of the bought body that represents the part, where one is drawn.
    pub body: Option<String>,
}

/// Electrical net.
#[derive(Clone, Debug, PartialEq)]
pub struct Net {
    /// Name: `+5V`, `GND`, `LED1`.
    pub name: String,
    /// Connected pins: designator and pin name.
    pub pins: Vec<(String, String)>,
    /// Largest current in any segment of the net, A.
    pub current_a: f64,
}

/// Region of one side of a board that another body occupies: no parts and no bare copper there.
#[derive(Clone, Debug, PartialEq)]
pub struct KeepOut {
    /// Side of the board.
    pub side: BoardSide,
    /// The region in the sensor's x and y, mm.
    pub region: KeepOutRegion,
    /// Description of the occupying body.
    pub description: String,
}

/// Shape of a keep-out region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeepOutRegion {
    /// Ring sector between two radii about the axis; a full ring where `half_rad` is pi.
    Sector {
        /// Inner radius, mm.
        inner_mm: f64,
        /// Outer radius, mm.
        outer_mm: f64,
        /// Angle of the middle of the sector, rad.
        middle_rad: f64,
        /// Half of the opening angle, rad.
        half_rad: f64,
    },
    /// Everything outside a rectangle centred on the axis.
    BeyondRect {
        /// Half edge lengths along x and y, mm.
        half_mm: [f64; 2],
    },
}

/// Calculation for equal resistors, each in series with LEDs that are connected in parallel.
///
/// ```
/// let four_leds = fabkit_geometry::SeriesResistor {
///     designators: vec!["R1".into()],
///     supply_v: 5.0,
///     forward_v: 3.0,
///     leds: 4,
///     led_rated_a: 0.020,
///     target_current_a: Some(0.010),
///     ohms: 51.0,
///     rated_w: 0.1,
///     source: "data sheet".into(),
/// };
/// assert!((four_leds.exact_ohms().unwrap() - 50.0).abs() < 1e-9); // 2 V at 40 mA
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesResistor {
    /// Designators of these resistors.
    pub designators: Vec<String>,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Forward voltage of the LEDs, V.
    pub forward_v: f64,
    /// Number of LEDs that share one resistor.
    pub leds: u32,
    /// Rated continuous current of each LED, A.
    pub led_rated_a: f64,
    /// Intended current of each LED, A; `None` where the resistor itself is given.
    pub target_current_a: Option<f64>,
    /// Resistance of the ordered resistor, ohm.
    pub ohms: f64,
    /// Rated power of the package, W.
    pub rated_w: f64,
    /// Source of the values.
    pub source: String,
}

/// Values of the E24 series in one decade (IEC 60063).
pub const E24: [f64; 24] = [
    1.0, 1.1, 1.2, 1.3, 1.5, 1.6, 1.8, 2.0, 2.2, 2.4, 2.7, 3.0, 3.3, 3.6, 3.9, 4.3, 4.7, 5.1, 5.6,
    6.2, 6.8, 7.5, 8.2, 9.1,
];

impl SeriesResistor {
    /// Returns the smallest E24 value that is not below `ohms`, so that the current stays at or below the intended one,
    /// ohm.
    ///
    /// ```
    /// use fabkit_geometry::SeriesResistor;
    /// // (5 V - 3.1 V) / 10 mA = 190 ohm.
    /// assert_eq!(SeriesResistor::e24_not_below((5.0 - 3.1) / 0.010), 200.0);
    /// ```
    pub fn e24_not_below(ohms: f64) -> f64 {
        // The tolerance keeps an exact E24 value from being skipped because of rounding.
        let least = ohms.max(1.0) * (1.0 - 1e-9);
        let decades = (0..8).flat_map(|decade| E24.map(|value| value * 10f64.powi(decade)));
        // Products of powers of ten are rounded to the digits that are printed on a resistor.
        let rounded = decades.map(|value| (value * 10.0).round() / 10.0);
        rounded.into_iter().find(|value| *value >= least).unwrap_or(least)
    }

    /// Computes the exact resistance for the intended LED current, ohm; `None` where no current is given.
    pub fn exact_ohms(&self) -> Option<f64> {
        let wanted = self.target_current_a? * f64::from(self.leds);
        Some((self.supply_v - self.forward_v) / wanted)
    }

    /// Computes the current through each resistor, A.
    pub fn current_a(&self) -> f64 {
        ((self.supply_v - self.forward_v) / self.ohms).max(0.0)
    }

    /// Computes the current through each LED, A.
    pub fn led_a(&self) -> f64 {
        self.current_a() / f64::from(self.leds.max(1))
    }

    /// Computes the power dissipated in each resistor, W.
    pub fn power_w(&self) -> f64 {
        self.current_a().powi(2) * self.ohms
    }
}

/// Wire or cable between two ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// Start of the connection: `led-board W1`.
    pub from: String,
    /// End of the connection: `5 V of the camera's host`.
    pub to: String,
    /// Signal or supply that it carries: `+5V`, `USB`.
    pub carries: String,
    /// Name of the bought body that represents the cable, where one is drawn.
    pub by: Option<String>,
    /// Drawn length, mm.
    pub length_mm: Option<f64>,
    /// Colour of the insulation, if a source states it.
    pub color: Option<String>,
}

/// Soldered parts and wiring of one board or wired group.
#[derive(Clone, Debug, PartialEq)]
pub struct Circuit {
    /// Name, `[a-z0-9-]{1,64}`: that of the board, or of the wired component.
    pub name: String,
    /// Name of the etched body; `None` where parts are wired without a custom board.
    pub board: Option<String>,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Largest current of the supply, A; `None` if only its data sheet can tell.
    pub supply_a: Option<f64>,
    /// Soldered parts.
    pub parts: Vec<CircuitPart>,
    /// Electrical nets.
    pub nets: Vec<Net>,
    /// Calculations of the series resistors.
    pub resistors: Vec<SeriesResistor>,
    /// Total current with everything switched on, A.
    pub current_a: f64,
    /// Regions of the board that other bodies occupy.
    pub keep_outs: Vec<KeepOut>,
    /// Cables to and from the circuit.
    pub connections: Vec<Connection>,
    /// Remarks for the person who builds it.
    pub notes: Vec<String>,
}

impl Circuit {
    /// Returns the part with this designator.
    pub fn part(&self, designator: &str) -> Option<&CircuitPart> {
        self.parts.iter().find(|part| part.designator == designator)
    }

    /// Returns the net of a pin.
    pub fn net_of(&self, designator: &str, pin: &str) -> Option<&Net> {
        self.nets.iter().find(|net| net.pins.iter().any(|(part, p)| part == designator && p == pin))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_on_the_lower_side_are_mirrored() {
        let place = |side| BoardPlacement { at_mm: [1.0, 2.0], turn_rad: 0.0, side };
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
            target_current_a: Some(0.010),
            ohms: 0.0,
            rated_w: 0.1,
            source: String::new(),
        };
        one.ohms = SeriesResistor::e24_not_below(one.exact_ohms().unwrap());
        assert_eq!(one.ohms, 51.0);
        assert!(one.led_a() <= 0.010 && one.power_w() < one.rated_w);
    }
}
