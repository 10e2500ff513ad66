//! What is needed to take an interrupted switch back.
//!
//! Before the first file of a set changes its name, a journal beside it says which files are about to
//! be replaced and under which names the old ones are kept. Deleting it is what makes the switch
//! final. Whoever next takes the lock of a folder in which a journal is left puts the old files back.
//!
//! A set may lie in several folders. Each has a journal; the first folder's decides for all, because
//! only one deletion is atomic: as long as it is there, nothing is final in any of them.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::lock::FolderLock;
use super::{StagingError, failed, sync_folder};

/// Its name in each folder: one at a time, because it is written and removed under the lock.
pub(super) const JOURNAL: &str = ".fabkit-switch";
const VERSION: u32 = 1;
/// Longest journal that is read: some hundred thousand files.
const MAX_BYTES: u64 = 64 << 20;

/// Names are kept as the system has them, which need not be text.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Journal {
    pub version: u32,
    /// Whose switch it is.
    pub writer: String,
    /// The folder whose journal decides.
    pub first: OsString,
    /// In that one: the other folders of the set.
    pub others: Vec<OsString>,
    pub records: Vec<Record>,
}

/// One file that changes its name.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Record {
    /// Its name in the folder.
    pub name: OsString,
    /// Under which name the old file is kept; `None` where there was none.
    pub previous: Option<OsString>,
    /// BLAKE3 of the new content; `None` for a file that goes. What has other content by now is
    /// somebody else's, and stays.
    pub blake3: Option<String>,
}

impl Journal {
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

    pub(super) fn write(&self, lock: &FolderLock) -> Result<(), StagingError> {
        let place = lock.folder().join(JOURNAL);
        let text = serde_json::to_vec(self).map_err(|e| failed("write", &place, e.into()))?;
        lock.put(JOURNAL, &text)
    }

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

    fn is_final(&self, folder: &Path) -> Result<bool, StagingError> {
        let first = Path::new(&self.first);
        if first == folder {
            return Ok(false);
        }
        Ok(Self::read(first)?.is_none_or(|deciding| deciding.writer != self.writer))
    }
}

fn newer() -> io::Error {
    io::Error::other("it was written by a newer version of fabkit")
}

fn is_missing(error: &io::Error) -> bool {
    // A folder on the way to it may be gone or have become a file.
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// Takes back what a dead writer left unfinished in a folder whose lock is held.
///
/// All of it may be done again after an interruption: what is back in its place has left its other
/// name.
///
/// # Errors
/// What cannot be put back stays under both names, and the journal with it.
pub(super) fn recover(folder: &Path) -> Result<(), StagingError> {
    let Some(journal) = Journal::read(folder)? else { return Ok(()) };
    // Journals name folders as they are, not as anybody spelled them.
    let here = fs::canonicalize(folder).map_err(|e| failed("look at", folder, e))?;
    if !journal.is_final(&here)? {
        for other in journal.others.iter().map(Path::new) {
            // Its own journal finds this one, which is removed last.
            let is_open = |there: Journal| there.writer == journal.writer;
            if Journal::read(other)?.is_some_and(is_open) {
                drop(FolderLock::take(other)?);
            }
        }
        take_back(folder, &journal.records).map_err(Unreturned::into_error)?;
        sync_folder(folder)?;
    }
    let path = folder.join(JOURNAL);
    fs::remove_file(&path).map_err(|e| failed("remove", &path, e))?;
    sync_folder(folder)
}

/// An old file that could not be put back.
struct Unreturned {
    place: PathBuf,
    kept: PathBuf,
    source: io::Error,
}

impl Unreturned {
    fn into_error(self) -> StagingError {
        let Self { place, kept, source } = self;
        StagingError::Kept { cause: None, place, kept, source }
    }
}

/// Puts the old files back, as many as can be, and tells of the first that cannot.
fn take_back(folder: &Path, records: &[Record]) -> Result<(), Unreturned> {
    let mut first = Ok(());
    for record in records.iter().rev() {
        let place = folder.join(&record.name);
        let kept = record.previous.as_ref().map(|previous| folder.join(previous));
        let result = match (there(&place, record), &kept) {
            (Err(error), _) => Err(error),
            // Never replaced, or already back; or changed by somebody since.
            (Ok(There::Other), _) | (Ok(There::Nothing), None) => Ok(()),
            (Ok(There::New), None) => fs::remove_file(&place),
            // The old file has the same content: nothing to put back.
            (Ok(There::New), Some(kept)) if matches!(there(kept, record), Ok(There::New)) => Ok(()),
            (Ok(_), Some(kept)) => match fs::rename(kept, &place) {
                Err(error) if is_missing(&error) => Ok(()),
                other => other,
            },
        };
        if let (Err(source), true) = (result, first.is_ok()) {
            first = Err(Unreturned { kept: kept.unwrap_or_else(|| place.clone()), place, source });
        }
    }
    first
}

/// What stands in a record's place.
enum There {
    Nothing,
    New,
    Other,
}

fn there(place: &Path, record: &Record) -> io::Result<There> {
    match fs::symlink_metadata(place) {
        Err(error) if is_missing(&error) => return Ok(There::Nothing),
        Err(error) => return Err(error),
        Ok(found) if !found.is_file() => return Ok(There::Other),
        Ok(_) => {}
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(place)?)?;
    let is_new = record.blake3.as_deref() == Some(hasher.finalize().to_hex().as_str());
    Ok(if is_new { There::New } else { There::Other })
}
