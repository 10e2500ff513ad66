//! One chunk: compressed, and followed by a checksum of what the compression gave.
//!
//! The checksum covers the frame's own header too, so that a flipped bit anywhere in a chunk is
//! noticed, whether or not it would change a value.

use super::checksum::zarr_checksum;
use crate::ExportError;

/// Zstandard level: on depth maps, higher levels save a few percent and cost several times as long.
pub(super) const ZSTD_LEVEL: i32 = 1;
const CHECKSUM_BYTES: usize = 4;

/// Packs one sample's little-endian bytes.
///
/// # Errors
/// The compressor's own.
pub fn zarr_pack(sample: &[u8]) -> Result<Vec<u8>, ExportError> {
    Ok(zarr_sealed(zstd::bulk::compress(sample, ZSTD_LEVEL)?))
}

/// A Zstandard frame with its checksum behind it, as [`zarr_pack`] gives it.
pub fn zarr_sealed(mut frame: Vec<u8>) -> Vec<u8> {
    let checksum = zarr_checksum(&frame);
    frame.extend(checksum.to_le_bytes());
    frame
}

/// Longest chunk that `bytes` bytes are packed into: what cannot be compressed is stored in blocks
/// with headers.
pub fn zarr_most_packed(bytes: usize) -> u64 {
    bytes as u64 + bytes as u64 / 64 + 1024
}

/// What was packed is not what was written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DamagedChunk {
    /// The checksum is another.
    #[error("its bytes do not match their checksum")]
    Checksum,
    /// Not as long as it should be.
    #[error("it holds {found} bytes, not {expected}")]
    Length {
        /// As unpacked.
        found: usize,
        /// As asked for.
        expected: usize,
    },
    /// Not compressed as it should be.
    #[error("it cannot be unpacked: {0}")]
    Frame(String),
}

/// Unpacks what [`zarr_pack`] packed: exactly `bytes` bytes.
///
/// # Errors
/// [`DamagedChunk`].
pub fn zarr_unpack(packed: &[u8], bytes: usize) -> Result<Vec<u8>, DamagedChunk> {
    let (frame, checksum) = packed.split_at(packed.len().saturating_sub(CHECKSUM_BYTES));
    if zarr_checksum(frame).to_le_bytes() != checksum {
        return Err(DamagedChunk::Checksum);
    }
    let values = zstd::bulk::decompress(frame, bytes);
    let values = values.map_err(|error| DamagedChunk::Frame(error.to_string()))?;
    match values.len() {
        found if found == bytes => Ok(values),
        found => Err(DamagedChunk::Length { found, expected: bytes }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_flipped_bit_of_a_chunk_is_noticed() {
        let sample: Vec<u8> = (0..4000u32).map(|i| (i * i / 97) as u8).collect();
        let packed = zarr_pack(&sample).unwrap();
        assert_eq!(zarr_unpack(&packed, sample.len()).unwrap(), sample);
        let mut flipped = packed.clone();
        for bit in 0..8 * packed.len() {
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(zarr_unpack(&flipped, sample.len()), Err(DamagedChunk::Checksum), "{bit}");
            flipped[bit / 8] ^= 1 << (bit % 8);
        }
        for length in 0..packed.len() {
            assert!(zarr_unpack(&packed[..length], sample.len()).is_err());
        }
        assert!(matches!(zarr_unpack(&packed, 3999), Err(DamagedChunk::Frame(_))));
        let longer = zarr_unpack(&packed, 4001);
        assert_eq!(longer, Err(DamagedChunk::Length { found: 4000, expected: 4001 }));
    }
}
