//! Stitching of samples: each left half with each right half.
//!
//! Each half is cut into chunks once. A chunk that belongs to one half alone is packed once and shared by every sample
//! that contains it. For a chunk through which the seam passes, the runs of both halves are merged. So the cost of N x
//! N samples is that of 2 N halves and of the seam.

use fabkit_depth::ground_truth::Side;
use fabkit_export::{
    ByteRun, RunContent, Shard, StoredChunk, ZarrArray, ZarrType, encode_zstd_runs,
    zarr_append_checksum, zarr_pack,
};
use rayon::prelude::*;
use serde_json::json;

use super::DatasetJob;
use super::halves::HalfPress;
use super::store::{DatasetError, Store};
use super::tiling::Tiling;

const NAMES: [&str; 2] = ["samples/indentation_mm", "samples/label"];

/// Largest size of a file's index, bytes, because readers fetch the whole index for any sample.
const MAX_INDEX_BYTES: usize = 64 << 10;
/// Size of a chunk's entry in the index, bytes.
const ENTRY_BYTES: usize = 16;

/// Returns the array of all samples of `count` patterns; a file holds the samples of one or more left halves.
pub(super) fn stitched_array(
    count: usize,
    tiling: &Tiling,
    [height, width]: [u32; 2],
    element: ZarrType,
    is: &str,
) -> ZarrArray {
    // As many left halves as the index allows; at least one, even if the index is then larger.
    let lefts = MAX_INDEX_BYTES / (ENTRY_BYTES * tiling.chunks() * count);
    ZarrArray {
        element,
        samples: (count * count) as u64,
        sample_shape: vec![height.into(), width.into()],
        chunk_shape: tiling.chunk_px().map(|px| px as u64).to_vec(),
        samples_per_shard: (count * lefts.clamp(1, count)) as u64,
        dimensions: ["sample", "row", "column"].map(String::from).to_vec(),
        attributes: json!({ "is": is }),
    }
}

/// Returns the arrays `samples/indentation_mm` and `samples/label`.
pub(super) fn arrays(job: &DatasetJob, tiling: &Tiling, size_px: [u32; 2]) -> Vec<ZarrArray> {
    let array = |element, is| stitched_array(job.patterns.len(), tiling, size_px, element, is);
    let mut indentation =
        array(ZarrType::F32, "range without contact minus range with it; 0 in the seam");
    indentation.attributes["unit"] = json!("mm");
    let is = "0: no surface or seam, 1: surface, from 2: bodies of the pattern on that side";
    vec![indentation, array(ZarrType::U8, is)]
}

/// Contribution of a half to its samples.
pub(super) struct HalfParts {
    indentation: HalfPart,
    label: HalfPart,
}

impl HalfParts {
    /// Cuts a half's values into chunks.
    pub(super) fn new(
        job: &DatasetJob,
        tiling: &Tiling,
        half: &HalfPress,
        side: Side,
    ) -> Result<Self, DatasetError> {
        let sides = job.seam.sides();
        let indentation =
            HalfPart::new(tiling, sides, side, |pixel| half.indentation_mm[pixel].to_le_bytes())?;
        let label = HalfPart::new(tiling, sides, side, |pixel| [half.label[pixel]])?;
        Ok(Self { indentation, label })
    }
}

/// Contribution of a half's own side of the seam to one array, chunk by chunk.
pub(super) struct HalfPart(Vec<PartChunk>);

enum PartChunk {
    /// Chunk of zeros, or without pixels of this side.
    Empty,
    /// Chunk of this side alone, packed.
    Whole(Vec<u8>),
    /// Chunk of both sides, as runs to be merged with those of the other side.
    Shared(Vec<ByteRun>),
}

impl HalfPart {
    /// Cuts a half into chunks; `bytes_of` returns the bytes of a pixel.
    pub(super) fn new<const N: usize>(
        tiling: &Tiling,
        sides: &[Side],
        own: Side,
        bytes_of: impl Fn(usize) -> [u8; N],
    ) -> Result<Self, DatasetError> {
        let chunk = |chunk: usize| -> Result<PartChunk, DatasetError> {
            let [left, right] = tiling.sides(chunk);
            let pixels = || tiling.pixels(chunk).filter(|(_, pixel)| sides[*pixel] == own);
            if left && right {
                return Ok(PartChunk::Shared(collect_runs(pixels(), &bytes_of)));
            }
            let mut bytes = vec![0; N * tiling.chunk_pixels()];
            let (places, _) = bytes.as_chunks_mut::<N>();
            pixels().for_each(|(place, pixel)| places[place] = bytes_of(pixel));
            if bytes.iter().all(|byte| *byte == 0) {
                Ok(PartChunk::Empty)
            } else {
                Ok(PartChunk::Whole(zarr_pack(&bytes)?))
            }
        };
        Ok(Self((0..tiling.chunks()).map(chunk).collect::<Result<_, _>>()?))
    }

    /// Stores the packed chunks in a file, and returns their places.
    fn store(&self, shard: &mut Shard) -> Vec<Option<StoredChunk>> {
        let store = |chunk: &PartChunk| match chunk {
            PartChunk::Whole(packed) => Some(shard.store(packed)),
            PartChunk::Empty | PartChunk::Shared(_) => None,
        };
        self.0.iter().map(store).collect()
    }
}

/// Writes all samples from the parts of the halves.
pub(super) fn write(
    store: &Store,
    arrays: &[ZarrArray],
    tiling: &Tiling,
    parts: &[HalfParts],
) -> Result<(), DatasetError> {
    let [indentations, labels] = arrays else { return Ok(()) };
    let of = |part: fn(&HalfParts) -> &HalfPart| parts.iter().map(part).collect::<Vec<&HalfPart>>();
    write_array(store, NAMES[0], indentations, tiling, &of(|parts| &parts.indentation))?;
    write_array(store, NAMES[1], labels, tiling, &of(|parts| &parts.label))
}

/// Writes one array of samples from the parts of the left halves, followed by those of the right ones.
pub(super) fn write_array(
    store: &Store,
    name: &str,
    array: &ZarrArray,
    tiling: &Tiling,
    parts: &[&HalfPart],
) -> Result<(), DatasetError> {
    store.put(&format!("{name}/zarr.json"), || Ok(array.metadata()?))?;
    let count = parts.len() / 2;
    let (lefts, rights) = parts.split_at(count);
    let chunk_bytes = tiling.chunk_pixels() * array.pixel_bytes();
    (0..array.shards()).into_par_iter().try_for_each(|number| {
        store.put(&format!("{name}/{}", array.shard_path(number)), || {
            let mut shard = Shard::default();
            // The chunks of all right halves are stored once at the beginning of each file.
            let of_rights: Vec<_> = rights.iter().map(|right| right.store(&mut shard)).collect();
            let samples = array.samples_in_shard(number);
            for left in &lefts[samples.start as usize / count..samples.end as usize / count] {
                let of_left = left.store(&mut shard);
                for (right, of_right) in rights.iter().zip(&of_rights) {
                    for chunk in 0..tiling.chunks() {
                        let stored = match (&left.0[chunk], &right.0[chunk]) {
                            (PartChunk::Shared(left), PartChunk::Shared(right)) => {
                                merge_runs(left, right, chunk_bytes)
                                    .map(|chunk| shard.store(&chunk))
                            }
                            // A chunk of one side is empty in the half of the other side.
                            _ => of_left[chunk].or(of_right[chunk]),
                        };
                        shard.assign(stored);
                    }
                }
            }
            Ok(shard.finish(array))
        })
    })
}

/// Collects the runs of pixels of a chunk, in order of place; zeros are left out.
fn collect_runs<const N: usize>(
    pixels: impl Iterator<Item = (usize, usize)>,
    bytes_of: impl Fn(usize) -> [u8; N],
) -> Vec<ByteRun> {
    let mut runs: Vec<ByteRun> = Vec::new();
    for (place, pixel) in pixels {
        let place = N * place..N * (place + 1);
        let bytes = bytes_of(pixel);
        // A pixel of equal bytes, such as 0.0 or a label, can be part of a run.
        let is_fill = bytes.iter().all(|byte| *byte == bytes[0]);
        let last = runs.last_mut().filter(|run| run.place.end == place.start);
        match last {
            Some(ByteRun { place: grown, content: RunContent::Fill(byte) })
                if is_fill && *byte == bytes[0] =>
            {
                grown.end = place.end;
            }
            Some(ByteRun { place: grown, content: RunContent::Bytes(content) }) if !is_fill => {
                grown.end = place.end;
                content.extend(bytes);
            }
            _ => {
                let content = if is_fill {
                    RunContent::Fill(bytes[0])
                } else {
                    RunContent::Bytes(bytes.to_vec())
                };
                runs.push(ByteRun { place, content });
            }
        }
    }
    // Chunks are zero unless a run says otherwise.
    runs.retain(|run| run.content != RunContent::Fill(0));
    runs
}

/// Merges the runs of both sides into a packed chunk of `length` bytes; everything else, including the seam, is zero.
/// `None` if all of it is.
fn merge_runs(left: &[ByteRun], right: &[ByteRun], length: usize) -> Option<Vec<u8>> {
    if left.is_empty() && right.is_empty() {
        return None;
    }
    let mut all: Vec<&ByteRun> = left.iter().chain(right).collect();
    // Both lists are ascending, so that this stable sort only merges.
    all.sort_by_key(|run| run.place.start);
    Some(zarr_append_checksum(encode_zstd_runs(all, length)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_make_up_the_image_between_them() {
        use Side::{Left, Neither, Right};
        let sides = [Left, Left, Neither, Right, Right, Left, Neither, Right];
        let values = [0u8, 3, 0, 0, 5, 7, 0, 7];
        let of = |own| {
            let own = (0..8).filter(move |pixel: &usize| sides[*pixel] == own);
            collect_runs(own.map(|pixel| (pixel, pixel)), |pixel| [values[pixel]])
        };
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
