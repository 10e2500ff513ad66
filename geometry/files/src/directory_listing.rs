//! Listing of folders: names, kinds, sizes and hashes of their entries.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::staging::StagingError;

/// Entry of a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DirectoryEntry {
    /// Name, with replacement characters where it is not UTF-8.
    pub name: String,
    /// Path with the exact name.
    pub path: PathBuf,
    /// True for a folder; links are not followed.
    pub is_folder: bool,
}

impl DirectoryEntry {
    /// Returns whether the name is valid UTF-8, so that `name` is exact.
    pub fn is_utf8(&self) -> bool {
        self.path.file_name().is_some_and(|name| name.to_str().is_some())
    }
}

/// Lists a folder lazily, in the order of the operating system.
///
/// # Errors
/// Those of the operating system, for the folder at once or for single entries.
///
/// ```
/// use fabkit_files::directory_listing::list_entries;
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// folder.make_folder("images")?;
/// folder.write(".hidden", b"")?;
/// let mut entries = list_entries(folder.path())?.collect::<Result<Vec<_>, _>>()?;
/// entries.sort_by(|a, b| a.name.cmp(&b.name));
/// let found: Vec<_> = entries.iter().map(|entry| (&*entry.name, entry.is_folder)).collect();
/// assert_eq!(found, [(".hidden", false), ("images", true)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn list_entries(folder: &Path) -> io::Result<impl Iterator<Item = io::Result<DirectoryEntry>>> {
    let entry = |entry: io::Result<fs::DirEntry>| {
        let entry = entry?;
        Ok(DirectoryEntry {
            name: entry.file_name().to_string_lossy().into_owned(),
            path: entry.path(),
            // Does not follow links, unlike `path.is_dir()`.
            is_folder: entry.file_type().is_ok_and(|found| found.is_dir()),
        })
    };
    Ok(fs::read_dir(folder)?.map(entry))
}

/// Lists the names of visible files in a folder, each with `before` in front. Links to files count; subfolders do not.
/// A missing folder has no files.
///
/// # Errors
/// [`StagingError::Io`] for errors of the operating system.
///
/// ```
/// use fabkit_files::directory_listing::list_visible_files;
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// folder.write("shell.stl", b"")?;
/// folder.write(".hidden", b"")?;
/// folder.make_folder("boards")?;
/// assert_eq!(list_visible_files(folder.path(), "parts/")?, ["parts/shell.stl"]);
/// assert!(list_visible_files(&folder.path_of_file("none"), "")?.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn list_visible_files(folder: &Path, before: &str) -> Result<Vec<String>, StagingError> {
    let unreadable =
        |source| StagingError::Io { action: "read the folder", path: folder.into(), source };
    let entries = match fs::read_dir(folder) {
        // A folder that does not exist yet has no files.
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

/// Returns the size in bytes; of a link itself, not of its target.
pub fn size_bytes(path: &Path) -> Option<u64> {
    fs::symlink_metadata(path).ok().map(|found| found.len())
}

/// Returns whether the path exists, even as a broken link.
pub fn exists_or_dangles(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Returns whether the path exists and is not a regular file: a folder, a device or a link.
pub fn is_not_a_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| !found.is_file())
}

/// Checks that the path exists, following links.
///
/// # Errors
/// Those of the operating system.
pub fn check_exists(path: &Path) -> io::Result<()> {
    fs::metadata(path).map(drop)
}

/// Returns the canonical path, or the path itself if it does not exist.
pub fn canonical_path(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.into())
}
