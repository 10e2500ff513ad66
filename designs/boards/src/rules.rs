//! What a fab makes and what a solderer needs.

/// Rules of a board. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Between copper of two nets.
    pub clearance_mm: f64,
    /// Narrowest track.
    pub track_mm: f64,
    /// Usual track, where there is room.
    pub usual_track_mm: f64,
    /// Between copper and a routed edge or an unplated hole.
    pub edge_mm: f64,
    /// Drill of a via.
    pub via_drill_mm: f64,
    /// Copper disc of a via.
    pub via_mm: f64,
    /// Narrowest ring of copper around a plated hole.
    pub ring_mm: f64,
    /// Smallest drill.
    pub drill_mm: f64,
    /// Between the edges of two holes.
    pub hole_to_hole_mm: f64,
    /// Opening of the mask beyond a pad, per side.
    pub mask_mm: f64,
    /// Between silk and an opening of the mask.
    pub silk_mm: f64,
    /// Width of a line of silk.
    pub silk_line_mm: f64,
    /// Between two parts' outlines.
    pub part_mm: f64,
    /// Smallest pad that a wire is soldered to, shorter edge.
    pub wire_pad_mm: f64,
    /// How much warmer than the board a track may become, K.
    pub rise_k: f64,
    /// Thickness of the copper.
    pub copper_mm: f64,
}

/// Two layers of 35 um copper as pool services make them without surcharge: 0.15 mm tracks and gaps, 0.3 mm
/// drills with 0.1 mm rings, 0.2 mm to a routed edge (their published tables; chosen: the wider of those known).
pub const USUAL: Rules = Rules {
    clearance_mm: 0.15,
    track_mm: 0.15,
    usual_track_mm: 0.25,
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
    rise_k: 10.0,
    copper_mm: 0.035,
};

/// mm to thousandths of an inch.
const MIL_PER_MM: f64 = 1.0 / 0.0254;

/// Narrowest outer track for a current, mm: IPC-2221 (6.2), `I = 0.048 dT^0.44 A^0.725`, A in square mil.
///
/// ```
/// use fabkit_boards::{USUAL, width_for_mm};
/// // The chart of the standard: about 0.3 mm for 1 A at 10 K on 35 um.
/// assert!((width_for_mm(1.0, &USUAL) - 0.30).abs() < 0.01);
/// ```
pub fn width_for_mm(current_a: f64, rules: &Rules) -> f64 {
    let area_mil2 = (current_a / (0.048 * rules.rise_k.powf(0.44))).powf(1.0 / 0.725);
    area_mil2 / (rules.copper_mm * MIL_PER_MM) / MIL_PER_MM
}
