//! A user's own materials and machines through the command: the file that the environment names,
//! plates, the manifest, profiles and sweeps.

use std::fs;
use std::path::Path;

use fabkit_tests::{Run, command, read_folder};
use serde_json::Value;

const LAB: &str = "\
format: 1
materials:
  Lab jelly: {density: 2 g/cm3, cure: {time: 1 h}, mix: {A: 1, B: 1}, pot_life: 9 min}
processes:
  Our Resin Printer:
    kind: sla
    bed: {width: 130 mm, depth: 90 mm, height: 150 mm}
    materials: [grey resin]
";

const SENSOR: &str = "\
format: 1
extends: rtac0
name: own
translucent_gel: {material: lab jelly}
molds: {route: printed}
parts: {mold-*: {process: our resin printer}}
";

fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("lab.yaml"), LAB).unwrap();
    fs::write(root.path().join("own.yaml"), SENSOR).unwrap();
    root
}

fn run(root: &Path, arguments: &[&str]) -> Run {
    let mut command = command(root);
    command.env("FABKIT_MATERIALS", "lab.yaml").args(arguments).output().unwrap().into()
}

fn parts(manifest: &Value) -> Vec<&Value> {
    manifest["parts"].as_array().unwrap().iter().collect()
}

#[test]
fn the_file_that_the_environment_names_goes_for_every_sensor() {
    let root = folder();
    let shown = run(root.path(), &["show", "own.yaml", "--json"]).ok().json();
    let materials = shown["materials"].as_array().unwrap();
    let jelly = materials.iter().find(|m| m["name"] == "Lab jelly").unwrap();
    assert_eq!((&jelly["origin"], &jelly["file"]), (&"own".into(), &"lab.yaml".into()));
    assert_eq!((&jelly["density_g_per_cm3"], &jelly["pot_life_min"]), (&2.0.into(), &9.0.into()));
    let solaris = materials.iter().find(|m| m["name"] == "Smooth-On Solaris");
    assert_eq!(solaris.unwrap()["origin"], "built-in");
    // Masses follow: by twice the density, half of it each.
    let chain = run(root.path(), &["show", "own.yaml", "--chain", "--json"]).ok().json();
    let batches = chain["steps"].as_array().unwrap().iter().map(|step| &step["batch"]);
    let batch = batches.into_iter().find(|batch| batch["layer"] == "translucent-gel").unwrap();
    let [volume, waste] = ["volume_mm3", "waste"].map(|key| batch[key].as_f64().unwrap());
    let mass = batch["components"][1]["mass_g"].as_f64().unwrap();
    assert!((mass - volume / 1000.0 * (1.0 + waste)).abs() < 1e-9 * mass, "{batch}");
    // Text names the file, too.
    let text = run(root.path(), &["show", "own.yaml"]).ok().stdout;
    assert!(text.lines().any(|l| l.starts_with("Lab jelly") && l.ends_with("lab.yaml")), "{text}");
    // Nobody else knows it.
    let plain = command(root.path()).args(["show", "own.yaml"]).output().unwrap();
    let plain = Run::from(plain);
    assert_eq!(plain.code, Some(2), "{plain:?}");
    assert!(plain.stderr.contains("fabkit knows neither mix nor cure"), "{}", plain.stderr);
}

#[test]
fn a_bad_file_is_shown_with_its_line_and_a_missing_one_is_missing() {
    let root = folder();
    let bad = LAB.replace("density: 2 g/cm3", "density: -2 g/cm3");
    fs::write(root.path().join("lab.yaml"), bad).unwrap();
    let shown = run(root.path(), &["show", "rtac0"]);
    assert_eq!(shown.code, Some(2), "{shown:?}");
    assert!(shown.stderr.contains("--> lab.yaml:3"), "{}", shown.stderr);
    fs::remove_file(root.path().join("lab.yaml")).unwrap();
    let shown = run(root.path(), &["show", "rtac0"]);
    assert_eq!(shown.code, Some(4), "{shown:?}");
    assert!(shown.stderr.contains("lab.yaml"), "{}", shown.stderr);
}

#[test]
fn plates_profiles_and_the_manifest_follow_the_machine() {
    let root = folder();
    let profile = "format: 1\nname: p\nprocess: sla\nmaterial: Grey resin\n\
                   shrinkage_percent: {x: 0.5, y: 0.5, z: 0.5}\n\
                   holes: {offset: 0 mm, gain: 1, smallest: 1 mm, largest: 12 mm}\n\
                   pins: {offset: 0 mm, gain: 1, smallest: 2 mm, largest: 8 mm}\n\
                   elephant_foot: 0 mm\n";
    fs::write(root.path().join("p.yaml"), profile).unwrap();
    let arguments =
        ["export", "own.yaml", "--format=3mf", "--tolerance=0.1mm", "--process=p.yaml", "--json"];
    let manifest = &run(root.path(), &arguments).ok().json()["manifest"];
    let is_mold = |name: &str| name.starts_with("mold-");
    for part in parts(manifest) {
        let name = part["name"].as_str().unwrap();
        let machine = &part["machine"];
        if is_mold(name) {
            assert_eq!(machine["name"], "Our Resin Printer", "{name}");
            let note = machine["note"].as_str().unwrap();
            assert!(note.contains("grey resin in place of PLA"), "{note}");
            assert_eq!(
                (&part["process"], &part["material"]),
                (&"sla".into(), &"grey resin".into())
            );
        } else {
            assert!(machine.is_null(), "{name}")
        }
        // The profile of that resin is for them alone.
        assert_eq!(part["compensation"]["print"].is_object(), is_mold(name), "{name}");
    }
    let plates: Vec<&Value> = manifest["files"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|file| file["name"].as_str().unwrap().starts_with("plate-sla"))
        .collect();
    assert!(!plates.is_empty());
    let mut laid = 0;
    for plate in plates {
        let name = plate["name"].as_str().unwrap();
        assert!(name.starts_with("plate-sla-our-resin-printer-grey-resin-"), "{name}");
        let held = plate["parts"].as_array().unwrap();
        laid += held.len();
        assert!(held.iter().all(|part| is_mold(part.as_str().unwrap())), "{plate}");
    }
    assert_eq!(
        laid,
        parts(manifest).iter().filter(|p| is_mold(p["name"].as_str().unwrap())).count()
    );
    let files = read_folder(&root.path().join("out/own"));
    assert!(files.keys().any(|name| name.starts_with("plate-fdm-pla-")), "{:?}", files.keys());
}

#[test]
fn sweeps_know_the_users_file_on_every_variant() {
    let root = folder();
    let plan = "format: 1\nsensor: own.yaml\naxes:\n  translucent_gel.material: [Lab jelly, Smooth-On \
                Solaris]\nmetrics: [layers_mass_g]\n";
    fs::write(root.path().join("sweep.yaml"), plan).unwrap();
    let report = run(root.path(), &["sweep", "sweep.yaml", "-o", "out", "--json"]).ok().json();
    assert_eq!(report["variants"], 2, "{report}");
    assert_eq!(report["status"]["ok"], 2, "{report}");
}
