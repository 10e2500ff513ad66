//! Stitching: each left half with each right half.
//!
//! A half is cut into runs once; a sample is the runs of two halves, in order, so that its cost is that of its contacts and not that of its pixels.

use fabkit_depth::truth::Side;
use fabkit_export::{Element, Run, RunContent, ZarrArray, zstd_of_runs};
use rayon::prelude::*;
use serde_json::json;

use super::Job;
use super::halves::Half;
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
            Element::U8,
            json!({ "is": "0: no surface or seam, 1: surface, from 2: bodies of the pattern on that side" }),
        ),
    ]
}

/// The part of a half that its own side of the seam contributes to samples.
pub(super) struct Part {
    indentation: Vec<Run>,
    label: Vec<Run>,
}

impl Part {
    pub(super) fn new(job: &Job, half: &Half, side: Side) -> Self {
        let sides = job.seam.sides();
        Self {
            indentation: runs(sides, side, |pixel| half.indentation_mm[pixel].to_le_bytes()),
            label: runs(sides, side, |pixel| [half.label[pixel]]),
        }
    }
}

/// Writes all samples, one left half after the other, from the parts of the left halves and then
/// those of the right ones.
pub(super) fn write(
    store: &Store,
    job: &Job,
    arrays: &[ZarrArray],
    parts: &[Part],
) -> Result<(), DatasetError> {
    let [indentations, labels] = arrays else { return Ok(()) };
    for (name, array) in NAMES.iter().zip(arrays) {
        store.put(&format!("{name}/zarr.json"), || Ok(array.metadata()?))?;
    }
    let pixels = job.seam.sides().len();
    let count = job.patterns.len();
    (0..count).into_par_iter().try_for_each(|left| {
        let path = |array: &ZarrArray| array.shard_path(left as u64);
        let (left, rights) = (&parts[left], &parts[count..]);
        store.put(&format!("{}/{}", NAMES[0], path(indentations)), || {
            let runs = rights.iter().map(|right| (&left.indentation, &right.indentation));
            let stitched = runs.map(|(left, right)| stitched(left, right, 4 * pixels));
            Ok(indentations.shard(&stitched.collect::<Vec<_>>()))
        })?;
        store.put(&format!("{}/{}", NAMES[1], path(labels)), || {
            let runs = rights.iter().map(|right| (&left.label, &right.label));
            let stitched = runs.map(|(left, right)| stitched(left, right, pixels));
            Ok(labels.shard(&stitched.collect::<Vec<_>>()))
        })
    })
}

/// The runs of the pixels on one side, in order of place; zeros are left out.
fn runs<const N: usize>(
    sides: &[Side],
    own: Side,
    bytes_of: impl Fn(usize) -> [u8; N],
) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (pixel, _) in sides.iter().enumerate().filter(|(_, side)| **side == own) {
        let place = N * pixel..N * (pixel + 1);
        let bytes = bytes_of(pixel);
        let is_fill = bytes.iter().all(|byte| *byte == bytes[0]);
        let last = runs.last_mut().filter(|run| run.place.end == place.start);
        match last {
            Some(Run { place: grown, content: RunContent::Fill(byte) })
                if is_fill && *byte == bytes[0] =>
            {
                grown.end = place.end;
            }
            Some(Run { place: grown, content: RunContent::Bytes(content) }) if !is_fill => {
                grown.end = place.end;
                content.extend(bytes);
            }
            _ => {
                let content = match is_fill {
                    true => RunContent::Fill(bytes[0]),
                    false => RunContent::Bytes(bytes.to_vec()),
                };
                runs.push(Run { place, content });
            }
        }
    }
    runs.retain(|run| run.content != RunContent::Fill(0));
    runs
}

/// A picture of `length` bytes; what neither part holds, the seam among it, is zero.
fn stitched(left: &[Run], right: &[Run], length: usize) -> Vec<u8> {
    let mut all: Vec<&Run> = left.iter().chain(right).collect();
    // Two ascending lists: the sort only merges.
    all.sort_by_key(|run| run.place.start);
    zstd_of_runs(all, length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_make_up_the_picture_between_them() {
        use Side::{Left, Neither, Right};
        let sides = [Left, Left, Neither, Right, Right, Left, Neither, Right];
        let values = [0u8, 3, 0, 0, 5, 7, 0, 7];
        let of = |own| runs(&sides, own, |pixel| [values[pixel]]);
        let (left, right) = (of(Left), of(Right));
        assert_eq!((left.len(), right.len()), (2, 2), "zeros are left out");
        let mut bytes = vec![0; values.len()];
        for run in [left, right].concat() {
            match run.content {
                RunContent::Fill(byte) => bytes[run.place].fill(byte),
                RunContent::Bytes(content) => bytes[run.place].copy_from_slice(&content),
            }
        }
        assert_eq!(bytes, values);
    }
}
