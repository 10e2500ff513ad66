//! `--fix` and `--limits` by the real binary: what fabkit has chosen gives way, and says so.

use std::fs;

use fabkit_tests::fabkit;

const EDIT: &str = "--set=markers.height=3.75mm";

#[test]
fn what_is_chosen_follows_and_is_told_to_people_and_programs() {
    let root = tempfile::tempdir().unwrap();
    let refused = fabkit(root.path(), &["show", "fluidic", EDIT]);
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("= help: write at most 3.6 mm, or change"), "{refused:?}");

    let told = fabkit(root.path(), &["show", "fluidic", EDIT, "--fix"]).ok();
    assert!(
        told.stderr.starts_with("fixed: marker_layer.thickness 3 mm -> 2.85 mm: because "),
        "{told:?}"
    );
    assert!(told.stderr.contains("markers.height must be at most 3.6 mm"), "{told:?}");

    let json = fabkit(root.path(), &["show", "fluidic", EDIT, "--fix", "--json"]).ok().json();
    let changes = json["changes"].as_array().unwrap();
    let values: Vec<_> = changes.iter().map(|c| (c["path"].as_str(), c["to"].as_str())).collect();
    assert_eq!(values, [(Some("marker_layer.thickness"), Some("2.85 mm"))]);

    // What was changed needs no more changes, and is all that it takes.
    let again = ["show", "fluidic", EDIT, "--set=marker_layer.thickness=2.85mm"];
    let again = [&again[..], &["--fix", "--json"]].concat();
    assert_eq!(fabkit(root.path(), &again).ok().json()["changes"], serde_json::json!([]));
}

#[test]
fn what_contradicts_itself_is_bad_input_and_says_so() {
    let root = tempfile::tempdir().unwrap();
    let run = fabkit(root.path(), &["check", "rtac0", "--set=surface.wall_height=2mm", "--fix"]);
    assert_eq!(run.code, Some(2), "{run:?}");
    for text in
        ["a contradiction: ", "at least 3.55 mm", "at most 2 mm", "for `surface.wall_height`"]
    {
        assert!(run.stderr.contains(text), "no `{text}` in {run:?}");
    }
}

#[test]
fn a_sweep_loses_only_what_contradicts_itself() {
    let plan = "format: 1\nsensor: fluidic\nfix: true\naxes:\n  markers.height: [3.75 mm, 3 mm, 12 mm]\n\
                metrics: [marker_count]\n";
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("sweep.yaml"), plan).unwrap();
    fabkit(root.path(), &["sweep", "sweep.yaml", "-o", "out"]).ok();
    let csv = fs::read_to_string(root.path().join("out/sweep.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].contains(",pareto,changes,markers.height_mm"), "{csv}");
    assert!(
        lines[1].starts_with("0,ok,") && lines[1].contains("marker_layer.thickness=2.85 mm"),
        "{csv}"
    );
    assert!(lines[2].starts_with("1,ok,") && !lines[2].contains("marker_layer"), "{csv}");
    assert!(lines[3].starts_with("2,invalid,design,") && csv.contains("a contradiction"), "{csv}");
}

#[test]
fn a_limit_that_is_shown_is_where_designs_end() {
    let root = tempfile::tempdir().unwrap();
    let shown = fabkit(root.path(), &["show", "9dtact", "--limits", "--json"]).ok().json();
    let limits = shown["limits"].as_array().unwrap();
    assert!(limits.len() > 30, "{limits:?}");
    let is_wanted = |limit: &&serde_json::Value| limit["path"] == "coat.thickness";
    let coat = limits.iter().find(is_wanted).unwrap();
    let high = coat["held"]["high"].as_f64().unwrap();
    assert!(coat["value"].as_f64().unwrap() <= high, "{coat}");
    assert_eq!(coat["held"]["high_is_largest_allowed"], false, "{coat}");
    let set = |mm: f64| format!("--set=coat.thickness={mm} mm");
    fabkit(root.path(), &["show", "9dtact", &set(high)]).ok();
    assert_eq!(fabkit(root.path(), &["show", "9dtact", &set(high + 0.01)]).code, Some(2));
    let text = fabkit(root.path(), &["show", "9dtact", "--limits"]).ok().stdout;
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
}
