//! Fabrication files of one board.

use fabkit_geometry::{BoardSide, Circuit, CircuitKind};

use crate::gerber::{Layer, Project, drills, field, side_word};
use crate::layout::{LARGEST_DRILL_MM, Layout, SIDES};
use crate::{Rules, artwork, tables};

/// One fabrication file.
#[derive(Clone, Debug, PartialEq)]
pub struct BoardFile {
    /// File name, for example `led-board-F_Cu.gbr`.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// Returns copper, mask, paste, silk, outline, drills, job file, placement, parts list, the board's own description,
/// and images of its artwork. The same board gives the same bytes.
pub fn files(
    layout: &Layout,
    circuit: &Circuit,
    rules: &Rules,
    design_hash: &str,
) -> Vec<BoardFile> {
    let board = layout.board.name.as_str();
    let project = Project::new(board, design_hash);
    let mut layers: Vec<(String, String, &'static str, Vec<u8>)> = Vec::new();
    for (side, letter, number) in [(SIDES[0], "F", 1), (SIDES[1], "B", 2)] {
        let word = side_word(side);
        let mut add = |name: &str,
                       function: String,
                       polarity: &'static str,
                       draw: &dyn Fn(&mut Layer)| {
            let mut layer = Layer::new(&project, &function, polarity);
            draw(&mut layer);
            layers.push((format!("{board}-{letter}_{name}.gbr"), function, polarity, layer.end()));
        };
        add("Cu", format!("Copper,L{number},{word}"), "Positive", &|layer| {
            copper(layer, layout, side)
        });
        add("Mask", format!("Soldermask,{word}"), "Negative", &|layer| {
            for (_, open) in layout.openings.iter().filter(|(on, _)| *on == side) {
                layer.flash(open, "Material", &[]);
            }
        });
        add("Paste", format!("Paste,{word}"), "Positive", &|layer| paste(layer, layout, side));
        add("Silkscreen", format!("Legend,{word}"), "Positive", &|layer| {
            for line in layout.silk.iter().filter(|line| line.side == side) {
                layer.line(line.ends, line.width_mm, "Material", &[]);
            }
        });
    }
    let mut edge = Layer::new(&project, "Profile,NP", "Positive");
    edge.outline(&layout.board.profile.outer);
    for (index, hole) in layout.board.profile.holes.iter().enumerate() {
        // Large and non-circular holes are milled with the outline. The others are in the drill file.
        let drilled = layout.board.round_hole(index);
        if drilled.is_none_or(|hole| hole.diameter_mm > LARGEST_DRILL_MM) {
            edge.outline(hole);
        }
    }
    layers.push((
        format!("{board}-Edge_Cuts.gbr"),
        "Profile,NP".to_owned(),
        "Positive",
        edge.end(),
    ));
    let plated: Vec<_> = layout.vias.iter().map(|via| (via.at_mm, via.drill_mm)).collect();
    let bare: Vec<_> = layout.drills.iter().map(|drill| (drill.at_mm, drill.diameter_mm)).collect();
    for (name, function, holes) in
        [("PTH", "Plated,1,2,PTH,Drill", plated), ("NPTH", "NonPlated,1,2,NPTH,Drill", bare)]
    {
        if !holes.is_empty() {
            let bytes = drills(&project, function, &holes);
            layers.push((format!("{board}-{name}.drl"), function.to_owned(), "Positive", bytes));
        }
    }
    let job = tables::job(layout, rules, &project, &layers);
    let mut files: Vec<BoardFile> =
        layers.into_iter().map(|(name, _, _, bytes)| BoardFile { name, bytes }).collect();
    let text = |name: String, text: String| BoardFile { name, bytes: text.into_bytes() };
    files.extend([
        text(format!("{board}.gbrjob"), job),
        text(format!("{board}-pos.csv"), tables::places(layout)),
        text(format!("{board}-bom.csv"), tables::parts(layout)),
        text(format!("{board}.board.json"), tables::description(layout, circuit, design_hash)),
    ]);
    for side in SIDES {
        let name = format!("{board}-{}.svg", side_word(side).to_lowercase());
        files.push(text(name, artwork::svg(layout, side) + "\n"));
    }
    files.sort_by(|a, b| a.name.cmp(&b.name));
    files
}

fn copper(layer: &mut Layer, layout: &Layout, side: BoardSide) {
    let net = |index: usize| format!("N,{}", field(&layout.nets[index]));
    for pad in layout.pads.iter().filter(|pad| pad.side == side) {
        let mut about = vec![format!("P,{},{}", field(&pad.part), field(&pad.pin))];
        about.extend(pad.net.map(net));
        about.push(format!("C,{}", field(&pad.part)));
        layer.flash(&pad.shape, function_of(layout, &pad.part), &about);
    }
    for via in &layout.vias {
        layer.flash(&via.shape(), "ViaPad", &[net(via.net)]);
    }
    for track in layout.tracks.iter().filter(|track| track.side == side) {
        layer.line(track.ends, track.width_mm, "Conductor", &[net(track.net)]);
    }
}

fn kind_of(layout: &Layout, part: &str) -> Option<CircuitKind> {
    layout.parts.iter().find(|one| one.designator == part).map(|one| one.kind)
}

fn function_of(layout: &Layout, part: &str) -> &'static str {
    match kind_of(layout, part) {
        Some(CircuitKind::TestPoint) => "TestPad",
        Some(CircuitKind::WirePad) => "ConnectorPad",
        _ => "SMDPad,CuDef",
    }
}

/// Draws paste on pads that are soldered in an oven, but not on those for wires and probes.
fn paste(layer: &mut Layer, layout: &Layout, side: BoardSide) {
    for pad in layout.pads.iter().filter(|pad| pad.side == side) {
        if !matches!(
            kind_of(layout, &pad.part),
            Some(CircuitKind::TestPoint | CircuitKind::WirePad)
        ) {
            layer.flash(&pad.shape, "Material", &[]);
        }
    }
}
