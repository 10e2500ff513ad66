//! Reading one sample of an array that a data set holds.
//!
//! Nothing is kept open or running between reads, so that processes that a training forks can read
//! side by side. What is read is the part of Zarr version 3 that fabkit writes: regular chunks with
//! the sharding codec, little-endian values, Zstandard.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use fabkit_export::{Element, ExportError, zarr_checksum, zarr_unpack};
use serde_json::Value;

/// The index's mark for a chunk that is all zeros.
const ABSENT: u64 = u64::MAX;
const INDEX_ENTRY_BYTES: usize = 16;
const CHECKSUM_BYTES: usize = 4;

/// Why a sample cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system said no.
    #[error("cannot read {}: {source}", .path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Metadata that is not fabkit's.
    #[error("{}: {what} is not what fabkit writes", .path.display())]
    Foreign {
        /// Which file.
        path: PathBuf,
        /// For example `codecs`.
        what: &'static str,
    },
    /// Content that was damaged after it was written.
    #[error("{} is damaged: {what}", .path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A sample beyond the last.
    #[error("there is no sample {index}; the array has {samples}")]
    OutOfRange {
        /// As asked for.
        index: usize,
        /// How many there are.
        samples: usize,
    },
}

/// An array whose first axis counts samples.
#[derive(Clone, Debug)]
pub struct SampleArray {
    folder: PathBuf,
    element: Element,
    shape: Vec<usize>,
    /// Of the part that one file holds, and of the parts that this consists of.
    shard: Vec<usize>,
    chunk: Vec<usize>,
}

impl SampleArray {
    /// Reads what an array's folder says about it.
    ///
    /// # Errors
    /// No `zarr.json`, or one that fabkit has not written.
    pub fn open(folder: &Path) -> Result<Self, ReadError> {
        let path = folder.join("zarr.json");
        let text =
            fs::read(&path).map_err(|source| ReadError::Io { path: path.clone(), source })?;
        let json: Value = serde_json::from_slice(&text)
            .map_err(|error| ReadError::Damaged { path: path.clone(), what: error.to_string() })?;
        let foreign = |what| ReadError::Foreign { path: path.clone(), what };
        let sizes = |value: &Value| -> Option<Vec<usize>> {
            let sizes = value.as_array()?.iter().map(|size| Some(size.as_u64()? as usize));
            sizes.collect::<Option<Vec<usize>>>().filter(|sizes| !sizes.is_empty())
        };
        let element = match json["data_type"].as_str() {
            Some("float32") => Element::F32,
            Some("uint16") => Element::U16,
            Some("uint8") => Element::U8,
            _ => return Err(foreign("data_type")),
        };
        let sharding = &json["codecs"][0];
        let shape = sizes(&json["shape"]).ok_or_else(|| foreign("shape"))?;
        let shard = sizes(&json["chunk_grid"]["configuration"]["chunk_shape"]);
        let shard = shard.ok_or_else(|| foreign("chunk_grid"))?;
        let chunk = sizes(&sharding["configuration"]["chunk_shape"]);
        let chunk = chunk.ok_or_else(|| foreign("codecs"))?;
        let names = |codecs: &Value| -> Vec<String> {
            let codecs = codecs.as_array().into_iter().flatten();
            codecs.filter_map(|codec| Some(codec["name"].as_str()?.to_owned())).collect()
        };
        let known = sharding["name"] == "sharding_indexed"
            && names(&sharding["configuration"]["codecs"]) == ["bytes", "zstd"]
            && names(&sharding["configuration"]["index_codecs"]) == ["bytes", "crc32c"]
            && sharding["configuration"]["index_location"] == "end";
        let fits = shape.len() == shard.len()
            && shape.len() == chunk.len()
            && chunk.iter().zip(&shard).all(|(c, s)| *c > 0 && s.is_multiple_of(*c));
        if !known || !fits {
            return Err(foreign("codecs"));
        }
        Ok(Self { folder: folder.into(), element, shape, shard, chunk })
    }

    /// Lengths of the axes, the samples' first.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// What a value is.
    pub fn element(&self) -> Element {
        self.element
    }

    /// A sample's values, little-endian, the last axis fastest. What is not stored is zero.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn sample(&self, index: usize) -> Result<Vec<u8>, ReadError> {
        let samples = self.shape[0];
        if index >= samples {
            return Err(ReadError::OutOfRange { index, samples });
        }
        let mut bytes = vec![0; self.shape[1..].iter().product::<usize>() * self.element.size()];
        let counts = self.shape.iter().zip(&self.shard).map(|(all, one)| all.div_ceil(*one));
        let mut counts: Vec<usize> = counts.collect();
        counts[0] = 1;
        for mut place in places(&counts) {
            place[0] = index / self.shard[0];
            self.read_shard(&place, index % self.shard[0], &mut bytes)?;
        }
        Ok(bytes)
    }

    fn read_shard(
        &self,
        place: &[usize],
        within: usize,
        sample: &mut [u8],
    ) -> Result<(), ReadError> {
        let keys: Vec<String> = place.iter().map(usize::to_string).collect();
        let path = self.folder.join("c").join(keys.join("/"));
        let failed = |source| ReadError::Io { path: path.clone(), source };
        let mut file = match File::open(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            file => file.map_err(failed)?,
        };
        let damaged = |what: String| ReadError::Damaged { path: path.clone(), what };
        let counts = self.shard.iter().zip(&self.chunk).map(|(all, one)| all / one);
        let mut counts: Vec<usize> = counts.collect();
        let index = read_index(&mut file, counts.iter().product()).map_err(failed)?;
        let index = index.ok_or_else(|| damaged("its index does not match its checksum".into()))?;

        let strides = strides(&counts);
        counts[0] = 1;
        for mut chunk in places(&counts) {
            chunk[0] = within / self.chunk[0];
            let entry: usize = chunk.iter().zip(&strides).map(|(i, stride)| i * stride).sum();
            let (offset, length) = index[entry];
            if (offset, length) == (ABSENT, ABSENT) {
                continue;
            }
            file.seek(SeekFrom::Start(offset)).map_err(failed)?;
            let mut packed = Vec::new();
            (&file).take(length).read_to_end(&mut packed).map_err(failed)?;
            let size = self.chunk.iter().product::<usize>() * self.element.size();
            let values = zarr_unpack(&packed, size)
                .map_err(|error: ExportError| damaged(error.to_string()))?;
            if values.len() != size {
                return Err(damaged(format!("a chunk of {} bytes, not {size}", values.len())));
            }
            let start = place.iter().zip(&self.shard).zip(chunk.iter().zip(&self.chunk));
            let start: Vec<usize> = start.map(|((p, s), (i, c))| p * s + i * c).collect();
            self.copy(&values, &start, within % self.chunk[0], sample);
        }
        Ok(())
    }

    /// Copies what one chunk holds of a sample, line by line; chunks may reach beyond the array.
    fn copy(&self, values: &[u8], start: &[usize], within: usize, sample: &mut [u8]) {
        let size = self.element.size();
        let (shape, chunk, start) = (&self.shape[1..], &self.chunk[1..], &start[1..]);
        let chunk_bytes = chunk.iter().product::<usize>() * size;
        let values = &values[within * chunk_bytes..];
        let Some((&last, rest)) = chunk.split_last() else {
            sample.copy_from_slice(&values[..size]);
            return;
        };
        let axis = rest.len();
        let length = last.min(shape[axis] - start[axis]) * size;
        let (to, from) = (strides(shape), strides(chunk));
        for line in places(rest) {
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

/// Offset and length of each chunk; `None` if the checksum is another.
fn read_index(file: &mut File, chunks: usize) -> io::Result<Option<Vec<(u64, u64)>>> {
    let length = chunks * INDEX_ENTRY_BYTES;
    file.seek(SeekFrom::End(-((length + CHECKSUM_BYTES) as i64)))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let (index, checksum) = bytes.split_at(length.min(bytes.len()));
    if zarr_checksum(index).to_le_bytes() != checksum {
        return Ok(None);
    }
    let number = |bytes: &[u8; 8]| u64::from_le_bytes(*bytes);
    let (numbers, _) = index.as_chunks::<8>();
    let entry = |pair: &[[u8; 8]]| (number(&pair[0]), number(&pair[1]));
    Ok(Some(numbers.chunks_exact(2).map(entry).collect()))
}

/// How many values one step along each axis skips.
fn strides(counts: &[usize]) -> Vec<usize> {
    (1..=counts.len()).map(|axis| counts[axis..].iter().product()).collect()
}

/// All places of a grid, the last axis fastest.
fn places(counts: &[usize]) -> impl Iterator<Item = Vec<usize>> + use<'_> {
    let strides = strides(counts);
    (0..counts.iter().product()).map(move |i: usize| {
        counts.iter().zip(&strides).map(|(count, stride)| i / stride % count).collect()
    })
}

#[cfg(test)]
mod tests {
    use fabkit_export::{ZarrArray, zarr_pack};
    use serde_json::json;

    use super::*;

    #[test]
    fn what_was_written_is_read_back_sample_by_sample() {
        let array = ZarrArray {
            element: Element::U16,
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
        // The shard of samples 2 and 3 is not there: zeros.
        for shard in [0, 2] {
            let packed = array.samples_of(shard).map(|i| zarr_pack(&sample(i as u8)).unwrap());
            let path = folder.path().join(array.shard_path(shard));
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, array.shard(&packed.collect::<Vec<_>>())).unwrap();
        }
        let read = SampleArray::open(folder.path()).unwrap();
        assert_eq!((read.shape(), read.element()), (&[5, 2, 3][..], Element::U16));
        for (i, expected) in
            [sample(0), sample(1), vec![0; 12], vec![0; 12], sample(4)].iter().enumerate()
        {
            assert_eq!(&read.sample(i).unwrap(), expected, "sample {i}");
        }
        assert!(matches!(read.sample(5), Err(ReadError::OutOfRange { samples: 5, .. })));
        // One flipped bit in the index is noticed.
        let path = folder.path().join(array.shard_path(0));
        let mut bytes = fs::read(&path).unwrap();
        let last = bytes.len() - 6;
        bytes[last] ^= 1;
        fs::write(&path, bytes).unwrap();
        assert!(matches!(read.sample(0), Err(ReadError::Damaged { .. })));
    }

    #[test]
    fn chunks_that_split_a_sample_are_joined() {
        // 3 x 5 values of a byte in chunks of 2 x 2, which reach beyond the array.
        let folder = tempfile::tempdir().unwrap();
        let (shape, chunk) = ([2, 3, 5], [1, 2, 2]);
        let array = SampleArray {
            folder: folder.path().into(),
            element: Element::U8,
            shape: shape.into(),
            shard: vec![2, 4, 6],
            chunk: chunk.into(),
        };
        let value = |s: usize, r: usize, c: usize| (100 * s + 10 * r + c) as u8;
        let (mut bytes, mut index) = (Vec::new(), Vec::new());
        for place in places(&[2, 2, 3]) {
            let values = places(&chunk[1..])
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
            let expected: Vec<u8> = places(&[3, 5]).map(|at| value(s, at[0], at[1])).collect();
            assert_eq!(array.sample(s).unwrap(), expected);
        }
    }
}
