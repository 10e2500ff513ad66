//! Conditions under which parameters count.

/// Condition under which a parameter of a family changes something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Condition {
    /// Word of the family; empty for all families.
    pub family: &'static str,
    /// Dotted path of the parameter, or of its section followed by `.*`.
    pub path: &'static str,
    /// What has to hold, as half a sentence after `if`.
    pub counts_if: &'static str,
}

/// Conditions of all parameters that change nothing in some designs. A test sets every parameter of every family, and
/// fails for one that changes nothing and is not listed here, and for a row here that no family has.
#[rustfmt::skip]
const CONDITIONS: &[Condition] = &[
    Condition { family: "", path: "mount.width", counts_if: "mount.pattern is `rectangle`" },
    Condition { family: "", path: "mount.depth", counts_if: "mount.pattern is `rectangle`" },
    Condition { family: "", path: "mount.x", counts_if: "mount.pattern is `list`" },
    Condition { family: "", path: "mount.y", counts_if: "mount.pattern is `list`" },
    Condition { family: "", path: "adapter.width", counts_if: "adapter.pattern is `rectangle`" },
    Condition { family: "", path: "adapter.depth", counts_if: "adapter.pattern is `rectangle`" },
    Condition { family: "", path: "adapter.thread", counts_if: "adapter.pattern is `rectangle`" },
    Condition { family: "", path: "adapter.offset", counts_if: "adapter.pattern names a finger" },
    Condition { family: "", path: "adapter.flange_angle", counts_if: "adapter.pattern names a flange" },
    Condition { family: "", path: "adapter.*", counts_if: "adapter.pattern is not `none`" },
    Condition { family: "", path: "markers.x", counts_if: "markers.pattern is `list`" },
    Condition { family: "", path: "markers.y", counts_if: "markers.pattern is `list`" },
    Condition { family: "", path: "leds.current_ma", counts_if: "leds.resistor_ohms is 0, so that the resistor follows from the current" },
    Condition { family: "flat-gel", path: "markers.columns", counts_if: "markers.pattern is `grid`, and markers.rows is above 0" },
    Condition { family: "flat-gel", path: "markers.rows", counts_if: "markers.pattern is `grid`, and markers.columns is above 0" },
    Condition { family: "flat-gel", path: "markers.*", counts_if: "there are dots: markers.columns and markers.rows above 0, or markers.pattern `list`" },
    Condition { family: "flat-gel", path: "leds.below_plate", counts_if: "leds.from is `sides`" },
    Condition { family: "flat-gel", path: "leds.step", counts_if: "leds.from is `below`" },
    Condition { family: "flat-gel", path: "leds.forward_volts", counts_if: "leds.from is `below`: strips come with their resistors" },
    Condition { family: "flat-gel", path: "leds.rated_ma", counts_if: "leds.from is `below`: strips come with their resistors" },
    Condition { family: "flat-gel", path: "leds.supply_ma", counts_if: "leds.from is `below`: strips come with their resistors" },
    Condition { family: "flat-gel", path: "leds.resistor_ohms", counts_if: "leds.from is `below`: strips come with their resistors" },
    Condition { family: "flat-gel", path: "shell.wall", counts_if: "shell.rim leaves less wall around the room inside: it is a minimum" },
    Condition { family: "dome", path: "base.cable_angle", counts_if: "base.cable_exit is `floor`" },
    Condition { family: "dome", path: "base.cable_slot_length", counts_if: "base.cable_exit is `floor`" },
    Condition { family: "dome", path: "base.cable_slot_width", counts_if: "base.cable_exit is `floor`" },
    Condition { family: "dome", path: "coating.*", counts_if: "coat.method is `dip`" },
    Condition { family: "dome", path: "envelope.*", counts_if: "the sensor were larger: it is a limit, which is checked" },
    Condition { family: "dome", path: "form.*", counts_if: "molds.route is `silicone`" },
    Condition { family: "dome", path: "mold.wall", counts_if: "molds.route is `printed`, and the block left less around its cavity: it is a minimum" },
    Condition { family: "dome", path: "mold.*", counts_if: "molds.route is `printed`" },
    Condition { family: "dome-cap", path: "dimples.azimuth", counts_if: "dimples.pattern is `list`" },
    Condition { family: "dome-cap", path: "dimples.polar", counts_if: "dimples.pattern is `list`" },
    Condition { family: "dome-cap", path: "mold.wall", counts_if: "the block left less around its cavity: it is a minimum" },
    Condition { family: "pin-tip", path: "pins.diameter", counts_if: "pins.layout is `free`" },
    Condition { family: "pin-tip", path: "pins.spacing", counts_if: "pins.layout is `free`, and pins.pattern is `rings`" },
    Condition { family: "pin-tip", path: "pins.azimuth", counts_if: "pins.pattern is `list`" },
    Condition { family: "pin-tip", path: "pins.polar", counts_if: "pins.pattern is `list`" },
    Condition { family: "half-ellipsoid", path: "markers.azimuth", counts_if: "markers.pattern is `list`" },
    Condition { family: "half-ellipsoid", path: "markers.polar", counts_if: "markers.pattern is `list`" },
    Condition { family: "half-ellipsoid", path: "markers.wall", counts_if: "markers were closer to each other: it is a minimum" },
    Condition { family: "sheet-mold", path: "channels.chamber_diameter", counts_if: "the channels' arrangement has chambers" },
    Condition { family: "sheet-mold", path: "stock.*", counts_if: "a part did not fit on the sheet: it is a limit, which is checked" },
];

/// Returns the conditions of all parameters that change nothing in some designs.
pub fn conditions() -> &'static [Condition] {
    CONDITIONS
}

/// Returns the condition under which a parameter counts, if it is one that does not always.
///
/// ```
/// use fabkit_designs::condition;
/// assert_eq!(condition("dome", "base.cable_angle"), Some("base.cable_exit is `floor`"));
/// assert_eq!(condition("dome", "shell.wall"), None);
/// ```
pub fn condition(family: &str, path: &str) -> Option<&'static str> {
    let is_section =
        |pattern: &str| pattern.strip_suffix('*').is_some_and(|section| path.starts_with(section));
    let is_it = |one: &&Condition| {
        (one.family.is_empty() || one.family == family)
            && (one.path == path || is_section(one.path))
    };
    CONDITIONS.iter().find(is_it).map(|one| one.counts_if)
}
