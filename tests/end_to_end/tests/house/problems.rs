//! What scripts are told of bad input: one document on standard output, with a code that stays, the place, the
//! value, the limit and, where there is one, what to write instead.

use std::fs;

use fabkit_tests::fabkit;
use serde_json::{Value, json};

/// Files that the commands below are about.
const FILES: [(&str, &[u8]); 10] = [
    ("key.yaml", b"format: 1\nextends: rtac0\nname: mine\nsurface:\n  radios: 15 mm\n"),
    ("empty.yaml", b""),
    ("broken.yaml", b"a: [1\n"),
    ("family.yaml", b"format: 1\nfamily: dom\nname: mine\n"),
    ("extends.yaml", b"format: 1\nextends: rtac\nname: mine\n"),
    ("format.yaml", b"format: 7\nextends: rtac0\nname: mine\n"),
    ("latin.yaml", b"format: 1\nname: \xff\n"),
    (
        "tolerance.yaml",
        b"format: 1\nextends: rtac0\nname: mine\nsurface:\n  radius: {value: 15 mm, tolerance: 0.1}\n",
    ),
    ("nothing.yaml", b"format: 1\nextends: rtac0\nname: mine\nsurface:\n  radius:\n"),
    ("camera.yaml", b"fabkit_camera: 1\n"),
];

/// The command line; exit code; code, path and suggested value of the first problem, `-` for none; and
/// what its message or hint says.
type Case<'a> = (&'a str, u64, &'a str, &'a str, &'a str, &'a str);

const CASES: &[Case] = &[
    // Names.
    ("show rtac1", 2, "unknown_sensor", "-", "rtac0", "`rtac1`"),
    ("export rtac0/shel", 2, "unknown_part", "-", "shell", "`shel`"),
    ("export rtac0 --part shel", 2, "unknown_part", "-", "shell", "`shel`"),
    ("check rtac0/pin-dom", 2, "unknown_fixture", "-", "pin-dome", "`pin-dom`"),
    ("show rtac0/shell", 2, "unknown_fixture", "-", "-", "a single part"),
    ("show tactip/pin-plate", 2, "unsuitable_fixture", "-", "-", "has pin-dome"),
    ("show rtac0 --preset published", 2, "unknown_preset", "-", "published-2025", "`published`"),
    ("render rtac0 --assembly sensro -o a.png", 2, "unknown_assembly", "-", "sensor", "`sensro`"),
    ("depth rtac0 --press ball@1 -o a.npz", 2, "unknown_press", "-", "-", "ball@1"),
    ("new mine --family dom", 2, "unknown_family", "-", "dome", "the families are"),
    ("schema --output shw", 2, "unknown_output", "-", "show", "`shw`"),
    // Parameters and their values.
    (
        "show rtac0 --set surface.radios=9mm",
        2,
        "unknown_parameter",
        "surface.radios",
        "surface.radius: 9mm",
        "did you mean",
    ),
    (
        "show key.yaml",
        2,
        "unknown_parameter",
        "surface.radios",
        "surface.radius: 15 mm",
        "`radios`",
    ),
    ("show rtac0 --set base.flange=3mm", 2, "unknown_parameter", "base.flange", "-", ""),
    (
        "show rtac0 --set camera.focal_length=3mm",
        2,
        "unknown_parameter",
        "camera.focal_length",
        "-",
        "",
    ),
    (
        "show rtac0 --set surface.radius=9",
        2,
        "missing_unit",
        "surface.radius",
        "surface.radius: 9 mm",
        "has no unit",
    ),
    // As a length it would be out of its limits.
    ("show rtac0 --set surface.radius=900", 2, "missing_unit", "surface.radius", "-", "no unit"),
    ("show rtac0 --set surface.radius=9deg", 2, "wrong_unit", "surface.radius", "-", "`deg`"),
    (
        "show rtac0 --set surface.radius=900mm",
        2,
        "out_of_range",
        "surface.radius",
        "surface.radius: 35 mm",
        "between 8 mm and 60 mm",
    ),
    // What follows from it has no value either, which is not worth a word.
    (
        "show rtac0 --set surface.radius=1e308mm",
        2,
        "out_of_range",
        "surface.radius",
        "surface.radius: 60 mm",
        "1e308mm",
    ),
    ("show rtac0 --set surface.radius=1e999mm", 2, "not_finite", "surface.radius", "-", "finite"),
    ("show rtac0 --set surface.radius=NaNmm", 2, "not_finite", "surface.radius", "-", "finite"),
    ("show rtac0 --set leds.count=8.5", 2, "not_a_number", "leds.count", "-", "whole number"),
    (
        "show rtac0 --set leds.count=80",
        2,
        "out_of_range",
        "leds.count",
        "leds.count: 32",
        "3 and 32",
    ),
    ("show rtac0 --set coat.material=gold", 2, "", "coat.material", "-", "gold"),
    ("show rtac0 --set surface=3", 2, "wrong_shape", "surface", "-", "is a section"),
    ("show rtac0 --set surface.radius=", 2, "no_value", "surface.radius", "-", "nothing"),
    ("show rtac0 --set surface", 2, "bad_override", "-", "-", "path=value"),
    (
        "show rtac0 --set surface.radius=15mm --set surface.radius=15.5mm",
        2,
        "set_twice",
        "surface.radius",
        "-",
        "keep one",
    ),
    (
        "show rtac0 --set connector.plug_length=9mm",
        2,
        "limit_broken",
        "connector.plug_length",
        "connector.plug_length: 6 mm",
        "at most 6 mm",
    ),
    // Expressions.
    (
        "show rtac0 --set surface.radius==tube.outer_diameter/2",
        2,
        "cycle",
        "surface.radius",
        "-",
        "follows from itself",
    ),
    (
        "show rtac0 --set surface.radius==3mm/(leds.count-8)",
        2,
        "division_by_zero",
        "surface.radius",
        "-",
        "which is 0",
    ),
    (
        "show rtac0 --set surface.radius==1e308mm*10",
        2,
        "not_finite",
        "surface.radius",
        "-",
        "1e308",
    ),
    ("show rtac0 --set surface.radius==3mm+2", 2, "wrong_unit", "surface.radius", "-", "2 mm"),
    (
        "show rtac0 --set surface.radius==surface.raduis",
        2,
        "unknown_parameter",
        "surface.radius",
        "-",
        "`surface.radius`?",
    ),
    // Files.
    ("show nowhere.yaml", 4, "file_missing", "-", "-", "nowhere.yaml"),
    ("verify nowhere/", 4, "file_missing", "-", "-", "nowhere/"),
    ("export rtac0 --process nowhere.yaml", 4, "file_missing", "-", "-", "nowhere.yaml"),
    ("profile nowhere.yaml -o printer.yaml", 4, "file_missing", "-", "-", "nowhere.yaml"),
    ("sweep nowhere.yaml -o sweep", 4, "file_missing", "-", "-", "nowhere.yaml"),
    (
        "depth rtac0 --pose nowhere.yaml --reference -o a.npz",
        4,
        "file_missing",
        "-",
        "-",
        "nowhere",
    ),
    ("dataset rtac0 --presses nowhere.txt -o data", 4, "file_missing", "-", "-", "nowhere.txt"),
    (
        "calibrate intrinsics rtac0 --board nowhere.json a.png -o c.yaml",
        4,
        "file_missing",
        "-",
        "-",
        "nowhere.json",
    ),
    ("show empty.yaml", 2, "wrong_shape", "-", "-", "is empty"),
    ("show broken.yaml", 2, "bad_yaml", "-", "-", "not YAML"),
    ("show family.yaml", 2, "unknown_family", "family", "family: dome", "`dom`"),
    ("show extends.yaml", 2, "unknown_sensor", "extends", "extends: rtac0", "`rtac`"),
    ("show format.yaml", 2, "wrong_format", "format", "-", "`7`"),
    ("show latin.yaml", 2, "not_utf8", "-", "-", "UTF-8"),
    ("show nothing.yaml", 2, "no_value", "surface.radius", "-", "has no value"),
    (
        "show tolerance.yaml",
        2,
        "missing_unit",
        "surface.radius.tolerance",
        "-",
        "the tolerance of surface.radius is `0.1`",
    ),
    ("show folder.yaml", 2, "not_a_file", "-", "-", "a folder"),
    (
        "depth rtac0 --camera camera.yaml --reference -o camera.yaml",
        2,
        "replaces_input",
        "-",
        "-",
        "camera.yaml",
    ),
    // The command line itself.
    ("exprot rtac0", 2, "unknown_command", "-", "export", "exprot"),
    ("export rtac0 --tolerence=1um", 2, "unknown_option", "-", "--tolerance", "--tolerence"),
    ("export", 2, "missing_argument", "<SENSOR>", "-", "SENSOR"),
    ("export rtac0 --tolerance=1", 2, "invalid_argument", "--tolerance", "-", "no unit"),
    ("export rtac0 --format=obj", 2, "invalid_argument", "--format", "-", "stl"),
    ("export rtac0 --nominal --kerf=0.1mm", 2, "conflicting_options", "--nominal", "-", "--kerf"),
    ("export rtac0 --bed=40x40mm", 2, "larger_than_bed", "-", "-", "30 x 30 mm"),
    ("render rtac0 -o a.png --size=10000x10000", 3, "limit_exceeded", "-", "-", "64000000"),
];

/// A folder with those files.
fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    for (name, bytes) in FILES {
        fs::write(root.path().join(name), bytes).unwrap();
    }
    fs::create_dir(root.path().join("folder.yaml")).unwrap();
    root
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or("-").to_owned()
}

/// `surface.radius: 9 mm`, or the value alone where it is no parameter's.
fn suggested(problem: &Value) -> String {
    let suggestion = &problem["suggestion"];
    match suggestion["path"].as_str() {
        Some(path) => format!("{path}: {}", text(&suggestion["value"])),
        None => text(&suggestion["value"]),
    }
}

#[test]
fn every_slip_has_its_code_and_what_to_write_instead() {
    let root = folder();
    let mut wrong = Vec::new();
    for (line, exit_code, code, path, suggestion, says) in CASES {
        let words: Vec<&str> = line.split(' ').chain(["--json"]).collect();
        let run = fabkit(root.path(), &words);
        let document = run.json();
        let problem = &document["problems"][0];
        let told = format!("{} {}", text(&problem["message"]), text(&problem["hint"]));
        let is_right = run.code == Some(i32::try_from(*exit_code).unwrap())
            && run.stderr.is_empty()
            && document["format"] == "fabkit-error"
            && document["exit_code"] == *exit_code
            && (code.is_empty() || problem["code"] == *code)
            && text(&problem["path"]) == *path
            && suggested(problem) == *suggestion
            && told.contains(says);
        if !is_right {
            wrong.push(format!("{line}: {:?}: {problem:#}", run.code));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn numbers_stand_beside_their_units() {
    let root = folder();
    let problem = |set: &str| {
        let run = fabkit(root.path(), &["show", "rtac0", "--json", "--set", set]);
        run.json()["problems"][0].clone()
    };
    let far = problem("surface.radius=900mm");
    assert_eq!((&far["value"], &far["unit"]), (&json!(900.0), &json!("mm")));
    assert_eq!(far["limit"], json!({ "min": 8.0, "max": 60.0, "unit": "mm", "choices": [] }));
    let count = problem("leds.count=80");
    assert_eq!((&count["value"], &count["unit"]), (&json!(80.0), &Value::Null));
    assert_eq!(count["limit"]["max"], 32.0);
    let word = problem("surface.radius=wide");
    assert_eq!((&word["value"], &word["written"]), (&json!("wide"), &json!("wide")));
    // Several at once, each for itself.
    let sets = ["--set", "surface.radius=900mm", "--set", "leds.count=80"];
    let run = fabkit(root.path(), &[&["show", "rtac0", "--json"][..], &sets].concat());
    let paths = run.json()["problems"].as_array().unwrap().clone();
    let paths: Vec<String> = paths.iter().map(|problem| text(&problem["path"])).collect();
    assert_eq!(paths, ["surface.radius", "leds.count"]);
}
