//! Casting of every half press, once.

use std::ops::Range;

use fabkit_depth::ground_truth::{DepthMap, PlacedIndenter, SURFACE_LABEL, Side, Uncertainty};
use fabkit_export::{NpyArray, NpyValues, ZarrArray, ZarrType, npz, zarr_pack};
use fabkit_scene::press_simulation::ContactSolution;
use rayon::prelude::*;
use serde_json::json;

use super::read::SampleArray;
use super::samples::HalfParts;
use super::store::{DatasetError, Store};
use super::tiling::Tiling;
use super::{DatasetJob, ShardFiles};

/// Number of half presses in one file.
const HALVES_PER_SHARD: u64 = 16;

/// Stored values of a half press.
pub(super) struct HalfPress {
    pub(super) indentation_mm: Vec<f32>,
    pub(super) label: Vec<u8>,
    /// Standard deviations, if the calibration has a covariance; else empty.
    indentation_sigma_mm: Vec<f32>,
}

/// Returns the arrays `halves/indentation_mm`, `halves/label` and, if the calibration has a covariance,
/// `halves/indentation_sigma_mm`.
pub(super) fn arrays(job: &DatasetJob, [height, width]: [u32; 2]) -> Vec<ZarrArray> {
    let array = |element, attributes| ZarrArray {
        element,
        samples: 2 * job.patterns.len() as u64,
        sample_shape: vec![height.into(), width.into()],
        chunk_shape: vec![height.into(), width.into()],
        samples_per_shard: HALVES_PER_SHARD,
        dimensions: ["half", "row", "column"].map(String::from).to_vec(),
        attributes,
    };
    let mut all = vec![
        array(
            ZarrType::F32,
            json!({ "unit": "mm", "is": "range without contact minus range with it" }),
        ),
        array(
            ZarrType::U8,
            json!({ "is": "0: no surface, 1: surface, from 2: bodies of the pattern" }),
        ),
    ];
    if job.uncertainty.is_some() {
        let is =
            "standard deviation of indentation_mm by camera and pose; 0 where nothing has moved";
        all.push(array(ZarrType::F32, json!({ "unit": "mm", "is": is })));
    }
    all
}

/// Names of [`arrays`], in order; the last may be absent.
const NAMES: [&str; 3] = ["halves/indentation_mm", "halves/label", "halves/indentation_sigma_mm"];

/// Result of a shard: the contributions of its halves to samples, if these are written, and the indices of halves that
/// touch nothing.
type ShardResult = (Vec<HalfParts>, Vec<usize>);

/// Casts and writes all halves. Returns their contributions to samples, if there is a tiling, and the indices of halves
/// that touch nothing.
pub(super) fn write(
    store: &Store,
    job: &DatasetJob,
    arrays: &[ZarrArray],
    tiling: Option<&Tiling>,
) -> Result<ShardResult, DatasetError> {
    for (name, array) in NAMES.iter().zip(arrays) {
        store.put(&format!("{name}/zarr.json"), || Ok(array.metadata()?))?;
    }
    let Some(first) = arrays.first() else { return Ok(ShardResult::default()) };
    let shard = |shard: u64| -> Result<ShardResult, DatasetError> {
        let names = shard_names(arrays, shard);
        let places = as_usize(first.samples_in_shard(shard));
        let is_there = names.iter().all(|name| store.has(name));
        let halves: Vec<HalfPress> = match (is_there, tiling) {
            // Nothing to write, and nothing to stitch: existing halves need not be read.
            (true, None) => Vec::new(),
            (true, Some(_)) => read_halves(store, arrays, places.clone())?,
            (false, _) => {
                places.clone().map(|half| cast_half(job, half)).collect::<Result<_, _>>()?
            }
        };
        for ((name, array), values) in names.iter().zip(arrays).zip(VALUES) {
            store.put(name, || pack(array, &halves, values))?;
        }
        let of_shard = || places.clone().zip(&halves);
        let untouched = of_shard()
            .filter(|(place, half)| !has_contact(job, *place, half))
            .map(|(place, _)| place);
        let parts = tiling.into_iter().flat_map(|tiling| {
            of_shard().map(|(place, half)| HalfParts::new(job, tiling, half, job.half(place).1))
        });
        Ok((parts.collect::<Result<_, _>>()?, untouched.collect()))
    };
    let cast: Vec<ShardResult> =
        (0..first.shards()).into_par_iter().map(shard).collect::<Result<_, _>>()?;
    let mut all = ShardResult::default();
    for (parts, untouched) in cast {
        all.0.extend(parts);
        all.1.extend(untouched);
    }
    Ok(all)
}

/// Computes the files of one shard, even if they exist.
pub(super) fn shard_files(
    job: &DatasetJob,
    arrays: &[ZarrArray],
    shard: u64,
) -> Result<ShardFiles, DatasetError> {
    let Some(first) = arrays.first() else { return Ok(ShardFiles::new()) };
    let places = as_usize(first.samples_in_shard(shard));
    let halves: Vec<HalfPress> =
        places.into_par_iter().map(|half| cast_half(job, half)).collect::<Result<_, _>>()?;
    let names = shard_names(arrays, shard);
    let packed = names.into_iter().zip(arrays).zip(VALUES);
    packed.map(|((name, array), values)| Ok((name, pack(array, &halves, values)?))).collect()
}

fn as_usize(range: Range<u64>) -> Range<usize> {
    range.start as usize..range.end as usize
}

/// Returns the paths of a shard's files, one for each array, in order.
pub(super) fn shard_names(arrays: &[ZarrArray], shard: u64) -> Vec<String> {
    let path = |(name, array): (&&str, &ZarrArray)| format!("{name}/{}", array.shard_path(shard));
    NAMES.iter().zip(arrays).map(path).collect()
}

/// Finds the array and the number of a shard from the path of its file.
pub(super) fn find_shard<'a>(arrays: &'a [ZarrArray], name: &str) -> Option<(&'a ZarrArray, u64)> {
    NAMES.iter().zip(arrays).find_map(|(of, array)| {
        let is_its = |shard: &u64| name == format!("{of}/{}", array.shard_path(*shard));
        Some((array, (0..array.shards()).find(is_its)?))
    })
}

/// Packs one kind of values of some halves into a shard.
fn pack(
    array: &ZarrArray,
    halves: &[HalfPress],
    values: fn(&HalfPress) -> Vec<u8>,
) -> Result<Vec<u8>, DatasetError> {
    let packed = halves.iter().map(|half| zarr_pack(&values(half)));
    Ok(array.shard(&packed.collect::<Result<Vec<_>, _>>()?))
}

/// Values of each of [`NAMES`], little-endian.
const VALUES: [fn(&HalfPress) -> Vec<u8>; 3] = [
    |half| bytes_of_f32(&half.indentation_mm),
    |half| half.label.clone(),
    |half| bytes_of_f32(&half.indentation_sigma_mm),
];

/// Reads halves that an earlier run, or another machine, cast.
pub(super) fn read_halves(
    store: &Store,
    arrays: &[ZarrArray],
    places: Range<usize>,
) -> Result<Vec<HalfPress>, DatasetError> {
    let open = |(name, array): (&&str, &ZarrArray)| {
        SampleArray::new(&store.folder().path().join(name), array.clone())
    };
    let open: Vec<SampleArray> = NAMES.iter().zip(arrays).map(open).collect();
    let [indentations, labels, ..] = &open[..] else { return Ok(Vec::new()) };
    let half = |place| -> Result<HalfPress, DatasetError> {
        let bytes = indentations.sample(place)?;
        let values = bytes.as_chunks().0.iter().map(|value| f32::from_le_bytes(*value));
        let (indentation_mm, label) = (values.collect(), labels.sample(place)?);
        // Halves that are read are stitched and not written again: their standard deviations are not needed.
        Ok(HalfPress { indentation_mm, label, indentation_sigma_mm: Vec::new() })
    };
    places.map(half).collect()
}

/// Casts one half by its index: left halves first, then right ones.
pub(super) fn cast_half(job: &DatasetJob, half: usize) -> Result<HalfPress, DatasetError> {
    with_depth_map(job, half, false, |map, _| HalfPress {
        indentation_mm: indentation_f32(map),
        label: labels_u8(map),
        indentation_sigma_mm: job.uncertainty.map_or_else(Vec::new, |of| sigma_f32(map, of)),
    })
}

/// Computes the contact solution of a half, if layers are simulated and touched.
pub(super) fn solve_contact<'a>(
    job: &DatasetJob<'a>,
    half: usize,
) -> Result<Option<ContactSolution<'a>>, DatasetError> {
    let (pattern, side) = job.half(half);
    match (job.elastic_solver, &pattern.response) {
        (Some(ready), Some(felt)) => felt.solve_contact(ready, job.contact, side),
        _ => Ok(None),
    }
}

/// Returns the bodies of a half.
pub(super) fn bodies_of_half<'a>(job: &'a DatasetJob, half: usize) -> &'a [PlacedIndenter] {
    let (pattern, side) = job.half(half);
    if side == Side::Left { &pattern.left } else { &pattern.right }
}

/// Calls `look` with the depth map of a half and its contact solution; the map has normals if `has_normals`.
pub(super) fn with_depth_map<R>(
    job: &DatasetJob,
    half: usize,
    has_normals: bool,
    look: impl FnOnce(&DepthMap<'_>, Option<&ContactSolution<'_>>) -> R,
) -> Result<R, DatasetError> {
    let indenters = bodies_of_half(job, half);
    let answer = solve_contact(job, half)?;
    let map = match &answer {
        Some(answer) => job.surface.map_deformed(indenters, answer, has_normals),
        None => job.surface.map_with_indenters(indenters).with_membrane(job.contact.membrane_mm()),
    };
    Ok(look(&map, answer.as_ref()))
}

/// Returns whether any pixel on the half's own side shows one of its bodies.
fn has_contact(job: &DatasetJob, place: usize, half: &HalfPress) -> bool {
    let (_, own) = job.half(place);
    let mut labels = half.label.iter().zip(job.seam.sides());
    labels.any(|(label, side)| u16::from(*label) > SURFACE_LABEL && *side == own)
}

/// Converts indentations; 0 where no surface is visible.
fn indentation_f32(map: &DepthMap) -> Vec<f32> {
    map.indentation_mm().map(|mm| if mm.is_finite() { mm as f32 } else { 0.0 }).collect()
}

/// Converts standard deviations of indentations; 0 where nothing has moved or no surface is visible.
fn sigma_f32(map: &DepthMap, uncertainty: &Uncertainty) -> Vec<f32> {
    let has_moved: Vec<bool> = map.indentation_mm().map(|mm| mm.is_finite() && mm != 0.0).collect();
    let sigmas = map.compute_standard_deviations_where(uncertainty, |pixel| has_moved[pixel]);
    sigmas.indentation_mm().map(|mm| if mm.is_finite() { mm as f32 } else { 0.0 }).collect()
}

/// Converts labels. They fit into bytes, because a pattern has at most [`MAX_BODIES`](super::MAX_BODIES) bodies.
fn labels_u8(map: &DepthMap) -> Vec<u8> {
    map.label().iter().map(|&label| u8::try_from(label).unwrap_or(u8::MAX)).collect()
}

fn bytes_of_f32(values: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(4 * values.len());
    values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes
}

/// Computes the content of `reference.npz`.
pub(super) fn reference(job: &DatasetJob) -> Result<Vec<u8>, DatasetError> {
    let map = job.surface.map_without_contact();
    let shape = vec![map.height_px() as usize, map.width_px() as usize];
    let array = |name: &str, values| NpyArray { name: name.into(), shape: shape.clone(), values };
    let vectors = |name: &str, values: Vec<f64>| NpyArray {
        name: name.into(),
        shape: vec![shape[0], shape[1], 3],
        values: NpyValues::F64(values),
    };
    let points = map.point_in_sensor().flat_map(|point| [point.x, point.y, point.z]).collect();
    let normals = map.normal_in_sensor().iter().flat_map(|n| [n.x, n.y, n.z]).collect();
    let on = |side: Side| NpyValues::Bool(job.seam.sides().iter().map(|s| *s == side).collect());
    let mut arrays = vec![
        array("range_mm", NpyValues::F64(map.range_mm().to_vec())),
        array("z_mm", NpyValues::F64(map.z_mm().collect())),
        vectors("point_in_sensor", points),
        vectors("normal_in_sensor", normals),
        array("incidence_rad", NpyValues::F64(map.incidence_rad().collect())),
        array("is_left", on(Side::Left)),
        array("is_right", on(Side::Right)),
    ];
    if let Some(uncertainty) = job.uncertainty {
        let sigmas = map.compute_standard_deviations(uncertainty);
        arrays.extend([
            array("sigma_mm", NpyValues::F64(sigmas.range_mm().collect())),
            array("point_sigma_mm", NpyValues::F64(sigmas.point_mm().collect())),
            array("normal_sigma_rad", NpyValues::F64(sigmas.normal_rad().collect())),
        ]);
    }
    Ok(npz(&arrays)?)
}
