//! Training data sets: ground truth for all combinations of two half presses.
//!
//! Each pattern is cast twice: on the left of the seam and, rotated by half a turn, on the right. N patterns are 2 N
//! casts. Each left half is combined with each right half, which makes N x N samples at the cost of stitching (R-Tac0,
//! section IV-B). The folder is a Zarr version 3 group:
//!
//! | path | content |
//! |---|---|
//! | `halves/indentation_mm`, `halves/label` | (2 N, rows, columns): left halves, then right ones |
//! | `halves/indentation_sigma_mm` | standard deviations of indentations, if the calibration has a covariance |
//! | `reference.npz` | range, points, normals without contact, their sigmas; the side of the seam of each pixel |
//! | `samples.csv` | the two halves of each sample, and its split |
//! | `halves.csv` | forces, moments and contact of each half, if layers are elastic |
//! | `samples/indentation_mm`, `samples/label` | the same as for halves, stitched, if materialised |
//! | `halves/image`, `samples/image` | captures of the halves, and stitched, if there are any |
//! | `dataset.json`, `README.md` | description of everything, for programs and for people |
//!
//! A sample's range is the reference's range minus the indentation. Splits are by *pattern*: a sample is for training
//! only if both of its patterns are, so that no shape leaks into the test.
//!
//! Every file appears complete or not at all, under its final name; `dataset.json` lists them with their hashes. A run
//! that was killed and resumed ends with the same bytes as an undisturbed one ([`resumable`](fabkit_files::resumable)).
//!
//! ```
//! use fabkit_dataset::{DatasetRequest, prepare_job};
//! # use fabkit_files::Error;
//! # use fabkit_scene::press_simulation::ContactModel;
//!
//! # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
//! # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
//! # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
//! # let viewpoint = viewpoint.resized([40, 30])?;
//! # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
//! let request = DatasetRequest {
//!     presses: None, // the sensor's own semi-domes
//!     contact: ContactModel::Rigid,
//!     seam_margin_mm: 0.5,
//!     seed: 1,
//! #     captures: None,
//! #     images: None,
//! #     allow_no_contact: false,
//! #     materialise: false,
//! #     resume: false,
//! };
//! let (patterns, lines) = prepare_job(&scene, &|error| Error::bug(error), &request, |job, _| {
//!     Ok::<_, Error>((job.patterns.len(), job.plan.samples_csv().lines().count()))
//! })?;
//! // Each left half with each right half, and the table's header.
//! assert_eq!(lines, 1 + patterns * patterns);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod captures;
mod card;
mod contact_sheet;
mod halves;
mod images;
mod memory;
mod patterns;
mod plan;
mod press_forces;
mod read;
mod reader;
mod remote_shards;
mod request;
mod samples;
mod shard_file;
mod store;
mod tiling;

use std::path::Path;

use fabkit_depth::ground_truth::{PlacedIndenter, ReferenceSurface, Seam, Side, Uncertainty};
use fabkit_export::ZarrArray;
use serde_json::json;

pub use captures::{HalfCaptures, InvalidCaptures};
pub use contact_sheet::render_contact_sheet;
pub use images::HalfImages;
pub use memory::DatasetMemory;
pub use patterns::{MAX_BODIES, MAX_PATTERNS, NamedPresses, PatternsError, read as read_patterns};
pub use plan::{DatasetPlan, Split};
pub use press_forces::PatternResponse;
pub use read::{SampleArray, SampleError};
pub use reader::DatasetReader;
pub use remote_shards::{ShardFiles, compute_shard};
pub use request::{DatasetRequest, DatasetRequestError, ImageRequest, prepare_job};
pub use store::{DatasetError, KIND};

use fabkit_files::progress::ProgressCallback;
use fabkit_files::resumable::{ResumableFolder, ResumableFolderError};
use fabkit_scene::press_simulation::{ContactModel, ElasticSolver};
use tiling::Tiling;

/// Pattern of bodies that is pressed on either side of the seam.
#[derive(Clone, Debug)]
pub struct PressPattern {
    /// Name, for example `semi-dome-017`.
    pub name: String,
    /// Bodies on the left, in the sensor frame.
    pub left: Vec<PlacedIndenter>,
    /// The same bodies after half a turn about z.
    pub right: Vec<PlacedIndenter>,
    /// Response of soft layers on either side, if it is simulated.
    pub response: Option<PatternResponse>,
}

/// Inputs of a data set.
///
/// ```
/// use fabkit_dataset::{DatasetJob, DatasetPlan, PressPattern, compute_shard};
/// # use fabkit_depth::ground_truth::{ReferenceSurface, Seam};
/// # use fabkit_scene::{ground_truth::compile_indenters, press_simulation::ContactModel};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([40, 30])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// # let grant = scene.request_memory("a data set of", 1, 100)?;
/// # let rays = scene.rays_of_rows(1, 0..u32::MAX, &grant);
/// # let surface = &ReferenceSurface::cast(scene.touch()?, &rays)?;
/// # let seam = &Seam::new(surface, fabkit_fixtures::SEAM_NORMAL, 0.5);
/// let press = scene.project.press("hemisphere@30deg,180deg,1mm")?;
/// let [left, right] = [compile_indenters(&[press.clone()])?, compile_indenters(&[press.flipped()])?];
/// let patterns = &[PressPattern { name: "one".into(), left, right, response: None }];
/// let job = DatasetJob {
///     patterns,
///     plan: &DatasetPlan::new(patterns, 1, serde_json::json!({})),
///     contact: ContactModel::Rigid,
/// #     surface,
/// #     seam,
/// #     elastic_solver: None,
/// #     uncertainty: None,
/// #     captures: None,
/// #     materialise: false,
/// #     resume: false,
/// };
/// // The first shard of each array: indentations and labels.
/// let (_, files) = compute_shard(&job, 0)?;
/// assert_eq!([&*files[0].0, &*files[1].0], ["halves/indentation_mm/c/0/0/0", "halves/label/c/0/0/0"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct DatasetJob<'a> {
    /// Surface as the camera sees it.
    pub surface: &'a ReferenceSurface<'a>,
    /// Seam between the left and the right side.
    pub seam: &'a Seam,
    /// Patterns, in order.
    pub patterns: &'a [PressPattern],
    /// Contact model of the surface.
    pub contact: ContactModel,
    /// Solver for the soft layers, if they are simulated.
    pub elastic_solver: Option<&'a ElasticSolver>,
    /// Uncertainty of camera and pose, if a calibration states it.
    pub uncertainty: Option<&'a Uncertainty>,
    /// Description of the data set, stored in its folder.
    pub plan: &'a DatasetPlan,
    /// Images of all halves.
    pub captures: Option<&'a HalfImages<'a>>,
    /// Write the stitched samples, not only their list.
    pub materialise: bool,
    /// Resume an earlier run that was stopped.
    pub resume: bool,
}

impl DatasetJob<'_> {
    /// Returns the pattern of a half, and the side of the seam on which it presses.
    fn half(&self, half: usize) -> (&PressPattern, Side) {
        let count = self.patterns.len();
        let side = if half < count { Side::Left } else { Side::Right };
        (&self.patterns[half % count], side)
    }

    fn half_name(&self, half: usize) -> String {
        let (pattern, side) = self.half(half);
        format!("{} {}", pattern.name, if side == Side::Left { "left" } else { "right" })
    }
}

/// Summary of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenDataset {
    /// Number of half presses.
    pub halves: usize,
    /// Number of their combinations.
    pub samples: usize,
    /// Number of files that an earlier run had finished.
    pub existing_files: usize,
    /// Number of files written in this run.
    pub written_files: usize,
    /// Rewritten files that existed with other content than an earlier run wrote.
    pub damaged: Vec<String>,
    /// Halves cast in this run whose bodies no pixel on their side of the seam shows.
    pub halves_without_contact: Vec<String>,
}

/// Data set that is being written. The folder is locked until this is dropped.
#[derive(Debug)]
pub struct DatasetWriter {
    folder: ResumableFolder,
    /// Plan with which the data set was begun.
    plan: serde_json::Value,
    /// Arrays `halves/indentation_mm`, `halves/label` and, if present, `halves/indentation_sigma_mm`.
    halves: Vec<ZarrArray>,
}

/// Begins a data set, or resumes one if [`DatasetJob::resume`] is set.
///
/// # Errors
/// Returns [`DatasetError::Folder`] for a folder that is not empty, holds another plan, or is in use.
pub fn begin(folder: &Path, job: &DatasetJob) -> Result<DatasetWriter, DatasetError> {
    let plan = job.plan.document(job);
    let folder = ResumableFolder::open(KIND, folder, plan.clone(), job.resume)?;
    Ok(DatasetWriter { folder, plan, halves: halves::arrays(job, size_px(job)) })
}

/// Writes a data set: calls [`begin`] and [`DatasetWriter::write`].
///
/// # Errors
/// Fails as these two.
///
/// ```
/// use fabkit_dataset::{DatasetReader, write};
/// # use fabkit_dataset::{DatasetJob, DatasetPlan, PressPattern};
/// # use fabkit_depth::ground_truth::{ReferenceSurface, Seam};
/// # use fabkit_files::progress::ignore_progress;
/// # use fabkit_scene::{ground_truth::compile_indenters, press_simulation::ContactModel};
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// # let viewpoint = fabkit_scene::ground_truth::Viewpoint::new(&project.design.sensor.camera, None, None)?;
/// # let viewpoint = viewpoint.resized([40, 30])?;
/// # let scene = fabkit_scene::SensorView::new(std::sync::Arc::new(project), viewpoint)?;
/// # let grant = scene.request_memory("a data set of", 1, 100)?;
/// # let rays = scene.rays_of_rows(1, 0..u32::MAX, &grant);
/// # let surface = &ReferenceSurface::cast(scene.touch()?, &rays)?;
/// # let seam = &Seam::new(surface, fabkit_fixtures::SEAM_NORMAL, 0.5);
/// # let press = scene.project.press("hemisphere@30deg,180deg,1mm")?;
/// # let [left, right] = [compile_indenters(&[press.clone()])?, compile_indenters(&[press.flipped()])?];
/// # let patterns = &[PressPattern { name: "one".into(), left, right, response: None }];
/// # let plan = &DatasetPlan::new(patterns, 1, serde_json::json!({}));
/// # let (contact, elastic_solver) = (ContactModel::Rigid, None);
/// # let (uncertainty, captures, materialise, resume) = (None, None, false, false);
/// # #[rustfmt::skip]
/// # let job = DatasetJob {
/// #     surface, seam, patterns, plan, contact, elastic_solver, uncertainty, captures, materialise, resume,
/// # };
/// let folder = std::env::temp_dir().join(format!("fabkit-dataset-{}", std::process::id()));
/// // `job` has one pattern, seen by a camera of 40 x 30 pixels.
/// let written = write(&folder, &job, &ignore_progress, &|| false)?;
/// assert_eq!((written.halves, written.samples), (2, 1));
/// let labels = DatasetReader::open(&folder)?.array("halves/label")?.ok_or("no labels")?;
/// assert_eq!(labels.shape(), [2, 30, 40]);
/// // The left half: 1 is the surface, 2 the pattern's first body.
/// assert!(labels.sample(0)?.contains(&2));
/// std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(
    folder: &Path,
    job: &DatasetJob,
    progress: ProgressCallback,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<WrittenDataset, DatasetError> {
    begin(folder, job)?.write(job, progress, cancelled)
}

impl DatasetWriter {
    /// Writes the files that are missing. `cancelled` is called before each file; files that are finished then remain
    /// for `resume`.
    ///
    /// # Errors
    /// Fails if a file cannot be computed or written, or if the job has another plan.
    pub fn write(
        self,
        job: &DatasetJob,
        progress: ProgressCallback,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<WrittenDataset, DatasetError> {
        self.check(job)?;
        let [height, width] = size_px(job);
        let halves = self.halves.as_slice();
        let tiling = job.materialise.then(|| Tiling::new(job.seam.sides(), width as usize));
        let tiling = tiling.as_ref();
        let samples = tiling.map(|tiling| samples::arrays(job, tiling, [height, width]));
        let samples = samples.unwrap_or_default();
        let images = job.captures.map(|captures| captures.arrays(job, tiling, [height, width]));
        let images = images.unwrap_or_default();
        let felt = press_forces::halves_csv(job);
        // Five files: group, reference, list of samples, data card, document.
        let groups = if job.materialise { ["halves", "samples"].as_slice() } else { &["halves"] };
        let arrays = halves.iter().chain(&samples).chain(images.iter().map(|(_, array)| array));
        let files = 5
            + usize::from(felt.is_some())
            + groups.len()
            + arrays.map(|array| 1 + array.shards() as usize).sum::<usize>();

        let store = store::Store::new(&self.folder, files, progress, cancelled);
        store.put("zarr.json", || Ok(fabkit_export::zarr_group(&job.plan.attributes())?))?;
        for group in groups {
            store.put(&format!("{group}/zarr.json"), || {
                Ok(fabkit_export::zarr_group(&json!({}))?)
            })?;
        }
        store.put("samples.csv", || Ok(job.plan.samples_csv().into_bytes()))?;
        if let Some(felt) = felt {
            store.put("halves.csv", || Ok(felt.into_bytes()))?;
        }
        // The data card may cast some halves, to compare contact models.
        store.put("README.md", || Ok(card::write_card(job)?.into_bytes()))?;
        // The reference and the halves are independent and both take long.
        let (reference, cast) = rayon::join(
            || store.put("reference.npz", || halves::reference(job)),
            || halves::write(&store, job, halves, tiling),
        );
        let ((), (parts, untouched)) = (reference?, cast?);
        if let Some(tiling) = tiling {
            samples::write(&store, &samples, tiling, &parts)?;
        }
        if let Some(captures) = job.captures {
            captures.write(&store, job, tiling, halves, &images)?;
        }
        let (found, made) = store.finish()?;
        let halves = 2 * job.patterns.len();
        let untouched = untouched.into_iter().map(|half| job.half_name(half)).collect();
        let damaged = self.folder.damaged().to_vec();
        Ok(WrittenDataset {
            halves,
            samples: job.patterns.len().pow(2),
            existing_files: found,
            written_files: made,
            damaged,
            halves_without_contact: untouched,
        })
    }

    /// Checks that the job still has the plan with which the data set was begun, as its inputs may have changed.
    fn check(&self, job: &DatasetJob) -> Result<(), DatasetError> {
        let differences =
            fabkit_files::resumable::find_differences(&self.plan, &job.plan.document(job));
        if differences.is_empty() {
            Ok(())
        } else {
            let folder = self.folder.path().into();
            Err(ResumableFolderError::OtherPlan { what: KIND.what, folder, differences }.into())
        }
    }
}

/// Returns rows and columns.
fn size_px(job: &DatasetJob) -> [u32; 2] {
    [job.surface.rays().height_px(), job.surface.rays().width_px()]
}
