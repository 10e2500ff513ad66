//! What lies in folders: names, kinds, sizes and hashes, without reading what is inside.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use crate::staging::StagingError;

/// Something that lies in a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name; what is not UTF-8 in it is replaced.
    pub name: String,
    /// Where it lies, spelled as it is.
    pub path: PathBuf,
    /// Whether it is a folder itself; links are not followed.
    pub is_folder: bool,
}

impl Entry {
    /// Whether its name can be written down as it is.
    pub fn is_utf8(&self) -> bool {
        self.path.file_name().is_some_and(|name| name.to_str().is_some())
    }
}

/// Lists a folder, in the system's order, piece by piece.
///
/// # Errors
/// The system's reasons, for the folder at once or for an entry.
pub fn entries(folder: &Path) -> io::Result<impl Iterator<Item = io::Result<Entry>>> {
    let entry = |entry: io::Result<fs::DirEntry>| {
        let entry = entry?;
        Ok(Entry {
            name: entry.file_name().to_string_lossy().into_owned(),
            path: entry.path(),
            is_folder: entry.file_type().is_ok_and(|found| found.is_dir()),
        })
    };
    Ok(fs::read_dir(folder)?.map(entry))
}

/// Names of visible files in a folder, links to files among them, and of none where there is no such folder;
/// each with `before` in front. What lies in folders below is left out.
///
/// # Errors
/// [`StagingError::Io`]: the system's reasons.
pub fn visible_files(folder: &Path, before: &str) -> Result<Vec<String>, StagingError> {
    let unreadable =
        |source| StagingError::Io { action: "read the folder", path: folder.into(), source };
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(unreadable)?,
    };
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(unreadable)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !name.starts_with('.') && entry.path().is_file() {
            names.push(format!("{before}{name}"));
        }
    }
    Ok(names)
}

/// Size of whatever has that name, bytes; of a link itself, not of what it names.
pub fn size_bytes(path: &Path) -> Option<u64> {
    fs::symlink_metadata(path).ok().map(|found| found.len())
}

/// Whether anything has that name, be it a link that leads nowhere.
pub fn is_there(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Whether something that is no file has that name: a folder, a device or a link.
pub fn is_no_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| !found.is_file())
}

/// Checks that something is there, following links.
///
/// # Errors
/// The system's reasons.
pub fn look_at(path: &Path) -> io::Result<()> {
    fs::metadata(path).map(drop)
}

/// The one name that all spellings of a path share; the path itself where nothing is there.
pub fn real_path(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.into())
}

/// BLAKE3 of a file's content, in hex; nothing where there is no file.
///
/// # Errors
/// [`StagingError::Io`]: the system's reasons.
pub fn hash_of(path: &Path) -> Result<Option<String>, StagingError> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => {}
        Ok(_) => return Ok(None),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(source) => {
            return Err(StagingError::Io { action: "look at", path: path.into(), source });
        }
    }
    let mut hasher = blake3::Hasher::new();
    File::open(path)
        .and_then(|file| hasher.update_reader(file).map(drop))
        .map_err(|source| StagingError::Io { action: "read", path: path.into(), source })?;
    Ok(Some(hasher.finalize().to_hex().to_string()))
}
