//! Training targets for all combinations of two half presses.
//!
//! Each pattern is cast twice: on the left of the seam and, turned by half a turn, on the right.
//! N patterns are 2 N casts; each left half goes with each right half, which makes N x N samples
//! at the price of stitching (R-Tac0, section IV-B). The folder is a Zarr version 3 group:
//!
//! | path | holds |
//! |---|---|
//! | `halves/indentation_mm`, `halves/label` | (2 N, rows, columns): left halves, then right ones |
//! | `halves/indentation_sigma_mm` | how sure indentations are, if a calibration says how sure it is |
//! | `reference.npz` | range, points, normals without contact, how sure they are; the side of the seam of each pixel |
//! | `samples.csv` | which two halves each sample consists of, and its split |
//! | `halves.csv` | forces, moments and contact of each half, if layers give way |
//! | `samples/indentation_mm`, `samples/label` | the same, stitched, if materialised |
//! | `halves/image`, `samples/image` | captures of the halves, and stitched, if there are any |
//! | `dataset.json`, `README.md` | what everything means, for programs and for people |
//!
//! A sample's range is the reference's minus its indentation. Splits are by *pattern*: a sample is
//! for training only if both of its patterns are, so that no shape leaks into the test.
//!
//! Every file appears whole or not at all, under its final name; `dataset.json` lists them with
//! their hashes. Killed and resumed, a run ends with the same bytes as an undisturbed one
//! ([`resumable`](fabkit_files::resumable)).

mod captures;
mod card;
mod elsewhere;
mod felt;
mod halves;
mod images;
mod order;
mod patterns;
mod plan;
mod read;
mod reader;
mod room;
mod samples;
mod shard_file;
mod sheet;
mod store;
mod tiling;

use std::path::Path;

use fabkit_depth::truth::{Presser, ReferenceSurface, Seam, Side, Uncertainty};
use fabkit_export::ZarrArray;
use serde_json::json;

pub use captures::{HalfCaptures, InvalidCaptures};
pub use elsewhere::{Files, shard};
pub use felt::Felt;
pub use images::HalfImages;
pub use order::{DatasetRequest, DatasetRequestError, ImageRequest, prepare};
pub use patterns::{MAX_BODIES, MAX_PATTERNS, NamedPresses, NoPatterns, read as read_patterns};
pub use plan::{DatasetPlan, Split};
pub use read::{SampleArray, SampleError};
pub use reader::DatasetReader;
pub use room::Room;
pub use sheet::sheet;
pub use store::{DatasetError, KIND};

use fabkit_files::progress::OnProgress;
use fabkit_files::resumable::{Folder, FolderError};
use fabkit_scene::pressing::{Contact, Ready};
use tiling::Tiling;

/// What is pressed: the same shape on either side of the seam.
#[derive(Clone, Debug)]
pub struct PressPattern {
    /// For example `semi-dome-017`.
    pub name: String,
    /// Bodies on the left, in the sensor frame.
    pub left: Vec<Presser>,
    /// The same bodies after half a turn about z.
    pub right: Vec<Presser>,
    /// What soft layers feel of either, if they are asked.
    pub felt: Option<Felt>,
}

/// What to compute, and from what.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The surface as the camera sees it.
    pub surface: &'a ReferenceSurface<'a>,
    /// Where left and right meet.
    pub seam: &'a Seam,
    /// What is pressed, in order.
    pub patterns: &'a [PressPattern],
    /// How the surface answers.
    pub contact: Contact,
    /// The soft layers, if they are asked.
    pub ready: Option<&'a Ready>,
    /// How sure camera and pose are, if a calibration says so.
    pub uncertainty: Option<&'a Uncertainty>,
    /// What the folder will say about itself.
    pub plan: &'a DatasetPlan,
    /// Pictures of all halves.
    pub captures: Option<&'a HalfImages<'a>>,
    /// Write the stitched samples too, instead of their list alone.
    pub materialise: bool,
    /// Go on where an earlier run was stopped.
    pub resume: bool,
}

impl Job<'_> {
    /// The pattern of a half, and on which side of the seam it presses.
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

/// What a run did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WrittenDataset {
    /// Half presses.
    pub halves: usize,
    /// Combinations of them.
    pub samples: usize,
    /// Files that an earlier run had finished.
    pub found: usize,
    /// Files written now.
    pub made: usize,
    /// Of these, files that were there and were not what an earlier run wrote.
    pub damaged: Vec<String>,
    /// Halves, of those cast now, that press nothing that the camera sees on their side of the
    /// seam.
    pub untouched: Vec<String>,
}

/// A data set that is being written: nobody else writes there until this is dropped.
#[derive(Debug)]
pub struct Begun {
    folder: Folder,
    /// The plan that it was begun with.
    plan: serde_json::Value,
    /// Shapes of `halves/indentation_mm` and `halves/label`.
    halves: Vec<ZarrArray>,
}

/// Begins a data set, or, to [`resume`](Job::resume), goes on with one.
///
/// # Errors
/// [`DatasetError::Folder`]: a folder that is not empty, holds another plan, or is in use.
pub fn begin(folder: &Path, job: &Job) -> Result<Begun, DatasetError> {
    let plan = job.plan.document(job);
    let folder = Folder::open(KIND, folder, plan.clone(), job.resume)?;
    Ok(Begun { folder, plan, halves: halves::arrays(job, size_px(job)) })
}

/// Writes a data set: [`begin`] and [`Begun::write`].
///
/// # Errors
/// Theirs.
pub fn write(
    folder: &Path,
    job: &Job,
    progress: OnProgress,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<WrittenDataset, DatasetError> {
    begin(folder, job)?.write(job, progress, cancelled)
}

impl Begun {
    /// Writes what is missing. `cancelled` is asked between files; what was finished until then
    /// stays for `resume`.
    ///
    /// # Errors
    /// [`DatasetError`]; a job with another plan.
    pub fn write(
        self,
        job: &Job,
        progress: OnProgress,
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
        let felt = felt::halves_csv(job);
        // Group, reference, list, card, plan.
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
        store.put("README.md", || Ok(card::text(job)?.into_bytes()))?;
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
            found,
            made,
            damaged,
            untouched,
        })
    }

    /// What a job is read from may have changed since the data set was begun.
    fn check(&self, job: &Job) -> Result<(), DatasetError> {
        let differences = fabkit_files::resumable::differences(&self.plan, &job.plan.document(job));
        match differences.is_empty() {
            true => Ok(()),
            false => {
                let folder = self.folder.path().into();
                Err(FolderError::OtherPlan { what: KIND.what, folder, differences }.into())
            }
        }
    }
}

/// Rows and columns.
fn size_px(job: &Job) -> [u32; 2] {
    [job.surface.rays().height_px(), job.surface.rays().width_px()]
}
