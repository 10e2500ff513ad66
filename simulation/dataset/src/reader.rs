//! Reader of a complete data set, which checks everything against `dataset.json`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit_export::ZarrType;
use fabkit_files::memory::{self, MemoryError, MemoryHint};
use fabkit_files::resumable::{FilesByPath, listed_files};
use serde_json::Value;

use super::read::{SampleArray, SampleError};
use super::shard_file::chunk_bytes;
use super::store::KIND;

/// Complete data set.
///
/// ```
/// use fabkit_dataset::{DatasetReader, SampleError};
///
/// let folder = std::env::temp_dir().join("no-such-dataset");
/// let missing = DatasetReader::open(&folder);
/// assert!(matches!(missing, Err(SampleError::NoDataset { is_begun: false, .. })));
/// ```
#[derive(Clone, Debug)]
pub struct DatasetReader {
    folder: PathBuf,
    document: Value,
    files: FilesByPath,
}

impl DatasetReader {
    /// Reads `dataset.json`. Every other file is read and checked when it is requested.
    ///
    /// # Errors
    /// Fails without a data set, for one that is not finished or of another version, or for a damaged document.
    pub fn open(folder: &Path) -> Result<Self, SampleError> {
        let path = folder.join(KIND.document());
        let Some(document) = KIND.read(&path)? else {
            let is_begun = folder.join(KIND.partial("plan.json")).exists();
            return Err(SampleError::NoDataset { path, is_begun });
        };
        Ok(Self { folder: folder.into(), files: listed_files(&document), document })
    }

    /// Content of `dataset.json`.
    pub fn document(&self) -> &Value {
        &self.document
    }

    /// Reads the content of a file, and checks its hash.
    ///
    /// # Errors
    /// Fails for a file that does not belong to this data set, is missing, or was damaged.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, SampleError> {
        let unknown = || {
            let what = "it is not among the data set's files".into();
            SampleError::ForeignMetadata { path: self.folder.join(name), what }
        };
        Ok(self.files.get(name).ok_or_else(unknown)?.read(&self.folder, name)?)
    }

    /// Opens an array such as `halves/label`, if there is one.
    ///
    /// # Errors
    /// Fails for metadata that were damaged, or do not fit the data set.
    pub fn array(&self, name: &str) -> Result<Option<SampleArray>, SampleError> {
        let metadata = format!("{name}/zarr.json");
        if !self.files.contains_key(&metadata) {
            return Ok(None);
        }
        let folder = self.folder.join(name);
        let array = SampleArray::from_metadata(&folder, &self.bytes(&metadata)?)?;
        let foreign =
            |what| SampleError::ForeignMetadata { path: self.folder.join(&metadata), what };
        let (shape, expected) = (array.shape(), self.shape(name));
        // Metadata with other sizes than the document's could make a reader allocate anything.
        if expected.as_deref() != Some(shape) {
            let expected = expected.unwrap_or_default();
            let message = format!("its shape is {shape:?}; the data set's is {expected:?}");
            return Err(foreign(message));
        }
        let is_real = name.ends_with("/indentation_mm") || name.ends_with("/indentation_sigma_mm");
        if array.element() != if is_real { ZarrType::F32 } else { ZarrType::U8 } {
            return Err(foreign("its values are of another kind than the data set's".into()));
        }
        let shards = 0..array.array().shards();
        let missing = shards.map(|shard| format!("{name}/{}", array.array().shard_path(shard)));
        match missing.into_iter().find(|file| !self.files.contains_key(file)) {
            Some(file) => Err(foreign(format!("{file} is not among the data set's files"))),
            None => Ok(Some(array)),
        }
    }

    /// Checks every chunk of every array: returns the names of damaged files with their first damage.
    ///
    /// # Errors
    /// Fails if chunks need more memory than allowed.
    pub fn damaged_chunks(&self) -> Result<BTreeMap<String, String>, MemoryError> {
        let mut damaged = BTreeMap::new();
        for name in self.files.keys().filter_map(|name| name.strip_suffix("/zarr.json")) {
            // Groups (`halves`, `samples`, the root) have no values.
            if !name.contains('/') {
                continue;
            }
            let array = match self.array(name) {
                Ok(Some(array)) => array,
                Ok(None) => continue,
                Err(error) => {
                    damaged.insert(format!("{name}/zarr.json"), error.to_string());
                    continue;
                }
            };
            // Packed and unpacked content of one chunk.
            let bytes = 2 * chunk_bytes(array.array()) as u64;
            let found =
                memory::run_on_workers("reading a chunk", 0, bytes, MemoryHint::Nothing, || {
                    Ok::<_, MemoryError>(array.damaged_chunks())
                })?;
            damaged.extend(found.into_iter().map(|(file, why)| (format!("{name}/{file}"), why)));
        }
        Ok(damaged)
    }

    /// Returns an array's shape according to the document.
    fn shape(&self, name: &str) -> Option<Vec<usize>> {
        let number = |value: &Value| Some(value.as_u64()? as usize);
        let (group, kind) = name.split_once('/')?;
        let [height, width] = self.document["size_px"].as_array()?.as_slice() else { return None };
        let mut shape = vec![number(&self.document[group])?, number(height)?, number(width)?];
        if kind == "image" {
            shape.push(number(&self.document["image_channels"])?);
        }
        Some(shape)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use fabkit_export::{Shard, ZarrArray, zarr_pack};
    use serde_json::{Map, json};

    use super::*;
    use fabkit_files::resumable::Piece;

    /// A folder whose document and hashes are in order, whatever the array's metadata say.
    fn folder(edit: impl Fn(&mut Value)) -> tempfile::TempDir {
        let array = ZarrArray {
            element: ZarrType::U8,
            samples: 2,
            sample_shape: vec![72, 96],
            chunk_shape: vec![72, 96],
            samples_per_shard: 16,
            dimensions: ["half", "row", "column"].map(String::from).to_vec(),
            attributes: json!({}),
        };
        let mut metadata: Value = serde_json::from_slice(&array.metadata().unwrap()).unwrap();
        edit(&mut metadata);
        let mut shard = Shard::default();
        let chunk = shard.store(&zarr_pack(&[7; 72 * 96]).unwrap());
        shard.assign(Some(chunk));
        shard.assign(Some(chunk));
        let contents = [
            ("halves/label/zarr.json", metadata.to_string().into_bytes()),
            ("halves/label/c/0/0/0", shard.finish(&array)),
        ];
        let root = tempfile::tempdir().unwrap();
        let mut files = FilesByPath::new();
        for (name, bytes) in contents {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, &bytes).unwrap();
            files.insert(name.into(), Piece::from_bytes(&bytes));
        }
        let plan = json!({ "version": 2, "size_px": [72, 96], "halves": 2, "samples": 1 });
        let document = KIND.whole(&plan, Map::new(), &files);
        fs::write(root.path().join("dataset.json"), document).unwrap();
        root
    }

    #[test]
    fn metadata_must_fit_the_plan() {
        let sound = folder(|_| ());
        let array =
            DatasetReader::open(sound.path()).unwrap().array("halves/label").unwrap().unwrap();
        assert_eq!(array.sample(1).unwrap(), vec![7; 72 * 96]);
        let grid = "/chunk_grid/configuration/chunk_shape";
        let chunk = "/codecs/0/configuration/chunk_shape";
        let numbers = [0, 1, 71, 73, 1_000_000, 1 << 31, 1 << 62, u64::MAX];
        for (axis, number) in (0..3).flat_map(|axis| numbers.map(|number| (axis, number))) {
            // Each alone, and all together, as a forger would change them.
            for places in [&["/shape"][..], &[grid], &[chunk], &["/shape", grid, chunk]] {
                let edit = |json: &mut Value| {
                    for place in places {
                        json.pointer_mut(place).unwrap()[axis] = json!(number);
                    }
                };
                let made_up = folder(edit);
                let array = DatasetReader::open(made_up.path()).unwrap().array("halves/label");
                match array {
                    Err(SampleError::ForeignMetadata { .. }) => {}
                    Err(other) => panic!("{places:?}[{axis}] = {number}: {other}"),
                    // Only how samples are shared out among files and chunks, and then files are
                    // not as that says.
                    Ok(array) => {
                        let shown = format!("{places:?}[{axis}] = {number}");
                        assert!(!places.contains(&"/shape"), "{shown}");
                        let is_same = *places == [chunk] && axis == 0 && number == 1;
                        let read = array.unwrap().sample(1);
                        assert!(
                            is_same || matches!(read, Err(SampleError::Damaged { .. })),
                            "{shown}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_data_set_is_told_from_what_is_not_finished() {
        let root = tempfile::tempdir().unwrap();
        let open = || DatasetReader::open(root.path()).unwrap_err();
        assert!(matches!(open(), SampleError::NoDataset { is_begun: false, .. }));
        fs::create_dir(root.path().join("dataset.partial")).unwrap();
        fs::write(root.path().join("dataset.partial/plan.json"), "").unwrap();
        assert!(matches!(open(), SampleError::NoDataset { is_begun: true, .. }));
        fs::write(root.path().join("dataset.json"), "{\"version\": 1}").unwrap();
        assert!(open().to_string().contains("version 1 of a data set"), "{}", open());
        fs::write(root.path().join("dataset.json"), "{\"version\": 2}").unwrap();
        assert!(open().to_string().contains("is damaged"), "{}", open());
    }
}
