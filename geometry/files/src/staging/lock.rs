//! Locks that allow one writer per folder.
//!
//! A writer holds the lock of its folder: a file that the operating system lets one process lock, and unlocks when that
//! process ends, however it ends. Under the lock, every temporary file of another writer is the remains of a dead one,
//! and is removed.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use super::{StagingError, check_replaceable, failed, journal, sync_folder};

/// Name prefix of all of fabkit's internal files in a folder.
pub(super) const HIDDEN_PREFIX: &str = ".fabkit-";
/// File name of the lock.
const LOCK_FILE: &str = ".fabkit-lock";
/// Maximum number of attempts when the lock file vanishes between opening and locking it. More than that means that
/// something else is wrong.
const ATTEMPTS: usize = 100;
/// Maximum length of the lock holder's description that is repeated in messages, bytes.
const MAX_HOLDER_BYTES: u64 = 400;

/// Exclusive right to write into a folder, released when dropped.
///
/// ```
/// use fabkit_files::scratch_folder::ScratchFolder;
/// use fabkit_files::staging::FolderLock;
///
/// let folder = ScratchFolder::new()?;
/// let lock = FolderLock::acquire(folder.path())?;
/// assert!(FolderLock::acquire(folder.path()).is_err());
/// lock.put("notes/a.txt", b"whole or not at all")?;
/// drop(lock);
/// assert_eq!(folder.read("notes/a.txt"), b"whole or not at all");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FolderLock {
    folder: PathBuf,
    /// Lock file, held open: closing it releases the lock.
    file: Option<File>,
    /// Identifier that differs from every other writer's, including writers in other containers with the same process
    /// number.
    writer: String,
    next_temporary: AtomicU64,
}

impl FolderLock {
    /// Locks the folder, which is created if it is missing. Then undoes what a killed writer left unfinished, and
    /// removes its temporary files.
    ///
    /// On file systems without locks, it goes on without one.
    ///
    /// # Errors
    /// [`StagingError::Locked`] if another process writes there now; [`StagingError::Io`].
    pub fn acquire(folder: &Path) -> Result<Self, StagingError> {
        let path = folder.join(LOCK_FILE);
        let writer = unique_id();
        let holder = format!("process {} ({})\n{writer}\n", std::process::id(), command_line());
        for _ in 0..ATTEMPTS {
            fs::create_dir_all(folder).map_err(|e| failed("create the folder", folder, e))?;
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            check_replaceable(&path)?;
            let mut file = match options.open(&path) {
                Ok(file) => file,
                // The process that created the folder has just removed it again.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(failed("write into", folder, error)),
            };
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let holder = read_holder(&mut file);
                    return Err(StagingError::Locked { folder: folder.into(), holder });
                }
                Err(TryLockError::Error(error)) if has_no_locks(&error) => {}
                Err(TryLockError::Error(error)) => return Err(failed("lock", &path, error)),
            }
            // The first line names the holder in messages to others. The second is unique and identifies this lock.
            let written = file
                .set_len(0)
                .and_then(|()| file.rewind())
                .and_then(|()| file.write_all(holder.as_bytes()));
            written.map_err(|e| {
                remove_if_same(&file, &path);
                failed("write", &path, e)
            })?;
            // The last holder may have removed the file between our opening and locking it. The locked file then has no
            // name any more, and locks nobody out.
            let there = match fs::read_to_string(&path) {
                Ok(there) => there,
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => {
                    remove_if_same(&file, &path);
                    return Err(failed("lock", &path, error));
                }
            };
            if there == holder {
                let lock = Self {
                    folder: folder.into(),
                    file: Some(file),
                    writer,
                    next_temporary: AtomicU64::new(0),
                };
                journal::recover(folder)?;
                lock.remove_leftovers()?;
                return Ok(lock);
            }
        }
        let error = io::Error::other("the lock vanished each time that it was taken");
        Err(failed("lock", &path, error))
    }

    /// Returns the locked folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Writes one file atomically; the name may contain subfolders.
    ///
    /// # Errors
    /// [`StagingError`]; the old file is then unchanged.
    pub fn put(&self, name: &str, bytes: &[u8]) -> Result<(), StagingError> {
        let place = self.folder.join(name);
        let parent = place.parent().unwrap_or(&self.folder);
        fs::create_dir_all(parent).map_err(|e| failed("create the folder", parent, e))?;
        check_replaceable(&place)?;
        let temporary = self.temporary_path();
        let written = File::create_new(&temporary).and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        });
        let renamed = written.and_then(|()| fs::rename(&temporary, &place));
        renamed.map_err(|error| {
            // A full disk must not keep half-written files.
            let _ = fs::remove_file(&temporary);
            failed("write", &place, error)
        })?;
        sync_folder(parent)
    }

    /// Returns the identifier of this writer.
    pub(super) fn writer(&self) -> &str {
        &self.writer
    }

    /// Returns an unused path in the folder for a temporary file. Its name is short, whatever the final name is.
    pub(super) fn temporary_path(&self) -> PathBuf {
        let number = self.next_temporary.fetch_add(1, Ordering::Relaxed);
        self.folder.join(format!("{HIDDEN_PREFIX}{}-{number}", self.writer))
    }

    /// Removes temporary files of dead writers.
    fn remove_leftovers(&self) -> Result<(), StagingError> {
        let unreadable = |e| failed("read the folder", &self.folder, e);
        for entry in fs::read_dir(&self.folder).map_err(unreadable)? {
            let name = entry.map_err(unreadable)?.file_name();
            let is_ours =
                name.to_str().is_some_and(|n| n.starts_with(HIDDEN_PREFIX) && n != LOCK_FILE);
            if is_ours {
                let path = self.folder.join(name);
                fs::remove_file(&path).map_err(|e| failed("remove", &path, e))?;
            }
        }
        Ok(())
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // The file is removed while the lock is still held, so that nobody locks a file without a name. Best effort: a
        // lock file that stays locks nobody out.
        let _ = fs::remove_file(self.folder.join(LOCK_FILE));
        drop(self.file.take());
    }
}

/// Removes a locked file, if `path` still refers to it. Best effort: a lock file that stays locks nobody out.
#[cfg(unix)]
fn remove_if_same(file: &File, path: &Path) {
    use std::os::unix::fs::MetadataExt;
    if let (Ok(ours), Ok(there)) = (file.metadata(), fs::metadata(path))
        && (ours.dev(), ours.ino()) == (there.dev(), there.ino())
    {
        let _ = fs::remove_file(path);
    }
}

#[cfg(not(unix))]
fn remove_ours(_: &File, _: &Path) {}

/// Returns whether the error means that the file system has no locks, as some network file systems.
fn has_no_locks(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::Unsupported
}

/// Reads who holds the lock.
fn read_holder(file: &mut File) -> String {
    let mut text = String::new();
    let read = file.take(MAX_HOLDER_BYTES).read_to_string(&mut text);
    match (read, text.lines().next()) {
        (Ok(_), Some(holder)) => holder.to_owned(),
        // The holder has just taken the lock and not yet written its name, or the system does not let others read.
        _ => "another process".to_owned(),
    }
}

/// Returns the command line of this process, shortened.
fn command_line() -> String {
    let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let line: String = words.collect::<Vec<_>>().join(" ");
    line.chars().map(|c| if c.is_control() { ' ' } else { c }).take(200).collect()
}

/// Creates an identifier that is unique with overwhelming likelihood, from process number, time, and a random seed that
/// the standard library draws for each process.
fn unique_id() -> String {
    use std::hash::{BuildHasher, Hasher, RandomState};
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let mut hasher = RandomState::new().build_hasher();
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    hasher.write_u128(now.as_nanos());
    hasher.write_u32(std::process::id());
    hasher.write_u64(COUNT.fetch_add(1, Ordering::Relaxed));
    format!("{:016x}", hasher.finish())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_locked_folder_names_its_holder() {
        let root = tempfile::tempdir().unwrap();
        let lock = FolderLock::acquire(root.path()).unwrap();
        let error = FolderLock::acquire(root.path()).unwrap_err();
        let expected = format!("process {}", std::process::id());
        assert!(error.to_string().contains(&expected), "{error}");
        drop(lock);
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
        FolderLock::acquire(root.path()).unwrap();
    }

    #[test]
    fn leftovers_of_a_dead_writer_are_removed_and_nothing_else() {
        let root = tempfile::tempdir().unwrap();
        for name in [".fabkit-0123456789abcdef-7", LOCK_FILE, ".fabkitrc", "a.stl"] {
            fs::write(root.path().join(name), "x").unwrap();
        }
        drop(FolderLock::acquire(root.path()).unwrap());
        let mut names: Vec<_> =
            fs::read_dir(root.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, [".fabkitrc", "a.stl"]);
    }

    #[test]
    fn long_names_can_be_written() {
        let root = tempfile::tempdir().unwrap();
        let lock = FolderLock::acquire(root.path()).unwrap();
        let name = "x".repeat(255);
        lock.put(&name, b"1").unwrap();
        assert_eq!(fs::read(root.path().join(name)).unwrap(), b"1");
    }
}
