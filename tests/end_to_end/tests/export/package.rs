//! What a lab publishes: one folder or one archive, from which the same is made again.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use fabkit_application::packaging::resolved_yaml;
use fabkit_application::source::Target;
use fabkit_designs::builtin_names;
use fabkit_tests::{fabkit, read_folder};
use serde_json::Value;

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap()
}

fn manifest(folder: &Path) -> Value {
    serde_json::from_str(&read(folder.join("manifest.json"))).unwrap()
}

/// A sensor with one fixture that is quickly made.
const SMALL: &[&str] = &["export", "fluidic"];

#[test]
fn a_package_holds_what_its_lists_say_and_makes_itself_again() {
    let root = tempfile::tempdir().unwrap();
    let run = |words: &[&str]| fabkit(root.path(), words);
    let words = [SMALL, &["--all", "-o", "package", "--author", "A. \"Lab\"", "--json"]].concat();
    let told = run(&words).ok().json();
    let folder = root.path().join("package");
    let own = manifest(&folder);
    let names: Vec<&str> = own["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|file| file["name"].as_str().unwrap())
        .collect();
    for name in
        ["CITATION.cff", "LICENSE.txt", "nominal-camera.yaml", "fluidic.yaml", "fluidic.glb"]
    {
        assert!(names.contains(&name) && folder.join(name).is_file(), "{name}: {names:?}");
    }
    // Every folder below has its list, and every file is on one.
    let fixtures = told["fixtures"].as_object().unwrap();
    assert!(!fixtures.is_empty());
    for name in fixtures.keys().map(String::as_str).chain(["."]) {
        let page = read(folder.join(name).join("guide/index.html"));
        assert!(page.contains("<h1"), "{name}");
        assert_eq!(
            manifest(&folder.join(name).join("guide"))["files"].as_array().unwrap().len(),
            4
        );
    }
    let again = run(&["verify", "package", "--json"]).ok().json();
    let folders = again["folders"].as_array().unwrap();
    assert_eq!(folders.len(), 2 * (fixtures.len() + 1));
    assert!(folders.iter().all(|one| one["passed"] == true && one["more_foreign"] == 0), "{again}");

    // The sensor's file is the same sensor, with the same fixtures.
    let file = "package/fluidic.yaml";
    assert_eq!(run(&["show", file, "--json"]).ok().json()["design_hash"], own["design_hash"]);
    for (name, list) in fixtures {
        let shown = run(&["show", &format!("{file}/{name}"), "--json"]);
        if shown.code == Some(0) {
            assert_eq!(shown.json()["design_hash"], list["design_hash"], "{name}");
        }
    }
    let citation = read(folder.join("CITATION.cff"));
    assert!(citation.starts_with("cff-version: 1.2.0\n"));
    assert!(citation.contains(r#"  - name: "A. \"Lab\"""#), "{citation}");
    assert!(read(folder.join("LICENSE.txt")).contains("SPDX-License-Identifier: CC-BY-4.0"));

    // A file that is changed is found.
    fs::write(folder.join("guide/bom.csv"), "kind\n").unwrap();
    let damaged = run(&["verify", "package", "--json"]);
    assert_eq!(damaged.code, Some(1), "{damaged:?}");
    assert!(damaged.stdout.contains("bom.csv"));
}

/// With its boards, and fixtures that have none.
#[test]
fn a_package_holds_boards() {
    let root = tempfile::tempdir().unwrap();
    let few = ["--set", "fixtures.half_plates.count=4"];
    let words = ["export", "9dtact", "--all", "--tolerance", "0.1mm", "-o", "package"];
    fabkit(root.path(), &[&words[..], &few].concat()).ok();
    let folder = root.path().join("package");
    let own = manifest(&folder);
    let files = own["files"].as_array().unwrap();
    let boards: Vec<&str> = files
        .iter()
        .filter(|file| file["format"] == "gerber")
        .map(|file| file["name"].as_str().unwrap())
        .collect();
    let there = read_folder(&folder.join("led-board"));
    assert_eq!(boards.len(), there.len(), "{boards:?}");
    for name in ["led-board.gbrjob", "led-board-F_Cu.gbr", "led-board-pos.csv"] {
        assert!(
            there.contains_key(name) && boards.contains(&&*format!("led-board/{name}")),
            "{boards:?}"
        );
    }
    // The design's formats are there as before.
    for format in ["stl", "3mf", "dxf", "svg", "glb"] {
        assert!(files.iter().any(|file| file["format"] == format), "{format}");
    }
    fabkit(root.path(), &["verify", "package"]).ok();
    // Without being asked, an export holds none.
    let plain = ["export", "9dtact", "--part", "led-board", "--force", "-o", "plain"];
    fabkit(root.path(), &plain).ok();
    assert!(!root.path().join("plain/led-board").exists());
}

#[test]
fn an_archive_is_the_same_on_any_number_of_threads() {
    // Few and small images.
    const SMALL: &[&str] = &["export", "digit-like", "--tolerance", "0.1mm"];
    let root = tempfile::tempdir().unwrap();
    let run = |words: &[&str]| fabkit(root.path(), words);
    let one = |name: &str, threads: &str| {
        let words = ["--guide", "--threads", threads, "--zip", name, "--json"];
        run(&[SMALL, &words].concat()).ok().json()
    };
    let (first, second) = (one("a.zip", "1"), one("b.zip", "2"));
    assert_eq!(first["blake3"], second["blake3"]);
    let bytes = fs::read(root.path().join("a.zip")).unwrap();
    assert_eq!(bytes, fs::read(root.path().join("b.zip")).unwrap());
    assert_eq!(&bytes[..4], b"PK\x03\x04");
    // The first of all names, sorted; and nothing else is written.
    assert_eq!(&bytes[30..30 + 11], b"digit-like/");
    let there: BTreeMap<_, _> = read_folder(root.path());
    assert_eq!(there.len(), 2, "{:?}", there.keys());

    let refused = run(&[SMALL, &["--zip", "a.zip"]].concat());
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("is there already"), "{refused:?}");
    run(&[SMALL, &["--zip", "a.zip", "--force"]].concat()).ok();
    assert_ne!(
        bytes,
        fs::read(root.path().join("a.zip")).unwrap(),
        "without the guide it is another"
    );
}

#[test]
fn slips_are_told_before_anything_is_made() {
    let root = tempfile::tempdir().unwrap();
    for (words, said) in [
        (&["export", "fluidic/mold-floor", "--all"][..], "--all is for a whole sensor"),
        (&["export", "fluidic", "--all", "--license", "mine"], "CC-BY-4.0"),
        (&["export", "fluidic", "--license", "MIT"], "--all"),
        (&["export", "fluidic", "--zip", "a.zip", "-o", "there"], "--output"),
    ] {
        let run = fabkit(root.path(), words);
        assert_eq!(run.code, Some(2), "{words:?}: {run:?}");
        assert!(run.stderr.contains(said), "{words:?}: {run:?}");
    }
    assert!(read_folder(root.path()).is_empty());
}

/// Every built-in sensor can be said in one text, with its fixtures.
#[test]
fn resolved_files_are_the_same_designs() {
    for name in builtin_names() {
        let target = Target::new(name);
        let (design, fixtures) = target.design_with_fixtures(&[]).unwrap();
        let text = resolved_yaml(&design, &fixtures);
        assert!(text.is_some_and(|text| text.contains("family: ")), "{name}");
    }
}
