//! Stitching: each left half with each right half.

use fabkit_export::{Element, ZarrArray, zarr_pack};
use rayon::prelude::*;
use serde_json::json;

use super::Job;
use super::halves::{Half, bytes_of_f32, bytes_of_u16};
use super::store::{DatasetError, Store};

const NAMES: [&str; 2] = ["samples/indentation_mm", "samples/label"];

/// `samples/indentation_mm` and `samples/label`: one file for each left half.
pub(super) fn arrays(job: &Job, [height, width]: [u32; 2]) -> Vec<ZarrArray> {
    let count = job.patterns.len() as u64;
    let array = |element, attributes| ZarrArray {
        element,
        samples: count * count,
        sample_shape: vec![height.into(), width.into()],
        samples_per_shard: count,
        dimensions: ["sample", "row", "column"].map(String::from).to_vec(),
        attributes,
    };
    vec![
        array(
            Element::F32,
            json!({ "unit": "mm", "is": "range without contact minus range with it; 0 in the seam" }),
        ),
        array(
            Element::U16,
            json!({ "is": "0: no surface or seam, 1: surface, from 2: bodies of the pattern on that side" }),
        ),
    ]
}

/// Writes all samples, one left half after the other.
pub(super) fn write(
    store: &Store,
    job: &Job,
    arrays: &[ZarrArray],
    halves: &[Half],
) -> Result<(), DatasetError> {
    for (name, array) in NAMES.iter().zip(arrays) {
        store.put(&format!("{name}/zarr.json"), || Ok(array.metadata()?))?;
    }
    let [indentations, labels] = arrays else { return Ok(()) };
    let count = job.patterns.len();
    (0..count).into_par_iter().try_for_each(|left| {
        let path = |array: &ZarrArray| array.shard_path(left as u64);
        let rights = &halves[count..];
        let left = &halves[left];
        store.put(&format!("{}/{}", NAMES[0], path(indentations)), || {
            let packed = rights.iter().map(|right| {
                let stitched = job.seam.stitch(&left.indentation_mm, &right.indentation_mm, 0.0);
                zarr_pack(&bytes_of_f32(&stitched))
            });
            Ok(indentations.shard(&packed.collect::<Result<Vec<_>, _>>()?))
        })?;
        store.put(&format!("{}/{}", NAMES[1], path(labels)), || {
            let packed = rights.iter().map(|right| {
                zarr_pack(&bytes_of_u16(&job.seam.stitch(&left.label, &right.label, 0)))
            });
            Ok(labels.shard(&packed.collect::<Result<Vec<_>, _>>()?))
        })
    })
}
