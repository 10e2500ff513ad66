//! Files that appear whole or not at all.
//!
//! Every file is first written under a temporary name beside its place and synced to disk. Only
//! when all of them are there are they renamed, in order. Whatever fails, on the way out the
//! temporary files are removed and the files that stood there before are as they were.

mod lock;

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub use lock::FolderLock;

/// A file to be written.
#[derive(Clone, Debug)]
pub struct OutputFile {
    /// Name within the folder; may have subfolders before it, `boards/manifest.json`.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
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
    /// The caller asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl StagingError {
    /// What to do about it, where that is known.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Io { source, .. } => io_hint(source),
            Self::Occupied { .. } => Some("move it away, or choose another place with -o"),
            Self::Locked { .. } => {
                Some("wait until it has finished, or choose another place with -o")
            }
            Self::Cancelled => None,
        }
    }
}

/// What to do about an error of the operating system, where that is known.
pub fn io_hint(error: &io::Error) -> Option<&'static str> {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            Some("the disk is full: free some space, or choose another folder with -o")
        }
        io::ErrorKind::FileTooLarge => {
            Some("the file is larger than the system allows here: see `ulimit -f`")
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            Some("choose a folder that you may write to with -o")
        }
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
            Some("part of the path is a file, not a folder: choose another with -o")
        }
        _ => None,
    }
}

/// Writes all files into the folder, which is made if it is missing, with its subfolders, or none.
///
/// They are renamed into place in the order given: put a list of contents last. `cancelled` is
/// asked before each write; from the first rename on there is no stopping.
///
/// # Errors
/// [`StagingError`]; the folder is then as it was.
pub fn write_all(
    folder: &Path,
    files: &[OutputFile],
    cancelled: &dyn Fn() -> bool,
) -> Result<(), StagingError> {
    let mut stage = Stage::open(folder)?;
    for file in files {
        if cancelled() {
            return Err(StagingError::Cancelled);
        }
        stage.add(file)?;
    }
    if cancelled() {
        return Err(StagingError::Cancelled);
    }
    stage.commit()
}

/// Undoes on drop whatever was not committed.
struct Stage<'a> {
    folder: &'a Path,
    /// Folders made for this, outermost first.
    made: Vec<PathBuf>,
    entries: Vec<Entry>,
    committed: bool,
}

struct Entry {
    temporary: PathBuf,
    place: PathBuf,
    /// A second name for the file that stood there before.
    previous: Option<PathBuf>,
    renamed: bool,
}

impl<'a> Stage<'a> {
    fn open(folder: &'a Path) -> Result<Self, StagingError> {
        let mut stage = Self { folder, made: Vec::new(), entries: Vec::new(), committed: false };
        stage.make(folder)?;
        Ok(stage)
    }

    fn make(&mut self, folder: &Path) -> Result<(), StagingError> {
        let missing = folder
            .ancestors()
            .take_while(|path| !path.as_os_str().is_empty() && !path.exists())
            .map(Path::to_path_buf);
        let missing: Vec<PathBuf> = missing.collect();
        self.made.extend(missing.into_iter().rev());
        fs::create_dir_all(folder).map_err(|e| failed("create the folder", folder, e))
    }

    fn add(&mut self, file: &OutputFile) -> Result<(), StagingError> {
        let place = self.folder.join(&file.name);
        let folder = place.parent().unwrap_or(self.folder).to_path_buf();
        self.make(&folder)?;
        check_replaceable(&place)?;
        let process = std::process::id();
        let name = place.file_name().unwrap_or_default().to_string_lossy();
        let hidden = |suffix| folder.join(format!(".{name}.{process}.{suffix}"));
        let (temporary, previous) = (hidden("new"), hidden("old"));
        let mut handle =
            File::create_new(&temporary).map_err(|e| failed("create", &temporary, e))?;
        // From here on the temporary file is ours to remove.
        let previous = place.exists().then_some(previous);
        self.entries.push(Entry { temporary, place: place.clone(), previous, renamed: false });
        handle.write_all(&file.bytes).map_err(|e| failed("write", &place, e))?;
        handle.sync_all().map_err(|e| failed("write", &place, e))
    }

    fn commit(mut self) -> Result<(), StagingError> {
        for entry in &mut self.entries {
            if let Some(previous) = &entry.previous {
                // File systems without hard links get a copy.
                fs::hard_link(&entry.place, previous)
                    .or_else(|_| fs::copy(&entry.place, previous).map(drop))
                    .map_err(|e| failed("keep", &entry.place, e))?;
            }
            fs::rename(&entry.temporary, &entry.place)
                .map_err(|e| failed("write", &entry.place, e))?;
            entry.renamed = true;
        }
        self.committed = true;
        let folders = self.entries.iter().filter_map(|entry| entry.place.parent());
        folders.collect::<BTreeSet<&Path>>().into_iter().try_for_each(sync_folder)
    }
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

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        // Best effort: there is nobody left to tell, and the first error is already on its way.
        for entry in self.entries.iter().rev() {
            if !self.committed && entry.renamed {
                let _ = match &entry.previous {
                    Some(previous) => fs::rename(previous, &entry.place),
                    None => fs::remove_file(&entry.place),
                };
            }
            if !entry.renamed {
                let _ = fs::remove_file(&entry.temporary);
            }
            if let Some(previous) = &entry.previous {
                let _ = fs::remove_file(previous);
            }
        }
        if !self.committed {
            for folder in self.made.iter().rev() {
                let _ = fs::remove_dir(folder);
            }
        }
    }
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
mod tests {
    use super::*;

    fn file(name: &str, text: &str) -> OutputFile {
        OutputFile { name: name.into(), bytes: text.into() }
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn all_files_appear_and_replace_older_ones() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("new/deep");
        write_all(&folder, &[file("a", "1"), file("b", "2")], &|| false).unwrap();
        write_all(&folder, &[file("b", "3"), file("c", "4")], &|| false).unwrap();
        assert_eq!(names(&folder), ["a", "b", "c"]);
        assert_eq!(fs::read(folder.join("b")).unwrap(), b"3");
    }

    #[test]
    fn subfolders_are_made_and_unmade_with_their_files() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("new");
        let files = [file("a", "1"), file("sub/deep/a", "2"), file("sub/b", "3")];
        write_all(&folder, &files, &|| false).unwrap();
        assert_eq!(names(&folder), ["a", "sub"]);
        assert_eq!(names(&folder.join("sub")), ["b", "deep"]);
        assert_eq!(fs::read(folder.join("sub/deep/a")).unwrap(), b"2");
        // A file where a folder should be: nothing of the new files is left.
        let files = [file("c/x", "1"), file("a/x", "2")];
        let error = write_all(&folder, &files, &|| false).unwrap_err();
        assert!(error.to_string().contains("create the folder"), "{error}");
        assert_eq!(names(&folder), ["a", "sub"]);
    }

    #[test]
    fn a_failure_after_some_writes_leaves_everything_as_it_was() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("a"), "old").unwrap();
        fs::create_dir(root.path().join("z")).unwrap();
        let result = write_all(root.path(), &[file("a", "new"), file("z", "new")], &|| false);
        let message = result.unwrap_err().to_string();
        assert!(message.ends_with("z: it is a folder, not a file"), "{message}");
        assert_eq!(names(root.path()), ["a", "z"]);
        assert_eq!(fs::read(root.path().join("a")).unwrap(), b"old");
    }

    /// A rename that fails after another has succeeded: the first is taken back.
    #[test]
    fn a_failed_rename_takes_the_others_back() {
        let root = tempfile::tempdir().unwrap();
        fs::write(root.path().join("a"), "old").unwrap();
        let mut stage = Stage::open(root.path()).unwrap();
        for name in ["a", "b", "c"] {
            stage.add(&file(name, "new")).unwrap();
        }
        fs::remove_file(&stage.entries[2].temporary).unwrap();
        assert!(stage.commit().is_err());
        assert_eq!(names(root.path()), ["a"]);
        assert_eq!(fs::read(root.path().join("a")).unwrap(), b"old");
    }

    #[test]
    fn stopping_removes_what_was_made_folders_included() {
        let root = tempfile::tempdir().unwrap();
        let asked = std::cell::Cell::new(0);
        let cancelled = || asked.replace(asked.get() + 1) == 1;
        let files = [file("a", "1"), file("b", "2")];
        let result = write_all(&root.path().join("x/y"), &files, &cancelled);
        assert!(matches!(result, Err(StagingError::Cancelled)));
        assert_eq!(names(root.path()), [""; 0]);
    }
}
