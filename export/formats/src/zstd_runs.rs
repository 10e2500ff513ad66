//! Images as runs of equal bytes, and their Zstandard frames without a search for matches.
//!
//! Stitched training targets are large and mostly of one value; searching each for repetitions costs far more than
//! writing it. Where the uniform runs are known, a frame (RFC 8878, section 3.1.1) can be assembled from run-length and
//! raw blocks alone. Any decompressor reads it.

use std::ops::Range;

/// A run of an image's bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ByteRun {
    /// Byte range in the image.
    pub place: Range<usize>,
    /// Content of the range.
    pub content: RunContent,
}

/// Content of a [`ByteRun`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunContent {
    /// The same byte throughout.
    Fill(u8),
    /// Arbitrary bytes.
    Bytes(Vec<u8>),
}

/// Shortest fill that becomes a run-length block; shorter ones join raw blocks. A block costs three bytes, and a run
/// one more.
const LEAST_FILL: usize = 16;
/// Largest block, RFC 8878, section 3.1.1.2.4.
const MAX_BLOCK: usize = 128 << 10;

const RAW: u32 = 0;
const RUN_LENGTH: u32 = 1;

/// Assembles a frame of `length` bytes from runs in ascending order; bytes outside of them are zero.
///
/// # Panics
/// If runs overlap or reach beyond the end.
///
/// ```
/// use fabkit_export::{ByteRun, RunContent, encode_zstd_runs, zarr_append_checksum, zarr_unpack};
///
/// let runs = [
///     ByteRun { place: 1..3, content: RunContent::Fill(9) },
///     ByteRun { place: 5..7, content: RunContent::Bytes(vec![1, 2]) },
/// ];
/// let frame = encode_zstd_runs(&runs, 8);
/// assert_eq!(zarr_unpack(&zarr_append_checksum(frame), 8)?, [0, 9, 9, 0, 0, 1, 2, 0]);
/// // A large image of one value takes a few blocks.
/// let sky = ByteRun { place: 0..1_000_000, content: RunContent::Fill(200) };
/// assert!(encode_zstd_runs([&sky], 1_000_000).len() < 60);
/// # Ok::<(), fabkit_export::DamagedChunk>(())
/// ```
pub fn encode_zstd_runs<'a>(runs: impl IntoIterator<Item = &'a ByteRun>, length: usize) -> Vec<u8> {
    let mut frame = Frame::default();
    for run in runs {
        assert!(run.place.start >= frame.length && run.place.end <= length, "runs are in order");
        frame.fill(0, run.place.start - frame.length);
        frame.length = run.place.end;
        match &run.content {
            RunContent::Fill(byte) => frame.fill(*byte, run.place.len()),
            RunContent::Bytes(bytes) => frame.raw(bytes),
        }
    }
    frame.fill(0, length - frame.length);
    frame.length = length;
    frame.finish()
}

/// A Zstandard frame under construction.
#[derive(Default)]
struct Frame {
    blocks: Vec<u8>,
    /// Position of the last block's header.
    last_header: usize,
    length: usize,
    raw: Vec<u8>,
    /// A fill that may still grow: byte and count.
    fill: (u8, usize),
}

impl Frame {
    fn fill(&mut self, byte: u8, count: usize) {
        if count == 0 {
            return;
        }
        if self.fill.0 != byte {
            self.end_fill();
            self.fill.0 = byte;
        }
        self.fill.1 += count;
    }

    fn raw(&mut self, bytes: &[u8]) {
        self.end_fill();
        self.raw.extend_from_slice(bytes);
    }

    /// Ends a fill: a short one joins the raw bytes before it, a long one becomes blocks.
    fn end_fill(&mut self) {
        let (byte, mut count) = self.fill;
        self.fill.1 = 0;
        if count < LEAST_FILL {
            self.raw.extend(std::iter::repeat_n(byte, count));
            return;
        }
        self.end_raw();
        while count > 0 {
            let size = count.min(MAX_BLOCK);
            self.block(RUN_LENGTH, size, &[byte]);
            count -= size;
        }
    }

    fn end_raw(&mut self) {
        let raw = std::mem::take(&mut self.raw);
        for part in raw.chunks(MAX_BLOCK) {
            self.block(RAW, part.len(), part);
        }
    }

    /// Writes a block. Its header (section 3.1.1.2) has the last-block flag in bit 0, two bits of type and 21 bits of
    /// size.
    fn block(&mut self, kind: u32, size: usize, content: &[u8]) {
        self.last_header = self.blocks.len();
        let header = kind << 1 | (size as u32) << 3;
        self.blocks.extend(&header.to_le_bytes()[..3]);
        self.blocks.extend(content);
    }

    /// Completes the frame; even an empty one needs a block.
    fn finish(mut self) -> Vec<u8> {
        self.end_fill();
        self.end_raw();
        if self.blocks.is_empty() {
            self.block(RAW, 0, &[]);
        }
        self.blocks[self.last_header] |= 1;
        // Section 3.1.1.1: magic number; descriptor with an 8-byte content size and a single segment; content size.
        let mut bytes = vec![0x28, 0xb5, 0x2f, 0xfd, 0b1110_0000];
        bytes.extend((self.length as u64).to_le_bytes());
        bytes.extend(self.blocks);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frame(contents: &[RunContent], lengths: &[usize]) -> (Vec<u8>, Vec<u8>) {
        let (mut runs, mut plain) = (Vec::new(), Vec::new());
        for (content, length) in contents.iter().zip(lengths) {
            let start = plain.len();
            match content {
                RunContent::Fill(byte) => plain.extend(std::iter::repeat_n(*byte, *length)),
                RunContent::Bytes(bytes) => plain.extend(bytes),
            }
            runs.push(ByteRun { place: start..plain.len(), content: content.clone() });
        }
        // Zeros need not be named.
        runs.retain(|run| run.content != RunContent::Fill(0));
        (encode_zstd_runs(&runs, plain.len()), plain)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..Default::default() })]
        #[test]
        fn the_real_decompressor_reads_it(
            runs in prop::collection::vec((any::<bool>(), 0u8..3, prop::sample::select(
                vec![0usize, 1, 7, 15, 16, 17, 1000, 131_071, 131_072, 131_073, 400_000])), 0..8)
        ) {
            let lengths: Vec<usize> = runs.iter().map(|run| run.2).collect();
            let content = |(fill, byte, length): &(bool, u8, usize)| {
                if *fill {
                    RunContent::Fill(*byte)
                } else {
                    RunContent::Bytes((0..*length).map(|i| (i * i / 7) as u8).collect())
                }
            };
            let contents: Vec<RunContent> = runs.iter().map(content).collect();
            let (packed, plain) = frame(&contents, &lengths);
            prop_assert!(zstd::bulk::decompress(&packed, plain.len()).unwrap() == plain);
        }
    }

    #[test]
    fn one_value_takes_a_few_bytes() {
        let (packed, plain) = frame(&[RunContent::Fill(0)], &[1_228_800]);
        assert_eq!(plain.len(), 1_228_800);
        assert!(packed.len() < 64, "{}", packed.len());
    }
}
