//! Reading of single samples of an array in a data set.
//!
//! Nothing stays open or running between reads, so that forked training processes can read side by side. It reads the
//! part of Zarr version 3 that fabkit writes: regular chunks with the sharding codec, little-endian values, Zstandard,
//! checksums. Sizes are checked before they are used in computations.

use std::io;
use std::path::{Path, PathBuf};

use fabkit_export::{ZarrArray, ZarrType};
use fabkit_files::reading::{self, ReadError};
use fabkit_files::resumable::{ResumableFolderError, read_regular};
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use rayon::prelude::*;

use super::shard_file::{ReadFault, ShardFile};

/// Largest `zarr.json` of an array, bytes.
pub(super) const MAX_METADATA_BYTES: u64 = 1 << 20;

/// Reason why a sample cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum SampleError {
    /// The operating system reported an error.
    #[error(transparent)]
    Io(#[from] ReadError),
    /// There is no data set.
    #[error("cannot read {}: there is no such file", .path.display())]
    NoDataset {
        /// Path of its `dataset.json`.
        path: PathBuf,
        /// True if a data set was begun there.
        is_begun: bool,
    },
    /// Metadata are not fabkit's, or do not belong to this data set.
    #[error("{}: {what}", .path.display())]
    ForeignMetadata {
        /// File concerned.
        path: PathBuf,
        /// Description of the problem.
        what: String,
    },
    /// A file was damaged after it was written.
    #[error("{} is damaged: {what}", .path.display())]
    Damaged {
        /// File concerned.
        path: PathBuf,
        /// Description of the damage, with the chunk.
        what: String,
    },
    /// A document or a file is not what was written.
    #[error(transparent)]
    Folder(#[from] ResumableFolderError),
    /// The index is beyond the last sample.
    #[error("there is no sample {index}; the array has {samples}")]
    OutOfRange {
        /// Index that was requested.
        index: usize,
        /// Number of samples.
        samples: usize,
    },
}

impl Explained for SampleError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Folder(error) => error.kind(),
            Self::Io(_) | Self::NoDataset { .. } | Self::Damaged { .. } => ErrorKind::Io,
            Self::ForeignMetadata { .. } | Self::OutOfRange { .. } => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Folder(error) => return error.hint(),
            Self::Io(_) | Self::OutOfRange { .. } => return None,
            Self::NoDataset { is_begun: true, .. } => {
                "it is not finished: go on with what began it"
            }
            Self::NoDataset { .. } => "is it the right folder? It holds no data set",
            Self::Damaged { .. } => "delete that file, and go on with what wrote it",
            Self::ForeignMetadata { .. } => "read it with the Python package `zarr`",
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Folder(error) => error.subject(),
            Self::NoDataset { .. } => ErrorSubject::new("no_dataset"),
            Self::Damaged { .. } => ErrorSubject::new("damaged"),
            Self::OutOfRange { .. } => ErrorSubject::new("out_of_range"),
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}

/// Array whose first axis counts samples.
#[derive(Clone, Debug)]
pub struct SampleArray {
    folder: PathBuf,
    array: ZarrArray,
    shape: Vec<usize>,
    /// Shapes of the part that one file holds, and of the chunks that it consists of.
    shard: Vec<usize>,
    chunk: Vec<usize>,
}

impl SampleArray {
    /// Reads an array's metadata from its folder. [`DatasetReader`](super::DatasetReader) also compares them with the
    /// data set that the array belongs to.
    ///
    /// # Errors
    /// Fails without a `zarr.json`, or for one that fabkit has not written.
    pub fn open(folder: &Path) -> Result<Self, SampleError> {
        let path = folder.join("zarr.json");
        let bytes = read_regular(&path, MAX_METADATA_BYTES)?;
        let source = || io::Error::from(io::ErrorKind::NotFound);
        let absent = || ReadError::Io { path: path.clone(), source: source() };
        let bytes = bytes.ok_or_else(absent)?;
        Self::from_metadata(folder, &bytes)
    }

    /// Creates the array from the content of its `zarr.json`.
    pub(super) fn from_metadata(folder: &Path, bytes: &[u8]) -> Result<Self, SampleError> {
        let array = ZarrArray::from_metadata(bytes).map_err(|error| {
            let path = folder.join("zarr.json");
            SampleError::ForeignMetadata { path, what: error.to_string() }
        })?;
        Ok(Self::new(folder, array))
    }

    /// Creates an array of known shape.
    pub(super) fn new(folder: &Path, array: ZarrArray) -> Self {
        let axes = |count: u64, of_sample: &[u64]| -> Vec<usize> {
            [&[count], of_sample].concat().into_iter().map(|size| size as usize).collect()
        };
        let along = array.sample_shape.iter().zip(&array.chunk_shape);
        // Chunks at the border are stored whole, beyond the end of the array.
        let whole: Vec<u64> = along.map(|(size, chunk)| size.div_ceil(*chunk) * chunk).collect();
        let shape = axes(array.samples, &array.sample_shape);
        let shard = axes(array.samples_per_shard, &whole);
        let chunk = axes(1, &array.chunk_shape);
        Self { folder: folder.into(), array, shape, shard, chunk }
    }

    /// Lengths of the axes, the samples' first.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// Type of the values.
    pub fn element(&self) -> ZarrType {
        self.array.element
    }

    pub(super) fn array(&self) -> &ZarrArray {
        &self.array
    }

    /// Reads a sample's values, little-endian, the last axis fastest. Chunks that are not in the index are zero.
    ///
    /// # Errors
    /// Fails for an index beyond the last, or a file that is missing or damaged where this sample lies.
    pub fn sample(&self, index: usize) -> Result<Vec<u8>, SampleError> {
        let samples = self.shape[0];
        if index >= samples {
            return Err(SampleError::OutOfRange { index, samples });
        }
        let size = self.element().size();
        let path = self.folder.join(self.array.shard_path((index / self.shard[0]) as u64));
        let fault = |fault| match fault {
            ReadFault::Io(source) => ReadError::Io { path: path.clone(), source }.into(),
            ReadFault::Damaged(what) => SampleError::Damaged { path: path.clone(), what },
        };
        let mut file = self.shard_file(&path).map_err(fault)?;
        let mut bytes = vec![0; self.shape[1..].iter().product::<usize>() * size];
        let grid: Vec<usize> =
            self.shard[1..].iter().zip(&self.chunk[1..]).map(|(all, one)| all / one).collect();
        let chunks: usize = grid.iter().product();
        let chunk_bytes = self.chunk.iter().product::<usize>() * size;
        // Chunks of a shard are numbered sample by sample.
        let first = index % self.shard[0] * chunks;
        for (place, number) in grid_positions(&grid).zip(first..) {
            if let Some(values) = file.chunk(number, chunk_bytes).map_err(fault)? {
                let start = place.iter().zip(&self.chunk[1..]).map(|(i, chunk)| i * chunk);
                self.copy(&values, &start.collect::<Vec<_>>(), &mut bytes);
            }
        }
        Ok(bytes)
    }

    /// Opens a shard's file, which a complete data set always has, even if all its values are zero.
    fn shard_file(&self, path: &Path) -> Result<ShardFile<reading::File>, ReadFault> {
        match reading::open(path) {
            Ok((file, length)) => ShardFile::open(file, length, &self.array),
            Err(ReadError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                Err(ReadFault::Damaged("it is missing".into()))
            }
            Err(ReadError::Io { source, .. }) => Err(source.into()),
            Err(_) => Err(ReadFault::Damaged("it is not a file".into())),
        }
    }

    /// Checks all files: returns the name of each damaged one, relative to the array's folder, with its first damaged
    /// chunk.
    pub(super) fn damaged_chunks(&self) -> Vec<(String, String)> {
        let look = |shard: u64| {
            let name = self.array.shard_path(shard);
            let file = self.shard_file(&self.folder.join(&name));
            let fault = file.and_then(|mut file| file.check(&self.array, shard)).err()?;
            Some((name, fault.to_string()))
        };
        (0..self.array.shards()).into_par_iter().filter_map(look).collect()
    }

    /// Copies a chunk's part of a sample, line by line; chunks may reach beyond the array.
    fn copy(&self, values: &[u8], start: &[usize], sample: &mut [u8]) {
        let size = self.element().size();
        let (shape, chunk) = (&self.shape[1..], &self.chunk[1..]);
        let Some((&last, rest)) = chunk.split_last() else {
            sample.copy_from_slice(&values[..size]);
            return;
        };
        let axis = rest.len();
        // The last chunk along an axis may reach beyond it.
        let length = last.min(shape[axis] - start[axis]) * size;
        let (to, from) = (strides(shape), strides(chunk));
        for line in grid_positions(rest) {
            let inside = line.iter().zip(start).zip(shape).all(|((i, s), n)| s + i < *n);
            if inside {
                let from: usize = line.iter().zip(&from).map(|(i, stride)| i * stride).sum();
                let to: usize =
                    line.iter().zip(start).zip(&to).map(|((i, s), stride)| (i + s) * stride).sum();
                let (from, to) = (from * size, (to + start[axis]) * size);
                sample[to..to + length].copy_from_slice(&values[from..from + length]);
            }
        }
    }
}

/// Returns the number of values that one step along each axis skips.
fn strides(counts: &[usize]) -> Vec<usize> {
    (1..=counts.len()).map(|axis| counts[axis..].iter().product()).collect()
}

/// Lists all positions of a grid, the last axis fastest.
fn grid_positions(counts: &[usize]) -> impl Iterator<Item = Vec<usize>> + use<'_> {
    let strides = strides(counts);
    (0..counts.iter().product()).map(move |i: usize| {
        counts.iter().zip(&strides).map(|(count, stride)| i / stride % count).collect()
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use fabkit_export::{zarr_checksum, zarr_pack};
    use serde_json::json;

    use super::*;

    #[test]
    fn what_was_written_is_read_back_sample_by_sample() {
        let array = ZarrArray {
            element: ZarrType::U16,
            samples: 5,
            sample_shape: vec![2, 3],
            chunk_shape: vec![2, 3],
            samples_per_shard: 2,
            dimensions: ["sample", "row", "column"].map(String::from).to_vec(),
            attributes: json!({}),
        };
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("zarr.json"), array.metadata().unwrap()).unwrap();
        let sample = |i: u8| (0..12).map(|k| 20 * i + k).collect::<Vec<u8>>();
        for shard in 0..3 {
            let packed =
                array.samples_in_shard(shard).map(|i| zarr_pack(&sample(i as u8)).unwrap());
            let path = folder.path().join(array.shard_path(shard));
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, array.shard(&packed.collect::<Vec<_>>())).unwrap();
        }
        let read = SampleArray::open(folder.path()).unwrap();
        assert_eq!((read.shape(), read.element()), (&[5, 2, 3][..], ZarrType::U16));
        for i in 0..5 {
            assert_eq!(read.sample(i).unwrap(), sample(i as u8), "sample {i}");
        }
        assert!(matches!(read.sample(5), Err(SampleError::OutOfRange { samples: 5, .. })));
        // One flipped bit, wherever it is, is noticed by those samples whose chunk it is in; in the
        // index, by all of them. So is every byte that is missing.
        let path = folder.path().join(array.shard_path(0));
        let whole = fs::read(&path).unwrap();
        let is_damaged = |i| matches!(read.sample(i), Err(SampleError::Damaged { .. }));
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, bytes).unwrap();
            assert!(is_damaged(0) || is_damaged(1), "bit {bit}");
        }
        for length in 0..whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(is_damaged(0) && is_damaged(1), "{length} bytes");
        }
        fs::remove_file(&path).unwrap();
        assert!(is_damaged(0));
        fs::create_dir(&path).unwrap();
        assert!(is_damaged(0));
    }

    #[test]
    fn chunks_that_split_a_sample_are_joined() {
        // 3 x 5 values of a byte in chunks of 2 x 2, which reach beyond the array.
        let folder = tempfile::tempdir().unwrap();
        let (shape, chunk) = ([2, 3, 5], [1, 2, 2]);
        let array = ZarrArray {
            element: ZarrType::U8,
            samples: shape[0],
            sample_shape: shape[1..].into(),
            chunk_shape: chunk[1..].into(),
            samples_per_shard: 2,
            dimensions: Vec::new(),
            attributes: json!({}),
        };
        let array = SampleArray::new(folder.path(), array);
        let value = |s: usize, r: usize, c: usize| (100 * s + 10 * r + c) as u8;
        let (mut bytes, mut index) = (Vec::new(), Vec::new());
        for place in grid_positions(&[2, 2, 3]) {
            let values = grid_positions(&[2, 2])
                .map(|at| value(place[0], 2 * place[1] + at[0], 2 * place[2] + at[1]));
            let packed = zarr_pack(&values.collect::<Vec<u8>>()).unwrap();
            index.extend((bytes.len() as u64).to_le_bytes());
            index.extend((packed.len() as u64).to_le_bytes());
            bytes.extend(packed);
        }
        let checksum = zarr_checksum(&index).to_le_bytes();
        bytes.extend(index);
        bytes.extend(checksum);
        fs::create_dir_all(folder.path().join("c/0/0")).unwrap();
        fs::write(folder.path().join("c/0/0/0"), bytes).unwrap();
        for s in 0..2 {
            let expected: Vec<u8> =
                grid_positions(&[3, 5]).map(|at| value(s, at[0], at[1])).collect();
            assert_eq!(array.sample(s).unwrap(), expected);
        }
    }
}
