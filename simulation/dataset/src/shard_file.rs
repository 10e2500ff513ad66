//! File of an array: chunks, and an index of their positions. Nothing without a valid checksum is used, and nothing
//! beyond the file is read.

use std::fmt;
use std::io::{self, Cursor, Read, Seek, SeekFrom};

use fabkit_export::{DamagedChunk, ZarrArray, zarr_checksum, zarr_max_packed_size, zarr_unpack};

/// Offset and length of a chunk in the index that is all zeros.
const ABSENT: u64 = u64::MAX;
const ENTRY_BYTES: u64 = 16;
const CHECKSUM_BYTES: u64 = 4;

/// Reason why values cannot be read.
pub(super) enum ReadFault {
    /// The operating system reported an error.
    Io(io::Error),
    /// The file is damaged, with a description.
    Damaged(String),
}

impl fmt::Display for ReadFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io(error) => error.fmt(f),
            Self::Damaged(what) => what.fmt(f),
        }
    }
}

impl From<io::Error> for ReadFault {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Open file with its index.
pub(super) struct ShardFile<F> {
    file: F,
    index: Vec<(u64, u64)>,
    /// Position where the chunks end and the index begins.
    end: u64,
}

impl<F: Read + Seek> ShardFile<F> {
    /// Reads the index of a file of `length` bytes.
    pub(super) fn open(mut file: F, length: u64, array: &ZarrArray) -> Result<Self, ReadFault> {
        let entries = array.samples_per_shard * array.chunks_per_sample();
        let bytes = ENTRY_BYTES * entries + CHECKSUM_BYTES;
        let Some(end) = length.checked_sub(bytes) else {
            let message = format!("it has {length} bytes, less than its index of {bytes}");
            return Err(ReadFault::Damaged(message));
        };
        // The index stands at the end of the file, followed by its checksum.
        file.seek(SeekFrom::Start(end))?;
        let mut index = vec![0; bytes as usize];
        file.read_exact(&mut index)?;
        let (index, checksum) = index.split_at((bytes - CHECKSUM_BYTES) as usize);
        if zarr_checksum(index).to_le_bytes() != checksum {
            return Err(ReadFault::Damaged("its index does not match its checksum".into()));
        }
        let number = |bytes: &[u8; 8]| u64::from_le_bytes(*bytes);
        let (numbers, _) = index.as_chunks::<8>();
        let entry = |pair: &[[u8; 8]]| (number(&pair[0]), number(&pair[1]));
        Ok(Self { file, index: numbers.chunks_exact(2).map(entry).collect(), end })
    }

    /// Reads the values of a chunk of `size` bytes; `None` if they are all zero.
    pub(super) fn chunk(
        &mut self,
        number: usize,
        size: usize,
    ) -> Result<Option<Vec<u8>>, ReadFault> {
        let (offset, length) = self.index[number];
        if (offset, length) == (ABSENT, ABSENT) {
            return Ok(None);
        }
        let damaged = |what: String| {
            ReadFault::Damaged(format!(
                "chunk {number}, bytes {offset} to {}: {what}",
                offset.saturating_add(length)
            ))
        };
        // Damaged numbers must not lead out of the file, nor to a huge allocation.
        let is_inside = offset.checked_add(length).is_some_and(|end| end <= self.end);
        if !is_inside || length > zarr_max_packed_size(size) {
            return Err(damaged("it cannot lie there".into()));
        }
        self.file.seek(SeekFrom::Start(offset))?;
        let mut packed = vec![0; length as usize];
        self.file.read_exact(&mut packed)?;
        let values = zarr_unpack(&packed, size);
        values.map(Some).map_err(|error: DamagedChunk| damaged(error.to_string()))
    }
}

impl<F: Read + Seek> ShardFile<F> {
    /// Reads every chunk, one after the other, to check them.
    pub(super) fn check(&mut self, array: &ZarrArray, shard: u64) -> Result<(), ReadFault> {
        let chunk = chunk_bytes(array);
        let samples = array.samples_in_shard(shard);
        for number in 0..(samples.end - samples.start) * array.chunks_per_sample() {
            self.chunk(number as usize, chunk)?;
        }
        Ok(())
    }
}

/// Returns the size of an unpacked chunk, bytes.
pub(super) fn chunk_bytes(array: &ZarrArray) -> usize {
    array.chunk_shape.iter().product::<u64>() as usize * array.element.size()
}

/// Checks every chunk of a file that another machine made.
pub(super) fn check(array: &ZarrArray, shard: u64, bytes: &[u8]) -> Result<(), String> {
    let file = ShardFile::open(Cursor::new(bytes), bytes.len() as u64, array);
    file.and_then(|mut file| file.check(array, shard)).map_err(|fault| fault.to_string())
}
