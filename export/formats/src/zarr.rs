//! Zarr version 3 arrays of many equal samples, with the sharding codec.
//!
//! A shard is one file with many samples, each in chunks that are compressed separately, so that each can be read
//! alone. Each chunk is followed by a checksum, and so is the index.
//!
//! A shard ends with an index of the chunks' positions. Equal chunks can share a position: data stitched from few parts
//! then takes little more room than the parts, and every reader still sees whole samples.
//!
//! Specifications: "Zarr core specification, version 3" and "Sharding codec, version 1.0" (zarr-specs). Everything here
//! makes bytes; the caller decides where they are stored.

mod checksum;
mod metadata;
mod packing;

use serde_json::{Value, json};

pub use checksum::zarr_checksum;
pub use metadata::InvalidMetadata;
pub use packing::{
    DamagedChunk, zarr_append_checksum, zarr_max_packed_size, zarr_pack, zarr_unpack,
};

use crate::{ExportError, json_bytes};

/// Index entry, offset and length, of a chunk that is not stored: it reads as zeros.
const ABSENT: u64 = u64::MAX;

/// Type of an array's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZarrType {
    /// 32-bit floating-point numbers.
    F32,
    /// 16-bit unsigned integers.
    U16,
    /// 8-bit unsigned integers.
    U8,
}

impl ZarrType {
    fn word(self) -> &'static str {
        match self {
            Self::F32 => "float32",
            Self::U16 => "uint16",
            Self::U8 => "uint8",
        }
    }

    /// Number of bytes of one value.
    pub fn size(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::U16 => 2,
            Self::U8 => 1,
        }
    }
}

/// An array whose first axis counts samples. A shard is a file of several samples.
///
/// ```
/// use fabkit_export::{ZarrArray, ZarrType};
/// use serde_json::json;
///
/// let depth = ZarrArray {
///     element: ZarrType::F32,
///     samples: 10,
///     sample_shape: vec![480, 640],
///     chunk_shape: vec![240, 200],
///     samples_per_shard: 4,
///     dimensions: ["sample", "row", "column"].map(String::from).to_vec(),
///     attributes: json!({ "unit": "mm" }),
/// };
/// // Two chunks down and four across, the last ones reaching beyond; three files, the last of two samples.
/// assert_eq!(depth.chunks_per_sample(), 8);
/// assert_eq!((depth.shards(), depth.samples_in_shard(2)), (3, 8..10));
/// assert_eq!(depth.shard_path(2), "c/2/0/0");
/// assert_eq!(ZarrArray::from_metadata(&depth.metadata()?)?, depth);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ZarrArray {
    /// Type of the values.
    pub element: ZarrType,
    /// Number of samples.
    pub samples: u64,
    /// Shape of one sample, the slowest axis first; empty for a single value.
    pub sample_shape: Vec<u64>,
    /// Shape of one chunk of a sample, at least 1 each; the last chunks may extend beyond the sample.
    pub chunk_shape: Vec<u64>,
    /// Number of samples in one file, at least 1.
    pub samples_per_shard: u64,
    /// Names of all axes, beginning with the sample axis.
    pub dimensions: Vec<String>,
    /// Attributes for people and programs, such as units and frames.
    pub attributes: Value,
}

impl ZarrArray {
    /// Writes the content of the array's `zarr.json`.
    ///
    /// # Errors
    /// Attributes that are not JSON.
    pub fn metadata(&self) -> Result<Vec<u8>, ExportError> {
        json_bytes(&self.document())
    }

    /// Returns the metadata document.
    fn document(&self) -> Value {
        let axes = |count: u64, of_sample: &[u64]| [&[count], of_sample].concat();
        // A shard covers whole chunks, also where the last ones extend beyond the sample.
        let whole: Vec<u64> = self
            .chunk_shape
            .iter()
            .zip(self.chunks_along())
            .map(|(px, count)| px * count)
            .collect();
        let little = json!({ "name": "bytes", "configuration": { "endian": "little" } });
        json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": axes(self.samples, &self.sample_shape),
            "data_type": self.element.word(),
            "chunk_grid": {
                "name": "regular",
                "configuration": { "chunk_shape": axes(self.samples_per_shard, &whole) },
            },
            "chunk_key_encoding": { "name": "default", "configuration": { "separator": "/" } },
            "fill_value": if self.element == ZarrType::F32 { json!(0.0) } else { json!(0) },
            "codecs": [{
                "name": "sharding_indexed",
                "configuration": {
                    "chunk_shape": axes(1, &self.chunk_shape),
                    "codecs": [
                        little,
                        {
                            "name": "zstd",
                            "configuration": { "level": packing::ZSTD_LEVEL, "checksum": false },
                        },
                        { "name": "crc32c" },
                    ],
                    "index_codecs": [little, { "name": "crc32c" }],
                    "index_location": "end",
                },
            }],
            "dimension_names": self.dimensions,
            "attributes": self.attributes,
        })
    }

    /// Number of bytes at one position of the first two axes of a sample.
    pub fn pixel_bytes(&self) -> usize {
        self.element.size() * self.sample_shape.iter().skip(2).product::<u64>() as usize
    }

    /// Number of files that hold the samples.
    pub fn shards(&self) -> u64 {
        self.samples.div_ceil(self.samples_per_shard)
    }

    /// Returns the samples of a shard.
    pub fn samples_in_shard(&self, shard: u64) -> std::ops::Range<u64> {
        let first = shard * self.samples_per_shard;
        first..(first + self.samples_per_shard).min(self.samples)
    }

    /// Returns the path of a shard below the array's folder.
    pub fn shard_path(&self, shard: u64) -> String {
        let rest = "/0".repeat(self.sample_shape.len());
        format!("c/{shard}{rest}")
    }

    /// Number of chunks of a sample.
    pub fn chunks_per_sample(&self) -> u64 {
        self.chunks_along().product()
    }

    /// Number of chunks along each axis of a sample.
    fn chunks_along(&self) -> impl Iterator<Item = u64> {
        self.sample_shape.iter().zip(&self.chunk_shape).map(|(axis, chunk)| axis.div_ceil(*chunk))
    }

    /// Assembles a file from samples, each packed whole by [`zarr_pack`], in order.
    pub fn shard(&self, packed: &[Vec<u8>]) -> Vec<u8> {
        let mut shard = Shard::default();
        for sample in packed {
            let chunk = shard.store(sample);
            shard.assign(Some(chunk));
        }
        shard.finish(self)
    }
}

/// A shard that is being written.
///
/// ```
/// use fabkit_export::{Shard, ZarrArray, ZarrType, zarr_pack};
///
/// let mask = ZarrArray {
///     element: ZarrType::U8,
///     samples: 3,
///     sample_shape: vec![2, 2],
///     chunk_shape: vec![2, 2],
///     samples_per_shard: 3,
///     dimensions: ["sample", "row", "column"].map(String::from).to_vec(),
///     attributes: serde_json::Value::Null,
/// };
/// let packed = zarr_pack(&[255; 4])?;
/// let mut shard = Shard::default();
/// let white = shard.store(&packed);
/// [Some(white), None, Some(white)].into_iter().for_each(|chunk| shard.assign(chunk));
/// // The chunk is stored once; the index has 16 bytes for each of three samples, and a checksum.
/// assert_eq!(shard.finish(&mask).len(), packed.len() + 3 * 16 + 4);
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Shard {
    bytes: Vec<u8>,
    index: Vec<u8>,
}

/// Position of a chunk in a [`Shard`].
#[derive(Clone, Copy, Debug)]
pub struct StoredChunk {
    offset: u64,
    length: u64,
}

impl Shard {
    /// Stores a chunk packed by [`zarr_pack`], without assigning it to a sample yet.
    pub fn store(&mut self, packed: &[u8]) -> StoredChunk {
        let offset = self.bytes.len() as u64;
        self.bytes.extend_from_slice(packed);
        StoredChunk { offset, length: packed.len() as u64 }
    }

    /// Assigns the next chunk: first those of the first sample row by row, then those of the second, and so on. `None`
    /// stands for zeros.
    pub fn assign(&mut self, chunk: Option<StoredChunk>) {
        let (offset, length) = chunk.map_or((ABSENT, ABSENT), |c| (c.offset, c.length));
        self.index.extend(offset.to_le_bytes());
        self.index.extend(length.to_le_bytes());
    }

    /// Completes the file. Chunks that were not assigned are zeros.
    pub fn finish(mut self, array: &ZarrArray) -> Vec<u8> {
        let entries = array.samples_per_shard * array.chunks_per_sample();
        self.index.resize(16 * entries as usize, u8::MAX);
        let checksum = zarr_checksum(&self.index);
        self.bytes.extend(self.index);
        self.bytes.extend(checksum.to_le_bytes());
        self.bytes
    }
}

/// Writes the content of a group's `zarr.json`.
///
/// # Errors
/// Attributes that are not JSON.
///
/// ```
/// let bytes = fabkit_export::zarr_group(&serde_json::json!({ "sensor": "rtac0" }))?;
/// let json: serde_json::Value = serde_json::from_slice(&bytes)?;
/// assert_eq!(json["zarr_format"], 3);
/// assert_eq!(json["node_type"], "group");
/// assert_eq!(json["attributes"]["sensor"], "rtac0");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn zarr_group(attributes: &Value) -> Result<Vec<u8>, ExportError> {
    json_bytes(&json!({ "zarr_format": 3, "node_type": "group", "attributes": attributes }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array() -> ZarrArray {
        ZarrArray {
            element: ZarrType::U16,
            samples: 5,
            sample_shape: vec![2, 3],
            chunk_shape: vec![2, 3],
            samples_per_shard: 2,
            dimensions: ["half", "row", "column"].map(String::from).to_vec(),
            attributes: json!({ "unit": "mm" }),
        }
    }

    #[test]
    fn a_shard_gives_every_sample_back() {
        let array = array();
        let samples: Vec<Vec<u8>> = (0..2u8).map(|i| (i..i + 12).collect()).collect();
        let packed: Vec<Vec<u8>> =
            samples.iter().map(|sample| zarr_pack(sample).unwrap()).collect();
        let bytes = array.shard(&packed);
        let index = &bytes[bytes.len() - 2 * 16 - 4..];
        assert_eq!(zarr_checksum(&index[..32]).to_le_bytes(), index[32..]);
        let number = |i: usize| u64::from_le_bytes(index[8 * i..8 * i + 8].try_into().unwrap());
        for (i, sample) in samples.iter().enumerate() {
            let (from, length) = (number(2 * i) as usize, number(2 * i + 1) as usize);
            assert_eq!(&zarr_unpack(&bytes[from..from + length], 12).unwrap(), sample);
        }
        // The last shard is not full.
        assert_eq!((array.shards(), array.samples_in_shard(2)), (3, 4..5));
        let last = array.shard(&packed[..1]);
        let index = &last[last.len() - 36..last.len() - 4];
        assert!(index[16..].iter().all(|byte| *byte == 0xff));
        assert_eq!(array.shard_path(2), "c/2/0/0");
    }

    #[test]
    fn equal_chunks_lie_at_one_place_and_absent_ones_nowhere() {
        // Chunks of 2 x 2 of samples of 2 x 3: the second one reaches beyond.
        let array = ZarrArray { chunk_shape: vec![2, 2], ..array() };
        assert_eq!(array.chunks_per_sample(), 2);
        let mut shard = Shard::default();
        let [left, right] = [7u8, 9].map(|byte| shard.store(&zarr_pack(&[byte; 8]).unwrap()));
        for chunk in [Some(left), Some(right), Some(left), None] {
            shard.assign(chunk);
        }
        let bytes = shard.finish(&array);
        let index = &bytes[bytes.len() - 4 * 16 - 4..bytes.len() - 4];
        assert_eq!(index[..16], index[32..48]);
        assert_ne!(index[..16], index[16..32]);
        assert_eq!(index[48..], [u8::MAX; 16]);
        assert_eq!(u64::from_le_bytes(index[16..24].try_into().unwrap()), left.length);
        let metadata: Value = serde_json::from_slice(&array.metadata().unwrap()).unwrap();
        assert_eq!(metadata["chunk_grid"]["configuration"]["chunk_shape"], json!([2, 2, 4]));
        assert_eq!(metadata["codecs"][0]["configuration"]["chunk_shape"], json!([1, 2, 2]));
    }

    #[test]
    fn the_metadata_name_shapes_types_and_codecs() {
        let metadata: Value = serde_json::from_slice(&array().metadata().unwrap()).unwrap();
        assert_eq!(metadata["shape"], json!([5, 2, 3]));
        assert_eq!(metadata["chunk_grid"]["configuration"]["chunk_shape"], json!([2, 2, 3]));
        assert_eq!(metadata["codecs"][0]["configuration"]["chunk_shape"], json!([1, 2, 3]));
        assert_eq!(metadata["data_type"], "uint16");
    }
}
