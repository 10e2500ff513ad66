//! Build guides: facts, tables and images of a design.

mod calibration_chapter;
mod step_images;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use fabkit_boards::{SIDES, svg};
use fabkit_checks::{InvalidBody, Stage};
use fabkit_designs::articles::{ArticleRole, Articles};
use fabkit_designs::{Design, design_hash};
use fabkit_files::Error;
use fabkit_files::progress::{ProgressCallback, ProgressStep, ignore_progress};
use fabkit_files::staging::OutputFile;
use fabkit_geometry::Order;
use fabkit_guide::{
    BoardArt, Calibration, Guide, GuideError, PageImages, Request, Shop, StepImages, SupplyKind,
};
use rayon::prelude::*;

use crate::exports;
use crate::images::{DrawingError, ImageView, default_assembly, draw_assembly, draw_body};
use crate::source::CheckErrors;

pub use calibration_chapter::describe_calibration;

/// File names of a guide.
pub const FILES: [&str; 4] = ["index.html", "guide.json", "bom.csv", "parts.csv"];

const COVER_PX: [u32; 2] = [560, 420];
const PART_PX: [u32; 2] = [160, 120];

/// Determines the bodies and their positions at each build step of a design.
///
/// # Errors
/// A solid that is invalid.
pub fn find_stages(design: &Design) -> Result<Vec<Stage<'_>>, InvalidBody> {
    fabkit_checks::stages(&design.sensor)
}

/// Collects what building a design needs. `stages` are those that [`find_stages`] returns for the same design, `faults`
/// the errors that `check` finds in it ([`Target::find_errors`](crate::source::Target::find_errors)): whoever builds from the
/// guide must know of them.
///
/// # Errors
/// A part that cannot be made.
///
/// ```
/// use fabkit_application::guides::{collect_facts, find_stages};
/// use fabkit_application::source::Target;
///
/// let design = Target::new("9dtact").design(&[])?;
/// let faults = Target::new("9dtact").find_errors(&[], false)??;
/// let guide = collect_facts(&design, &find_stages(&design)?, None, 2, &faults)?;
/// assert!(guide.check_errors.is_empty());
/// // One entry for each part that is made, and a list of what to buy.
/// assert_eq!(guide.made.len(), design.sensor.parts().count());
/// assert!(guide.bom_csv().lines().count() > 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn collect_facts(
    design: &Design,
    stages: &[Stage],
    calibration: Option<&Calibration>,
    units: u32,
    faults: &CheckErrors,
) -> Result<Guide, GuideError> {
    let hash = design_hash(design);
    let density = |material: &str| {
        let body = design.sensor.bodies.iter().find(|body| body.material == material)?;
        body.substance.density_g_per_cm3
    };
    let shop = ArticleShop(&design.articles);
    let (density, shop) = (&density, &shop);
    let request = Request { design_hash: &hash, units, density, shop, stages, calibration };
    let mut guide = Guide::new(&design.sensor, &request)?;
    let plan = exports::sheet_plan(design, units);
    let (sheets, _) = plan.map_err(|error| GuideError::PrintSettings(error.to_string()))?;
    guide.set_sheets(sheets);
    guide.check_errors = faults.messages().map(str::to_owned).collect();
    Ok(guide)
}

/// Adapter from the design's list of articles to the guide's shop.
struct ArticleShop<'a>(&'a Articles);

impl Shop for ArticleShop<'_> {
    fn article(&self, name: &str) -> Order {
        self.0.article(name)
    }

    fn stock(&self, process: &str, material: &str) -> Order {
        self.0.stock(process, material)
    }

    fn asked_for(&self, sentence: &str) -> Vec<(SupplyKind, Order)> {
        let used = |(role, order)| match role {
            ArticleRole::Tool => (SupplyKind::Tool, order),
            ArticleRole::Supply | ArticleRole::Piece | ArticleRole::Stock => {
                (SupplyKind::Supply, order)
            }
        };
        self.0.find_supplies(sentence).into_iter().map(used).collect()
    }
}

/// Makes all files of a guide.
///
/// # Errors
/// Bodies that cannot be drawn or meshed.
pub fn files(
    design: &Design,
    stages: &[Stage],
    guide: &Guide,
    progress: ProgressCallback,
) -> Result<Vec<OutputFile>, Error> {
    let page = guide.to_html(&pictures(design, stages, guide, progress)?);
    let json = serde_json::to_string_pretty(&guide.to_json()).expect("names and numbers alone");
    let texts = [page, json + "\n", guide.bom_csv(), guide.parts_csv()];
    let file =
        |(name, text): (&str, String)| OutputFile { name: name.into(), bytes: text.into_bytes() };
    Ok(FILES.into_iter().zip(texts).map(file).collect())
}

fn pictures(
    design: &Design,
    stages: &[Stage],
    guide: &Guide,
    progress: ProgressCallback,
) -> Result<PageImages, Error> {
    let sensor = &design.sensor;
    let (_, sheets) = exports::sheet_plan(design, guide.units)?;
    let stock = step_images::CompiledBodies::new(sensor, stages)?;
    let scenes: Vec<_> = stages.iter().map(|stage| (stage.step, stock.scenes(stage))).collect();
    let mut wanted: BTreeMap<&str, &step_images::Scene> = BTreeMap::new();
    for scene in scenes.iter().flat_map(|(_, both)| both.iter().flatten()) {
        // Scenes with the same key are drawn once. The total is the cover, the model, all scenes and all parts.
        wanted.insert(&scene.key, scene);
    }
    let (done, all) = (AtomicUsize::new(0), 2 + wanted.len() + guide.made.len());
    let count = || {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        progress(ProgressStep { done, total: all, ..ProgressStep::default() });
    };
    let quiet = ignore_progress;
    let shot = |size_px| ImageView { size_px, is_section: false, from: None };
    let cover = draw_assembly(sensor, &default_assembly(sensor), false, shot(COVER_PX), &quiet)?;
    count();
    let model = crate::model_view::build_model(design)?;
    count();
    let drawn = wanted.into_par_iter().map(|(key, scene)| {
        let png = scene.draw()?;
        count();
        Ok((key, png))
    });
    let drawn: BTreeMap<&str, Vec<u8>> = drawn.collect::<Result<_, DrawingError>>()?;
    let of =
        |scene: &Option<step_images::Scene>| Some(drawn.get(scene.as_ref()?.key.as_str())?.clone());
    let steps = scenes.iter().map(|(step, [before, after])| {
        (step + 1, StepImages { before: of(before), after: of(after) })
    });
    let bodies: BTreeMap<&str, _> = sensor.parts().map(|part| (part.name.as_str(), part)).collect();
    let parts = guide.made.par_iter().map(|part| {
        let png = draw_body(bodies[part.name.as_str()], shot(PART_PX), &quiet)?;
        count();
        Ok((part.name.clone(), png))
    });
    Ok(PageImages {
        cover: Some(cover),
        model: Some(model),
        boards: board_art(design),
        sheets,
        steps: steps.collect(),
        parts: parts.collect::<Result<_, DrawingError>>()?,
    })
}

/// Draws both sides of each circuit board, or states why it cannot be laid out.
fn board_art(design: &Design) -> BTreeMap<String, BoardArt> {
    let circuits = design.sensor.circuits.iter();
    let etched = circuits.filter_map(|circuit| Some((circuit, circuit.board.clone()?)));
    let art = etched.map(|(circuit, board)| {
        let art = match exports::lay_out_board(&design.sensor, circuit) {
            Ok(Some(layout)) => BoardArt::Drawn(SIDES.map(|side| svg(&layout, side))),
            Ok(None) => BoardArt::Refused("its body is not part of the sensor".to_owned()),
            Err(error) => BoardArt::Refused(error.to_string()),
        };
        (board, art)
    });
    art.collect()
}
