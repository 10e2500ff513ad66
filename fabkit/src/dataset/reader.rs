//! A whole data set, read again: everything is compared with what `dataset.json` says of it.

use std::path::{Path, PathBuf};

use fabkit_export::Element;
use serde_json::Value;

use super::read::{ReadError, SampleArray};
use super::store::KIND;
use crate::resumable::{Files, files_of};

/// A data set that is whole.
#[derive(Clone, Debug)]
pub struct Reader {
    folder: PathBuf,
    document: Value,
    files: Files,
}

impl Reader {
    /// Reads `dataset.json`; every other file is looked at when it is asked for.
    ///
    /// # Errors
    /// No data set, one that is not finished, one of another version, a damaged document.
    pub fn open(folder: &Path) -> Result<Self, ReadError> {
        let path = folder.join(KIND.document());
        let Some(document) = KIND.read(&path)? else {
            let is_begun = folder.join(KIND.partial("plan.json")).exists();
            return Err(ReadError::Absent { path, is_begun });
        };
        Ok(Self { folder: folder.into(), files: files_of(&document), document })
    }

    /// What `dataset.json` says.
    pub fn document(&self) -> &Value {
        &self.document
    }

    /// The content of a file.
    ///
    /// # Errors
    /// A file that is not of this data set, is missing, or was damaged.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, ReadError> {
        let unknown = || {
            let what = "it is not among the data set's files".into();
            ReadError::Foreign { path: self.folder.join(name), what }
        };
        Ok(self.files.get(name).ok_or_else(unknown)?.read(&self.folder, name)?)
    }

    /// An array such as `halves/label`, if there is one.
    ///
    /// # Errors
    /// Metadata that was damaged, or does not fit the data set.
    pub fn array(&self, name: &str) -> Result<Option<SampleArray>, ReadError> {
        let metadata = format!("{name}/zarr.json");
        if !self.files.contains_key(&metadata) {
            return Ok(None);
        }
        let folder = self.folder.join(name);
        let array = SampleArray::of_metadata(&folder, &self.bytes(&metadata)?)?;
        let foreign = |what| ReadError::Foreign { path: self.folder.join(&metadata), what };
        let (shape, expected) = (array.shape(), self.shape(name));
        if expected.as_deref() != Some(shape) {
            let expected = expected.unwrap_or_default();
            let message = format!("its shape is {shape:?}; the data set's is {expected:?}");
            return Err(foreign(message));
        }
        let is_real = name.ends_with("/indentation_mm");
        if array.element() != if is_real { Element::F32 } else { Element::U8 } {
            return Err(foreign("its values are of another kind than the data set's".into()));
        }
        let shards = 0..array.array().shards();
        let missing = shards.map(|shard| format!("{name}/{}", array.array().shard_path(shard)));
        match missing.into_iter().find(|file| !self.files.contains_key(file)) {
            Some(file) => Err(foreign(format!("{file} is not among the data set's files"))),
            None => Ok(Some(array)),
        }
    }

    /// The shape that the plan gives an array.
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
