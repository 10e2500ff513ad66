//! Design rules: the limits of a fab, and the needs of soldering by hand.

/// Design rules of a board. Lengths are in mm.
///
/// ```
/// use fabkit_boards::{BoardRules, STANDARD_RULES, min_track_width_mm};
/// // Thicker copper carries a current on a narrower track.
/// let rules = BoardRules { copper_mm: 0.070, ..STANDARD_RULES };
/// let [usual_mm, thick_mm] =
///     [&STANDARD_RULES, &rules].map(|rules| min_track_width_mm(1.0, rules));
/// assert!((thick_mm - usual_mm / 2.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoardRules {
    /// Minimum clearance between copper of two nets.
    pub clearance_mm: f64,
    /// Minimum width of a track.
    pub track_mm: f64,
    /// Preferred width of a track, used if there is room.
    pub preferred_track_mm: f64,
    /// Minimum distance between copper and a routed edge or an unplated hole.
    pub edge_mm: f64,
    /// Drill diameter of a via.
    pub via_drill_mm: f64,
    /// Copper diameter of a via.
    pub via_mm: f64,
    /// Minimum width of the copper ring around a plated hole.
    pub ring_mm: f64,
    /// Minimum drill diameter.
    pub drill_mm: f64,
    /// Minimum distance between the edges of two holes.
    pub hole_to_hole_mm: f64,
    /// Margin of a mask opening beyond its pad, per side.
    pub mask_mm: f64,
    /// Minimum distance between silk and an opening of the mask.
    pub silk_mm: f64,
    /// Line width of silk.
    pub silk_line_mm: f64,
    /// Minimum distance between two parts' outlines.
    pub part_mm: f64,
    /// Minimum shorter edge of a pad to which a wire is soldered.
    pub wire_pad_mm: f64,
    /// Allowed temperature rise of a track above the board, K.
    pub temperature_rise_k: f64,
    /// Thickness of the copper.
    pub copper_mm: f64,
}

/// Rules for two layers of 35 um copper as pooling services make them without surcharge: 0.15 mm tracks and gaps,
/// 0.3 mm drills with 0.1 mm rings, 0.2 mm to a routed edge. The values are from their published tables; of those
/// known, the wider one is chosen.
pub const STANDARD_RULES: BoardRules = BoardRules {
    clearance_mm: 0.15,
    track_mm: 0.15,
    preferred_track_mm: 0.25,
    edge_mm: 0.2,
    via_drill_mm: 0.3,
    via_mm: 0.5,
    ring_mm: 0.1,
    drill_mm: 0.3,
    hole_to_hole_mm: 0.25,
    mask_mm: 0.05,
    silk_mm: 0.1,
    silk_line_mm: 0.12,
    part_mm: 0.15,
    wire_pad_mm: 0.5,
    temperature_rise_k: 10.0,
    copper_mm: 0.035,
};

/// Thousandths of an inch (mil) per millimetre.
const MIL_PER_MM: f64 = 1.0 / 0.0254;

/// Minimum width of an outer track for a current, mm: IPC-2221 (6.2), `I = 0.048 dT^0.44 A^0.725`, with A in square
/// mil.
///
/// ```
/// use fabkit_boards::{STANDARD_RULES, min_track_width_mm};
/// // The chart of the standard: about 0.3 mm for 1 A at 10 K on 35 um.
/// assert!((min_track_width_mm(1.0, &STANDARD_RULES) - 0.30).abs() < 0.01);
/// ```
pub fn min_track_width_mm(current_a: f64, rules: &BoardRules) -> f64 {
    let area_mil2 = (current_a / (0.048 * rules.temperature_rise_k.powf(0.44))).powf(1.0 / 0.725);
    area_mil2 / (rules.copper_mm * MIL_PER_MM) / MIL_PER_MM
}
