//! Folders that are filled piece by piece, by runs that may be killed at any moment.
//!
//! | path | holds |
//! |---|---|
//! | `NAME.partial/plan.json` | plan of the pieces, [sealed](seal) |
//! | `NAME.partial/journal` | hash, size and path of each finished piece, one per line |
//! | `NAME.json` | in a complete folder: the plan, and size and hash of every file; sealed |
//!
//! A piece is finished when it is a regular file with the recorded size and hash. One process writes at a time. A run
//! that is killed and resumed ends with the same bytes as an uninterrupted one.

mod error;
mod piece;
mod seal;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;
use serde_json::{Map, Value};

pub use error::SAME_VERSION_HINT;
pub use error::{ResumableFolderError, find_differences};
pub use piece::{Piece, PieceState, is_safe_name, read_regular};
pub use seal::{SealError, seal, seal_text, unseal};

use crate::staging::FolderLock;

/// Maximum size of a plan, list of contents or journal that is read, bytes.
pub const MAX_DOCUMENT_BYTES: u64 = 64 << 20;
/// File name of the plan.
const PLAN: &str = "plan.json";
/// File name of the journal.
const JOURNAL: &str = "journal";
/// Name prefix of the lock file and other temporary files of a writer.
const HIDDEN_PREFIX: &str = ".fabkit-";

/// Kind of a folder's content.
///
/// ```
/// use fabkit_files::resumable::FolderKind;
///
/// let kind = FolderKind { what: "data set", name: "dataset", version: 1 };
/// assert_eq!(kind.document(), "dataset.json");
/// assert_eq!(kind.partial("plan.json"), "dataset.partial/plan.json");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FolderKind {
    /// Name for people: `data set`.
    pub what: &'static str,
    /// File name stem: the document is `NAME.json`, unfinished work lies in `NAME.partial`.
    pub name: &'static str,
    /// Version of the document.
    pub version: u64,
}

impl FolderKind {
    /// Returns the file name of the document of a complete folder.
    pub fn document(self) -> String {
        format!("{}.json", self.name)
    }

    /// Returns the path of a file that is removed once the folder is complete.
    pub fn partial(self, name: &str) -> String {
        format!("{}.partial/{name}", self.name)
    }

    /// Returns whether a file belongs to unfinished work.
    fn is_partial(self, name: &str) -> bool {
        name.strip_prefix(self.name).is_some_and(|rest| rest.starts_with(".partial/"))
    }

    /// Builds the sealed document of a complete folder: the plan, the results, and the list of files.
    pub fn whole(self, plan: &Value, results: Map<String, Value>, files: &FilesByPath) -> Vec<u8> {
        let mut document = plan.as_object().cloned().unwrap_or_default();
        document.extend(results);
        let files = files.iter().map(|(name, piece)| (name.clone(), piece.to_json()));
        document.insert("files".into(), Value::Object(files.collect()));
        seal(&document)
    }

    /// Reads and checks a document that [`seal`] made; `None` if there is none.
    ///
    /// # Errors
    /// [`ResumableFolderError::DamagedDocument`], [`ResumableFolderError::OtherVersion`] and [`ResumableFolderError::Io`].
    pub fn read(self, path: &Path) -> Result<Option<Value>, ResumableFolderError> {
        let Some(bytes) = read_regular(path, MAX_DOCUMENT_BYTES)? else { return Ok(None) };
        let damaged = |what: SealError| {
            Err(ResumableFolderError::DamagedDocument { path: path.into(), what: what.to_string() })
        };
        let document = match unseal(&bytes) {
            Ok(document) => document,
            // Documents of older versions have no seal: they are reported as an other version, not as damaged.
            Err(SealError::Missing) => match serde_json::from_slice::<Value>(&bytes) {
                Ok(document) if document["version"] != self.version => document,
                _ => return damaged(SealError::Missing),
            },
            Err(error) => return damaged(error),
        };
        match document["version"].as_u64() {
            Some(found) if found != self.version => Err(ResumableFolderError::OtherVersion {
                what: self.what,
                path: path.into(),
                found,
                known: self.version,
            }),
            Some(_) => Ok(Some(document)),
            None => damaged(SealError::Missing),
        }
    }
}

/// Files by their paths below the folder.
pub type FilesByPath = BTreeMap<String, Piece>;

/// Open folder, locked until it is dropped.
///
/// ```
/// use fabkit_files::resumable::{FolderKind, ResumableFolder, listed_files};
/// use fabkit_files::scratch_folder::ScratchFolder;
/// use serde_json::{Map, json};
///
/// let kind = FolderKind { what: "data set", name: "dataset", version: 1 };
/// let plan = json!({ "version": 1, "images": 2 });
/// let root = ScratchFolder::new()?;
/// let first = ResumableFolder::open(kind, root.path(), plan.clone(), false)?;
/// first.put("0.png", b"zero")?;
/// drop(first); // as a run that is killed
/// let second = ResumableFolder::open(kind, root.path(), plan, true)?;
/// assert!(second.is_finished("0.png") && !second.is_finished("1.png"));
/// second.put("1.png", b"one")?;
/// second.finish(Map::new())?;
/// let document = kind.read(&root.path_of_file("dataset.json"))?.unwrap_or_default();
/// assert!(listed_files(&document).keys().eq(["0.png", "1.png"]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ResumableFolder {
    kind: FolderKind,
    lock: FolderLock,
    plan: Value,
    /// The document, if the folder is complete.
    document: Option<Value>,
    /// Pieces that exist but do not have the recorded content.
    damaged: Vec<String>,
    state: Mutex<FolderState>,
}

/// State that changes while a folder is filled.
#[derive(Debug)]
struct FolderState {
    /// Finished pieces.
    done: FilesByPath,
    /// Names requested by this run. Other names in the journal of an earlier run do not belong to the result.
    requested: BTreeSet<String>,
    /// Open journal of finished pieces; `None` in a complete folder.
    journal: Option<File>,
}

impl ResumableFolder {
    /// Locks the folder and writes the plan into it. With `resume`, the folder may have been begun with the same plan,
    /// and every recorded piece is checked.
    ///
    /// # Errors
    /// [`ResumableFolderError`].
    pub fn open(
        kind: FolderKind,
        folder: &Path,
        plan: Value,
        resume: bool,
    ) -> Result<Self, ResumableFolderError> {
        let lock = FolderLock::acquire(folder)?;
        let not_empty = || ResumableFolderError::NotEmpty { folder: folder.into() };
        let is_empty = is_empty(folder, kind)?;
        if !resume && !is_empty {
            return Err(not_empty());
        }
        let whole = kind.read(&folder.join(kind.document()))?;
        let begun = kind.read(&folder.join(kind.partial(PLAN)))?;
        if !is_empty && whole.is_none() && begun.is_none() {
            return Err(not_empty());
        }
        for found in [&whole, &begun].into_iter().flatten() {
            let differences = find_differences(found, &plan);
            if !differences.is_empty() {
                let what = kind.what;
                return Err(ResumableFolderError::OtherPlan {
                    what,
                    folder: folder.into(),
                    differences,
                });
            }
        }
        let mut noted = read_journal(&folder.join(kind.partial(JOURNAL)))?;
        // The document of a complete folder replaces what the journal says.
        noted.extend(whole.iter().flat_map(listed_files));
        let states: Vec<PieceState> = noted
            .par_iter()
            .map(|(name, piece)| piece.verify(folder, name))
            .collect::<Result<_, _>>()?;
        let is_whole = whole.is_some() && states.iter().all(|state| *state == PieceState::Intact);
        let mut done = FilesByPath::new();
        let mut damaged = Vec::new();
        for ((name, piece), state) in noted.into_iter().zip(states) {
            match state {
                PieceState::Intact => drop(done.insert(name, piece)),
                PieceState::Changed(_) => damaged.push(name),
                PieceState::Missing => {}
            }
        }
        if whole.is_some() && !damaged.is_empty() {
            // The user may have edited these files, so they are not replaced.
            let paths = damaged.iter().map(|name| folder.join(name)).collect();
            return Err(ResumableFolderError::Changed { what: kind.what, paths });
        }
        let state = FolderState { done, requested: BTreeSet::new(), journal: None };
        let whole = whole.filter(|_| is_whole);
        let folder = Self { kind, lock, plan, document: whole, damaged, state: Mutex::new(state) };
        if !is_whole {
            folder.write_plan()?;
        }
        Ok(folder)
    }

    /// Writes the plan, and a journal of the pieces that exist.
    fn write_plan(&self) -> Result<(), ResumableFolderError> {
        let plan = seal(&self.plan.as_object().cloned().unwrap_or_default());
        self.write_within(&self.kind.partial(PLAN), &plan)?;
        let mut state = self.state();
        let lines: String =
            state.done.iter().map(|(name, piece)| piece.journal_line(name)).collect();
        // Written anew, because the journal of a killed run may end within a line.
        let journal = self.kind.partial(JOURNAL);
        self.write_within(&journal, lines.as_bytes())?;
        let path = self.path().join(journal);
        let file = OpenOptions::new().append(true).open(&path);
        state.journal = Some(file.map_err(|e| ResumableFolderError::io("write", &path, e))?);
        Ok(())
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.lock.folder()
    }

    /// Returns the document of a folder that was found complete. Only [finish](Self::finish) remains to be called.
    pub fn document(&self) -> Option<&Value> {
        self.document.as_ref()
    }

    /// Returns the pieces whose content is not what an earlier run wrote. They count as missing.
    ///
    /// ```
    /// use fabkit_files::resumable::{FolderKind, ResumableFolder};
    /// use fabkit_files::scratch_folder::ScratchFolder;
    /// use serde_json::json;
    ///
    /// let kind = FolderKind { what: "data set", name: "dataset", version: 1 };
    /// let root = ScratchFolder::new()?;
    /// let open = |resume| ResumableFolder::open(kind, root.path(), json!({ "version": 1 }), resume);
    /// open(false)?.put("0.png", b"zero")?;
    /// root.write("0.png", b"ZERO")?;
    /// let folder = open(true)?;
    /// assert_eq!(folder.damaged(), ["0.png"]);
    /// assert!(!folder.is_finished("0.png") && folder.read("0.png").is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn damaged(&self) -> &[String] {
        &self.damaged
    }

    /// Returns the names of finished pieces that begin with `prefix`.
    pub fn names(&self, prefix: &str) -> Vec<String> {
        let state = self.state();
        state.done.keys().filter(|name| name.starts_with(prefix)).cloned().collect()
    }

    /// Returns whether a piece is finished, and records the name as one of this run's.
    pub fn is_finished(&self, name: &str) -> bool {
        let mut state = self.state();
        state.requested.insert(name.to_owned());
        state.done.contains_key(name)
    }

    /// Writes a piece atomically and records it in the journal.
    ///
    /// # Errors
    /// [`ResumableFolderError`].
    pub fn put(&self, name: &str, bytes: &[u8]) -> Result<(), ResumableFolderError> {
        self.write_within(name, bytes)?;
        let piece = Piece::from_bytes(bytes);
        let mut state = self.state();
        if let Some(journal) = &mut state.journal {
            let noted = journal.write_all(piece.journal_line(name).as_bytes());
            let path = || self.path().join(self.kind.partial(JOURNAL));
            noted.map_err(|e| ResumableFolderError::io("write", &path(), e))?;
        }
        state.requested.insert(name.to_owned());
        state.done.insert(name.to_owned(), piece);
        Ok(())
    }

    /// Reads a finished piece.
    ///
    /// # Errors
    /// [`ResumableFolderError::Damaged`] if it is missing or its content has changed.
    pub fn read(&self, name: &str) -> Result<Vec<u8>, ResumableFolderError> {
        let piece = self.state().done.get(name).copied();
        let missing = || ResumableFolderError::Damaged {
            path: self.path().join(name),
            what: "it is missing".into(),
        };
        piece.ok_or_else(missing)?.read(self.path(), name)
    }

    /// Marks the folder as complete, and removes the files of unfinished work.
    ///
    /// # Errors
    /// [`ResumableFolderError`].
    pub fn finish(&self, results: Map<String, Value>) -> Result<(), ResumableFolderError> {
        if self.document.is_none() {
            let state = self.state();
            // Pieces that an earlier run of the same plan left, and that this run did not request, are not listed.
            let is_ours =
                |name: &String| state.requested.contains(name) && !self.kind.is_partial(name);
            let files = state.done.iter().filter(|(name, _)| is_ours(name));
            let files = files.map(|(name, piece)| (name.clone(), *piece)).collect();
            let document = self.kind.whole(&self.plan, results, &files);
            self.write_within(&self.kind.document(), &document)?;
        }
        let partial = self.path().join(format!("{}.partial", self.kind.name));
        match fs::remove_dir_all(&partial) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(ResumableFolderError::io("remove", &partial, error))
            }
            _ => Ok(()),
        }
    }

    /// Writes a file within the folder. Names that leave the folder and links on the way are refused.
    fn write_within(&self, name: &str, bytes: &[u8]) -> Result<(), ResumableFolderError> {
        if !piece::is_safe_name(name) {
            return Err(ResumableFolderError::Outside {
                name: name.into(),
                folder: self.path().into(),
            });
        }
        if let Some(path) = piece::find_link_on_path(self.path(), name)? {
            return Err(ResumableFolderError::Link { path });
        }
        Ok(self.lock.put(name, bytes)?)
    }

    /// Locks the state.
    fn state(&self) -> MutexGuard<'_, FolderState> {
        // A panicking thread leaves the state valid, since each change is complete in itself.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns whether the folder holds nothing but remains of a run that was killed before it wrote its plan.
fn is_empty(folder: &Path, kind: FolderKind) -> Result<bool, ResumableFolderError> {
    let failed = |error| ResumableFolderError::io("read the folder", folder, error);
    for entry in fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        let is_partial = name == format!("{}.partial", kind.name).as_str();
        let is_leftover = is_partial
            && entry.file_type().map_err(failed)?.is_dir()
            && fs::read_dir(entry.path()).map_err(failed)?.next().is_none();
        let is_ours = name.to_str().is_some_and(|name| name.starts_with(HIDDEN_PREFIX));
        if !is_ours && !is_leftover {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Reads the entries of a journal. Unreadable lines are skipped: their pieces are made again.
fn read_journal(path: &Path) -> Result<FilesByPath, ResumableFolderError> {
    let bytes = read_regular(path, MAX_DOCUMENT_BYTES)?.unwrap_or_default();
    Ok(String::from_utf8_lossy(&bytes).lines().filter_map(Piece::from_line).collect())
}

/// Returns the files that the document of a complete folder lists.
pub fn listed_files(document: &Value) -> FilesByPath {
    let files = document["files"].as_object();
    let piece = |(name, value): (&String, &Value)| Some((name.clone(), Piece::from_json(value)?));
    files
        .into_iter()
        .flatten()
        .filter_map(piece)
        .filter(|(name, _)| piece::is_safe_name(name))
        .collect()
}

#[cfg(test)]
mod tests;
