//! Fabrication files of one board.

use fabkit_geometry::{BoardSide, Circuit, CircuitKind};

use crate::gerber::{GerberLayer, Project, attribute_text, drill_file, side_word};
use crate::layout::{BoardLayout, MAX_DRILL_MM, SIDES};
use crate::{BoardRules, artwork, tables};

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
pub fn fabrication_files(
    layout: &BoardLayout,
    circuit: &Circuit,
    rules: &BoardRules,
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
                       draw: &dyn Fn(&mut GerberLayer)| {
            let mut layer = GerberLayer::new(&project, &function, polarity);
            draw(&mut layer);
            layers.push((
                format!("{board}-{letter}_{name}.gbr"),
                function,
                polarity,
                layer.finish(),
            ));
        };
        add("Cu", format!("Copper,L{number},{word}"), "Positive", &|layer| {
            draw_copper(layer, layout, side)
        });
        add("Mask", format!("Soldermask,{word}"), "Negative", &|layer| {
            for (_, open) in layout.openings.iter().filter(|(on, _)| *on == side) {
                layer.flash(open, "Material", &[]);
            }
        });
        add("Paste", format!("Paste,{word}"), "Positive", &|layer| draw_paste(layer, layout, side));
        add("Silkscreen", format!("Legend,{word}"), "Positive", &|layer| {
            for line in layout.silk.iter().filter(|line| line.side == side) {
                layer.line(line.ends, line.width_mm, "Material", &[]);
            }
        });
    }
    let mut edge = GerberLayer::new(&project, "Profile,NP", "Positive");
    edge.outline(&layout.board.profile.outer);
    for (index, hole) in layout.board.profile.holes.iter().enumerate() {
        // Large and non-circular holes are milled with the outline. The others are in the drill file.
        let drilled = layout.board.round_hole(index);
        if drilled.is_none_or(|hole| hole.diameter_mm > MAX_DRILL_MM) {
            edge.outline(hole);
        }
    }
    layers.push((
        format!("{board}-Edge_Cuts.gbr"),
        "Profile,NP".to_owned(),
        "Positive",
        edge.finish(),
    ));
    let plated: Vec<_> = layout.vias.iter().map(|via| (via.at_mm, via.drill_mm)).collect();
    let bare: Vec<_> = layout.drills.iter().map(|drill| (drill.at_mm, drill.diameter_mm)).collect();
    for (name, function, holes) in
        [("PTH", "Plated,1,2,PTH,Drill", plated), ("NPTH", "NonPlated,1,2,NPTH,Drill", bare)]
    {
        if !holes.is_empty() {
            let bytes = drill_file(&project, function, &holes);
            layers.push((format!("{board}-{name}.drl"), function.to_owned(), "Positive", bytes));
        }
    }
    let job = tables::job_file(layout, rules, &project, &layers);
    let mut files: Vec<BoardFile> =
        layers.into_iter().map(|(name, _, _, bytes)| BoardFile { name, bytes }).collect();
    let text = |name: String, text: String| BoardFile { name, bytes: text.into_bytes() };
    files.extend([
        text(format!("{board}.gbrjob"), job),
        text(format!("{board}-pos.csv"), tables::placement_table(layout)),
        text(format!("{board}-bom.csv"), tables::parts_list(layout)),
        text(format!("{board}.board.json"), tables::description(layout, circuit, design_hash)),
    ]);
    for side in SIDES {
        let name = format!("{board}-{}.svg", side_word(side).to_lowercase());
        files.push(text(name, artwork::svg(layout, side) + "\n"));
    }
    files.sort_by(|a, b| a.name.cmp(&b.name));
    files
}

fn draw_copper(layer: &mut GerberLayer, layout: &BoardLayout, side: BoardSide) {
    let net = |index: usize| format!("N,{}", attribute_text(&layout.nets[index]));
    for pad in layout.pads.iter().filter(|pad| pad.side == side) {
        let mut about =
            vec![format!("P,{},{}", attribute_text(&pad.part), attribute_text(&pad.pin))];
        about.extend(pad.net.map(net));
        about.push(format!("C,{}", attribute_text(&pad.part)));
        layer.flash(&pad.shape, pad_function(layout, &pad.part), &about);
    }
    for via in &layout.vias {
        layer.flash(&via.shape(), "ViaPad", &[net(via.net)]);
    }
    for track in layout.tracks.iter().filter(|track| track.side == side) {
        layer.line(track.ends, track.width_mm, "Conductor", &[net(track.net)]);
    }
}

fn part_kind(layout: &BoardLayout, part: &str) -> Option<CircuitKind> {
    layout.parts.iter().find(|one| one.designator == part).map(|one| one.kind)
}

fn pad_function(layout: &BoardLayout, part: &str) -> &'static str {
    match part_kind(layout, part) {
        Some(CircuitKind::TestPoint) => "TestPad",
        Some(CircuitKind::WirePad) => "ConnectorPad",
        _ => "SMDPad,CuDef",
    }
}

/// Draws paste on pads that are soldered in an oven, but not on those for wires and probes.
fn draw_paste(layer: &mut GerberLayer, layout: &BoardLayout, side: BoardSide) {
    for pad in layout.pads.iter().filter(|pad| pad.side == side) {
        if !matches!(
            part_kind(layout, &pad.part),
            Some(CircuitKind::TestPoint | CircuitKind::WirePad)
        ) {
            layer.flash(&pad.shape, "Material", &[]);
        }
    }
}
