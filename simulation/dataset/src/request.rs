//! Preparation of a data set: reads, checks and casts what a request names.

use std::path::Path;

use fabkit_capture::{Renderer, unit_document};
use fabkit_depth::ground_truth::{ReferenceSurface, Seam};
use fabkit_designs::design_hash;
use fabkit_files::diagnostics::{DiagnosedDesign, SourceText};
use fabkit_files::reading::MAX_YAML_BYTES;
use fabkit_files::reading::{self, ExpectedFile};
use fabkit_files::{Error, ErrorKind, ErrorSubject, Explained, join_first_messages};
use fabkit_fixtures::{PressError, SEAM_NORMAL};
use fabkit_scene::press_simulation::{ContactModel, ElasticSolver, LinearOptions, resources};
use fabkit_scene::{MARGIN_LIMITS_MM, MEMBRANE_LIMITS_MM, SensorView, check_length};
use fabkit_text::InvalidDesign;
use serde_json::{Value, json};

use super::memory::DatasetMemory;
use super::{
    DatasetJob, DatasetPlan, HalfCaptures, HalfImages, InvalidCaptures, NamedPresses,
    PatternsError, patterns, press_forces,
};

/// Request for a data set, besides the camera and the sensor.
#[derive(Clone, Debug)]
pub struct DatasetRequest<'a> {
    /// File with a list of patterns; `None` for all semi-domes.
    pub presses: Option<&'a Path>,
    /// Folder or list of existing images of the halves.
    pub captures: Option<&'a Path>,
    /// Simulated images of the halves instead.
    pub images: Option<ImageRequest<'a>>,
    /// Contact model of the surface.
    pub contact: ContactModel,
    /// Width that is left out on either side of the seam, mm.
    pub seam_margin_mm: f64,
    /// True if presses may miss the surface.
    pub allow_no_contact: bool,
    /// Seed for the assignment of patterns to splits, and for the noise of simulated images.
    pub seed: u64,
    /// Write the stitched samples too.
    pub materialise: bool,
    /// Resume an earlier run that was stopped.
    pub resume: bool,
}

/// Request for simulated images of halves.
#[derive(Clone, Copy, Debug)]
pub struct ImageRequest<'a> {
    /// Name of the sensor's light that is on; the usual one by default.
    pub light: Option<&'a str>,
    /// File with the constants of a unit's light.
    pub constants: Option<&'a Path>,
}

/// Reason why a data set cannot be prepared.
#[derive(Debug, thiserror::Error)]
pub enum DatasetRequestError {
    /// No patterns were named, and the sensor has no halves of its own.
    #[error(transparent)]
    NoPatterns(PatternsError),
    /// Some presses have no contact solution.
    #[error("{}", join_first_messages(.faults))]
    Presses {
        /// Messages, one line for each press.
        faults: Vec<String>,
        /// Advice about the first.
        hint: Option<String>,
    },
    /// Images of halves are missing, or not from this camera.
    #[error(transparent)]
    HalfCaptures(#[from] InvalidCaptures),
}

impl Explained for DatasetRequestError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Presses { hint, .. } => return hint.clone(),
            Self::NoPatterns(_) => "list presses in a text file and name it",
            Self::HalfCaptures(_) => {
                "a folder holds `PATTERN-left.png` and `PATTERN-right.png` (or .jpg, .tif, .bmp) for \
                 each pattern; a CSV file has the columns pattern, side, file"
            }
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::NoPatterns(_) => "no_presses",
            Self::Presses { .. } => "no_contact_solution",
            Self::HalfCaptures(_) => "half_captures",
        })
    }
}

/// Reads what a request names, casts the surface, and calls `work` with the job and the memory that writing it takes.
/// `explain` turns the error of a press into one that shows the source texts.
///
/// # Errors
/// Fails for lengths beyond their limits, presses and captures that cannot be used, and errors of `work`.
pub fn prepare_job<R, E: From<Error>>(
    scene: &SensorView,
    explain: &dyn Fn(PressError) -> Error,
    order: &DatasetRequest,
    work: impl FnOnce(&DatasetJob, DatasetMemory) -> Result<R, E>,
) -> Result<R, E> {
    check_length("membrane_mm", order.contact.membrane_mm(), MEMBRANE_LIMITS_MM)
        .map_err(Error::from)?;
    check_length("seam_margin_mm", order.seam_margin_mm, MARGIN_LIMITS_MM).map_err(Error::from)?;
    let named = read_patterns(order, explain, scene)?;
    let room = DatasetMemory::new(scene, order, named.len());
    // Fails early if memory is short, before anything expensive.
    let grant = room.request().map_err(Error::from)?;
    let presses =
        named.iter().flat_map(|of| of.presses.iter().map(|press| (of.name.as_str(), press)));
    scene.check_contacts(presses, order.allow_no_contact)?;
    let touch = scene.touch().map_err(Error::from)?;
    let ready = match order.contact {
        ContactModel::Linear(LinearOptions { spacing_mm, .. }) => {
            let sensor = &scene.project.design.sensor;
            // Shear needs more of the solver than pressing alone.
            let is_dragged = named.iter().any(|of| of.shear_mm != [0.0; 2]);
            let ready = ElasticSolver::for_any_press(sensor, spacing_mm, is_dragged, resources());
            Some(ready.map_err(Error::from)?)
        }
        _ => None,
    };
    let patterns = press_forces::prepare(&named, touch, ready.as_ref(), order)?;
    let rays = scene.rays_of_rows(1, 0..u32::MAX, &grant);
    let surface = ReferenceSurface::cast(touch, &rays).map_err(Error::bug)?;
    let seam = Seam::new(&surface, SEAM_NORMAL, order.seam_margin_mm);
    let lit =
        |of: ImageRequest| fabkit_capture::select_lighting(&scene.project, of.light, of.constants);
    let light = order.images.map(lit).transpose()?;
    let captures = match &light {
        Some((lighting, constants)) => {
            let studio = Renderer::new(scene, &surface, lighting, constants, order.contact)?;
            Some(HalfImages::Simulated(Box::new(studio), order.seed))
        }
        None => read_captures(order, &named, [rays.width_px(), rays.height_px()])?,
    };
    let mut about = describe_origin(order, scene, &named, captures.as_ref());
    if let Some(ready) = &ready {
        about["elastic"] = press_forces::describe_elasticity(ready, &patterns);
    }
    if scene.viewpoint.has_uncertainty() {
        about["sigma_parameters"] = scene.viewpoint.sigma_parameters().into();
    }
    let plan = DatasetPlan::new(&patterns, order.seed, about);
    // Surfaces are as drawn, and a designed camera is exactly at its place.
    let uncertainty = scene.viewpoint.uncertainty(0.0);
    // Without a covariance the data set has no standard deviations, rather than zeros.
    let is_said = scene.viewpoint.has_uncertainty();
    let job = DatasetJob {
        surface: &surface,
        seam: &seam,
        patterns: &patterns,
        contact: order.contact,
        elastic_solver: ready.as_ref(),
        uncertainty: is_said.then_some(&uncertainty),
        plan: &plan,
        captures: captures.as_ref(),
        materialise: order.materialise,
        resume: order.resume,
    };
    work(&job, room)
}

/// Reads the patterns that a request names.
fn read_patterns(
    order: &DatasetRequest,
    explain: &dyn Fn(PressError) -> Error,
    scene: &SensorView,
) -> Result<Vec<NamedPresses>, Error> {
    let Some(path) = order.presses else {
        return patterns::semi_domes(&scene.project).map_err(|error| match error {
            PatternsError::Press(error) => explain(error),
            other => DatasetRequestError::NoPatterns(other).into(),
        });
    };
    let hint = "is it the right file? It has one pattern on a line";
    let expected = ExpectedFile { what: "a list of presses", max_bytes: MAX_YAML_BYTES, hint };
    let text = reading::read_text(path, expected)?;
    patterns::read(&text, &scene.project).map_err(|faults| {
        let file = path.display().to_string();
        let problems = faults.into_iter().map(|fault| fault.in_file(&file)).collect();
        DiagnosedDesign::new(InvalidDesign::new(problems), [SourceText { file, text }]).into()
    })
}

/// Reads the images that a request names, if any.
fn read_captures(
    order: &DatasetRequest,
    named: &[NamedPresses],
    size_px: [u32; 2],
) -> Result<Option<HalfImages<'static>>, Error> {
    let Some(place) = order.captures else { return Ok(None) };
    let names: Vec<String> = named.iter().map(|pattern| pattern.name.clone()).collect();
    let given = HalfCaptures::read(place, &names, size_px).map_err(DatasetRequestError::from)?;
    Ok(Some(HalfImages::Given(given)))
}

/// Describes the data set's origin for its document.
fn describe_origin(
    order: &DatasetRequest,
    scene: &SensorView,
    named: &[NamedPresses],
    captures: Option<&HalfImages<'_>>,
) -> Value {
    let design = &scene.project.design;
    json!({
        "fabkit": fabkit_export::VERSION,
        "sensor": design.sensor.name,
        "design_hash": design_hash(design),
        "presses_hash": patterns::hash_patterns(named),
        "images": captures.map(HalfImages::document),
        "unit": unit_document(&scene.project),
        "viewpoint": scene.viewpoint.to_json(),
        "surface_seen": scene.coverage.to_json(),
        "seed": order.seed,
        "seam": {
            "left_to_right_in_sensor": <[f64; 3]>::from(SEAM_NORMAL),
            "margin_mm": order.seam_margin_mm,
        },
        "membrane_mm": order.contact.membrane_mm(),
        "contact": order.contact.name(),
        "units": { "length": "mm", "angle": "rad", "pixel": "px, centres at integers" },
        "frames": {
            "sensor": "right-handed; origin at the centre of the surface's base circle, +z toward \
                       the tip",
            "camera": "right-handed; +z forward, +x right, +y down",
        },
    })
}
