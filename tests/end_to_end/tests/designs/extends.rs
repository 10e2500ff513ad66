//! A sensor's file that extends another file of the user's.

use std::fs;
use std::path::Path;

use fabkit_tests::{Run, fabkit};

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, format!("format: 1\n{text}")).unwrap();
}

/// Every parameter's value in what `show --json` says, by its path.
fn value(shown: &Run, path: &str) -> String {
    let json = shown.json();
    let rows = json["parameters"].as_array().unwrap();
    let row = rows.iter().find(|row| row["path"] == path).unwrap();
    row["written"].as_str().unwrap().to_owned()
}

#[test]
fn files_lie_over_each_other_and_expressions_follow_the_last_word() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    // Three folders, each path relative to the file that says it.
    write(folder, "lab/common.yaml", "extends: rtac0\nname: common\nshell:\n  wall: 1.6 mm\n");
    let wall = "coating:\n  wall: \"= shell.wall + 0.5 mm\"\n";
    write(folder, "lab/wide.yml", &format!("extends: ./common.yaml\n{wall}"));
    write(folder, "a/mine.yaml", "extends: ../lab/wide.yml\nname: mine\nshell:\n  wall: 1.7 mm\n");
    let shown = fabkit(folder, &["show", "a/mine.yaml", "--json"]).ok();
    assert_eq!(shown.json()["name"], "mine");
    assert_eq!(value(&shown, "shell.wall"), "1.7 mm");
    assert_eq!(value(&shown, "coating.wall"), "2.2 mm");
    let shown = fabkit(folder, &["show", "lab/wide.yml", "--json"]).ok();
    assert_eq!(shown.json()["name"], "common");
    assert_eq!(value(&shown, "coating.wall"), "2.1 mm");
    let set = ["show", "a/mine.yaml", "--json", "--set", "shell.wall=1.8mm"];
    assert_eq!(value(&fabkit(folder, &set).ok(), "coating.wall"), "2.3 mm");

    // What is wrong in a file that is extended is shown there; what is extended is not replaced.
    write(folder, "lab/wide.yml", "extends: common.yaml\nshell:\n  wal: 1 mm\n");
    let wrong = fabkit(folder, &["show", "a/mine.yaml"]);
    assert_eq!(wrong.code, Some(2), "{wrong:?}");
    for text in ["--> a/../lab/wide.yml:4:3", "  wal: 1 mm", "did you mean `wall`?"] {
        assert!(wrong.stderr.contains(text), "no `{text}` in:\n{}", wrong.stderr);
    }
    write(folder, "lab/wide.yml", "extends: common.yaml\n");
    let refused = fabkit(folder, &["verify", "a/mine.yaml", "--report", "lab/common.yaml"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("would replace what SENSOR reads"), "{}", refused.stderr);
}

#[test]
fn a_sweep_varies_a_sensor_that_extends_a_file_and_knows_when_that_one_changed() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    write(folder, "base.yaml", "extends: rtac0\nname: base\n");
    write(folder, "mine.yaml", "extends: base.yaml\nname: mine\n");
    let plan = "sensor: mine.yaml\naxes:\n  surface.radius: [15 mm, 15.5 mm]\n\
                metrics: [camera]\n";
    write(folder, "plan.yaml", plan);
    let sweep = fabkit(folder, &["sweep", "plan.yaml", "-o", "out", "--json"]).ok();
    let hash = |_: Run| {
        let text = fs::read_to_string(folder.join("out/sweep.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["plan_hash"].to_string()
    };
    let before = hash(sweep);
    write(folder, "base.yaml", "extends: rtac0\nname: base\nshell:\n  wall: 1.6 mm\n");
    fs::remove_dir_all(folder.join("out")).unwrap();
    assert_ne!(hash(fabkit(folder, &["sweep", "plan.yaml", "-o", "out", "--json"]).ok()), before);
}

#[test]
fn circles_and_too_many_files_are_refused_with_all_of_them() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    write(folder, "sub/a.yaml", "extends: b.yaml\n");
    write(folder, "sub/b.yaml", "name: b\nextends: ../sub/./a.yaml\n");
    let refused = fabkit(folder, &["check", "sub/a.yaml"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    let chain = "extends itself: sub/a.yaml -> sub/b.yaml -> sub/a.yaml";
    for text in [chain, "--> sub/b.yaml:3:10"] {
        assert!(refused.stderr.contains(text), "no `{text}` in:\n{}", refused.stderr);
    }

    // Sixteen files below the first, and a built-in sensor below them.
    for i in 0..17 {
        write(folder, &format!("{i}.yaml"), &format!("extends: {}.yaml\n", i + 1));
    }
    write(folder, "17.yaml", "extends: rtac0-published-2025\n");
    fabkit(folder, &["show", "1.yaml", "--quiet"]).ok();
    let refused = fabkit(folder, &["show", "0.yaml"]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    let chain = "more than 16 files extend each other: 0.yaml -> 1.yaml -> 2.yaml";
    for text in [chain, "16.yaml -> 17.yaml", "--> 16.yaml:2:10", "at most 16"] {
        assert!(refused.stderr.contains(text), "no `{text}` in:\n{}", refused.stderr);
    }
}

#[test]
fn a_file_that_is_not_there_is_named_with_the_line_that_extends_it() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    write(folder, "base.yaml", "extends: rtac0\n");
    write(folder, "mine.yaml", "name: mine\nextends: bace.yaml\n");
    let missing = fabkit(folder, &["show", "mine.yaml"]);
    assert_eq!(missing.code, Some(4), "{missing:?}");
    for text in ["mine.yaml:3: extends `bace.yaml`", "cannot read", "did you mean `base.yaml`"] {
        assert!(missing.stderr.contains(text), "no `{text}` in:\n{}", missing.stderr);
    }
}
