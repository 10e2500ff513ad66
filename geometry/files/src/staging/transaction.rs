//! Sets of files in one or more folders that are replaced together, or not at all.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::journal::{JOURNAL, Journal, Record};
use super::lock::FolderLock;
use super::{MANIFEST_FILE, StagingError, check_replaceable, failed, sync_folder};

/// Maximum time to wait for another writer of the same folder. Many runs may write there in parallel, and each takes
/// less than a second.
const LOCK_TIMEOUT: Duration = Duration::from_secs(20);
/// Time between two attempts to lock a folder.
const POLL: Duration = Duration::from_millis(10);

/// Set of files being written. Everything is undone unless it is committed.
///
/// ```
/// use fabkit_files::scratch_folder::ScratchFolder;
/// use fabkit_files::staging::Transaction;
///
/// let root = ScratchFolder::new()?;
/// let [a, b] = ["here/a.txt", "there/b.txt"].map(|name| root.path_of_file(name));
/// let mut set = Transaction::open([a.as_path(), b.as_path()], &|| false)?;
/// set.write(&a, b"1")?;
/// set.write(&b, b"2")?;
/// assert!(!a.exists());
/// set.commit()?;
/// assert_eq!(std::fs::read(&b)?, b"2");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Transaction {
    /// Folders created for this set, outermost first.
    created_folders: Vec<PathBuf>,
    /// Canonical folders with their locks. The journal of the first one decides.
    folders: Vec<(PathBuf, FolderLock)>,
    /// Index into `folders`, by the spelling that the caller uses.
    by_spelling: BTreeMap<PathBuf, usize>,
    entries: Vec<Entry>,
    committed: bool,
}

/// File of the set.
#[derive(Debug)]
struct Entry {
    folder: usize,
    place: PathBuf,
    /// New content; `None` for a file to be removed.
    new: Option<Staged>,
    /// Hidden name under which the old file is kept.
    previous: Option<PathBuf>,
}

/// New content under its temporary name.
#[derive(Debug)]
struct Staged {
    temporary: PathBuf,
    blake3: blake3::Hash,
}

impl Entry {
    /// Returns whether the file is a folder's list of contents.
    fn is_contents(&self) -> bool {
        self.place.file_name().is_some_and(|name| name == MANIFEST_FILE)
    }

    /// Returns whether the old file is hidden while others are replaced: lists of contents and removed files.
    fn is_hidden_first(&self) -> bool {
        self.is_contents() || self.new.is_none()
    }
}

impl Transaction {
    /// Creates the missing folders of these files and locks all of them.
    ///
    /// Waits for other writers until `cancelled` returns true.
    ///
    /// # Errors
    /// [`StagingError`]; created folders are removed again.
    pub fn open<'a>(
        places: impl IntoIterator<Item = &'a Path>,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Self, StagingError> {
        let mut set = Self {
            created_folders: Vec::new(),
            folders: Vec::new(),
            by_spelling: BTreeMap::new(),
            entries: Vec::new(),
            committed: false,
        };
        let spellings: BTreeSet<PathBuf> = places.into_iter().map(parent_folder).collect();
        let mut by_identity: BTreeMap<PathBuf, Vec<PathBuf>> = BTreeMap::new();
        for folder in spellings {
            set.create_folders(&folder)?;
            let real = fs::canonicalize(&folder).map_err(|e| failed("look at", &folder, e))?;
            by_identity.entry(real).or_default().push(folder);
        }
        // Everybody locks in the same order, so that no two processes wait for each other.
        for (real, spellings) in by_identity {
            let lock = acquire_lock(&spellings[0], cancelled)?;
            let index = set.folders.len();
            set.by_spelling.extend(spellings.into_iter().map(|folder| (folder, index)));
            set.folders.push((real, lock));
        }
        Ok(set)
    }

    /// Writes the new content of a file under a hidden name and syncs it to disk.
    ///
    /// # Errors
    /// [`StagingError`].
    pub fn write(&mut self, place: &Path, bytes: &[u8]) -> Result<(), StagingError> {
        check_replaceable(place)?;
        let folder = self.index_of(place)?;
        let temporary = self.folders[folder].1.temporary_path();
        let mut file = File::create_new(&temporary).map_err(|e| failed("write", place, e))?;
        // From here on, the temporary file is removed on drop.
        let new = Some(Staged { temporary, blake3: blake3::hash(bytes) });
        self.entries.push(Entry { folder, place: place.into(), new, previous: None });
        file.write_all(bytes).map_err(|e| failed("write", place, e))?;
        file.sync_all().map_err(|e| failed("write", place, e))
    }

    /// Schedules a file for removal at commit.
    ///
    /// # Errors
    /// [`StagingError`].
    ///
    /// ```
    /// use fabkit_files::scratch_folder::ScratchFolder;
    /// use fabkit_files::staging::Transaction;
    ///
    /// let folder = ScratchFolder::new()?;
    /// folder.write("old.stl", b"1")?;
    /// let [old, new] = ["old.stl", "new.stl"].map(|name| folder.path_of_file(name));
    /// let mut set = Transaction::open([old.as_path(), new.as_path()], &|| false)?;
    /// set.remove(&old)?;
    /// set.write(&new, b"2")?;
    /// assert!(old.exists() && !new.exists());
    /// set.commit()?;
    /// assert!(!old.exists() && new.exists());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn remove(&mut self, place: &Path) -> Result<(), StagingError> {
        check_replaceable(place)?;
        let folder = self.index_of(place)?;
        self.entries.push(Entry { folder, place: place.into(), new: None, previous: None });
        Ok(())
    }

    /// Moves all files to their places, lists of contents last.
    ///
    /// # Errors
    /// [`StagingError`]; all files are then unchanged. If they cannot even be restored, [`StagingError::NotRestored`] names
    /// the copy, and the next writer restores it.
    pub fn commit(mut self) -> Result<(), StagingError> {
        // The sort is stable: other files keep the given order.
        self.entries.sort_by_key(Entry::is_contents);
        if let [Entry { place, new: Some(new), folder, .. }] = &self.entries[..] {
            // A single renaming is atomic and needs no journal.
            fs::rename(&new.temporary, place).map_err(|e| failed("write", place, e))?;
            let folder = *folder;
            self.entries.clear();
            self.committed = true;
            return sync_folder(self.folders[folder].1.folder());
        }
        self.keep_previous()?;
        let records = self.records();
        self.write_journals(&records)?;
        let mut done = 0;
        if let Err(cause) = self.rename_all(&mut done) {
            return Err(self.undo(done, cause));
        }
        self.committed = true;
        // Failures from here on are harmless: the next writer removes the remains.
        for (_, lock) in self.folders.iter().skip(1) {
            let _ = fs::remove_file(lock.folder().join(JOURNAL));
        }
        match self.folders.first() {
            Some((_, lock)) => sync_folder(lock.folder()),
            None => Ok(()),
        }
    }

    /// Creates a folder with its missing parents.
    fn create_folders(&mut self, folder: &Path) -> Result<(), StagingError> {
        let missing = folder
            .ancestors()
            .take_while(|path| !path.as_os_str().is_empty() && !path.exists())
            .map(Path::to_path_buf);
        let missing: Vec<PathBuf> = missing.collect();
        // Recorded before they are created, so that a partial creation is undone too.
        self.created_folders.extend(missing.into_iter().rev());
        fs::create_dir_all(folder).map_err(|e| failed("create the folder", folder, e))
    }

    /// Returns the index of a file's folder.
    fn index_of(&self, place: &Path) -> Result<usize, StagingError> {
        let index = self.by_spelling.get(&parent_folder(place)).copied();
        let closed = || io::Error::other("its folder was not opened for this");
        index.ok_or_else(|| failed("write", place, closed()))
    }

    /// Gives a second name to every file that will be replaced.
    fn keep_previous(&mut self) -> Result<(), StagingError> {
        for entry in &mut self.entries {
            if fs::symlink_metadata(&entry.place).is_err() {
                continue;
            }
            let previous = self.folders[entry.folder].1.temporary_path();
            // Files that are hidden first are moved there during the switch.
            let stays = !entry.is_hidden_first();
            let (place, to) = (&entry.place, &previous);
            let kept = match stays {
                // File systems without hard links get a copy.
                true => fs::hard_link(place, to).or_else(|_| {
                    fs::copy(place, to)?;
                    File::open(to)?.sync_all()
                }),
                false => Ok(()),
            };
            // Recorded before the error is returned, so that a partial copy is removed too.
            entry.previous = Some(previous);
            kept.map_err(|e| failed("keep", &entry.place, e))?;
        }
        Ok(())
    }

    /// Returns the journal records of each folder.
    fn records(&self) -> Vec<Vec<Record>> {
        let mut records = vec![Vec::new(); self.folders.len()];
        let name = |path: &Path| path.file_name().map(OsString::from).unwrap_or_default();
        for Entry { folder, place, new, previous } in &self.entries {
            records[*folder].push(Record {
                name: name(place),
                previous: previous.as_deref().map(name),
                blake3: new.as_ref().map(|new| new.blake3.to_hex().to_string()),
            });
        }
        records
    }

    /// Writes the journals of all folders, the deciding one last.
    fn write_journals(&self, records: &[Vec<Record>]) -> Result<(), StagingError> {
        let Some(((first, lead), others)) = self.folders.split_first() else { return Ok(()) };
        let paths: Vec<&PathBuf> = others.iter().map(|(real, _)| real).collect();
        let write = |lock: &FolderLock, others: &[&PathBuf], records: &Vec<Record>| {
            // `put` syncs the folder, and with it the names of the staged files.
            Journal::new(lead.writer(), first, others, records.clone()).write(lock)
        };
        for ((_, lock), records) in others.iter().zip(&records[1..]) {
            write(lock, &[], records)?;
        }
        write(lead, &paths, &records[0])
    }

    /// Renames all files. Only here old and new are mixed, so there is nothing but renames, and no list of contents
    /// that could be wrong. `done` counts the renames.
    fn rename_all(&self, done: &mut usize) -> Result<(), StagingError> {
        for Rename { from, to, .. } in self.renames() {
            fs::rename(from, to).map_err(|e| failed("write", to, e))?;
            *done += 1;
        }
        for (_, lock) in &self.folders {
            sync_folder(lock.folder())?;
        }
        if let Some((_, lead)) = self.folders.first() {
            let journal = lead.folder().join(JOURNAL);
            fs::remove_file(&journal).map_err(|e| failed("remove", &journal, e))?;
        }
        Ok(())
    }

    /// Lists the renames in order: removed files and old lists of contents leave first, new lists come last.
    fn renames(&self) -> Vec<Rename<'_>> {
        let mut renames = Vec::new();
        for entry in self.entries.iter().filter(|entry| entry.is_hidden_first()) {
            if let Some(previous) = entry.previous.as_deref() {
                renames.push(Rename {
                    from: &entry.place,
                    to: previous,
                    back: Undo::Rename(previous),
                });
            }
        }
        for entry in &self.entries {
            let Some(new) = &entry.new else { continue };
            let back = match entry.previous.as_deref() {
                None => Undo::Remove,
                // The old file returns when its own renaming is undone.
                Some(_) if entry.is_hidden_first() => Undo::Nothing,
                Some(previous) => Undo::Rename(previous),
            };
            renames.push(Rename { from: &new.temporary, to: &entry.place, back });
        }
        renames
    }

    /// Undoes the first `done` renames. What cannot be undone now is left, with its journal, to the next writer.
    fn undo(&mut self, done: usize, cause: StagingError) -> StagingError {
        let mut unreturned = None;
        for Rename { from, to, back } in self.renames().into_iter().take(done).rev() {
            // A hidden file returns to where it came from; any other old file replaces the new one.
            let (place, kept, result) = match back {
                Undo::Nothing => continue,
                Undo::Remove => (to, to, fs::remove_file(to)),
                Undo::Rename(previous) if previous == to => (from, to, fs::rename(to, from)),
                Undo::Rename(previous) => (to, previous, fs::rename(previous, to)),
            };
            if let (Err(source), None) = (result, &unreturned) {
                unreturned = Some((place.to_owned(), kept.to_owned(), source));
            }
        }
        let Some((place, kept, source)) = unreturned else { return cause };
        // Nothing is removed on drop, because these may be the last copies of the old files.
        self.entries.clear();
        self.created_folders.clear();
        StagingError::NotRestored { cause: Some(Box::new(cause)), place, kept, source }
    }
}

/// One renaming of a switch, and how it is undone.
struct Rename<'a> {
    from: &'a Path,
    to: &'a Path,
    back: Undo<'a>,
}

/// Way to undo a renaming: nothing to do, removal of the new file, or renaming of the old one.
enum Undo<'a> {
    Nothing,
    Remove,
    Rename(&'a Path),
}

#[cfg(test)]
impl Transaction {
    /// Leaves the files as a process does that is killed after so many renames.
    pub(super) fn interrupt_after(mut self, renames: usize) {
        self.entries.sort_by_key(Entry::is_contents);
        self.keep_previous().unwrap();
        self.write_journals(&self.records()).unwrap();
        for Rename { from, to, .. } in self.renames().into_iter().take(renames) {
            fs::rename(from, to).unwrap();
        }
        self.entries.clear();
        self.created_folders.clear();
    }
}

impl Drop for Transaction {
    fn drop(&mut self) {
        // Best effort: the first error has been returned already. The next writer removes what stays.
        for Entry { new, previous, .. } in &self.entries {
            let new = new.as_ref().map(|new| &new.temporary);
            for path in new.into_iter().chain(previous) {
                let _ = fs::remove_file(path);
            }
        }
        if !self.committed && !self.entries.is_empty() {
            // The deciding journal is removed last.
            for (_, lock) in self.folders.iter().rev() {
                let _ = fs::remove_file(lock.folder().join(JOURNAL));
            }
        }
        self.folders.clear();
        if !self.committed {
            for folder in self.created_folders.iter().rev() {
                // Fails for folders that are not empty, as intended.
                let _ = fs::remove_dir(folder);
            }
        }
    }
}

/// Returns the folder of a file; `.` for a bare name.
pub(super) fn parent_folder(place: &Path) -> PathBuf {
    match place.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Locks a folder, waiting for other writers up to [`LOCK_TIMEOUT`].
fn acquire_lock(folder: &Path, cancelled: &dyn Fn() -> bool) -> Result<FolderLock, StagingError> {
    let start = Instant::now();
    loop {
        match FolderLock::acquire(folder) {
            Err(StagingError::Locked { .. }) if cancelled() => return Err(StagingError::Cancelled),
            Err(StagingError::Locked { .. }) if start.elapsed() < LOCK_TIMEOUT => sleep(POLL),
            result => return result,
        }
    }
}
