//! Silk print: designators, marks of cathodes and first pins, names of nets at wires, and the board's name.

use std::f64::consts::FRAC_PI_2;

use fabkit_geometry::{BoardPlacement, BoardSide, Circuit, CircuitKind};

use crate::BoardRules;
use crate::font;
use crate::layout::{BoardLayout, PlacedPart, SilkLine};
use crate::shapes::{Point, Shape};

/// Heights of letters that are tried, mm. The smaller one is the smallest that fabs still print.
const HEIGHTS_MM: [f64; 2] = [1.0, 0.7];
/// Minimum distance between ink and the board's edge, mm.
const EDGE_MM: f64 = 0.15;
/// Largest distance of a text from its part, in steps of a quarter millimetre.
const RINGS: u32 = 10;

/// Prints everything for which there is room. Nothing lies on solder or on other ink.
pub(crate) fn print_silk(layout: &mut BoardLayout, circuit: &Circuit, rules: &BoardRules) {
    let parts = layout.parts.clone();
    // Marks of polarity first: they must stand at their pads, while texts may move.
    for part in &parts {
        print_polarity_mark(layout, part, rules);
    }
    for part in &parts {
        let text = match part.kind {
            // The net's name says more than a number.
            CircuitKind::WirePad | CircuitKind::TestPoint => {
                circuit.net_of(&part.designator, "1").map(|net| net.name.clone())
            }
            _ => None,
        };
        let text = text.unwrap_or_else(|| part.designator.clone());
        let outline = part.outline.clone();
        print_text(layout, rules, &text, part.place.side, &outline, part.place.at_mm);
    }
    // The board's name goes near the outer edge, on the upper side if there is room.
    let far = Shape::disc([0.0, layout.board.max_radius_mm() * 0.8], 0.0);
    let name = layout.board.name.clone();
    for side in crate::SIDES {
        if print_text(layout, rules, &name, side, &far, far.centre()) {
            break;
        }
    }
}

/// Prints a line beside the cathode or the first pin, on the part's side.
fn print_polarity_mark(layout: &mut BoardLayout, part: &PlacedPart, rules: &BoardRules) {
    let pin = match part.kind {
        CircuitKind::Led => "K",
        CircuitKind::Switch => "1",
        _ => return,
    };
    let Some(pad) = layout.pads.iter().find(|pad| pad.part == part.designator && pad.pin == pin)
    else {
        return;
    };
    let [low, high] = pad.shape.bounds();
    let reach = (high[0] - low[0]).hypot(high[1] - low[1]) / 2.0;
    let at = pad.shape.centre();
    let away = [at[0] - part.place.at_mm[0], at[1] - part.place.at_mm[1]];
    let angle = away[1].atan2(away[0]);
    // Beyond the pad first, then to its sides in steps of 15 degrees.
    let tried = (0..24).flat_map(|step| {
        let off = f64::from(step / 2) * FRAC_PI_2 / 6.0 * if step % 2 == 0 { 1.0 } else { -1.0 };
        [0.6, 0.4].into_iter().flat_map(move |length| {
            (0..6).map(move |far| (angle + off, 0.15 * f64::from(far), length))
        })
    });
    for (angle, far, length) in tried {
        let (sin, cos) = angle.sin_cos();
        let out = reach * 0.6 + far;
        let half = length / 2.0;
        let end = |s: f64| [at[0] + out * cos - s * half * sin, at[1] + out * sin + s * half * cos];
        let line = SilkLine { side: part.place.side, ends: [end(-1.0), end(1.0)], width_mm: 0.2 };
        if is_free(layout, rules, &[line]) {
            layout.silk.push(line);
            return;
        }
    }
}

/// Prints a text as near to `at` as there is room. Returns whether it was printed.
fn print_text(
    layout: &mut BoardLayout,
    rules: &BoardRules,
    text: &str,
    side: BoardSide,
    outline: &Shape,
    at: Point,
) -> bool {
    let [low, high] = outline.bounds();
    let reach = (high[0] - low[0]).hypot(high[1] - low[1]) / 4.0;
    for height in HEIGHTS_MM {
        for ring in 0..RINGS {
            let far = reach + 0.25 * f64::from(ring);
            for step in 0..24 {
                let angle = f64::from(step) * FRAC_PI_2 / 6.0;
                let middle = [at[0] + far * angle.cos(), at[1] + far * angle.sin()];
                // Level first, then along the board's edge.
                let around = middle[1].atan2(middle[0]) - FRAC_PI_2;
                for turn_rad in [0.0, around] {
                    let place = BoardPlacement { at_mm: middle, turn_rad, side };
                    let lines = text_lines(text, height, &place, rules);
                    if is_free(layout, rules, &lines) {
                        layout.silk.extend(lines);
                        return true;
                    }
                }
            }
        }
    }
    false
}

/// Returns the lines of a text. On the lower side it reads from below.
fn text_lines(
    text: &str,
    height_mm: f64,
    place: &BoardPlacement,
    rules: &BoardRules,
) -> Vec<SilkLine> {
    let ends = font::lines(text, height_mm).into_iter().map(|ends| {
        ends.map(|[x, y]| match place.side {
            BoardSide::Top => place.point([x, y]),
            // Seen from below, x runs the other way.
            BoardSide::Bottom => place.point([-x, -y]),
        })
    });
    ends.map(|ends| SilkLine { side: place.side, ends, width_mm: rules.silk_line_mm }).collect()
}

/// Returns whether lines stay clear of the board's edge, other ink, mask openings and parts.
fn is_free(layout: &BoardLayout, rules: &BoardRules, lines: &[SilkLine]) -> bool {
    lines.iter().all(|line| {
        let ink = line.shape();
        let others = layout.silk.iter().filter(|other| other.side == line.side);
        let is_on = |side: &BoardSide| *side == line.side;
        layout.board.point_edge_distance_mm(line.ends[0]) > EDGE_MM
            && layout.board.point_edge_distance_mm(line.ends[1]) > EDGE_MM
            && others.into_iter().all(|other| other.shape().distance(&ink) > rules.silk_mm)
            && layout
                .openings
                .iter()
                .filter(|(side, _)| is_on(side))
                .all(|(_, open)| open.distance(&ink) > rules.silk_mm)
            // Parts cover ink below them. A test point has no body.
            && layout.parts.iter().filter(|part| is_on(&part.place.side)).all(|part| {
                part.kind == CircuitKind::TestPoint || part.outline.distance(&ink) > 0.0
            })
    })
}
