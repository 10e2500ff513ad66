use serde_json::json;

use super::*;

const KIND: FolderKind = FolderKind { what: "thing", name: "thing", version: 2 };

fn plan(seed: u64) -> Value {
    json!({ "format": "thing", "version": 2, "seed": seed })
}

fn open(folder: &Path, resume: bool) -> Result<ResumableFolder, ResumableFolderError> {
    ResumableFolder::open(KIND, folder, plan(1), resume)
}

/// Fills a folder with three pieces and leaves it unfinished.
fn begun(root: &Path) {
    let folder = open(root, false).unwrap();
    for name in ["a", "sub/b", "thing.partial/c"] {
        folder.put(name, name.as_bytes()).unwrap();
    }
}

#[test]
fn a_resumed_run_ends_with_the_bytes_of_an_uninterrupted_one() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    begun(one.path());
    let folder = open(one.path(), true).unwrap();
    assert!(folder.is_finished("a") && folder.is_finished("sub/b") && !folder.is_finished("d"));
    assert_eq!(folder.names("thing.partial/"), ["thing.partial/c"]);
    assert_eq!(folder.read("sub/b").unwrap(), b"sub/b");
    folder.put("d", b"d").unwrap();
    folder.finish(Map::new()).unwrap();
    drop(folder);
    let folder = open(two.path(), false).unwrap();
    for name in ["d", "sub/b", "a"] {
        folder.put(name, name.as_bytes()).unwrap();
    }
    folder.finish(Map::new()).unwrap();
    drop(folder);
    let [one, two] = [one, two].map(|root| {
        let mut names: Vec<_> =
            fs::read_dir(root.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["a", "d", "sub", "thing.json"]);
        assert!(matches!(open(root.path(), false), Err(ResumableFolderError::NotEmpty { .. })));
        assert!(open(root.path(), true).unwrap().document().is_some());
        fs::read(root.path().join("thing.json")).unwrap()
    });
    assert_eq!(one, two);
}

#[test]
fn one_writer_at_a_time_and_one_plan() {
    let root = tempfile::tempdir().unwrap();
    let first = open(root.path(), false).unwrap();
    let error = open(root.path(), true).unwrap_err().to_string();
    assert!(error.contains(&format!("process {}", std::process::id())), "{error}");
    drop(first);
    let other = ResumableFolder::open(KIND, root.path(), plan(2), true).unwrap_err().to_string();
    assert!(other.contains("another thing") && other.contains("seed: 1 there, 2"), "{other}");
    let newer = FolderKind { version: 3, ..KIND };
    let error = ResumableFolder::open(newer, root.path(), plan(1), true).unwrap_err();
    assert!(
        matches!(error, ResumableFolderError::OtherVersion { found: 2, known: 3, .. }),
        "{error}"
    );
}

/// Pieces that are no longer what was written count as missing.
#[test]
fn changed_pieces_count_as_missing() {
    let root = tempfile::tempdir().unwrap();
    let path = |name: &str| root.path().join(name);
    begun(root.path());
    fs::write(path("a"), "A").unwrap();
    fs::remove_file(path("sub/b")).unwrap();
    let folder = open(root.path(), true).unwrap();
    assert_eq!((folder.is_finished("a"), folder.is_finished("sub/b")), (false, false));
    assert_eq!(folder.damaged(), ["a"]);
    folder.put("a", b"a").unwrap();
    drop(folder);
    // The content is right, but lies outside the folder, behind a link.
    #[cfg(unix)]
    {
        fs::rename(path("a"), path("elsewhere")).unwrap();
        std::os::unix::fs::symlink("elsewhere", path("a")).unwrap();
        let folder = open(root.path(), true).unwrap();
        assert!(!folder.is_finished("a"));
        folder.put("a", b"a").unwrap();
        assert!(!fs::symlink_metadata(path("a")).unwrap().is_symlink());
    }
    // Torn lines of a journal, and those with unsafe names, are ignored.
    let journal = path("thing.partial/journal");
    let text = fs::read_to_string(&journal).unwrap();
    let line = text.lines().find(|line| line.ends_with(" a")).unwrap();
    let foreign = line.replace(" a", " ../a");
    fs::write(&journal, format!("{line}\n{foreign}\n\u{fffd}\n{}", &line[..20])).unwrap();
    let folder = open(root.path(), true).unwrap();
    assert!(folder.is_finished("a") && folder.names("").len() == 1, "{:?}", folder.names(""));
}

#[test]
fn changed_files_of_a_complete_folder_are_named_and_kept() {
    let root = tempfile::tempdir().unwrap();
    begun(root.path());
    let folder = open(root.path(), true).unwrap();
    assert!(folder.is_finished("a") && folder.is_finished("sub/b"));
    folder.finish(Map::new()).unwrap();
    drop(folder);
    fs::write(root.path().join("a"), "mine").unwrap();
    let error = open(root.path(), true).unwrap_err().to_string();
    assert!(error.contains("no longer what it was"), "{error}");
    assert_eq!(fs::read(root.path().join("a")).unwrap(), b"mine");
    fs::remove_file(root.path().join("a")).unwrap();
    let folder = open(root.path(), true).unwrap();
    assert!(folder.document().is_none() && !folder.is_finished("a") && folder.is_finished("sub/b"));
    folder.put("a", b"a").unwrap();
    folder.finish(Map::new()).unwrap();
    drop(folder);
    assert!(open(root.path(), true).unwrap().document().is_some());
    // The document itself.
    let document = root.path().join("thing.json");
    let mut bytes = fs::read(&document).unwrap();
    bytes[20] ^= 4;
    fs::write(document, bytes).unwrap();
    assert!(matches!(open(root.path(), true), Err(ResumableFolderError::DamagedDocument { .. })));
}

#[cfg(unix)]
#[test]
fn nothing_is_written_outside_the_folder() {
    let (root, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let folder = open(root.path(), false).unwrap();
    std::os::unix::fs::symlink(outside.path(), root.path().join("link")).unwrap();
    for name in ["../x", "/tmp/x", "a/../../x", "a//b", "", "./x", "C:\\x", "a\nb"] {
        let error = folder.put(name, b"x").unwrap_err();
        assert!(matches!(error, ResumableFolderError::Outside { .. }), "{name}: {error}");
    }
    assert!(matches!(folder.put("link/x", b"x"), Err(ResumableFolderError::Link { .. })));
    assert_eq!(fs::read_dir(outside.path()).unwrap().count(), 0);
}
