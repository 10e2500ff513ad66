//! Images of half presses, given or simulated, stitched like the halves that they show.

use std::borrow::Cow;

use fabkit_capture::Renderer;
use fabkit_checks::UnknownProperty;
use fabkit_export::{ZarrArray, ZarrType, zarr_pack};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::captures::HalfCaptures;
use super::samples::{HalfPart, stitched_array, write_array};
use super::store::{DatasetError, Store};
use super::tiling::Tiling;
use super::{DatasetJob, halves};

const HALVES: &str = "halves/image";
const SAMPLES: &str = "samples/image";

/// Images of all halves: left halves, then right ones.
#[derive(Debug)]
pub enum HalfImages<'a> {
    /// Existing images.
    Given(HalfCaptures),
    /// Images that are rendered when needed, with noise from this seed and the half's number.
    Simulated(Box<Renderer<'a>>, u64),
}

impl HalfImages<'_> {
    /// Returns the number of values per pixel: 1 or 3.
    pub fn channels(&self) -> u32 {
        match self {
            Self::Given(captures) => captures.channels(),
            Self::Simulated(studio, _) => studio.channels() as u32,
        }
    }

    /// Returns the material properties that simulated images depend on and no source states.
    pub fn not_known(&self) -> Vec<UnknownProperty> {
        match self {
            Self::Given(_) => Vec::new(),
            Self::Simulated(studio, _) => studio.not_known(),
        }
    }

    /// Describes the images for the data set's document.
    pub(super) fn document(&self) -> Value {
        match self {
            Self::Given(captures) => json!({ "is_simulated": false, "hash": captures.hash() }),
            Self::Simulated(studio, seed) => {
                let mut document = studio.document();
                document["seed"] = json!(seed);
                document
            }
        }
    }

    fn description(&self) -> &'static str {
        match self {
            Self::Given(_) => "captures as given",
            Self::Simulated(..) => "simulated captures",
        }
    }

    /// Returns the image of a half, rendered if it is simulated.
    fn render(
        &self,
        store: &Store,
        job: &DatasetJob,
        halves: &[ZarrArray],
        half: usize,
    ) -> Result<Cow<'_, [u8]>, DatasetError> {
        let (studio, seed) = match self {
            Self::Given(captures) => return Ok(Cow::Borrowed(captures.image(half))),
            Self::Simulated(studio, seed) => (studio, seed),
        };
        // Distinct seeds of data sets give distinct seeds of halves.
        let seed = Some(seed.wrapping_mul(2 * job.patterns.len() as u64 + 1) + half as u64);
        let taken = if studio.needs_normals() {
            halves::with_depth_map(job, half, true, |map, answer| studio.render(map, answer, seed))?
        } else {
            // The half's depth map has been written: rays need not be cast again.
            let written = halves::read_halves(store, halves, half..half + 1)?;
            let Some(truth) = written.first() else { return Ok(Cow::Owned(Vec::new())) };
            let (by_mm, label) = (&truth.indentation_mm, &truth.label);
            let map = job.surface.map_from_indentation(by_mm, label, Renderer::MOTION_THRESHOLD_MM);
            studio.render(&map, halves::solve_contact(job, half)?.as_ref(), seed)
        };
        let taken = taken.map_err(|error| DatasetError::Image(Box::new(error)))?;
        Ok(Cow::Owned(taken.iter().map(|grey| grey.round() as u8).collect()))
    }

    /// Returns the array `halves/image` and, if there is a tiling, `samples/image`.
    pub(super) fn arrays(
        &self,
        job: &DatasetJob,
        tiling: Option<&Tiling>,
        [height, width]: [u32; 2],
    ) -> Vec<(String, ZarrArray)> {
        let count = job.patterns.len();
        let shape: Vec<u64> = [height, width, self.channels()].map(u64::from).to_vec();
        let halves = ZarrArray {
            element: ZarrType::U8,
            samples: 2 * count as u64,
            sample_shape: shape.clone(),
            chunk_shape: shape,
            samples_per_shard: count as u64,
            dimensions: ["half", "row", "column", "channel"].map(String::from).to_vec(),
            attributes: json!({ "is": self.description() }),
        };
        let mut arrays = vec![(HALVES.to_owned(), halves)];
        arrays.extend(tiling.map(|tiling| {
            let is = format!(
                "{} stitched like the labels; 0 in the seam and off the surface",
                self.description()
            );
            let mut samples = stitched_array(count, tiling, [height, width], ZarrType::U8, &is);
            samples.sample_shape.push(self.channels().into());
            samples.chunk_shape.push(self.channels().into());
            samples.dimensions.push("channel".into());
            (SAMPLES.to_owned(), samples)
        }));
        arrays
    }

    /// Writes the images, and all pairs of them if they are materialised. The halves' depth maps have been written.
    pub(super) fn write(
        &self,
        store: &Store,
        job: &DatasetJob,
        tiling: Option<&Tiling>,
        halves: &[ZarrArray],
        arrays: &[(String, ZarrArray)],
    ) -> Result<(), DatasetError> {
        // Each image is rendered once, even if several arrays need it, and none if all files exist.
        let names = arrays.iter().flat_map(|(name, array)| {
            (0..array.shards()).map(move |shard| format!("{name}/{}", array.shard_path(shard)))
        });
        let is_whole = names.into_iter().all(|name| store.has(&name));
        let count = if is_whole { 0 } else { 2 * job.patterns.len() };
        let taken = (0..count).into_par_iter().map(|half| {
            let picture = self.render(store, job, halves, half)?;
            let part = tiling.map(|tiling| self.part(job, tiling, half, &picture)).transpose()?;
            Ok((zarr_pack(&picture)?, part))
        });
        let taken: Vec<(Vec<u8>, Option<HalfPart>)> = taken.collect::<Result<_, DatasetError>>()?;
        for (name, array) in arrays {
            if let Some(tiling) = tiling.filter(|_| name == SAMPLES) {
                let parts: Vec<&HalfPart> =
                    taken.iter().filter_map(|(_, part)| part.as_ref()).collect();
                write_array(store, name, array, tiling, &parts)?;
                continue;
            }
            store.put(&format!("{name}/zarr.json"), || Ok(array.metadata()?))?;
            (0..array.shards()).into_par_iter().try_for_each(|shard| {
                store.put(&format!("{name}/{}", array.shard_path(shard)), || {
                    let of_shard = array.samples_in_shard(shard);
                    let packed = &taken[of_shard.start as usize..of_shard.end as usize];
                    let packed: Vec<Vec<u8>> =
                        packed.iter().map(|(packed, _)| packed.clone()).collect();
                    Ok(array.shard(&packed))
                })
            })?;
        }
        Ok(())
    }

    /// Cuts a half's image into its part of samples.
    fn part(
        &self,
        job: &DatasetJob,
        tiling: &Tiling,
        half: usize,
        picture: &[u8],
    ) -> Result<HalfPart, DatasetError> {
        let (sides, own) = (job.seam.sides(), job.half(half).1);
        if self.channels() == 1 {
            return HalfPart::new(tiling, sides, own, |pixel| [picture[pixel]]);
        }
        let (colors, _) = picture.as_chunks::<3>();
        HalfPart::new(tiling, sides, own, |pixel| colors[pixel])
    }
}
