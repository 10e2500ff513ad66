//! Tables of a board: job file, placement, parts list, and the full description.

use fabkit_geometry::csv::{CsvCell, CsvTable};
use fabkit_geometry::{BoardSide, Circuit, CircuitKind};
use serde_json::{Value, json};

use crate::gerber::{DATE, Project};
use crate::layout::{BoardLayout, PlacedPart};
use crate::shapes::Shape;
use crate::{BoardRules, Drill};

/// Rounds to millionths of a millimetre, the resolution of the Gerber layers.
fn round_to_nm(mm: f64) -> Value {
    json!((mm * 1e6).round() / 1e6)
}

fn points(shape: &Shape) -> Vec<Value> {
    shape.corners().iter().map(|p| json!([round_to_nm(p[0]), round_to_nm(p[1])])).collect()
}

/// Writes the job file (Ucamco's Gerber job format).
pub(crate) fn job_file(
    layout: &BoardLayout,
    rules: &BoardRules,
    project: &Project<'_>,
    layers: &[(String, String, &'static str, Vec<u8>)],
) -> String {
    let [low, high] = Shape::polygon(layout.board.edge.clone()).bounds();
    let files: Vec<Value> = layers
        .iter()
        .map(|(name, function, polarity, _)| {
            json!({ "Path": name, "FileFunction": function, "FilePolarity": polarity })
        })
        .collect();
    // The thickness of the board includes the copper on both sides.
    let core = layout.board.thickness_mm - 2.0 * rules.copper_mm;
    let stack: Vec<Value> = [
        ("Legend", None, "Top Silk Screen"),
        ("SolderMask", None, "Top Solder Mask"),
        ("Copper", Some(rules.copper_mm), "F.Cu"),
        ("Dielectric", Some(core), "FR4"),
        ("Copper", Some(rules.copper_mm), "B.Cu"),
        ("SolderMask", None, "Bottom Solder Mask"),
        ("Legend", None, "Bottom Silk Screen"),
    ]
    .into_iter()
    .map(|(kind, thickness, name)| match thickness {
        Some(mm) => json!({ "Type": kind, "Thickness": round_to_nm(mm), "Name": name }),
        None => json!({ "Type": kind, "Name": name }),
    })
    .collect();
    let job = json!({
        "Header": {
            "GenerationSoftware": {
                "Vendor": "fabkit", "Application": "fabkit", "Version": env!("CARGO_PKG_VERSION"),
            },
            "CreationDate": DATE,
        },
        "GeneralSpecs": {
            "ProjectId": { "Name": project.name, "GUID": project.guid, "Revision": project.revision },
            "Size": { "X": round_to_nm(high[0] - low[0]), "Y": round_to_nm(high[1] - low[1]) },
            "LayerNumber": 2,
            "BoardThickness": round_to_nm(layout.board.thickness_mm),
        },
        "DesignRules": [{
            "Layers": "Outer",
            "PadToPad": rules.clearance_mm,
            "PadToTrack": rules.clearance_mm,
            "TrackToTrack": rules.clearance_mm,
            "MinLineWidth": rules.track_mm,
        }],
        "FilesAttributes": files,
        "MaterialStackup": stack,
    });
    serde_json::to_string_pretty(&job).expect("names and numbers alone") + "\n"
}

/// Returns whether a part is bought, unlike test points and pads for wires.
fn is_bought(part: &&PlacedPart) -> bool {
    !matches!(part.kind, CircuitKind::TestPoint | CircuitKind::WirePad)
}

fn side(of: BoardSide) -> &'static str {
    if of == BoardSide::Top { "top" } else { "bottom" }
}

/// Angle from the sensor's x axis to that of the part, counter-clockwise seen from above, degrees.
fn rotation_deg(part: &PlacedPart) -> f64 {
    let deg = part.place.turn_rad.to_degrees().rem_euclid(360.0);
    // Avoids -0, and 360 as the rounding of 359.9999.
    ((deg * 1e3).round() / 1e3).rem_euclid(360.0) + 0.0
}

/// Writes the pick-and-place table: centre and rotation of each part, seen from above on both sides.
pub(crate) fn placement_table(layout: &BoardLayout) -> String {
    let mut table = CsvTable::new("Ref,Val,Package,PosX,PosY,Rot,Side");
    for part in layout.parts.iter().filter(is_bought) {
        // Adding 0 turns -0 into 0.
        let [x, y] = part.place.at_mm.map(|mm| (mm * 1e4).round() / 1e4 + 0.0);
        table.row([
            CsvCell::text(&part.designator),
            CsvCell::quoted(&part.value),
            CsvCell::quoted(&part.package),
            CsvCell::fixed(x, 4),
            CsvCell::fixed(y, 4),
            CsvCell::fixed(rotation_deg(part), 3),
            CsvCell::text(side(part.place.side)),
        ]);
    }
    table.finish()
}

/// Writes the list of parts to order for one board.
pub(crate) fn parts_list(layout: &BoardLayout) -> String {
    let mut rows: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for part in layout.parts.iter().filter(is_bought) {
        match rows.iter_mut().find(|row| row.0 == part.value && row.1 == part.package) {
            Some(row) => row.2.push(&part.designator),
            None => rows.push((&part.value, &part.package, vec![&part.designator])),
        }
    }
    let mut table = CsvTable::new("Designators,Quantity,Value,Package");
    for (value, package, names) in rows {
        table.row([
            CsvCell::quoted(&names.join(" ")),
            names.len().into(),
            CsvCell::quoted(value),
            CsvCell::quoted(package),
        ]);
    }
    table.finish()
}

/// Writes everything that is drawn, drilled and connected, for checking the layers independently.
pub(crate) fn description(layout: &BoardLayout, circuit: &Circuit, design_hash: &str) -> String {
    let name = |net: usize| layout.nets[net].as_str();
    let pads: Vec<Value> = layout
        .pads
        .iter()
        .map(|pad| {
            json!({
                "part": pad.part,
                "pin": pad.pin,
                "net": pad.net.map(name),
                "side": side(pad.side),
                "at_mm": pad.shape.centre().map(round_to_nm),
                "corners_mm": points(&pad.shape),
                "radius_mm": round_to_nm(pad.shape.radius_mm()),
            })
        })
        .collect();
    let vias: Vec<Value> = layout
        .vias
        .iter()
        .map(|via| {
            json!({
                "at_mm": via.at_mm.map(round_to_nm),
                "drill_mm": via.drill_mm,
                "diameter_mm": via.diameter_mm,
                "net": name(via.net),
            })
        })
        .collect();
    let drill = |drill: &Drill| json!({ "at_mm": drill.at_mm.map(round_to_nm), "diameter_mm": round_to_nm(drill.diameter_mm) });
    let parts: Vec<Value> = layout
        .parts
        .iter()
        .map(|part| {
            let body = circuit.part(&part.designator).and_then(|part| part.body.as_deref());
            json!({
                "designator": part.designator,
                "value": part.value,
                "package": part.package,
                "side": side(part.place.side),
                "at_mm": part.place.at_mm.map(round_to_nm),
                "turn_deg": rotation_deg(part),
                "body": body,
            })
        })
        .collect();
    let tracks: Vec<Value> = layout
        .tracks
        .iter()
        .map(|track| {
            json!({
                "side": side(track.side),
                "net": name(track.net),
                "ends_mm": track.ends.map(|end| end.map(round_to_nm)),
                "width_mm": track.width_mm,
            })
        })
        .collect();
    let document = json!({
        "format": "fabkit-board",
        "version": 1,
        "board": layout.board.name,
        "design_hash": design_hash,
        "thickness_mm": round_to_nm(layout.board.thickness_mm),
        "profile": layout.board.profile,
        "nets": layout.nets,
        "parts": parts,
        "pads": pads,
        "tracks": tracks,
        "vias": vias,
        "drills": layout.drills.iter().map(drill).collect::<Vec<_>>(),
    });
    serde_json::to_string_pretty(&document).expect("names and numbers alone") + "\n"
}
