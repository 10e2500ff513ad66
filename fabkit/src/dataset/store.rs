//! The folder of a data set: files that appear whole, and a plan that says whose they are.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use fabkit_export::ExportError;
use serde_json::{Map, Value};

use super::read::ReadError;
use super::{Job, OnProgress};

/// The plan of a finished data set.
const FINISHED: &str = "dataset.json";
/// The same while files are missing.
const UNFINISHED: &str = "dataset.partial.json";

/// Why there is no data set.
#[derive(Debug, thiserror::Error)]
pub enum DatasetError {
    /// Something is there already.
    #[error("{} is not empty", .folder.display())]
    NotEmpty {
        /// Where.
        folder: PathBuf,
    },
    /// A data set is there, but another one.
    #[error(
        "{} holds another data set, whose plan has the hash {found}; this one has {wanted}{}",
        .folder.display(),
        differences.iter().map(|line| format!("\n  {line}")).collect::<String>()
    )]
    OtherPlan {
        /// Where.
        folder: PathBuf,
        /// BLAKE3 of the plan that is there, shortened.
        found: String,
        /// BLAKE3 of the plan asked for, shortened.
        wanted: String,
        /// The first few values that differ: path, what is there, what was asked for.
        differences: Vec<String>,
    },
    /// The operating system said no.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// For example `write`.
        action: &'static str,
        /// Which file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file that cannot be made.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A half that an earlier run wrote cannot be read again.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The caller asked to stop.
    #[error("stopped; `--resume` goes on from here")]
    Cancelled,
}

/// An open data set.
pub(super) struct Store<'a> {
    folder: &'a Path,
    plan: Vec<u8>,
    files: usize,
    found: AtomicUsize,
    made: AtomicUsize,
    progress: OnProgress<'a>,
    cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Store<'a> {
    /// Makes the folder and leaves the plan in it, or finds the same plan there.
    pub(super) fn open(
        folder: &'a Path,
        job: &Job,
        files: usize,
        progress: OnProgress<'a>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
    ) -> Result<Self, DatasetError> {
        let plan = job.plan.document(job.materialise)?;
        let store = Self {
            folder,
            plan,
            files,
            found: AtomicUsize::new(0),
            made: AtomicUsize::new(0),
            progress,
            cancelled,
        };
        fs::create_dir_all(folder).map_err(|e| failed("create the folder", folder, e))?;
        match store.read_plan()? {
            Some(found) if job.resume && found == store.plan => {}
            Some(found) if job.resume => {
                return Err(DatasetError::OtherPlan {
                    folder: folder.into(),
                    found: short_hash(&found),
                    wanted: short_hash(&store.plan),
                    differences: differences(&found, &store.plan),
                });
            }
            Some(_) => return Err(DatasetError::NotEmpty { folder: folder.into() }),
            None if store.is_empty()? => store.replace(UNFINISHED, &store.plan)?,
            None => return Err(DatasetError::NotEmpty { folder: folder.into() }),
        }
        Ok(store)
    }

    /// The plan that is there, finished or not.
    fn read_plan(&self) -> Result<Option<Vec<u8>>, DatasetError> {
        for name in [FINISHED, UNFINISHED] {
            let path = self.folder.join(name);
            match fs::read(&path) {
                Ok(bytes) => return Ok(Some(bytes)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(failed("read", &path, error)),
            }
        }
        Ok(None)
    }

    /// Whether there is nothing but what a run leaves that was killed before it had a plan.
    fn is_empty(&self) -> Result<bool, DatasetError> {
        let failed = |error| failed("read the folder", self.folder, error);
        for entry in fs::read_dir(self.folder).map_err(failed)? {
            if entry.map_err(failed)?.file_name() != temporary_name(UNFINISHED).as_str() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Where the files are.
    pub(super) fn folder(&self) -> &Path {
        self.folder
    }

    /// Whether an earlier run finished a file.
    pub(super) fn has(&self, name: &str) -> bool {
        self.folder.join(name).exists()
    }

    /// Writes a file unless it is there.
    pub(super) fn put(
        &self,
        name: &str,
        bytes: impl FnOnce() -> Result<Vec<u8>, DatasetError>,
    ) -> Result<(), DatasetError> {
        if (self.cancelled)() {
            return Err(DatasetError::Cancelled);
        }
        if self.has(name) {
            self.found.fetch_add(1, Ordering::Relaxed);
        } else {
            self.replace(name, &bytes()?)?;
            self.made.fetch_add(1, Ordering::Relaxed);
        }
        let found = self.found.load(Ordering::Relaxed);
        (self.progress)(found + self.made.load(Ordering::Relaxed), found, self.files);
        Ok(())
    }

    /// Marks the data set as whole; the numbers of files found and made.
    pub(super) fn finish(&self) -> Result<(usize, usize), DatasetError> {
        if self.has(FINISHED) {
            self.found.fetch_add(1, Ordering::Relaxed);
        } else {
            self.replace(FINISHED, &self.plan)?;
            self.made.fetch_add(1, Ordering::Relaxed);
        }
        let unfinished = self.folder.join(UNFINISHED);
        match fs::remove_file(&unfinished) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(failed("remove", &unfinished, error));
            }
            _ => {}
        }
        let found = self.found.load(Ordering::Relaxed);
        (self.progress)(self.files, found, self.files);
        Ok((found, self.made.load(Ordering::Relaxed)))
    }

    fn replace(&self, name: &str, bytes: &[u8]) -> Result<(), DatasetError> {
        replace(self.folder, name, bytes)
    }
}

/// Writes beside the place, syncs, and renames. A leftover of a killed run is overwritten: each name
/// is written by one thread of one run.
pub(super) fn replace(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), DatasetError> {
    let place = folder.join(name);
    let parent = place.parent().unwrap_or(folder);
    fs::create_dir_all(parent).map_err(|e| failed("create the folder", parent, e))?;
    let file_name = place.file_name().and_then(|n| n.to_str()).unwrap_or(name);
    let temporary = parent.join(temporary_name(file_name));
    let written = File::create(&temporary).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    let renamed = written.and_then(|()| fs::rename(&temporary, &place));
    renamed.map_err(|error| {
        // Nothing half-written stays behind a full disk.
        let _ = fs::remove_file(&temporary);
        failed("write", &place, error)
    })
}

fn temporary_name(name: &str) -> String {
    format!(".{name}.new")
}

fn failed(action: &'static str, path: &Path, source: io::Error) -> DatasetError {
    DatasetError::Io { action, path: path.into(), source }
}

pub(super) fn short_hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..16].to_owned()
}

/// The first values in which two plans differ.
fn differences(found: &[u8], wanted: &[u8]) -> Vec<String> {
    const MOST: usize = 5;
    let read = |bytes| serde_json::from_slice::<Value>(bytes).unwrap_or_default();
    let mut lines = Vec::new();
    differ("", &read(found), &read(wanted), &mut lines);
    lines.truncate(MOST);
    lines
}

fn differ(path: &str, found: &Value, wanted: &Value, lines: &mut Vec<String>) {
    match (found, wanted) {
        (Value::Object(a), Value::Object(b)) => {
            let keys: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            for key in keys {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                let of = |map: &Map<String, Value>| map.get(key).cloned().unwrap_or_default();
                differ(&path, &of(a), &of(b), lines);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() != b.len() => {
            lines.push(format!("{path}: {} there, {} asked for", a.len(), b.len()));
        }
        (Value::Array(a), Value::Array(b)) => {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                differ(&format!("{path}[{i}]"), a, b, lines);
            }
        }
        (a, b) if a == b => {}
        (a, b) => lines.push(format!("{path}: {a} there, {b} asked for")),
    }
}
