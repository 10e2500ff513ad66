//! The pages to build a design from: facts, tables and pictures.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_boards::{SIDES, svg};
use fabkit_depth::RenderError;
use fabkit_designs::Design;
use fabkit_guide::{BoardArt, Guide, NoSuchPart, Pictures, Request};
use fabkit_sweep::stock_density_g_per_cm3;

use crate::exporting;
use crate::identity::design_hash;
use crate::pictures::{PictureError, Shot, default_assembly, picture_of_assembly, picture_of_body};
use crate::progress::{OnProgress, Step, unwatched};
use crate::staging::OutputFile;

/// Names of the files of a guide.
pub const FILES: [&str; 4] = ["index.html", "guide.json", "bom.csv", "parts.csv"];

const COVER_PX: [u32; 2] = [560, 420];
const ASSEMBLY_PX: [u32; 2] = [420, 315];
const PART_PX: [u32; 2] = [160, 120];

/// What a design needs.
///
/// # Errors
/// A part that cannot be made.
pub fn facts(design: &Design, units: u32) -> Result<Guide, NoSuchPart> {
    let hash = design_hash(design);
    let density = |material: &str| stock_density_g_per_cm3(material);
    Guide::of(&design.sensor, &Request { design_hash: &hash, units, density: &density })
}

/// The files of a guide, all of them.
///
/// # Errors
/// Bodies that cannot be drawn.
pub fn files(
    design: &Design,
    guide: &Guide,
    progress: OnProgress,
) -> Result<Vec<OutputFile>, PictureError> {
    let page = guide.to_html(&pictures(design, guide, progress)?);
    let json = serde_json::to_string_pretty(&guide.to_json()).expect("names and numbers alone");
    let texts = [page, json + "\n", guide.bom_csv(), guide.parts_csv()];
    let file =
        |(name, text): (&str, String)| OutputFile { name: name.into(), bytes: text.into_bytes() };
    Ok(FILES.into_iter().zip(texts).map(file).collect())
}

fn pictures(
    design: &Design,
    guide: &Guide,
    progress: OnProgress,
) -> Result<Pictures, PictureError> {
    let sensor = &design.sensor;
    let assemblies: BTreeSet<&str> =
        guide.steps.iter().filter_map(|step| step.assembly.as_deref()).collect();
    let total = 1 + assemblies.len() + guide.made.len();
    let mut done = 0;
    let mut count = || {
        done += 1;
        progress(Step { done, all: total, ..Step::default() });
    };
    let quiet = unwatched;
    let shot = |size_px, section| Shot { size_px, section, from: None };
    let of_assembly = |name: &str| {
        // Molds, layers and pins are inside.
        let cut = picture_of_assembly(sensor, name, false, shot(ASSEMBLY_PX, true), &quiet);
        match cut {
            Err(PictureError::Render(RenderError::NothingToDraw)) => {
                picture_of_assembly(sensor, name, false, shot(ASSEMBLY_PX, false), &quiet)
            }
            other => other,
        }
    };
    let cover = shot(COVER_PX, false);
    let cover = picture_of_assembly(sensor, &default_assembly(sensor), false, cover, &quiet)?;
    count();
    let mut pictures = Pictures { cover: Some(cover), ..Pictures::default() };
    for name in assemblies {
        // A step may name a place where nothing is drawn.
        match of_assembly(name) {
            Ok(png) => _ = pictures.assemblies.insert(name.to_owned(), png),
            Err(PictureError::Unknown(_)) => {}
            Err(error) => return Err(error),
        }
        count();
    }
    pictures.boards = board_art(design);
    let bodies: BTreeMap<&str, _> = sensor.parts().map(|part| (part.name.as_str(), part)).collect();
    for part in &guide.made {
        let body = bodies[part.name.as_str()];
        let png = picture_of_body(body, shot(PART_PX, false), &quiet)?;
        pictures.parts.insert(part.name.clone(), png);
        count();
    }
    Ok(pictures)
}

/// Both sides of each circuit board, or why it cannot be laid out.
fn board_art(design: &Design) -> BTreeMap<String, BoardArt> {
    let circuits = design.sensor.circuits.iter();
    let etched = circuits.filter_map(|circuit| Some((circuit, circuit.board.clone()?)));
    let art = etched.map(|(circuit, board)| {
        let art = match exporting::board(&design.sensor, circuit) {
            Ok(Some(layout)) => BoardArt::Drawn(SIDES.map(|side| svg(&layout, side))),
            Ok(None) => BoardArt::Refused("its body is not part of the sensor".to_owned()),
            Err(error) => BoardArt::Refused(error.to_string()),
        };
        (board, art)
    });
    art.collect()
}
