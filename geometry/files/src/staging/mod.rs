//! Atomic writing of files.
//!
//! Every file is first written under a temporary name beside its place and synced to disk. Only when all of them are
//! complete are they renamed ([`Transaction`]), under the locks of their folders ([`FolderLock`]). After any failure,
//! the temporary files are removed and the old files are unchanged. A process that is killed leaves a journal with
//! which the next writer puts the old files back.

mod file_hash;
mod journal;
mod lock;
mod own_files;
mod transaction;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::{ErrorKind, ErrorSubject, Explained};

pub use file_hash::hash_file;
pub use lock::FolderLock;
use own_files::join_places;
pub use own_files::{OWN_FILES_NAME, write_all};
pub use transaction::Transaction;

/// File name of a folder's list of contents. It is absent while the files that it describes are being replaced.
pub const MANIFEST_FILE: &str = "manifest.json";

/// File to be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// Name within the folder, possibly with subfolders, such as `boards/manifest.json`.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// File that was made outside an export and is listed in its manifest.
#[derive(Clone, Debug)]
pub struct ForeignFile {
    /// Name and content.
    pub file: OutputFile,
    /// Name of the format in the manifest.
    pub format: &'static str,
    /// Names of the bodies that the file contains.
    pub parts: Vec<String>,
}

/// Reason why nothing was written.
///
/// ```
/// use fabkit_files::Explained;
/// use fabkit_files::scratch_folder::ScratchFolder;
/// use fabkit_files::staging::{OutputFile, StagingError, write_all};
///
/// let folder = ScratchFolder::new()?;
/// folder.make_folder("a.txt")?;
/// let files = ["b.txt", "a.txt"].map(|name| OutputFile { name: name.into(), bytes: vec![1] });
/// let error = write_all(folder.path(), &files, &|| false).unwrap_err();
/// assert!(matches!(error, StagingError::Occupied { found: "a folder", .. }));
/// assert_eq!(error.hint().as_deref(), Some("move it away, or choose another place"));
/// assert!(!folder.path_of_file("b.txt").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, thiserror::Error)]
pub enum StagingError {
    /// Error of the operating system.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// Action that failed, for example `write`.
        action: &'static str,
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Something other than a file under the name of an output.
    #[error("cannot replace {}: it is {found}, not a file", .path.display())]
    Occupied {
        /// Path.
        path: PathBuf,
        /// Description of what is there.
        found: &'static str,
    },
    /// Files in a folder that fabkit did not write there, or that somebody changed since.
    #[error("{}", join_places(.places))]
    Foreign {
        /// Paths of the files, at least one.
        places: Vec<PathBuf>,
    },
    /// Folder locked by another process.
    #[error("{} is being written to by {holder}", .folder.display())]
    Locked {
        /// Path of the folder.
        folder: PathBuf,
        /// Holder of the lock: `process 4711 (fabkit export rtac0)`.
        holder: String,
    },
    /// Replaced file that could not be restored after a later file failed.
    #[error(
        "{}cannot put {} back: {source}; its old content is kept as {}",
        .cause.iter().map(|cause| format!("{cause}, and ")).collect::<String>(),
        .place.display(),
        .kept.display()
    )]
    NotRestored {
        /// Original failure; `None` for the remains of an earlier run.
        cause: Option<Box<StagingError>>,
        /// Place of the file.
        place: PathBuf,
        /// Path under which the old content is kept.
        kept: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Stop at the caller's request.
    #[error("interrupted")]
    Cancelled,
}

impl Explained for StagingError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Cancelled => ErrorKind::Interrupted,
            Self::Foreign { .. } => ErrorKind::BadInput,
            _ => ErrorKind::Io,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Io { source, .. } => io_hint(source)?,
            Self::Occupied { .. } => "move it away, or choose another place",
            Self::Foreign { places } if places.len() == 1 => {
                "move it away, or choose another folder"
            }
            Self::Foreign { .. } => "move them away, or choose another folder",
            Self::Locked { .. } => "wait until it has finished, or choose another place",
            Self::NotRestored { .. } => {
                "nothing is lost: the next run that writes there puts it back"
            }
            Self::Cancelled => return None,
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Io { path, source, .. } => ErrorSubject::from_io(path, source, "cannot_write"),
            Self::Occupied { path, .. } => ErrorSubject::from_path("not_a_file", path),
            Self::Foreign { places } => match &places[..] {
                [first, ..] => ErrorSubject::from_path("edited_by_hand", first),
                [] => ErrorSubject::new("edited_by_hand"),
            },
            Self::Locked { folder, .. } => ErrorSubject::from_path("folder_locked", folder),
            Self::NotRestored { place, .. } => ErrorSubject::from_path("not_put_back", place),
            Self::Cancelled => ErrorSubject::new("interrupted"),
        }
    }
}

/// Returns what to do about an error of the operating system, if known.
///
/// ```
/// use std::io;
///
/// use fabkit_files::staging::io_hint;
///
/// let full = io_hint(&io::ErrorKind::StorageFull.into());
/// assert_eq!(full, Some("the disk is full: free some space, or choose another folder"));
/// assert_eq!(io_hint(&io::ErrorKind::TimedOut.into()), None);
/// ```
pub fn io_hint(error: &io::Error) -> Option<&'static str> {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            Some("the disk is full: free some space, or choose another folder")
        }
        io::ErrorKind::FileTooLarge => {
            Some("the file is larger than the system allows here: see `ulimit -f`")
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            Some("choose a folder that you may write to")
        }
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
            Some("part of the path is a file, not a folder: choose another")
        }
        _ => None,
    }
}

/// Writes all files, or none, at places that the user named one by one: what is there is replaced. Files whose names are
/// fabkit's are written by [`write_all`].
///
/// # Errors
/// [`StagingError`]; all folders are then unchanged.
///
/// ```
/// use fabkit_files::scratch_folder::ScratchFolder;
/// use fabkit_files::staging::write_each;
///
/// let (here, there) = (ScratchFolder::new()?, ScratchFolder::new()?);
/// let files = [(here.path_of_file("a"), &b"1"[..]), (there.path_of_file("b"), &b"22"[..])];
/// write_each(files, &|| false)?;
/// assert_eq!((here.read("a"), there.read("b")), (b"1".to_vec(), b"22".to_vec()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_each<'a>(
    files: impl IntoIterator<Item = (PathBuf, &'a [u8])>,
    cancelled: &dyn Fn() -> bool,
) -> Result<(), StagingError> {
    let files: Vec<(PathBuf, &[u8])> = files.into_iter().collect();
    // All folders are locked before anything is written.
    let mut set = Transaction::open(files.iter().map(|(place, _)| place.as_path()), cancelled)?;
    for (place, bytes) in &files {
        if cancelled() {
            return Err(StagingError::Cancelled);
        }
        // On an error, dropping the set removes what was written.
        set.write(place, bytes)?;
    }
    if cancelled() {
        return Err(StagingError::Cancelled);
    }
    set.commit()
}

/// Syncs a folder, which brings the names of its files to disk. Systems that cannot sync folders are accepted; a
/// failing sync is an error.
fn sync_folder(folder: &Path) -> Result<(), StagingError> {
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(error) if !cannot_sync_folders(&error) => Err(failed("sync the folder", folder, error)),
        _ => Ok(()),
    }
}

/// Returns whether the error means that the system cannot sync folders.
fn cannot_sync_folders(error: &io::Error) -> bool {
    let cannot = [io::ErrorKind::Unsupported, io::ErrorKind::InvalidInput];
    // Windows does not open folders as files at all.
    cannot.contains(&error.kind()) || cfg!(windows)
}

/// Refuses places that are taken by something other than a file. Checked before anything moves, because renaming over a
/// folder fails, and over a device it succeeds.
fn check_replaceable(place: &Path) -> Result<(), StagingError> {
    let occupied = |found| Err(StagingError::Occupied { path: place.into(), found });
    match fs::metadata(place) {
        Ok(found) if found.is_file() => Ok(()),
        Ok(found) if found.is_dir() => occupied("a folder"),
        Ok(_) => occupied("a device or a pipe"),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(e) => Err(failed("look at", place, e)),
    }
}

/// Creates an error of the operating system.
fn failed(action: &'static str, path: &Path, source: io::Error) -> StagingError {
    StagingError::Io { action, path: path.into(), source }
}

#[cfg(test)]
mod tests;
