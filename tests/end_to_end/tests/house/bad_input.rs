//! Bad input: a message with file, line, value, limit and a hint; the right exit code; no file.

use std::fs;
use std::path::Path;

use fabkit_tests::{Run, fabkit};
use serde_json::{Value, json};

const HEADER: &str = "format: 1\nextends: rtac0\nname: mine\n";

/// Exports a file with this text, which must fail without a trace.
fn refused(yaml: impl AsRef<[u8]>) -> Run {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("mine.yaml"), yaml).unwrap();
    let run = fabkit(root.path(), &["export", "mine.yaml"]);
    assert!(!root.path().join("out").exists(), "{run:?}");
    assert_eq!(run.stdout, "", "{run:?}");
    run
}

/// All of these stand in the message.
fn assert_says(run: &Run, texts: &[&str]) {
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

#[test]
fn an_unknown_key_gets_a_suggestion() {
    let run = refused(format!("{HEADER}surface:\n  radios: 15 mm\n"));
    assert_eq!(run.code, Some(2));
    assert_says(
        &run,
        &["`radios`", "mine.yaml:5:3", "  radios: 15 mm", "^^^^^^", "did you mean `radius`?"],
    );
}

#[test]
fn wrong_and_missing_units_are_named() {
    let run = refused(format!("{HEADER}surface:\n  radius: 15 deg\n  wall_height: 6\n"));
    assert_eq!(run.code, Some(2));
    assert_says(&run, &["surface.radius is `15 deg`", "between 8 mm and 60 mm", "mine.yaml:5:11"]);
    assert_says(&run, &["surface.wall_height is `6`", "no unit", "mine.yaml:6:16", "write `6 mm`"]);
    assert_says(&run, &["2 problems"]);
}

#[test]
fn numbers_that_are_none_and_numbers_below_zero_are_refused() {
    for nan in [".nan", "nan mm", "-.inf", "1e999 mm"] {
        let run = refused(format!("{HEADER}surface:\n  radius: {nan}\n"));
        assert_eq!(run.code, Some(2));
        assert_says(&run, &[nan, "not finite", "mine.yaml:5:11", "8 mm and 60 mm", "= help: "]);
    }
    let run = refused(format!("{HEADER}surface:\n  radius: -15 mm\n"));
    assert_eq!(run.code, Some(2));
    assert_says(&run, &["surface.radius is -15 mm", "mine.yaml:5:11", "between 8 mm and 60 mm"]);
}

#[test]
fn impossible_combinations_name_the_limit_and_what_it_comes_from() {
    let run = refused(format!(
        "{HEADER}translucent_gel:\n  thickness: 9 mm\ntube:\n  outer_diameter: 24 mm\n"
    ));
    assert_eq!(run.code, Some(2));
    assert_says(&run, &["translucent_gel.thickness is 9 mm", "at most", "mine.yaml:5:14"]);
    assert_says(&run, &["surface.radius", "= help: "]);

    let run = refused(format!(
        "{HEADER}leds:\n  circle_radius: 40 mm\nshell:\n  outer_diameter: 30 mm\n"
    ));
    assert_eq!(run.code, Some(2));
    assert_says(&run, &["leds.circle_radius is 40 mm", "at most", "mine.yaml:5:18", "shell.wall"]);
}

#[test]
fn an_expression_that_has_no_value_is_refused_where_it_stands() {
    let deep = format!("{}1 mm{}", "(".repeat(400), ")".repeat(400));
    for (expression, says) in [
        ("tube.wall / (leds.count - 8)", "divides by `(leds.count - 8)`, which is 0"),
        ("surface.wall_height + 3", "`3` is a plain number"),
        ("coat.thicknes / 2", "did you mean `coat.thickness`?"),
        ("1e308 mm * 10", "is not finite"),
        ("tube.outer_diameter / 4", "surface.radius -> tube.outer_diameter -> surface.radius"),
        (&deep, "nested more than 64 deep"),
    ] {
        let run = refused(format!("{HEADER}surface:\n  radius: = {expression}\n"));
        assert_eq!(run.code, Some(2), "{run:?}");
        assert_says(&run, &["surface.radius is `= ", "mine.yaml:5:11", says, "= help: "]);
    }
}

#[test]
fn what_the_user_changed_is_named_where_it_reaches_a_limit_through_an_expression() {
    let root = tempfile::tempdir().unwrap();
    let set =
        ["--set", "surface.radius=20mm", "--set", "mold.wall=8mm", "--set", "mold.width=50mm"];
    let run = fabkit(root.path(), &[&["show", "rtac0"][..], &set].concat());
    assert_eq!(run.code, Some(2));
    assert_says(&run, &["mold.width is 50 mm; it must be at least 65.2 mm", "`surface.radius`"]);
    // What follows is shown with what it follows from, and a number in its place stays.
    let shown = |set: &str| {
        let run = fabkit(root.path(), &["show", "rtac0", "--json", "--set", set]).ok();
        let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        let all = json["parameters"].as_array().unwrap().clone();
        let tube = all.into_iter().find(|one| one["path"] == "tube.outer_diameter").unwrap();
        (tube["written"].clone(), tube["expression"].clone())
    };
    let formula = "= min(2 * (surface.radius - translucent_gel.thickness) - 1.6 mm, \
                   max(2 * (surface.radius - translucent_gel.thickness) - 3 mm, \
                   2 * (given(diffuser.notch_radius, 0 mm) + tube.wall + 0.2 mm)))";
    assert_eq!(shown("surface.radius=16mm"), ("26 mm".into(), formula.into()));
    assert_eq!(shown("tube.outer_diameter=23mm"), ("23 mm".into(), serde_json::Value::Null));
}

#[test]
fn a_bomb_is_refused_where_it_begins() {
    let mut bomb = String::from("a0: &a0 [x, x, x, x, x, x, x, x, x]\n");
    for i in 1..10 {
        let copies = vec![format!("*a{}", i - 1); 9].join(", ");
        bomb += &format!("a{i}: &a{i} [{copies}]\n");
    }
    let run = refused(bomb);
    assert_eq!(run.code, Some(2));
    assert_says(&run, &["anchor", "mine.yaml:1:", "not allowed", "= help: "]);
}

#[test]
fn a_file_of_10_mb_is_not_even_read() {
    let run = refused("a".repeat(10_000_000));
    assert_eq!(run.code, Some(3));
    assert_says(&run, &["mine.yaml", "10000000 bytes", "1048576", "= help: "]);
}

#[test]
fn text_that_is_not_utf8_is_located() {
    let run = refused(b"format: 1\nname: \xff\n");
    assert_eq!(run.code, Some(2));
    assert_says(&run, &["mine.yaml:2", "byte 17", "UTF-8"]);
}

#[test]
fn places_that_hold_no_sensor_are_refused() {
    let root = tempfile::tempdir().unwrap();
    fs::create_dir(root.path().join("folder.yaml")).unwrap();
    let run = |sensor| fabkit(root.path(), &["show", sensor]);
    for (sensor, code, texts) in [
        ("nowhere.yaml", 4, ["cannot read nowhere.yaml", "No such file"]),
        ("floder.yaml", 4, ["cannot read floder.yaml", "did you mean `folder.yaml`?"]),
        ("folder.yaml", 2, ["folder.yaml is a folder", "not a file"]),
        ("rtac1", 2, ["there is no sensor `rtac1`", "did you mean `rtac0`?"]),
    ] {
        let run = run(sensor);
        assert_eq!(run.code, Some(code));
        assert_says(&run, &texts);
    }
    if Path::new("/dev/zero").exists() {
        let run = run("/dev/zero");
        assert_eq!(run.code, Some(2));
        assert_says(&run, &["/dev/zero is a device or a pipe"]);
    }
}

#[test]
fn overrides_are_checked_like_the_file() {
    let root = tempfile::tempdir().unwrap();
    let run = |set| fabkit(root.path(), &["show", "rtac0", "--set", set]);
    for (set, texts) in [
        ("surface.radios=9mm", ["`surface.radios`", "did you mean `surface.radius`?"]),
        ("surface.radius=900mm", ["surface.radius is 900mm", "between 8 mm and 60 mm"]),
        ("surface.radius=9", ["no unit", "= help: "]),
    ] {
        let run = run(set);
        assert_eq!(run.code, Some(2));
        assert_says(&run, &["--> --set"]);
        assert_says(&run, &texts);
    }
}

#[test]
fn options_out_of_range_are_refused_with_their_limits() {
    let root = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| fabkit(root.path(), arguments);
    for (option, text) in [
        ("--tolerance=0.01", "no unit"),
        ("--tolerance=0.1um", "0.0005 mm and 1 mm"),
        ("--tolerance=NaN mm", "not finite"),
        ("--threads=0", "1..=256"),
        ("--format=obj", "stl, 3mf, dxf, svg, png, tree"),
        ("--bed=1x1mm", "20 mm and 5000 mm"),
        ("--part=shel", "did you mean `shell`?"),
        ("--bed=40x40mm", "30 x 30 mm are usable"),
    ] {
        let run = run(&["export", "rtac0", option]);
        assert_eq!(run.code, Some(2), "{option}: {run:?}");
        assert_says(&run, &[text]);
    }
    let run = run(&["render", "rtac0", "-o", "a.png", "--size", "10000x10000"]);
    assert_eq!(run.code, Some(3), "{run:?}");
    assert_says(&run, &["10000 x 10000", "64000000"]);
    assert!(fs::read_dir(root.path()).unwrap().next().is_none());
}

#[test]
fn scripts_get_all_problems_as_one_document() {
    let root = tempfile::tempdir().unwrap();
    let yaml = format!("{HEADER}surface:\n  radios: 15 mm\n  wall_height: 6\n");
    fs::write(root.path().join("mine.yaml"), yaml).unwrap();
    let run = fabkit(root.path(), &["export", "mine.yaml", "--json"]);
    assert_eq!((run.code, run.stderr.as_str()), (Some(2), ""));
    let document = run.json();
    assert_eq!((&document["format"], &document["version"]), (&"fabkit-error".into(), &2.into()));
    assert_eq!((&document["exit_code"], &document["kind"]), (&2.into(), &"bad-input".into()));
    let problems = document["problems"].as_array().unwrap();
    let lines: Vec<_> = problems.iter().map(|p| p["line"].as_u64()).collect();
    assert_eq!(lines, [Some(5), Some(6)]);
    assert_eq!(problems[1]["path"], "surface.wall_height");
    assert_eq!((&problems[1]["value"], &problems[1]["unit"]), (&6.0.into(), &Value::Null));
    assert_eq!(
        (&problems[1]["written"], &problems[1]["code"]),
        (&"6".into(), &"missing_unit".into())
    );
    assert_eq!(problems[1]["limit"]["max"], 60.0);
    assert_eq!(
        problems[1]["suggestion"],
        json!({ "path": "surface.wall_height", "value": "6 mm" })
    );
    assert_eq!(problems[0]["suggestion"], json!({ "path": "surface.radius", "value": "15 mm" }));
}

#[test]
fn scripts_get_slips_on_the_command_line_as_a_document_too() {
    let root = tempfile::tempdir().unwrap();
    for (words, message, hint) in [
        (&["exprot", "rtac0", "--json"][..], "unrecognized subcommand 'exprot'", "export"),
        (&["--json", "export", "--tolerence=1um"], "'--tolerence'", "--tolerance"),
        (&["export", "--json"], "required arguments were not provided", "<SENSOR>"),
    ] {
        let run = fabkit(root.path(), words);
        assert_eq!((run.code, run.stderr.as_str()), (Some(2), ""), "{words:?}");
        let document = run.json();
        assert_eq!(
            (&document["format"], &document["exit_code"]),
            (&"fabkit-error".into(), &2.into())
        );
        let problem = &document["problems"][0];
        let text = |key: &str| problem[key].as_str().unwrap_or_default().to_owned();
        assert!((text("message") + &text("hint")).contains(message), "{problem}");
        assert!(text("hint").contains(hint), "{problem}");
    }
}
