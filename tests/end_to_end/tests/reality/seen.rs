//! Sensors whose camera does not see, through the drawn bodies, what it is there to see.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_geometry::{Angle, Pose, Sensor};
use fabkit_tests::fabkit;
use serde_json::Value;

fn sensor(name: &str, set: &str, tilt_deg: f64) -> Sensor {
    let yaml = fabkit_designs::builtin_yaml(name).unwrap();
    let settings: Vec<String> =
        Some(set).filter(|set| !set.is_empty()).map(str::to_owned).into_iter().collect();
    let design = fabkit_designs::load(name, yaml, &settings, &["fixtures"])
        .unwrap_or_else(|error| panic!("{name} {set}: {error:?}"));
    let mut sensor = design.sensor;
    let pose = &mut sensor.camera.sensor_from_camera;
    *pose = pose.then_in(Pose::rotation_x(Angle::from_deg(tilt_deg).unwrap()));
    sensor
}

fn seen(name: &str, set: &str, tilt_deg: f64) -> Vec<Finding> {
    fabkit_checks::check_visibility(&sensor(name, set, tilt_deg)).unwrap()
}

const BESIDE: &str = "lies beside the image";

/// Sensor, what is set, by how much the camera is turned away, and what the warning says.
const WRONG: [(&str, &str, f64, &str); 16] = [
    ("rtac0", "", 60.0, BESIDE),
    ("shadowtac", "", 60.0, BESIDE),
    ("uvdtact", "", 60.0, BESIDE),
    ("9dtact", "", 60.0, BESIDE),
    ("digit-like", "", 60.0, BESIDE),
    ("tactip", "", 60.0, BESIDE),
    ("fluidic", "", 60.0, BESIDE),
    ("rtac0", "camera.field_of_view=60deg", 0.0, BESIDE),
    ("shadowtac", "camera.field_of_view=70deg", 0.0, BESIDE),
    ("rtac0", "diffuser.bore_radius=6mm", 0.0, "diffuser hides"),
    ("rtac0", "diffuser.bore_radius=5mm", 0.0, "diffuser hides"),
    ("rtac0", "filling_gel.material=Smooth-On Psycho Paint, white", 0.0, "locking-gel hides"),
    ("shadowtac", "plate.material=black acrylic", 0.0, "plate hides"),
    ("uvdtact", "shell.material=black resin", 0.0, "shell hides"),
    ("9dtact", "plate.material=white acrylic", 0.0, "plate hides"),
    ("tactip", "lens.material=frosted acrylic", 0.0, "lens hides"),
];

#[test]
fn what_is_sold_as_seen_and_is_not_is_found() {
    for (name, set, tilt_deg, words) in WRONG {
        let found = seen(name, set, tilt_deg);
        let warnings: Vec<_> = found.iter().filter(|f| f.severity == Severity::Warning).collect();
        // One cause, one finding.
        let [warning] = &warnings[..] else { panic!("{name} {set} {tilt_deg}: {found:#?}") };
        assert_eq!(warning.rule, Rule::Sight);
        assert!(warning.message.contains(words), "{name} {set} {tilt_deg}: {}", warning.message);
        let measured = warning.measured.unwrap();
        assert!(measured.value > measured.limit, "{measured:?}");
    }
}

#[test]
fn what_ships_is_told_and_has_no_fault() {
    for name in fabkit_tests::tested_sensors() {
        let found = seen(name, "", 0.0);
        assert!(!found.is_empty(), "{name}");
        assert!(found.iter().all(|f| f.severity == Severity::Note), "{name}: {found:#?}");
        let markers = ["tactip", "fluidic"].contains(&name);
        let told = |what: &str| found.iter().any(|f| f.message.contains(what));
        assert_eq!(told("of the sensing surface"), name != "fluidic", "{name}: {found:#?}");
        assert_eq!(told("of dots") || told("of marker-paint"), markers, "{name}: {found:#?}");
    }
}

/// The bore is looked through: the narrower it is, the more it hides, and from a millimetre on that is said.
#[test]
fn a_narrower_bore_hides_more() {
    let seen_percent = |set: &str| {
        let note = seen("rtac0", set, 0.0).swap_remove(0).message;
        let percent = note.strip_prefix("the camera sees ").unwrap().split(' ').next().unwrap();
        percent.parse::<f64>().unwrap()
    };
    let radii = ["", "diffuser.bore_radius=7mm", "diffuser.bore_radius=5mm"].map(seen_percent);
    assert!(radii[0] > radii[1] + 2.0 && radii[1] > radii[2] + 2.0, "{radii:?}");
}

/// `check` and `depth` say the same of the same sensor.
#[test]
fn the_note_is_what_depth_says() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["rtac0", "tactip", "9dtact"] {
        let json = |args: &[&str]| -> Value { fabkit(folder.path(), args).ok().json() };
        let depth = json(&["depth", name, "--reference", "--mask", "mask.png", "--json"]);
        let check = json(&["check", name, "--json"]);
        let area = depth["coverage"].as_f64().unwrap();
        let findings = check["findings"].as_array().unwrap();
        let note = findings.iter().filter_map(|f| f["message"].as_str());
        let mut note = note.filter(|message| message.contains("of the sensing surface"));
        let note = note.next().unwrap();
        let percent = note.strip_prefix("the camera sees ").unwrap().split(' ').next().unwrap();
        let percent: f64 = percent.parse().unwrap();
        assert!((percent - 100.0 * area).abs() < 3.0, "{name}: {note}, {area}");
    }
}
