//! Files that fabkit names itself, in folders that belong to somebody else.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{OutputFile, StagingError, Transaction, hash_file};
use crate::reading::{self, ExpectedFile};

/// Hidden file of a folder that lists the files that fabkit wrote there, each with its BLAKE3 hash.
pub const OWN_FILES_NAME: &str = ".written-by-fabkit.json";

const FORMAT: &str = "fabkit-files";

/// A guide has four files, data of a bench a few dozen; a million bytes are ten thousand.
const EXPECTED: ExpectedFile =
    ExpectedFile { what: "a list of files", max_bytes: 1_000_000, hint: "" };

/// Writes files with names of fabkit's choice into a folder, or none. The folder and subfolders are created if missing.
///
/// Whoever names a folder does not name the files in it: one that is there is replaced only if fabkit wrote it and nobody
/// changed it since, which a hidden list tells ([`OWN_FILES_NAME`]). A file whose place the user named is written by
/// [`write_each`](super::write_each) instead.
///
/// `cancelled` is polled before each write; once renaming has begun, the operation completes.
///
/// # Errors
/// [`StagingError`], among them [`StagingError::Foreign`]; the folder is then unchanged.
///
/// ```
/// use fabkit_files::scratch_folder::ScratchFolder;
/// use fabkit_files::staging::{OutputFile, StagingError, write_all};
///
/// let folder = ScratchFolder::new()?;
/// let file = |name: &str, bytes: &[u8]| OutputFile { name: name.into(), bytes: bytes.into() };
/// write_all(folder.path(), &[file("base.stl", b"solid"), file("boards/led.dxf", b"")], &|| false)?;
/// assert_eq!(folder.read("base.stl"), b"solid");
/// // What fabkit wrote it replaces; what somebody else did stays.
/// write_all(folder.path(), &[file("base.stl", b"solid 2")], &|| false)?;
/// folder.write("notes.txt", b"mine")?;
/// let refused = write_all(folder.path(), &[file("notes.txt", b"")], &|| false);
/// assert!(matches!(refused, Err(StagingError::Foreign { .. })));
/// // A caller that has been interrupted gets nothing.
/// let stopped = write_all(folder.path(), &[file("lid.stl", b"")], &|| true);
/// assert!(matches!(stopped, Err(StagingError::Cancelled)));
/// assert!(!folder.path_of_file("lid.stl").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_all(
    folder: &Path,
    files: &[OutputFile],
    cancelled: &dyn Fn() -> bool,
) -> Result<(), StagingError> {
    let list_place = folder.join(OWN_FILES_NAME);
    let places: Vec<PathBuf> = files.iter().map(|file| folder.join(&file.name)).collect();
    // Nobody else writes there from here on, so that what is looked at now is what is replaced.
    let all = places.iter().chain([&list_place]).map(PathBuf::as_path);
    let mut set = Transaction::open(all, cancelled)?;
    let mut list = read_list(&list_place);
    let mut foreign = Vec::new();
    for (file, place) in files.iter().zip(&places) {
        let new = blake3::hash(&file.bytes).to_hex().to_string();
        // A folder or other non-file in its place is refused when it is written.
        if let Some(found) = hash_file(place)?
            && found != new
            && list.get(&file.name) != Some(&found)
        {
            foreign.push(place.clone());
        }
        list.insert(file.name.clone(), new);
    }
    if !foreign.is_empty() {
        return Err(StagingError::Foreign { places: foreign });
    }
    let text = json!({ "format": FORMAT, "version": 1, "blake3": list });
    let list_bytes = format!("{text:#}\n").into_bytes();
    let contents = files.iter().map(|file| &file.bytes).chain([&list_bytes]);
    for (place, bytes) in places.iter().chain([&list_place]).zip(contents) {
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

/// Reads the list of a folder. One that is missing or unreadable lists nothing: then all files are somebody else's.
fn read_list(place: &Path) -> BTreeMap<String, String> {
    let list = reading::read(place, EXPECTED).ok();
    let list: Option<Value> = list.and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let list = list.filter(|list| list["format"] == FORMAT);
    let files = list.as_ref().and_then(|list| list["blake3"].as_object());
    let entry = |(name, hash): (&String, &Value)| Some((name.clone(), hash.as_str()?.to_owned()));
    files.into_iter().flatten().filter_map(entry).collect()
}

/// Names places, at most three, and counts the others.
pub(super) fn join_places(places: &[PathBuf]) -> String {
    const MOST: usize = 3;
    let shown = places.iter().take(MOST).map(|place| place.display().to_string());
    let shown = shown.collect::<Vec<_>>().join(", ");
    match places.len() {
        1 => format!("{shown} is there, and fabkit did not write it"),
        0..=MOST => format!("{shown} are there, and fabkit did not write them"),
        all => format!("{shown} and {} more are there, and fabkit did not write them", all - MOST),
    }
}
