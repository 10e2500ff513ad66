//! Packing of one chunk: compression, followed by a checksum of the compressed bytes.
//!
//! The checksum covers the frame's own header too, so that a flipped bit anywhere in a chunk is detected, whether or
//! not it would change a value.

use super::checksum::zarr_checksum;
use crate::ExportError;

/// Zstandard level. On depth maps, higher levels save a few percent and take several times as long.
pub(super) const ZSTD_LEVEL: i32 = 1;
const CHECKSUM_BYTES: usize = 4;

/// Compresses one sample's little-endian bytes and appends the checksum.
///
/// # Errors
/// Errors of the compressor.
///
/// ```
/// use fabkit_export::{zarr_pack, zarr_unpack};
///
/// let sample = [7u8; 1000];
/// let packed = zarr_pack(&sample)?;
/// assert!(packed.len() < 50);
/// assert_eq!(zarr_unpack(&packed, 1000)?, sample);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn zarr_pack(sample: &[u8]) -> Result<Vec<u8>, ExportError> {
    Ok(zarr_append_checksum(zstd::bulk::compress(sample, ZSTD_LEVEL)?))
}

/// Appends the checksum to a Zstandard frame, as [`zarr_pack`] does.
pub fn zarr_append_checksum(mut frame: Vec<u8>) -> Vec<u8> {
    let checksum = zarr_checksum(&frame);
    frame.extend(checksum.to_le_bytes());
    frame
}

/// Upper bound of a packed chunk's size for `bytes` bytes: incompressible data is stored in blocks with headers.
///
/// ```
/// use fabkit_export::{zarr_max_packed_size, zarr_pack};
///
/// // Even of nothing, a frame and its checksum remain.
/// let packed = zarr_pack(&[])?;
/// assert!(!packed.is_empty() && packed.len() as u64 <= zarr_max_packed_size(0));
/// assert_eq!(zarr_max_packed_size(64_000), 66_024);
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
pub fn zarr_max_packed_size(bytes: usize) -> u64 {
    bytes as u64 + bytes as u64 / 64 + 1024
}

/// Reasons why a chunk is damaged.
///
/// ```
/// use fabkit_export::{DamagedChunk, zarr_pack, zarr_unpack};
///
/// let mut packed = zarr_pack(&[1, 2, 3, 4])?;
/// let length = DamagedChunk::Length { found: 4, expected: 5 };
/// assert_eq!(zarr_unpack(&packed, 5), Err(length));
/// packed[6] ^= 1;
/// assert_eq!(zarr_unpack(&packed, 4), Err(DamagedChunk::Checksum));
/// # Ok::<(), fabkit_export::ExportError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DamagedChunk {
    /// Checksum that does not match.
    #[error("its bytes do not match their checksum")]
    Checksum,
    /// Length that does not match.
    #[error("it holds {found} bytes, not {expected}")]
    Length {
        /// Number of bytes after unpacking.
        found: usize,
        /// Expected number of bytes.
        expected: usize,
    },
    /// Invalid compressed data.
    #[error("it cannot be unpacked: {0}")]
    Frame(String),
}

/// Unpacks a chunk packed by [`zarr_pack`] to exactly `bytes` bytes.
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
