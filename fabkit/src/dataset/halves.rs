//! Casting every half press once.

use fabkit_depth::truth::{DepthMap, SURFACE_LABEL, Side};
use fabkit_export::{Array, Element, Values, ZarrArray, npz, zarr_pack};
use rayon::prelude::*;
use serde_json::json;

use super::Job;
use super::samples::Parts;
use super::store::{DatasetError, Store};
use super::tiling::Tiling;

/// Half presses in one file.
const HALVES_PER_SHARD: u64 = 16;

/// What is kept of a half press.
pub(super) struct Half {
    pub(super) indentation_mm: Vec<f32>,
    pub(super) label: Vec<u8>,
}

/// `halves/indentation_mm` and `halves/label`.
pub(super) fn arrays(job: &Job, [height, width]: [u32; 2]) -> Vec<ZarrArray> {
    let array = |element, attributes| ZarrArray {
        element,
        samples: 2 * job.patterns.len() as u64,
        sample_shape: vec![height.into(), width.into()],
        chunk_shape: vec![height.into(), width.into()],
        samples_per_shard: HALVES_PER_SHARD,
        dimensions: ["half", "row", "column"].map(String::from).to_vec(),
        attributes,
    };
    vec![
        array(
            Element::F32,
            json!({ "unit": "mm", "is": "range without contact minus range with it" }),
        ),
        array(
            Element::U8,
            json!({ "is": "0: no surface, 1: surface, from 2: bodies of the pattern" }),
        ),
    ]
}

/// Names of [`arrays`], in order.
const NAMES: [&str; 2] = ["halves/indentation_mm", "halves/label"];

/// What a shard's work leaves: what its halves contribute to samples, if these are written, and
/// which halves touch nothing.
type Cast = (Vec<Parts>, Vec<usize>);

/// Casts and writes. What samples will be stitched from is handed back if there is a tiling for them,
/// and with it the places of halves that touch nothing.
pub(super) fn write(
    store: &Store,
    job: &Job,
    arrays: &[ZarrArray],
    tiling: Option<&Tiling>,
) -> Result<Cast, DatasetError> {
    for (name, array) in NAMES.iter().zip(arrays) {
        store.put(&format!("{name}/zarr.json"), || Ok(array.metadata()?))?;
    }
    let [indentations, labels] = arrays else { return Ok(Cast::default()) };
    let shard = |shard: u64| -> Result<Cast, DatasetError> {
        let name = |i: usize| format!("{}/{}", NAMES[i], arrays[i].shard_path(shard));
        let names = [name(0), name(1)];
        let places = indentations.samples_of(shard).map(|half| half as usize);
        let is_there = names.iter().all(|name| store.has(name));
        let halves: Vec<Half> = match is_there && tiling.is_none() {
            true => Vec::new(),
            false => places.clone().map(|half| cast_half(job, half)).collect(),
        };
        store.put(&names[0], || {
            let packed = halves.iter().map(|half| zarr_pack(&bytes_of_f32(&half.indentation_mm)));
            Ok(indentations.shard(&packed.collect::<Result<Vec<_>, _>>()?))
        })?;
        store.put(&names[1], || {
            let packed = halves.iter().map(|half| zarr_pack(&half.label));
            Ok(labels.shard(&packed.collect::<Result<Vec<_>, _>>()?))
        })?;
        let of_shard = || places.clone().zip(&halves);
        let untouched =
            of_shard().filter(|(place, half)| !touches(job, *place, half)).map(|(place, _)| place);
        let parts = tiling.into_iter().flat_map(|tiling| {
            of_shard().map(|(place, half)| Parts::new(job, tiling, half, job.half(place).1))
        });
        Ok((parts.collect::<Result<_, _>>()?, untouched.collect()))
    };
    let cast: Vec<Cast> =
        (0..indentations.shards()).into_par_iter().map(shard).collect::<Result<_, _>>()?;
    let mut all = Cast::default();
    for (parts, untouched) in cast {
        all.0.extend(parts);
        all.1.extend(untouched);
    }
    Ok(all)
}

/// Casts one half: the left ones in order, then the right ones.
pub(super) fn cast_half(job: &Job, half: usize) -> Half {
    let pressers = match job.half(half) {
        (pattern, Side::Left) => &pattern.left,
        (pattern, _) => &pattern.right,
    };
    let map = job.surface.pressed(pressers).with_membrane(job.membrane_mm);
    Half { indentation_mm: indentation_f32(&map), label: labels_u8(&map) }
}

/// Whether any pixel on its own side sees what presses.
fn touches(job: &Job, place: usize, half: &Half) -> bool {
    let (_, own) = job.half(place);
    let mut labels = half.label.iter().zip(job.seam.sides());
    labels.any(|(label, side)| u16::from(*label) > SURFACE_LABEL && *side == own)
}

/// Where no surface is seen there is no indentation either.
fn indentation_f32(map: &DepthMap) -> Vec<f32> {
    map.indentation_mm().map(|mm| if mm.is_finite() { mm as f32 } else { 0.0 }).collect()
}

/// A pattern has at most [`MAX_BODIES`](super::MAX_BODIES).
fn labels_u8(map: &DepthMap) -> Vec<u8> {
    map.label().iter().map(|&label| u8::try_from(label).unwrap_or(u8::MAX)).collect()
}

fn bytes_of_f32(values: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(4 * values.len());
    values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes
}

/// The bytes of `reference.npz`.
pub(super) fn reference(job: &Job) -> Result<Vec<u8>, DatasetError> {
    let map = job.surface.untouched();
    let shape = vec![map.height_px() as usize, map.width_px() as usize];
    let array = |name: &str, values| Array { name: name.into(), shape: shape.clone(), values };
    let vectors = |name: &str, values: Vec<f64>| Array {
        name: name.into(),
        shape: vec![shape[0], shape[1], 3],
        values: Values::F64(values),
    };
    let points = map.point_in_sensor().flat_map(|point| [point.x, point.y, point.z]).collect();
    let normals = map.normal_in_sensor().iter().flat_map(|n| [n.x, n.y, n.z]).collect();
    let on = |side: Side| Values::Bool(job.seam.sides().iter().map(|s| *s == side).collect());
    Ok(npz(&[
        array("range_mm", Values::F64(map.range_mm().to_vec())),
        array("z_mm", Values::F64(map.z_mm().collect())),
        vectors("point_in_sensor", points),
        vectors("normal_in_sensor", normals),
        array("incidence_rad", Values::F64(map.incidence_rad().collect())),
        array("is_left", on(Side::Left)),
        array("is_right", on(Side::Right)),
    ])?)
}
