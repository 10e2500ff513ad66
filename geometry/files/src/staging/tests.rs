use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::thread;

use super::*;

fn file(name: &str, text: &str) -> OutputFile {
    OutputFile { name: name.into(), bytes: text.into() }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.retain(|name| name != OWN_FILES_NAME);
    names.sort();
    names
}

fn text(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap()
}

/// Prepares a set of two folders with old files in both, up to just before its commit.
fn staged(root: &Path) -> Transaction {
    for name in ["one/a", "one/manifest.json", "two/b", "two/gone"] {
        fs::create_dir_all(root.join(name).parent().unwrap()).unwrap();
        fs::write(root.join(name), "old").unwrap();
    }
    let places = ["one/a", "one/manifest.json", "one/c", "two/b"].map(|name| root.join(name));
    let mut set = Transaction::open(places.iter().map(|p| p.as_path()), &|| false).unwrap();
    for place in &places {
        set.write(place, b"new").unwrap();
    }
    set.remove(&root.join("two/gone")).unwrap();
    set
}

fn assert_old(root: &Path) {
    assert_eq!(names(&root.join("one")), ["a", "manifest.json"]);
    assert_eq!(names(&root.join("two")), ["b", "gone"]);
    for name in ["one/a", "one/manifest.json", "two/b", "two/gone"] {
        assert_eq!(text(root.join(name)), "old", "{name}");
    }
}

#[test]
fn all_files_appear_and_replace_older_ones() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("new/deep");
    write_all(&folder, &[file("a", "1"), file("b", "2")], &|| false).unwrap();
    write_all(&folder, &[file("b", "3"), file("c", "4")], &|| false).unwrap();
    assert_eq!(names(&folder), ["a", "b", "c"]);
    assert_eq!(text(folder.join("b")), "3");
}

#[test]
fn a_set_in_two_folders_appears_and_leaves_nothing_else() {
    let root = tempfile::tempdir().unwrap();
    staged(root.path()).commit().unwrap();
    assert_eq!(names(&root.path().join("one")), ["a", "c", "manifest.json"]);
    assert_eq!(names(&root.path().join("two")), ["b"]);
    assert_eq!(text(root.path().join("two/b")), "new");
}

#[test]
fn a_set_that_is_dropped_leaves_no_trace() {
    let root = tempfile::tempdir().unwrap();
    drop(staged(root.path()));
    assert_old(root.path());
}

#[test]
fn subfolders_are_made_and_unmade_with_their_files() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("new");
    let files = [file("a", "1"), file("sub/deep/a", "2"), file("sub/b", "3")];
    write_all(&folder, &files, &|| false).unwrap();
    assert_eq!(names(&folder), ["a", "sub"]);
    assert_eq!(names(&folder.join("sub")), ["b", "deep"]);
    assert_eq!(text(folder.join("sub/deep/a")), "2");
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
    let files = ["a", "z"].map(|name| (root.path().join(name), &b"new"[..]));
    let result = write_each(files, &|| false);
    let message = result.unwrap_err().to_string();
    assert!(message.ends_with("z: it is a folder, not a file"), "{message}");
    assert_eq!(names(root.path()), ["a", "z"]);
    assert_eq!(text(root.path().join("a")), "old");
}

/// A rename that fails after others have succeeded: they are taken back, in all folders.
#[test]
fn a_failed_rename_takes_the_others_back() {
    let root = tempfile::tempdir().unwrap();
    let set = staged(root.path());
    // This file is renamed last but one; the list of contents in the other folder comes last.
    let [.., lost] = &names(&root.path().join("two"))[..] else { unreachable!() };
    assert_eq!(lost, "gone");
    let hidden = names(&root.path().join("two")).into_iter().find(|n| n.ends_with("-0")).unwrap();
    fs::remove_file(root.path().join("two").join(hidden)).unwrap();
    let error = set.commit().unwrap_err();
    assert!(error.to_string().contains("two/b"), "{error}");
    assert_old(root.path());
}

/// An interrupted switch is undone by the next writer, in whichever of the folders, at any moment of the interruption.
#[test]
fn the_next_writer_undoes_an_interrupted_switch() {
    for next in ["one", "two"] {
        for renames in 0..=6 {
            let root = tempfile::tempdir().unwrap();
            let set = staged(root.path());
            set.interrupt_after(renames);
            let [one, two] = ["one", "two"].map(|name| root.path().join(name));
            // An existing list of contents matches the files; during the switch there is none.
            let list = fs::read_to_string(one.join("manifest.json"));
            let files = [one.join("a"), two.join("b")].map(text);
            assert!(list.is_err() || files.iter().all(|f| Ok(f) == list.as_ref().map_err(drop)));
            drop(FolderLock::acquire(&root.path().join(next)).unwrap());
            drop(FolderLock::acquire(&one).unwrap());
            drop(FolderLock::acquire(&two).unwrap());
            assert_old(root.path());
        }
    }
}

#[test]
fn files_changed_after_an_interrupted_switch_are_kept() {
    let root = tempfile::tempdir().unwrap();
    staged(root.path()).interrupt_after(6);
    fs::write(root.path().join("one/a"), "mine").unwrap();
    fs::write(root.path().join("one/c"), "mine too").unwrap();
    drop(FolderLock::acquire(&root.path().join("one")).unwrap());
    assert_eq!(names(&root.path().join("one")), ["a", "c", "manifest.json"]);
    assert_eq!(text(root.path().join("one/a")), "mine");
    assert_eq!(text(root.path().join("one/c")), "mine too");
    assert_eq!(text(root.path().join("one/manifest.json")), "old");
}

/// The old files stay, and the message says where.
#[test]
fn a_rename_that_cannot_be_taken_back_keeps_the_old_files() {
    let root = tempfile::tempdir().unwrap();
    staged(root.path()).interrupt_after(6);
    let one = root.path().join("one");
    // A folder in a file's place: nothing can be renamed over it.
    fs::remove_file(one.join("a")).unwrap();
    fs::create_dir(one.join("a")).unwrap();
    let kept_before = names(&one);
    drop(FolderLock::acquire(&one));
    // A folder in the place of the file was made by somebody else and is kept.
    assert!(one.join("a").is_dir());

    let other = tempfile::tempdir().unwrap();
    staged(other.path()).interrupt_after(6);
    let one = other.path().join("one");
    if !binds(&one) {
        println!("skipped: permissions do not bind this user");
        return;
    }
    fs::set_permissions(&one, fs::Permissions::from_mode(0o555)).unwrap();
    let error = FolderLock::acquire(&one).unwrap_err();
    fs::set_permissions(&one, fs::Permissions::from_mode(0o755)).unwrap();
    assert!(error.to_string().contains("Permission denied"), "{error}");
    assert_eq!(names(&one).len(), kept_before.len());
    drop(FolderLock::acquire(&one).unwrap());
    assert_old(other.path());
}

fn binds(folder: &Path) -> bool {
    fs::set_permissions(folder, fs::Permissions::from_mode(0o555)).unwrap();
    let bound = fs::write(folder.join("probe"), "").is_err();
    fs::set_permissions(folder, fs::Permissions::from_mode(0o755)).unwrap();
    let _ = fs::remove_file(folder.join("probe"));
    bound
}

#[test]
fn writers_of_one_folder_take_turns() {
    let root = tempfile::tempdir().unwrap();
    let write = |text: &str| {
        let files = ["a", "b", "manifest.json"].map(|name| file(name, text));
        write_all(root.path(), &files, &|| false).unwrap();
    };
    thread::scope(|scope| {
        for i in 0..8 {
            scope.spawn(move || write(&i.to_string()));
        }
    });
    assert_eq!(names(root.path()), ["a", "b", "manifest.json"]);
    let all = ["a", "b", "manifest.json"].map(|name| text(root.path().join(name)));
    assert!(all.iter().all(|text| *text == all[0]), "{all:?}");
}

#[test]
fn one_folder_may_be_spelled_in_several_ways() {
    let root = tempfile::tempdir().unwrap();
    let (plain, other) = (root.path().join("a"), root.path().join("x/../b"));
    fs::create_dir(root.path().join("x")).unwrap();
    write_each([(plain, &b"1"[..]), (other, &b"2"[..])], &|| false).unwrap();
    assert_eq!(names(root.path()), ["a", "b", "x"]);
}

#[test]
fn cancelling_removes_created_files_and_folders() {
    let root = tempfile::tempdir().unwrap();
    let asked = std::cell::Cell::new(0);
    let cancelled = || asked.replace(asked.get() + 1) == 1;
    let files = [file("a", "1"), file("b", "2")];
    let result = write_all(&root.path().join("x/y"), &files, &cancelled);
    assert!(matches!(result, Err(StagingError::Cancelled)));
    assert_eq!(names(root.path()), [""; 0]);
}

#[test]
fn files_of_somebody_else_stay() {
    let root = tempfile::tempdir().unwrap();
    let place = |name: &str| root.path().join(name);
    let names = ["a", "b", "c", "d", "e"];
    let files = |text: &str| names.map(|name| file(name, text));
    // A file with the new content needs no permission.
    fs::write(place("a"), "1").unwrap();
    write_all(root.path(), &files("1"), &|| false).unwrap();
    write_all(root.path(), &files("2"), &|| false).unwrap();
    // Somebody edits all but one.
    for name in &names[..4] {
        fs::write(place(name), "mine").unwrap();
    }
    let error = write_all(root.path(), &files("3"), &|| false).unwrap_err();
    let shown = ["a", "b", "c"].map(|name| place(name).display().to_string()).join(", ");
    let says = format!("{shown} and 1 more are there, and fabkit did not write them");
    assert_eq!(error.to_string(), says);
    assert_eq!((text(place("a")), text(place("e"))), ("mine".to_owned(), "2".to_owned()));
    // Without its list, everything is somebody's.
    fs::remove_file(place(OWN_FILES_NAME)).unwrap();
    assert!(matches!(
        write_all(root.path(), &[file("e", "3")], &|| false),
        Err(StagingError::Foreign { .. })
    ));
}
