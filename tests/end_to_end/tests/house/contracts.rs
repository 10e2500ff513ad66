//! Every document of `--json` is as its schema says. That of a command is compared wherever a test reads it
//! ([`fabkit_tests::Run::json`]); here are the schemas themselves, and the outputs that no other test reads.

use std::collections::BTreeSet;

use fabkit_tests::{contract, fabkit};
use serde_json::{Value, json};

#[test]
fn every_schema_is_printed_by_its_name() {
    let root = tempfile::tempdir().unwrap();
    let unknown = fabkit(root.path(), &["schema", "--output", "-", "--json"]).json();
    let names = unknown["problems"][0]["limit"]["choices"].as_array().unwrap().clone();
    let print = |name: &Value| {
        fabkit(root.path(), &["schema", "--output", name.as_str().unwrap()]).ok().json()
    };
    let printed: BTreeSet<String> = names
        .iter()
        .map(|name| print(name)["properties"]["format"]["const"].as_str().unwrap().to_owned())
        .collect();
    let known: BTreeSet<String> = contract::schemas().keys().cloned().collect();
    assert_eq!(printed, known);
    assert_eq!(printed.len(), names.len());
}

#[test]
fn what_is_not_in_a_schema_is_noticed() {
    let right = json!({ "format": "fabkit-render", "version": 1, "file": "a.png", "width_px": 4,
        "height_px": 3, "bytes": 90 });
    assert_eq!(contract::find_faults(&right), [""; 0]);
    for (key, value) in [
        ("version", json!(2)),
        ("file", Value::Null),
        ("width_px", json!("4")),
        ("height_px", json!(-1)),
        ("new", json!(1)),
    ] {
        let mut wrong = right.clone();
        wrong[key] = value;
        assert_eq!(contract::find_faults(&wrong).len(), 1, "{key}");
    }
    let mut short = right.clone();
    short.as_object_mut().unwrap().remove("bytes");
    assert_eq!(contract::find_faults(&short).len(), 1);
    assert_eq!(contract::find_faults(&json!({ "format": "other" })).len(), 1);
}

#[test]
fn outputs_are_as_their_schemas_say() {
    let root = tempfile::tempdir().unwrap();
    let json = |line: &str| {
        let words: Vec<&str> = line.split(' ').chain(["--json"]).collect();
        fabkit(root.path(), &words).ok().json()
    };
    for line in [
        "list",
        "show rtac0",
        "show fluidic",
        "show rtac0/pin-dome",
        "show uvdtact --chain",
        "check tactip",
        "check rtac0/coupon",
        "export rtac0 --part collar --format stl,tree -o out",
        "verify ./out",
        "new mine --family dome",
        "guide 9dtact -o guide",
        "render rtac0/base --size 16x12 -o base.png",
        "completions bash",
        "man",
    ] {
        json(line);
    }
    // A fixture's own parameters come first, numbers beside their units.
    let shown = json("show rtac0/pin-dome");
    let parameters = shown["parameters"].as_array().unwrap();
    assert!(parameters[0]["path"].as_str().unwrap().starts_with("fixtures.pin_dome."));
    let of = |path: &str| parameters.iter().find(|one| one["path"] == path).unwrap();
    let radius = of("surface.radius");
    assert_eq!((&radius["value"], &radius["unit"]), (&json!(15.0), &json!("mm")));
    assert_eq!(radius["limit"], json!({ "min": 8.0, "max": 60.0, "unit": "mm", "choices": [] }));
    let angle = of("camera.field_of_view");
    assert_eq!((&angle["value"], &angle["unit"]), (&json!(160.0), &json!("deg")));
    assert_eq!(of("leds.count")["value"], json!(8));
    let list = parameters.iter().find(|one| one["value"].is_array()).unwrap();
    assert!(list["value"].as_array().unwrap().iter().all(Value::is_number), "{list}");
    assert!(list["unit"].is_string(), "{list}");
}

#[test]
fn an_export_says_first_that_its_design_does_not_pass() {
    let root = tempfile::tempdir().unwrap();
    let export = |target: &str, more: &[&str]| {
        let all = ["export", target, "--format=stl", "-o", target];
        fabkit(root.path(), &[&all, more].concat()).ok()
    };
    let collar = ["--part=collar"];
    let passed = export("rtac0", &collar);
    assert!(!passed.stdout.contains("fabkit check"), "{}", passed.stdout);
    let passed = export("rtac0", &[&collar[..], &["--json"]].concat()).json();
    assert_eq!(passed["check"], json!({ "passed": true, "findings": 0, "first": null }));

    // A lens holder that reaches into a narrow diffuser: each value is allowed.
    let settings = [
        "camera.depth=2mm",
        "camera.lens_height=15mm",
        "camera.holder_height=14.5mm",
        "diffuser.bore_radius=5mm",
        "diffuser.notch_radius=6mm",
        "diffuser.notch_width=2mm",
    ];
    let clash: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let clash = [&collar[..], &clash, &["--clean"]].concat();
    let first = export("rtac0", &clash).stdout.lines().next().unwrap().to_owned();
    for says in ["warning: rtac0 does not pass `fabkit check` (3 errors", "--force silences"] {
        assert!(first.contains(says), "{first}");
    }
    let told = export("rtac0", &[&clash[..], &["--json"]].concat()).json();
    assert_eq!((&told["check"]["passed"], &told["check"]["findings"]), (&json!(false), &json!(3)));
    assert!(first.contains(told["check"]["first"].as_str().unwrap()), "{first}");
    let forced = [&clash[..], &["--force"]].concat();
    assert!(!export("rtac0", &forced).stdout.contains("fabkit check"));
    let forced = [&forced[..], &["--json"]].concat();
    assert_eq!(export("rtac0", &forced).json()["check"], Value::Null);

    // So does that of a fixture.
    let first = export("rtac0-published-2025/pin-dome", &[]).stdout;
    let first = first.lines().next().unwrap();
    assert!(first.contains("rtac0-published-2025/pin-dome does not pass"), "{first}");
}

#[test]
fn what_is_shown_fits_a_hundred_columns() {
    let root = tempfile::tempdir().unwrap();
    for target in ["rtac0", "tactip", "uvdtact", "fluidic", "9dtact", "rtac0/pin-dome"] {
        for more in [&[][..], &["--chain"]] {
            let run = fabkit(root.path(), &[&["show", target][..], more].concat()).ok();
            let wide = run.stdout.lines().find(|line| line.chars().count() > 100);
            assert_eq!(wide, None, "{target}");
        }
    }
    // Values before reasons, the fixture's before the sensor's, each on a line of its own.
    let shown = fabkit(root.path(), &["show", "rtac0/pin-dome"]).ok().stdout;
    let line = |start: &str| shown.lines().position(|line| line.starts_with(start)).unwrap();
    assert_eq!(line("parameter ") + 1, line("fixtures.pin_dome."));
    assert!(line("fixtures.pin_dome.") < line("surface.radius"));
    assert!(line("surface.radius") < line("derived"));
    let wall = shown.lines().nth(line("surface.radius")).unwrap();
    assert!(wall.contains("15 mm") && wall.contains("8 mm to 60 mm") && wall.ends_with("measured"));
}
