//! Image of one side of a board, in the colours that it will have.

use std::fmt::Write;

use fabkit_geometry::{BoardSide, CircuitKind, Path, Segment};

use crate::layout::BoardLayout;
use crate::shapes::{Point, Shape};

// Colours of solder mask, covered copper, bare copper, silk and parts' outlines.
const MASK: &str = "#1f6b43";
const COPPER_BELOW_MASK: &str = "#3c8f5f";
const BARE: &str = "#d8c27a";
const INK: &str = "#ffffff";
const BODY: &str = "#20242a";
/// Margin around the board, mm.
const MARGIN_MM: f64 = 0.8;

/// Draws one side as SVG with 1 unit per millimetre. The upper side is seen from above, the lower one from below.
pub fn svg(layout: &BoardLayout, side: BoardSide) -> String {
    let [low, high] = Shape::polygon(layout.board.edge.clone()).bounds();
    let size = [0, 1].map(|axis| high[axis] - low[axis] + 2.0 * MARGIN_MM);
    let left = match side {
        BoardSide::Top => low[0] - MARGIN_MM,
        BoardSide::Bottom => -high[0] - MARGIN_MM,
    };
    // SVG's y axis points down, so y is flipped. On the lower side x is flipped too.
    let flip = if side == BoardSide::Top { "1 -1" } else { "-1 -1" };
    let word = if side == BoardSide::Top { "upper" } else { "lower" };
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" width=\"{:.1}\" height=\"{:.1}\" \
         viewBox=\"{:.2} {:.2} {:.2} {:.2}\"><title>{}, {word} side</title><g transform=\"scale({flip})\">\n",
        size[0] * 14.0,
        size[1] * 14.0,
        left,
        -high[1] - MARGIN_MM,
        size[0],
        size[1],
        layout.board.name,
    );
    let profile = &layout.board.profile;
    let outline: String =
        std::iter::once(&profile.outer).chain(&profile.holes).map(svg_path).collect();
    _ = writeln!(text, "<path fill=\"{MASK}\" fill-rule=\"evenodd\" d=\"{outline}\"/>");
    for track in layout.tracks.iter().filter(|track| track.side == side) {
        line(&mut text, track.ends, track.width_mm, COPPER_BELOW_MASK);
    }
    for via in &layout.vias {
        shape(&mut text, &via.shape(), COPPER_BELOW_MASK);
        shape(&mut text, &Shape::disc(via.at_mm, via.drill_mm), MASK);
    }
    for pad in layout.pads.iter().filter(|pad| pad.side == side) {
        shape(&mut text, &pad.shape, BARE);
    }
    for one in layout.silk.iter().filter(|line| line.side == side) {
        line(&mut text, one.ends, one.width_mm, INK);
    }
    for part in layout.parts.iter().filter(|part| part.place.side == side) {
        if !matches!(part.kind, CircuitKind::WirePad | CircuitKind::TestPoint) {
            let corners = corners(&part.outline);
            _ = writeln!(
                text,
                "<polygon points=\"{corners}\" fill=\"none\" stroke=\"{BODY}\" stroke-width=\"0.06\"/>"
            );
        }
    }
    text + "</g></svg>"
}

/// Returns the corners of a shape as an SVG point list.
fn corners(shape: &Shape) -> String {
    let corners = shape.corners().iter().map(|p| format!("{:.3},{:.3}", p[0], p[1]));
    corners.collect::<Vec<_>>().join(" ")
}

fn line(text: &mut String, [a, b]: [Point; 2], width: f64, color: &str) {
    _ = writeln!(
        text,
        "<path d=\"M{:.3} {:.3}L{:.3} {:.3}\" stroke=\"{color}\" stroke-width=\"{width:.3}\" \
         stroke-linecap=\"round\"/>",
        a[0], a[1], b[0], b[1]
    );
}

fn shape(text: &mut String, shape: &Shape, color: &str) {
    _ = match shape.corners() {
        [[x, y]] => writeln!(
            text,
            "<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{:.3}\" fill=\"{color}\"/>",
            shape.radius_mm()
        ),
        _ => writeln!(text, "<polygon points=\"{}\" fill=\"{color}\"/>", corners(shape)),
    };
}

/// Returns an SVG path with the exact lines and arcs of `path`.
fn svg_path(path: &Path) -> String {
    let mut text = format!("M{:.4} {:.4}", path.start[0], path.start[1]);
    let mut from = path.start;
    for segment in &path.segments {
        let to = segment.to();
        match segment {
            Segment::Arc { centre, ccw, .. } => {
                let radius = (from[0] - centre[0]).hypot(from[1] - centre[1]);
                let [a, b] = [from, to].map(|p| (p[1] - centre[1]).atan2(p[0] - centre[0]));
                let sweep = if *ccw { b - a } else { a - b }.rem_euclid(std::f64::consts::TAU);
                // SVG's large-arc flag: set for arcs of more than half a turn.
                let large = u8::from(sweep > std::f64::consts::PI + 1e-9);
                let ccw = u8::from(*ccw);
                _ = write!(
                    text,
                    "A{radius:.4} {radius:.4} 0 {large} {ccw} {:.4} {:.4}",
                    to[0], to[1]
                );
            }
            _ => _ = write!(text, "L{:.4} {:.4}", to[0], to[1]),
        }
        from = to;
    }
    text + "Z"
}
