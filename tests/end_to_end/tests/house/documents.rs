//! What the commands print and write when all is well.

use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;

use fabkit_tests::{Run, command, fabkit, read_folder};
use serde_json::Value;

fn strings(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect()
}

#[test]
fn the_manifest_tells_the_truth_about_every_file() {
    let root = tempfile::tempdir().unwrap();
    let run = fabkit(root.path(), &["export", "rtac0", "--format=stl,3mf,tree"]).ok();
    let files = read_folder(&root.path().join("out/rtac0"));
    let manifest: Value = serde_json::from_slice(&files["manifest.json"]).unwrap();
    assert_eq!(manifest["format"], "fabkit-manifest");

    let entries = manifest["files"].as_array().unwrap();
    assert_eq!(entries.len() + 1, files.len(), "{:?}", files.keys());
    for entry in entries {
        let bytes = &files[entry["name"].as_str().unwrap()];
        assert_eq!(entry["bytes"], bytes.len());
        assert_eq!(entry["blake3"], blake3::hash(bytes).to_hex().as_str());
    }
    let parts = manifest["parts"].as_array().unwrap();
    for part in parts {
        let name = part["name"].as_str().unwrap();
        for suffix in ["stl", "3mf", "tree.json"] {
            assert!(files.contains_key(&format!("{name}.{suffix}")), "{name}.{suffix}");
        }
        let stl = &files[&format!("{name}.stl")];
        assert_eq!(part["mesh"]["triangles"], (stl.len() - 84) / 50);
        assert_eq!(part["bounds_in_file_mm"][0], serde_json::json!([0.0, 0.0, 0.0]));
        assert!(run.stdout.contains(name), "{}", run.stdout);
    }
    // The sensor's envelope, from the paper: its shell is 30 mm across.
    let shell = parts.iter().find(|part| part["name"] == "shell").unwrap();
    let size = &shell["bounds_in_file_mm"][1];
    assert!((size[0].as_f64().unwrap() - 30.0).abs() < 1e-5, "{size}");
}

#[test]
fn show_says_how_to_make_each_part() {
    let root = tempfile::tempdir().unwrap();
    let text = fabkit(root.path(), &["show", "rtac0"]).ok().stdout;
    let document = fabkit(root.path(), &["show", "rtac0", "--json"]).ok().json();
    let bodies = document["bodies"].as_array().unwrap();
    let notes: Vec<&str> = bodies.iter().flat_map(|body| strings(&body["notes"])).collect();
    assert!(notes.iter().any(|note| note.contains("no supports")), "{notes:?}");
    // On several lines, where they are long.
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(notes.iter().all(|note| text.contains(note)), "{text}");
}

#[test]
fn plates_hold_every_printed_part_as_often_as_it_is_needed() {
    let root = tempfile::tempdir().unwrap();
    // A bed that takes several plates.
    let arguments = ["export", "rtac0", "--format=3mf", "--bed=120x120mm", "--json"];
    let run = fabkit(root.path(), &arguments).ok().json();
    let manifest = &run["manifest"];
    let files = manifest["files"].as_array().unwrap();
    let plates: Vec<&Value> =
        files.iter().filter(|f| f["name"].as_str().unwrap().starts_with("plate-fdm-")).collect();
    assert!(plates.len() > 1, "{plates:?}");
    let mut laid: Vec<&str> = plates.iter().flat_map(|plate| strings(&plate["parts"])).collect();
    let mut wanted: Vec<&str> = manifest["parts"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|part| part["process"] == "fdm")
        .flat_map(|part| {
            let quantity = part["quantity"].as_u64().unwrap() as usize;
            std::iter::repeat_n(part["name"].as_str().unwrap(), quantity)
        })
        .collect();
    laid.sort_unstable();
    wanted.sort_unstable();
    assert_eq!(laid, wanted);
}

#[test]
fn one_part_or_layer_can_be_had_alone() {
    let root = tempfile::tempdir().unwrap();
    let names = |arguments: &[&str]| {
        fabkit(root.path(), &[&["export", "-o", "here", "--quiet"], arguments].concat()).ok();
        let files = read_folder(&root.path().join("here"));
        fs::remove_dir_all(root.path().join("here")).unwrap();
        files.into_keys().collect::<Vec<_>>()
    };
    assert_eq!(names(&["rtac0/shell"]), ["manifest.json", "shell.3mf", "shell.stl"]);
    assert_eq!(
        names(&["rtac0", "--part=black-coat", "--part=base", "--part=base", "--format=stl"]),
        ["base.stl", "black-coat.stl", "manifest.json"]
    );
}

#[test]
fn a_file_of_ones_own_and_an_override_change_the_design() {
    let root = tempfile::tempdir().unwrap();
    let yaml = "format: 1\nextends: rtac0\nname: mine\ncoat:\n  thickness: 0.1 mm\n";
    fs::write(root.path().join("mine.yaml"), yaml).unwrap();
    let show = |arguments: &[&str]| {
        fabkit(root.path(), &[&["show", "--json"], arguments].concat()).ok().json()
    };
    let coat = |shown: &Value| {
        let parameters = shown["parameters"].as_array().unwrap();
        let coat = parameters.iter().find(|p| p["path"] == "coat.thickness").unwrap();
        (coat["written"].as_str().unwrap().to_owned(), coat["source"].as_str().unwrap().to_owned())
    };
    let pair = |value: &str, source: &str| (value.to_owned(), source.to_owned());
    let (built_in, mine) = (show(&["rtac0"]), show(&["mine.yaml"]));
    let set = show(&["mine.yaml", "--set", "coat.thickness=0.2 mm"]);
    assert_eq!(coat(&built_in), pair("0.05 mm", "chosen"));
    assert_eq!(coat(&mine), pair("0.1 mm", "user"));
    assert_eq!(coat(&set), pair("0.2 mm", "user"));
    let hashes = [&built_in, &mine, &set].map(|shown| shown["design_hash"].as_str().unwrap());
    assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[0] != hashes[2]);

    fabkit(root.path(), &["export", "mine.yaml", "--part=base"]).ok();
    assert!(root.path().join("out/mine/base.stl").is_file());
}

#[test]
fn every_listed_body_is_shown_and_has_a_source_for_every_parameter() {
    let root = tempfile::tempdir().unwrap();
    let list = fabkit(root.path(), &["list", "--json"]).ok().json();
    let text = fabkit(root.path(), &["list"]).ok().stdout;
    for sensor in list["sensors"].as_array().unwrap() {
        let name = sensor["name"].as_str().unwrap();
        let shown = fabkit(root.path(), &["show", name, "--json"]).ok().json();
        let bodies: Vec<&str> = shown["bodies"]
            .as_array()
            .unwrap()
            .iter()
            .map(|b| b["name"].as_str().unwrap())
            .collect();
        let listed: Vec<&str> =
            ["parts", "layers", "components"].iter().flat_map(|k| strings(&sensor[k])).collect();
        assert_eq!(bodies, listed);
        assert!(listed.iter().all(|body| text.contains(body)), "{text}");
        for parameter in shown["parameters"].as_array().unwrap() {
            assert!(!parameter["note"].as_str().unwrap().is_empty(), "{parameter}");
        }
        let shown = fabkit(root.path(), &["show", name]).ok().stdout;
        assert!(listed.iter().all(|body| shown.contains(body)), "{shown}");
    }
}

#[test]
fn images_are_drawn_of_parts_and_assemblies() {
    let root = tempfile::tempdir().unwrap();
    let size = |name: &str| {
        let bytes = fs::read(root.path().join(name)).unwrap();
        assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"));
        let side = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
        [side(16), side(20)]
    };
    let render = |arguments: &[&str]| {
        fabkit(root.path(), &[&["render", "--size=64x48", "-o", "new/a.png"], arguments].concat())
    };
    for arguments in [&["rtac0/shell"][..], &["rtac0", "--exploded"], &["rtac0", "--section"]] {
        render(arguments).ok();
        assert_eq!(size("new/a.png"), [64, 48]);
    }
    let before = read_folder(&root.path().join("new"));
    for wrong in [&["rtac0/shell", "--exploded"][..], &["rtac0", "--assembly=x"], &["rtac0/x"]] {
        assert_eq!(render(wrong).code, Some(2));
    }
    assert_eq!(read_folder(&root.path().join("new")), before);
    assert_eq!(fabkit(root.path(), &["render", "rtac0", "-o", "a.jpg"]).code, Some(2));
    let view = fabkit(root.path(), &["render", "rtac0", "-o", "a.png", "--view", "toop"]);
    assert_eq!(view.code, Some(2));
    assert!(view.stderr.contains("did you mean `top`?"), "{}", view.stderr);
    let side = |view| {
        let image = ["render", "rtac0", "--size=64x48", "-o", "a.png", "--view", view];
        assert_eq!(fabkit(root.path(), &image).code, Some(0), "{view}");
        fs::read(root.path().join("a.png")).unwrap()
    };
    assert_eq!(side("front"), side("-90,0"));
    assert_ne!(side("front"), side("bottom"));
}

#[test]
fn schema_completions_and_manual_are_there() {
    let root = tempfile::tempdir().unwrap();
    let schema = fabkit(root.path(), &["schema"]).ok().json();
    assert!(schema["$schema"].as_str().unwrap().contains("draft-07"));
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = fabkit(root.path(), &["completions", shell]).ok().stdout;
        assert!(script.contains("COMPLETE"), "{shell}: {script}");
    }
    // As the script for fish asks: the words of the line, the last one begun.
    let offered = |words: &[&str]| {
        let mut command = command(root.path());
        let output = command.env("COMPLETE", "fish").args(["--", "fabkit"]).args(words).output();
        Run::from(output.unwrap()).ok().stdout.trim_end().to_owned()
    };
    fs::write(root.path().join("rt.yaml"), "").unwrap();
    assert_eq!(offered(&["show", "rt"]), "rtac0\nrtac0-published-2025\nrt.yaml");
    assert_eq!(offered(&["check", "rtac0/p"]), "rtac0/pin-dome");
    assert_eq!(offered(&["export", "tactip/bo"]), "tactip/boards\ntactip/body");
    assert_eq!(
        offered(&["export", "x", "--set", "translucent_gel.thi"]),
        "translucent_gel.thickness="
    );
    assert!(offered(&["export", "x", "--tol"]).starts_with("--tolerance\t"));
    assert!(fabkit(root.path(), &["man"]).ok().stdout.starts_with(".ie"));
    fabkit(root.path(), &["man", "-o", "pages"]).ok();
    let pages = read_folder(&root.path().join("pages"));
    assert!(pages.contains_key("fabkit.1") && pages.contains_key("fabkit-export.1"));
    let help = fabkit(root.path(), &["--help"]).ok().stdout;
    for command in
        ["list", "new", "show", "check", "export", "render", "schema", "completions", "man"]
    {
        assert!(help.contains(command) && pages.contains_key(&format!("fabkit-{command}.1")));
    }
}

#[test]
fn quiet_says_nothing_and_progress_stays_off_files() {
    let root = tempfile::tempdir().unwrap();
    let run = fabkit(root.path(), &["export", "rtac0/base", "--quiet"]).ok();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    let run = fabkit(root.path(), &["export", "rtac0/base"]).ok();
    assert_eq!(run.stderr, "");
    let json = fabkit(root.path(), &["export", "rtac0/base", "--json"]).ok().json();
    assert_eq!(json["format"], "fabkit-export");
    assert_eq!(Path::new(json["folder"].as_str().unwrap()), Path::new("out/rtac0"));
}

/// As in `fabkit show rtac0 | head -c 1`.
#[test]
fn a_reader_who_has_seen_enough_is_no_error() {
    let root = tempfile::tempdir().unwrap();
    let mut child = command(root.path())
        .args(["schema"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Closed before the command can have written anything to it.
    drop(child.stdout.take());
    let mut complaints = String::new();
    child.stderr.take().unwrap().read_to_string(&mut complaints).unwrap();
    assert_eq!((child.wait().unwrap().code(), complaints.as_str()), (Some(0), ""));
}
