//! Checks of a finished board against its circuit and the design rules.

use std::fmt;

use fabkit_geometry::{BoardSide, Circuit, CircuitKind};

use crate::BoardRules;
use crate::connectivity::{boxes_overlap, find_copper_pieces};
use crate::layout::{BoardLayout, SIDES, land_shape};
use crate::placement::overlaps_keep_out;
use crate::rules::min_track_width_mm;
use crate::shapes::{Point, Shape};

/// Tolerance of lengths on a board, mm.
const EXACT_MM: f64 = 1e-6;

/// Kind of rule that a board breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BoardFlaw {
    /// Pins of one net are on several pieces of copper.
    Open,
    /// Pins of several nets are on one piece of copper.
    Short,
    /// A pad is not at the place that the circuit gives it.
    PadPosition,
    /// A part is turned round: one of its pads is where another one of its pads should be.
    SwappedPads,
    /// Copper of two nets is too close.
    Clearance,
    /// Copper is too close to an edge, or beyond it.
    Edge,
    /// A track is too narrow for the fab or for its current.
    Track,
    /// A drill is too small.
    Drill,
    /// The ring of copper around a drill is too narrow.
    Ring,
    /// Two holes are too close.
    HoleSpacing,
    /// The mask covers a pad, or is open over copper that is not a pad.
    Mask,
    /// Silk lies on solder.
    Silk,
    /// Two parts overlap, or a part stands in a keep-out region.
    Parts,
    /// A resistor differs from its calculation, or its power rating is too low.
    Resistor,
}

/// One violation of a rule.
///
/// ```
/// use fabkit_boards::{BoardFinding, BoardFlaw};
/// let message = "net V+ is open".to_owned();
/// let finding = BoardFinding { flaw: BoardFlaw::Open, at_mm: [5.0, -1.5], message };
/// assert_eq!(finding.to_string(), "at (5.00, -1.50) mm: net V+ is open");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BoardFinding {
    /// Kind of the rule.
    pub flaw: BoardFlaw,
    /// Position in the sensor's x and y, mm.
    pub at_mm: Point,
    /// Description with names and numbers.
    pub message: String,
}

impl fmt::Display for BoardFinding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at ({:.2}, {:.2}) mm: {}", self.at_mm[0], self.at_mm[1], self.message)
    }
}

/// Returns all violations, in the order of the rules.
pub fn check(layout: &BoardLayout, circuit: &Circuit, rules: &BoardRules) -> Vec<BoardFinding> {
    let mut found = Vec::new();
    // Every check below reports through this closure.
    let mut tell =
        |flaw, at_mm, what: String| found.push(BoardFinding { flaw, at_mm, message: what });
    check_netlist(layout, circuit, &mut tell);
    check_pad_places(layout, circuit, &mut tell);
    check_copper(layout, circuit, rules, &mut tell);
    check_holes(layout, rules, &mut tell);
    check_mask_and_silk(layout, rules, &mut tell);
    check_parts(layout, circuit, &mut tell);
    check_resistors(circuit, &mut tell);
    found.sort_by_key(|finding| finding.flaw);
    found
}

/// Checks the connectivity of the copper against the nets of the circuit.
fn check_netlist(
    layout: &BoardLayout,
    circuit: &Circuit,
    tell: &mut impl FnMut(BoardFlaw, Point, String),
) {
    let pieces = find_copper_pieces(layout);
    let net_of = |(part, pin): &(String, String)| circuit.net_of(part, pin).map(|net| &net.name);
    let named = |(part, pin): &(String, String)| format!("{part}.{pin}");
    for net in &circuit.nets {
        let on: Vec<_> = pieces
            .iter()
            .filter(|piece| piece.pins.iter().any(|pin| net_of(pin) == Some(&net.name)))
            .collect();
        // One piece is enough to show the net as open; the first piece counts as the rest.
        if on.len() > 1 {
            let ends = on[1].pins.iter().map(named).collect::<Vec<_>>().join(", ");
            let what = format!("net {} is open: {ends} is not connected to the rest", net.name);
            tell(BoardFlaw::Open, on[1].at_mm, what);
        }
    }
    for piece in &pieces {
        let mut nets: Vec<String> = piece
            .pins
            .iter()
            // A pin without a net must not touch anything, so it counts as a net of its own.
            .map(|pin| net_of(pin).map_or_else(|| format!("unused {}", named(pin)), Clone::clone))
            .collect();
        nets.sort();
        nets.dedup();
        if nets.len() > 1 {
            tell(
                BoardFlaw::Short,
                piece.at_mm,
                format!("nets {} are one piece of copper", nets.join(", ")),
            );
        }
    }
}

/// Checks that pads are where the circuit has them.
fn check_pad_places(
    layout: &BoardLayout,
    circuit: &Circuit,
    tell: &mut impl FnMut(BoardFlaw, Point, String),
) {
    for part in &circuit.parts {
        let Some(placed) = layout.parts.iter().find(|one| one.designator == part.designator) else {
            if !layout.unplaced_test_points.contains(&part.designator) {
                tell(
                    BoardFlaw::PadPosition,
                    [0.0; 2],
                    format!("{} is not on the board", part.designator),
                );
            }
            continue;
        };
        // The circuit's place decides; only parts without one were free to be placed.
        let place = part.place.unwrap_or(placed.place);
        let wanted: Vec<(&str, Shape)> =
            part.lands.iter().map(|land| (&*land.pin, land_shape(&place, land))).collect();
        for (pin, shape) in &wanted {
            let on = |pad: &&crate::Pad| pad.part == part.designator && pad.pin == **pin;
            let Some(pad) = layout.pads.iter().find(on) else {
                tell(
                    BoardFlaw::PadPosition,
                    shape.centre(),
                    format!("{}.{pin} has no pad", part.designator),
                );
                continue;
            };
            let same = |other: &Shape| distance_mm(other.centre(), pad.shape.centre()) <= 1e-3;
            if pad.side == place.side && same(shape) {
                continue;
            }
            let is_swapped = wanted.iter().any(|(other, at)| other != pin && same(at));
            let flaw = if is_swapped { BoardFlaw::SwappedPads } else { BoardFlaw::PadPosition };
            let how = if is_swapped { "is turned round" } else { "is not where its part stands" };
            tell(flaw, pad.shape.centre(), format!("{}.{pin} {how}", part.designator));
            // The other pads of the part would repeat this.
            break;
        }
    }
}

fn distance_mm(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Checks clearances, distances from edges, and widths of tracks. Nets are those for which the copper was laid.
fn check_copper(
    layout: &BoardLayout,
    circuit: &Circuit,
    rules: &BoardRules,
    tell: &mut impl FnMut(BoardFlaw, Point, String),
) {
    for side in SIDES {
        let mut copper: Vec<(Option<usize>, Shape, String)> = Vec::new();
        for pad in layout.pads.iter().filter(|pad| pad.side == side) {
            copper.push((pad.net, pad.shape.clone(), format!("{}.{}", pad.part, pad.pin)));
        }
        for track in layout.tracks.iter().filter(|track| track.side == side) {
            copper.push((
                Some(track.net),
                track.shape(),
                format!("track of {}", layout.nets[track.net]),
            ));
        }
        for via in &layout.vias {
            copper.push((Some(via.net), via.shape(), format!("via of {}", layout.nets[via.net])));
        }
        let boxes: Vec<[Point; 2]> =
            copper.iter().map(|one| one.1.enlarged_by(rules.clearance_mm).bounds()).collect();
        for i in 0..copper.len() {
            for j in i + 1..copper.len() {
                // Two pins without a net have no common net, although both are `None`.
                if (copper[i].0 == copper[j].0 && copper[i].0.is_some())
                    || !boxes_overlap(&boxes[i], &boxes[j])
                {
                    continue;
                }
                let apart = copper[i].1.distance(&copper[j].1);
                // Copper that touches is a short, which is reported separately.
                if apart > 0.0 && apart < rules.clearance_mm - EXACT_MM {
                    let what = format!(
                        "{} is {apart:.3} mm from {}; it must be {:.2} mm",
                        copper[i].2, copper[j].2, rules.clearance_mm
                    );
                    tell(BoardFlaw::Clearance, copper[i].1.centre(), what);
                }
            }
        }
        // A via is on both sides, so its distance from the edge is reported for the upper side alone.
        for (_, shape, name) in
            copper.iter().filter(|(_, _, name)| side == SIDES[0] || !name.starts_with("via"))
        {
            let inside = layout.board.edge_distance_mm(shape);
            if inside < rules.edge_mm - EXACT_MM {
                let what = format!(
                    "{name} is {inside:.3} mm inside the edge; it must be {:.2} mm",
                    rules.edge_mm
                );
                tell(BoardFlaw::Edge, shape.centre(), what);
            }
        }
    }
    for track in &layout.tracks {
        let current_a = circuit.nets.get(track.net).map_or(0.0, |net| net.current_a);
        let least = rules.track_mm.max(min_track_width_mm(current_a, rules));
        if track.width_mm < least - EXACT_MM {
            let what = format!(
                "a track of {} is {:.3} mm wide; for {current_a:.3} A it must be {least:.3} mm",
                layout.nets[track.net], track.width_mm
            );
            tell(BoardFlaw::Track, track.ends[0], what);
        }
    }
}

/// Checks the diameters of drills, the rings around them, and the distances between holes.
fn check_holes(
    layout: &BoardLayout,
    rules: &BoardRules,
    tell: &mut impl FnMut(BoardFlaw, Point, String),
) {
    let vias = layout.vias.iter().map(|via| ("a via's drill", via.at_mm, via.drill_mm));
    let bare = layout.drills.iter().map(|drill| ("a hole", drill.at_mm, drill.diameter_mm));
    let holes: Vec<(&str, Point, f64)> = vias.chain(bare).collect();
    for (name, at, diameter) in &holes {
        if *diameter < rules.drill_mm - EXACT_MM {
            let what = format!("{name} is {diameter:.2} mm; it must be {:.2} mm", rules.drill_mm);
            tell(BoardFlaw::Drill, *at, what);
        }
    }
    for via in &layout.vias {
        let ring = (via.diameter_mm - via.drill_mm) / 2.0;
        if ring < rules.ring_mm - EXACT_MM {
            let what = format!("a via's ring is {ring:.3} mm; it must be {:.2} mm", rules.ring_mm);
            tell(BoardFlaw::Ring, via.at_mm, what);
        }
    }
    for (i, (_, at, diameter)) in holes.iter().enumerate() {
        for (_, other, other_diameter) in &holes[i + 1..] {
            let apart = distance_mm(*at, *other) - (diameter + other_diameter) / 2.0;
            if apart < rules.hole_to_hole_mm - EXACT_MM {
                let what = format!(
                    "two holes are {apart:.3} mm apart; it must be {:.2} mm",
                    rules.hole_to_hole_mm
                );
                tell(BoardFlaw::HoleSpacing, *at, what);
            }
        }
    }
}

/// Checks the openings of the mask, and that silk stays clear of them.
fn check_mask_and_silk(
    layout: &BoardLayout,
    rules: &BoardRules,
    tell: &mut impl FnMut(BoardFlaw, Point, String),
) {
    let opens =
        |side: BoardSide| layout.openings.iter().filter(move |(on, _)| *on == side).map(|(_, o)| o);
    for pad in &layout.pads {
        // The opening must reach beyond the pad on all sides.
        let grown = pad.shape.enlarged_by(rules.mask_mm - 1e-3);
        let is_open = opens(pad.side).any(|open| grown.corners().iter().all(|p| open.contains(*p)));
        if !is_open {
            let what = format!("the mask covers {}.{}", pad.part, pad.pin);
            tell(BoardFlaw::Mask, pad.shape.centre(), what);
        }
    }
    for side in SIDES {
        for open in opens(side) {
            let shown = layout.pads.iter().filter(|pad| pad.side == side);
            // Nets of the pads that this opening is for. A track of another net would be bare in it.
            let own: Vec<Option<usize>> =
                shown.filter(|pad| open.contains(pad.shape.centre())).map(|pad| pad.net).collect();
            for track in layout.tracks.iter().filter(|track| track.side == side) {
                if !own.contains(&Some(track.net)) && track.shape().distance(open) <= 0.0 {
                    let what =
                        format!("the mask is open over a track of {}", layout.nets[track.net]);
                    tell(BoardFlaw::Mask, track.ends[0], what);
                }
            }
        }
    }
    for line in &layout.silk {
        let ink = line.shape();
        if opens(line.side).any(|open| open.distance(&ink) < rules.silk_mm - EXACT_MM) {
            tell(BoardFlaw::Silk, line.ends[0], "silk lies on or beside a pad".to_owned());
        }
    }
}

/// Checks that parts clear each other and the keep-out regions.
fn check_parts(
    layout: &BoardLayout,
    circuit: &Circuit,
    tell: &mut impl FnMut(BoardFlaw, Point, String),
) {
    for (i, one) in layout.parts.iter().enumerate() {
        for other in &layout.parts[i + 1..] {
            if one.place.side == other.place.side && one.outline.distance(&other.outline) <= 0.0 {
                let what = format!("{} and {} overlap", one.designator, other.designator);
                tell(BoardFlaw::Parts, one.place.at_mm, what);
            }
        }
        for keep in circuit.keep_outs.iter().filter(|keep| keep.side == one.place.side) {
            // Parts that the sensor places have been checked by its own constraints.
            let is_ours = circuit.part(&one.designator).is_some_and(|part| part.place.is_none());
            if is_ours && overlaps_keep_out(keep, &one.outline) {
                tell(
                    BoardFlaw::Parts,
                    one.place.at_mm,
                    format!("{} is where {} is", one.designator, keep.description),
                );
            }
        }
    }
}

/// Checks resistors against their calculation and their power rating.
fn check_resistors(circuit: &Circuit, tell: &mut impl FnMut(BoardFlaw, Point, String)) {
    for one in &circuit.resistors {
        let names = one.designators.join(", ");
        // The tolerance only absorbs rounding of the calculation.
        if let Some(exact) = one.exact_ohms().filter(|exact| one.ohms < exact * (1.0 - 1e-9)) {
            let what = format!(
                "{names}: {} ohm let more than the wanted current through; {exact:.1} ohm do not",
                one.ohms
            );
            tell(BoardFlaw::Resistor, [0.0; 2], what);
        }
        if one.power_w() > one.rated_w {
            let what = format!(
                "{names}: {:.3} W in a resistor that bears {} W",
                one.power_w(),
                one.rated_w
            );
            tell(BoardFlaw::Resistor, [0.0; 2], what);
        }
        for name in &one.designators {
            let told = circuit.part(name).map(|part| (part.kind, part.value.as_str()));
            let value = ohms_text(one.ohms);
            if told != Some((CircuitKind::Resistor, value.as_str())) {
                let what =
                    format!("{name} is {:?}, calculated are {value}", told.map(|told| told.1));
                tell(BoardFlaw::Resistor, [0.0; 2], what);
            }
        }
    }
}

/// Formats a resistance as it is ordered: `470 ohm`, `4.7 kohm`.
pub fn ohms_text(ohms: f64) -> String {
    if ohms >= 1e3 { format!("{} kohm", ohms / 1e3) } else { format!("{ohms} ohm") }
}
