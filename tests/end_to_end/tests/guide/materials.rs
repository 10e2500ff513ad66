//! What is printed together and what a printer's profile is for: parts of one process and material.

use std::fs;

use fabkit_tests::{fabkit, read_folder, sample_cases};
use serde_json::Value;

const SENSORS: [&str; 5] = ["rtac0", "tactip", "shadowtac", "uvdtact", "fluidic"];

fn strings(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|v| v.as_str().unwrap()).collect()
}

#[test]
fn no_plate_or_sheet_of_any_sensor_or_fixture_mixes_materials() {
    let root = tempfile::tempdir().unwrap();
    for sensor in sample_cases(&SENSORS) {
        let mut plates = 0;
        let arguments = ["export", sensor, "--fixtures", "--format=3mf,dxf", "--tolerance=0.1mm"];
        let few = ["--set", "fixtures.semi_domes.count=20", "--json"];
        let run = fabkit(root.path(), &[&arguments[..], &few].concat()).ok().json();
        let fixtures = run["fixtures"].as_object().unwrap().values();
        for manifest in fixtures.chain([&run["manifest"]]) {
            let name = manifest["sensor"].as_str().unwrap();
            let parts = manifest["parts"].as_array().unwrap();
            let of = |name: &str| parts.iter().find(|part| part["name"] == name).unwrap();
            for file in manifest["files"].as_array().unwrap() {
                let file_name = file["name"].as_str().unwrap();
                if file["process"].is_null() {
                    let is_layout = ["plate-", "sheet-"].iter().any(|l| file_name.starts_with(l));
                    assert!(!is_layout, "{name}: {file_name} does not say what it is made of");
                    continue;
                }
                plates += usize::from(file_name.starts_with("plate-"));
                for part in strings(&file["parts"]) {
                    for key in ["process", "material"] {
                        assert_eq!(of(part)[key], file[key], "{name}: {file_name}, {part}");
                    }
                }
                // What the name says.
                let made: Vec<String> = [&file["process"], &file["material"]]
                    .iter()
                    .flat_map(|v| v.as_str().unwrap().split([' ', ',', '(', ')']))
                    .map(str::to_lowercase)
                    .collect();
                let words = made.iter().filter(|word| !word.is_empty() && **word != "laser");
                for word in words {
                    assert!(file_name.contains(word.as_str()), "{name}: {file_name}, {word}");
                }
            }
        }
        assert!(plates > 0, "{sensor} has no plate");
    }
}

fn profile(process: &str, material: &str) -> String {
    format!(
        "format: 1\nname: my-printer\nprocess: {process}\nmaterial: {material}\n\
         shrinkage_percent: {{x: 0.5, y: 0.5, z: 0.5}}\n\
         holes: {{offset: -0.2 mm, gain: 0.995, smallest: 1 mm, largest: 12 mm}}\n\
         pins: {{offset: 0.1 mm, gain: 0.995, smallest: 2 mm, largest: 8 mm}}\n\
         elephant_foot: 0.1 mm\n"
    )
}

#[test]
fn a_profile_is_for_parts_of_its_process_and_material_and_names_the_others() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("pla.yaml"), profile("fdm", "PLA")).unwrap();
    fs::write(root.path().join("abs.yaml"), profile("fdm", "ABS")).unwrap();
    let export = |more: &[&str]| {
        let arguments = ["export", "tactip", "--format=stl", "--tolerance=0.1mm"];
        fabkit(root.path(), &[&arguments, more].concat())
    };
    export(&["-o", "plain"]).ok();
    let plain = read_folder(&root.path().join("plain"));

    // Nothing of this sensor is of PLA: an error that says what would help, and no file.
    let run = export(&["--process=pla.yaml", "-o", "none"]);
    assert_eq!(run.code, Some(2), "{run:?}");
    for says in ["my-printer is for fdm of PLA", "fdm of ABS", "--process-for-any-material"] {
        assert!(run.stderr.contains(says), "{}", run.stderr);
    }
    assert!(!root.path().join("none").exists());

    // Asked for: applied to both parts of ABS with a warning, and to nothing else.
    let run =
        export(&["--process=pla.yaml", "--process-for-any-material", "-o", "any", "--json"]).ok();
    let profile = &run.json()["manifest"]["profile"];
    assert_eq!(
        strings(&profile["applied_to_other_material"]),
        ["body", "robot-mount", "focus-gauge", "controller-holder"]
    );
    let run = export(&["--process=pla.yaml", "--process-for-any-material", "-o", "any"]).ok();
    let warning = "warning: my-printer was measured on PLA and is applied to other materials: body, \
         robot-mount, focus-gauge, controller-holder\n";
    assert!(run.stdout.contains(warning), "{}", run.stdout);
    assert!(run.stdout.contains("my-printer, which was measured on PLA"), "{}", run.stdout);

    // The right one: the same files without a warning, and what it is not for by name.
    let run = export(&["--process=abs.yaml", "-o", "right"]).ok();
    assert!(!run.stdout.contains("warning"), "{}", run.stdout);
    let left = "my-printer (fdm of ABS) is not applied to polyjet of Vero White: dots, ring\n";
    assert!(run.stdout.contains(left), "{}", run.stdout);
    let [any, right] = ["any", "right"].map(|folder| read_folder(&root.path().join(folder)));
    for (name, bytes) in plain.iter().filter(|(name, _)| name.ends_with(".stl")) {
        let of_abs = ["body", "robot-mount", "focus-gauge", "controller-holder"];
        let is_changed = of_abs.contains(&name.trim_end_matches(".stl"));
        assert_eq!(right[name] != *bytes, is_changed, "{name}");
        assert!(any[name] == right[name], "{name}");
    }
    let manifest: Value = serde_json::from_slice(&right["manifest.json"]).unwrap();
    let profile = &manifest["profile"];
    let applied = ["body", "robot-mount", "focus-gauge", "controller-holder"];
    assert_eq!(strings(&profile["applied"]), applied);
    let left: Vec<&str> = profile["not_applied"]
        .as_array()
        .unwrap()
        .iter()
        .map(|left| left["part"].as_str().unwrap())
        .collect();
    assert_eq!(left, ["skin", "dots", "ring", "lens", "led-board"]);
    let manifest: Value = serde_json::from_slice(&plain["manifest.json"]).unwrap();
    assert!(manifest["profile"].is_null());
}

#[test]
fn a_profile_that_changes_nothing_is_refused_and_one_for_a_fixture_alone_is_not() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("pla.yaml"), profile("fdm", "PLA")).unwrap();
    fs::write(root.path().join("abs.yaml"), profile("fdm", "ABS")).unwrap();
    let export = |arguments: &[&str]| {
        fabkit(root.path(), &[&["export", "--tolerance=0.1mm", "-o", "out"], arguments].concat())
    };
    for (arguments, says, help) in [
        (&["uvdtact", "--process=pla.yaml"][..], "sla of Formlabs Clear", "leave --process out"),
        (&["rtac0/diffuser", "--process=pla.yaml"], "laser of acrylic", "leave --process out"),
        (&["rtac0", "--process=abs.yaml"], "fdm of PLA; fdm of black PLA", "fixtures.coupon"),
        (&["rtac0", "--format=tree", "--process=pla.yaml"], "STL and 3MF", "--format stl"),
        (&["rtac0/shell", "--format=dxf", "--process=pla.yaml"], "STL and 3MF", "--format stl"),
        (&["rtac0", "--process-for-any-material"], "--process <FILE.yaml>", "--help"),
    ] {
        let run = export(arguments);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains(says) && run.stderr.contains(help), "{}", run.stderr);
    }
    assert!(!root.path().join("out").exists());
    // Only the coupon is of filament here.
    let run = export(&[
        "uvdtact",
        "--fixtures",
        "--set=fixtures.semi_domes.count=4",
        "--format=stl",
        "--process=pla.yaml",
    ])
    .ok();
    assert!(run.stdout.contains("is not applied to sla of white resin: "), "{}", run.stdout);
    // Another sensor has a folder of its own.
    fs::remove_dir_all(root.path().join("out")).unwrap();
    let run = export(&["rtac0/shell", "--format=stl", "--process=pla.yaml"]).ok();
    assert!(run.stdout.contains("holes fitted for my-printer"), "{}", run.stdout);
}
