//! Journal from which an interrupted switch of files is undone.
//!
//! Before the first file of a set is renamed, a journal beside it records which files are about to be replaced and
//! under which names the old ones are kept. Deleting the journal makes the switch final. The next process that locks a
//! folder with a journal in it puts the old files back.
//!
//! A set may span several folders. Each has a journal, and the first folder's journal decides for all, because only one
//! deletion is atomic: as long as that one exists, nothing is final in any of them.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::lock::FolderLock;
use super::{StagingError, failed, sync_folder};

/// File name of the journal in each folder. One name is enough, because it is written and removed under the lock.
pub(super) const JOURNAL: &str = ".fabkit-switch";
/// Version of the journal's format.
const VERSION: u32 = 1;
/// Maximum size of a journal that is read, bytes: enough for some hundred thousand files.
const MAX_BYTES: u64 = 64 << 20;

/// Journal of a switch. Names are kept as the operating system has them, which need not be text.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Journal {
    pub version: u32,
    /// Identifier of the writer that makes the switch.
    pub writer: String,
    /// Folder whose journal decides.
    pub first: OsString,
    /// Other folders of the set; empty except in the deciding journal.
    pub others: Vec<OsString>,
    pub records: Vec<Record>,
}

/// Change of one file name.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Record {
    /// Name in the folder.
    pub name: OsString,
    /// Name under which the old file is kept; `None` if there was none.
    pub previous: Option<OsString>,
    /// BLAKE3 of the new content; `None` for a file that is removed. A file with different content was changed by
    /// somebody else and is left alone.
    pub blake3: Option<String>,
}

impl Journal {
    /// Creates a journal.
    pub(super) fn new(
        writer: &str,
        first: &Path,
        others: &[&PathBuf],
        records: Vec<Record>,
    ) -> Self {
        let others = others.iter().map(|path| path.as_os_str().to_owned()).collect();
        let (writer, first) = (writer.to_owned(), first.as_os_str().to_owned());
        Self { version: VERSION, writer, first, others, records }
    }

    /// Writes the journal into a locked folder.
    pub(super) fn write(&self, lock: &FolderLock) -> Result<(), StagingError> {
        let place = lock.folder().join(JOURNAL);
        let text = serde_json::to_vec(self).map_err(|e| failed("write", &place, e.into()))?;
        lock.put(JOURNAL, &text)
    }

    /// Reads the journal of a folder, if there is one.
    fn read(folder: &Path) -> Result<Option<Self>, StagingError> {
        let path = folder.join(JOURNAL);
        let unreadable = |error| failed("read", &path, error);
        let text = match fs::metadata(&path) {
            Ok(found) if found.len() <= MAX_BYTES => fs::read(&path).map_err(unreadable)?,
            Ok(_) => return Err(unreadable(io::ErrorKind::InvalidData.into())),
            Err(error) if is_missing(&error) => return Ok(None),
            Err(error) => return Err(unreadable(error)),
        };
        let journal: Self = serde_json::from_slice(&text).map_err(|e| unreadable(e.into()))?;
        if journal.version == VERSION { Ok(Some(journal)) } else { Err(unreadable(newer())) }
    }

    /// Returns whether the switch of a folder was completed.
    fn is_final(&self, folder: &Path) -> Result<bool, StagingError> {
        let first = Path::new(&self.first);
        // The deciding journal still exists, so the switch is not final.
        if first == folder {
            return Ok(false);
        }
        // A missing journal, or that of another writer, means that ours was deleted.
        Ok(Self::read(first)?.is_none_or(|deciding| deciding.writer != self.writer))
    }
}

/// Creates the error of a journal with another version.
fn newer() -> io::Error {
    io::Error::other("it was written by a newer version of fabkit")
}

/// Returns whether the error means that there is no such file.
fn is_missing(error: &io::Error) -> bool {
    // A folder on the way may be gone, or may have become a file.
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// Undoes what a killed writer left unfinished in a folder. The caller holds the lock.
///
/// All steps may be repeated after an interruption: a file that has been put back no longer has its other name.
///
/// # Errors
/// [`StagingError::NotRestored`] for files that cannot be put back; they keep both names, and the journal stays.
pub(super) fn recover(folder: &Path) -> Result<(), StagingError> {
    let Some(journal) = Journal::read(folder)? else { return Ok(()) };
    // Journals contain canonical folder names.
    let here = fs::canonicalize(folder).map_err(|e| failed("look at", folder, e))?;
    if !journal.is_final(&here)? {
        for other in journal.others.iter().map(Path::new) {
            // Locking the other folder undoes its part: its journal refers to this one, which is removed last.
            let is_open = |there: Journal| there.writer == journal.writer;
            if Journal::read(other)?.is_some_and(is_open) {
                drop(FolderLock::acquire(other)?);
            }
        }
        restore_files(folder, &journal.records).map_err(RestoreFailure::into_error)?;
        sync_folder(folder)?;
    }
    let path = folder.join(JOURNAL);
    fs::remove_file(&path).map_err(|e| failed("remove", &path, e))?;
    sync_folder(folder)
}

/// Old file that could not be put back.
struct RestoreFailure {
    place: PathBuf,
    backup: PathBuf,
    source: io::Error,
}

impl RestoreFailure {
    fn into_error(self) -> StagingError {
        let Self { place, backup: kept, source } = self;
        StagingError::NotRestored { cause: None, place, kept, source }
    }
}

/// Puts back as many old files as possible and returns the first failure.
fn restore_files(folder: &Path, records: &[Record]) -> Result<(), RestoreFailure> {
    let mut first = Ok(());
    // In reverse order of the switch.
    for record in records.iter().rev() {
        let place = folder.join(&record.name);
        let kept = record.previous.as_ref().map(|previous| folder.join(previous));
        let result = match (inspect(&place, record), &kept) {
            (Err(error), _) => Err(error),
            // The file was never replaced, is back already, or was changed by somebody since.
            (Ok(FoundContent::Other), _) | (Ok(FoundContent::Nothing), None) => Ok(()),
            (Ok(FoundContent::New), None) => fs::remove_file(&place),
            // The old file has the same content, so nothing needs to be put back.
            (Ok(FoundContent::New), Some(kept))
                if matches!(inspect(kept, record), Ok(FoundContent::New)) =>
            {
                Ok(())
            }
            (Ok(_), Some(kept)) => match fs::rename(kept, &place) {
                Err(error) if is_missing(&error) => Ok(()),
                other => other,
            },
        };
        if let (Err(source), true) = (result, first.is_ok()) {
            first = Err(RestoreFailure {
                backup: kept.unwrap_or_else(|| place.clone()),
                place,
                source,
            });
        }
    }
    first
}

/// Content found under a record's name.
enum FoundContent {
    Nothing,
    New,
    Other,
}

/// Compares a file with the new content of its record.
fn inspect(place: &Path, record: &Record) -> io::Result<FoundContent> {
    match fs::symlink_metadata(place) {
        Err(error) if is_missing(&error) => return Ok(FoundContent::Nothing),
        Err(error) => return Err(error),
        Ok(found) if !found.is_file() => return Ok(FoundContent::Other),
        Ok(_) => {}
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(place)?)?;
    let is_new = record.blake3.as_deref() == Some(hasher.finalize().to_hex().as_str());
    Ok(if is_new { FoundContent::New } else { FoundContent::Other })
}
