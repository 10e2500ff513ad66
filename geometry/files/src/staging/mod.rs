//! Files that appear whole or not at all.
//!
//! Every file is first written under a temporary name beside its place and synced to disk. Only
//! when all of them are there are they renamed ([`Transaction`]), under the locks of their folders
//! ([`FolderLock`]). Whatever fails, on the way out the temporary files are removed and the files
//! that stood there before are as they were. A process that is killed leaves a journal with which
//! the next writer puts them back.

mod journal;
mod lock;
mod transaction;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::{ErrorKind, ErrorSubject, Explained};

pub use lock::FolderLock;
pub use transaction::Transaction;

/// Name of the list of contents of a folder. While the files that it is about are being replaced,
/// there is none.
pub const CONTENTS: &str = "manifest.json";

/// A file to be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// Name within the folder; may have subfolders before it, `boards/manifest.json`.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// A file made outside of an export that is to stand in its manifest.
#[derive(Clone, Debug)]
pub struct ForeignFile {
    /// Name and content.
    pub file: OutputFile,
    /// The word used in the manifest.
    pub format: &'static str,
    /// Which bodies it holds.
    pub parts: Vec<String>,
}

/// Why nothing was written.
#[derive(Debug, thiserror::Error)]
pub enum StagingError {
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
    /// Something other than a file has the name of an output.
    #[error("cannot replace {}: it is {found}, not a file", .path.display())]
    Occupied {
        /// Where.
        path: PathBuf,
        /// What is there.
        found: &'static str,
    },
    /// Another process writes into the folder.
    #[error("{} is being written to by {holder}", .folder.display())]
    Locked {
        /// Which folder.
        folder: PathBuf,
        /// Who: `process 4711 (fabkit export rtac0)`.
        holder: String,
    },
    /// A file was replaced, another could not be, and the first cannot be put back.
    #[error(
        "{}cannot put {} back: {source}; its old content is kept as {}",
        .cause.iter().map(|cause| format!("{cause}, and ")).collect::<String>(),
        .place.display(),
        .kept.display()
    )]
    Kept {
        /// Why it was to be put back; nothing for what an earlier run left.
        cause: Option<Box<StagingError>>,
        /// Where it stood.
        place: PathBuf,
        /// Where it is.
        kept: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The caller asked to stop.
    #[error("interrupted")]
    Cancelled,
}

impl Explained for StagingError {
    fn kind(&self) -> ErrorKind {
        if matches!(self, Self::Cancelled) { ErrorKind::Interrupted } else { ErrorKind::Io }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Io { source, .. } => io_hint(source)?,
            Self::Occupied { .. } => "move it away, or choose another place",
            Self::Locked { .. } => "wait until it has finished, or choose another place",
            Self::Kept { .. } => "nothing is lost: the next run that writes there puts it back",
            Self::Cancelled => return None,
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Io { path, source, .. } => ErrorSubject::of_io(path, source, "cannot_write"),
            Self::Occupied { path, .. } => ErrorSubject::at("not_a_file", path),
            Self::Locked { folder, .. } => ErrorSubject::at("folder_locked", folder),
            Self::Kept { place, .. } => ErrorSubject::at("not_put_back", place),
            Self::Cancelled => ErrorSubject::new("interrupted"),
        }
    }
}

/// What to do about an error of the operating system, where that is known.
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

/// Writes all files into the folder, which is made if it is missing, with its subfolders, or none.
///
/// `cancelled` is asked before each write; from the first rename on there is no stopping.
///
/// # Errors
/// [`StagingError`]; the folder is then as it was.
pub fn write_all(
    folder: &Path,
    files: &[OutputFile],
    cancelled: &dyn Fn() -> bool,
) -> Result<(), StagingError> {
    write_each(files.iter().map(|file| (folder.join(&file.name), &file.bytes[..])), cancelled)
}

/// Writes all files, wherever they are to lie, or none.
///
/// # Errors
/// As [`write_all`].
pub fn write_each<'a>(
    files: impl IntoIterator<Item = (PathBuf, &'a [u8])>,
    cancelled: &dyn Fn() -> bool,
) -> Result<(), StagingError> {
    let files: Vec<(PathBuf, &[u8])> = files.into_iter().collect();
    let mut set = Transaction::open(files.iter().map(|(place, _)| place.as_path()), cancelled)?;
    for (place, bytes) in &files {
        if cancelled() {
            return Err(StagingError::Cancelled);
        }
        set.write(place, bytes)?;
    }
    if cancelled() {
        return Err(StagingError::Cancelled);
    }
    set.commit()
}

/// The names of files reach the disk with their folder. A system that cannot sync folders is no
/// failure; one that can, and fails, is.
fn sync_folder(folder: &Path) -> Result<(), StagingError> {
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(error) if !cannot_sync_folders(&error) => Err(failed("sync the folder", folder, error)),
        _ => Ok(()),
    }
}

fn cannot_sync_folders(error: &io::Error) -> bool {
    let cannot = [io::ErrorKind::Unsupported, io::ErrorKind::InvalidInput];
    // Windows does not open folders as files at all.
    cannot.contains(&error.kind()) || cfg!(windows)
}

/// Renaming over a folder fails, and over a device it succeeds: refuse both before anything moves.
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

fn failed(action: &'static str, path: &Path, source: io::Error) -> StagingError {
    StagingError::Io { action, path: path.into(), source }
}

#[cfg(test)]
mod tests;
