//! Values that a user sets and that change nothing, or the size of the whole, are named: on every command that loads a design.

use std::fs;

use fabkit_tests::fabkit;

#[test]
fn values_that_change_nothing_are_named_with_their_condition() {
    let root = tempfile::tempdir().unwrap();
    for (sensor, set, condition) in [
        ("rtac0", "base.cable_angle=90deg", "base.cable_exit is `floor`"),
        ("rtac0", "mount.width=31mm", "mount.pattern is `rectangle`"),
        ("rtac0", "adapter.thickness=6mm", "adapter.pattern is not `none`"),
        ("digit-like", "markers.x=[1mm,2mm]", "markers.pattern is `list`"),
        ("tactip", "pins.diameter=1.5mm", "pins.layout is `free`"),
    ] {
        let run = fabkit(root.path(), &["show", sensor, "--set", set]).ok();
        let (path, value) = set.split_once('=').unwrap();
        let says = format!(
            "warning: {path} = {value} changes nothing in this design: it counts if {condition}\n"
        );
        assert_eq!(run.stderr, says);
        let run = fabkit(root.path(), &["show", sensor, "--set", set, "--json"]).ok();
        assert_eq!(run.stderr, "");
        let effects = &run.json()["value_effects"];
        assert_eq!(effects[0]["code"], "value_without_effect");
        assert_eq!((&effects[0]["path"], effects[1].is_null()), (&path.into(), true));
    }
    // What counts is no matter, and neither is what is as it was: 15 mm is the radius that is drawn.
    for set in ["shell.wall=1.6mm", "base.cable_exit=side", "surface.radius=15mm"] {
        let run = fabkit(root.path(), &["show", "rtac0", "--set", set, "--json"]);
        assert!(run.stderr.is_empty() && run.json().get("value_effects").is_none(), "{run:?}");
    }
}

#[test]
fn values_of_files_are_named_too() {
    let root = tempfile::tempdir().unwrap();
    let yaml = "format: 1\nextends: rtac0\nname: mine\ntitle: Mine\nmount:\n  width: 31 mm\n\
                coat:\n  thickness: 0.1 mm\n";
    fs::write(root.path().join("mine.yaml"), yaml).unwrap();
    for command in ["check", "show"] {
        let run = fabkit(root.path(), &[command, "mine.yaml"]);
        let mut lines = run.stderr.lines();
        assert!(lines.next().is_some_and(|line| {
            line.starts_with("warning: mount.width = 31 mm changes nothing in this design")
        }));
        assert_eq!(lines.next(), None, "{run:?}");
    }
    // A file that extends it knows nothing of its own.
    let top = "format: 1\nextends: mine.yaml\nname: top\ntitle: Top\nbase: {cable_exit: side}\n";
    fs::write(root.path().join("top.yaml"), top).unwrap();
    let run = fabkit(root.path(), &["show", "top.yaml", "--set", "base.cable_angle=90deg"]);
    let paths: Vec<&str> = run.stderr.lines().filter_map(|line| line.split(' ').nth(1)).collect();
    assert_eq!(paths, ["base.cable_angle", "mount.width"], "{run:?}");
}

#[test]
fn a_camera_that_makes_the_sensor_higher_says_so() {
    let root = tempfile::tempdir().unwrap();
    let run = fabkit(root.path(), &["show", "digit-like", "--set", "camera.width_px=1920"]).ok();
    let rest = run.stderr.strip_prefix(
        "warning: camera.width_px = 1920 changes the size of the whole from 25.0 x 21.0 x 22.1 mm to ",
    );
    // The camera keeps its angle per pixel, so that three times the pixels see the pad from further away.
    let height: f64 = rest.unwrap().split([' ', '\n']).nth(4).unwrap().parse().unwrap();
    assert!(height > 1.5 * 22.1, "{}", run.stderr);
    // A length is there to change lengths.
    let run = fabkit(root.path(), &["show", "digit-like", "--set", "bed.thickness=5mm"]).ok();
    assert_eq!(run.stderr, "");
}
