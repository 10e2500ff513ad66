//! Sensors without a screw, a nut or a glue: each is found by the rule `held`, which blames what comes off.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_geometry::Sensor;
use fabkit_tests::{build_design, find_findings, sample_cases};
use rayon::prelude::*;

fn errors(sensor: &Sensor) -> Vec<Finding> {
    let mut found = find_findings(sensor, &[Rule::Retention]).unwrap();
    found.retain(|finding| finding.severity == Severity::Error);
    assert!(found.iter().all(|finding| finding.rule == Rule::Retention));
    found
}

/// Sensor, the screws or nuts that are left out, and what comes off.
const WITHOUT: [(&str, &str, &str); 18] = [
    // The shell's screws, which go into nuts in the base.
    ("rtac0", "screw-m2x4", "base"),
    ("rtac0", "nut-m2", "base"),
    ("rtac0", "screw-m1-6x5", "camera"),
    ("rtac0-published-2025", "screw-m2x4", "base"),
    ("shadowtac", "screw-m2x16", "plate"),
    ("shadowtac", "screw-m2x16", "holder"),
    ("tactip", "screw-m3x6", "camera"),
    ("tactip", "cable-tie", "controller"),
    ("uvdtact", "bolt-m1-2x3", "diffusion-ring"),
    ("9dtact", "screw-m1-6x5", "camera"),
    ("9dtact", "screw-m1-6x6", "base"),
    ("digit-like", "screw-m1-6x5", "camera"),
    ("digit-like", "screw-m1-6x6", "base"),
    ("gelsight-like", "screw-m1-6x6", "base"),
    ("fluidic", "screw-m2x12", "camera"),
    ("fluidic", "nut-m2", "camera"),
    // The lid of the box.
    ("fluidic", "box-spacer", "clamp-bar"),
    ("fluidic", "stand-spacer", "stand-plate"),
];

/// Sensor, the body that nothing sticks to any more, and what comes off.
const UNGLUED: [(&str, &str, &str); 10] = [
    ("uvdtact", "shell", "inner-elastomer"),
    ("uvdtact", "shell", "shell-holder"),
    ("uvdtact", "shell-holder", "shell-holder"),
    ("uvdtact", "camera", "camera"),
    ("shadowtac", "plate", "plate"),
    ("shadowtac", "holder", "plate"),
    ("fluidic", "display-cover", "display-seal"),
    ("tactip", "controller-holder", "controller-holder"),
    ("digit-like", "plate", "plate"),
    ("gelsight-like", "plate", "plate"),
];

fn blames(sensor: &Sensor, body: &str) -> bool {
    errors(sensor).iter().any(|finding| finding.bodies.iter().any(|name| name == body))
}

#[test]
fn what_lacks_its_screws_comes_off() {
    sample_cases(&WITHOUT).par_iter().for_each(|(name, screw, blamed)| {
        let mut sensor = build_design(name, &[]).sensor;
        let count = sensor.bodies.len();
        sensor.bodies.retain(|body| body.name != *screw);
        assert_eq!(sensor.bodies.len() + 1, count, "{name} has a {screw}");
        assert!(blames(&sensor, blamed), "{name} without {screw}: {:#?}", errors(&sensor));
    });
}

#[test]
fn what_lacks_its_glue_comes_off() {
    sample_cases(&UNGLUED).par_iter().for_each(|(name, body, blamed)| {
        let mut sensor = build_design(name, &[]).sensor;
        let count = sensor.adhesions.len();
        sensor.adhesions.retain(|one| one.bodies.iter().all(|other| other != body));
        assert!(sensor.adhesions.len() < count, "something sticks to {name}'s {body}");
        assert!(blames(&sensor, blamed), "{name}, {body} without glue: {:#?}", errors(&sensor));
    });
}

#[test]
fn a_screw_that_finds_no_thread_is_named() {
    let mut sensor = build_design("rtac0", &[]).sensor;
    sensor.bodies.retain(|body| body.name != "nut-m2");
    let found = errors(&sensor);
    assert!(
        found
            .iter()
            .any(|f| f.message.contains("these have no thread and hold nothing: screw-m2x4"))
    );
    // Its own camera's screws have theirs, though they leave with the base.
    assert!(!found.iter().any(|f| f.message.contains("screw-m1-6x5")), "{found:#?}");
}

#[test]
fn names_tell_nothing() {
    // Whatever they are called, screws hold and lamps do not count.
    for name in sample_cases(&["rtac0", "uvdtact", "fluidic", "tactip"]) {
        let mut sensor = build_design(name, &[]).sensor;
        let before = find_findings(&sensor, &[Rule::Retention]).unwrap().len();
        let renamed = |name: &mut String| *name = format!("x{}", blake(name));
        for body in &mut sensor.bodies {
            renamed(&mut body.name);
        }
        for fit in &mut sensor.press_fits {
            renamed(&mut fit.inner);
            renamed(&mut fit.outer);
        }
        sensor.adhesions.iter_mut().for_each(|one| one.bodies.iter_mut().for_each(renamed));
        sensor.print_groups.iter_mut().for_each(|one| one.parts.iter_mut().for_each(renamed));
        for fixing in sensor.chain.iter_mut().flat_map(|step| &mut step.fixings) {
            fixing.bodies.iter_mut().chain(&mut fixing.onto).for_each(renamed);
        }
        assert_eq!(errors(&sensor), [], "{name}");
        assert_eq!(find_findings(&sensor, &[Rule::Retention]).unwrap().len(), before, "{name}");
    }
}

/// A name that tells nothing.
fn blake(name: &str) -> String {
    blake3::hash(name.as_bytes()).to_hex()[..12].to_owned()
}

#[test]
fn what_ships_stays_together() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        assert_eq!(errors(&build_design(name, &[]).sensor), [], "{name}");
    });
}

/// The screws of one side alone: the same screws hold the other side, and the display.
#[test]
fn a_box_without_its_lower_corner_screws_leaves_its_floor() {
    let mut sensor = build_design("fluidic", &[]).sensor;
    let screws = &mut sensor.body_mut("screw-m3x12").unwrap().placements;
    let count = screws.len();
    screws.retain(|place| {
        let at = place.assembly_from_body.translation_mm();
        // The box stands around the axis, the display beside it.
        place.assembly.0 != "sensor" || at.z > -50.0 || at.y.abs() > 60.0
    });
    assert_eq!(screws.len() + 4, count);
    let found = errors(&sensor);
    let [finding] = &found[..] else { panic!("{found:#?}") };
    assert!(finding.message.contains("along +z"), "{finding:#?}");
    for body in ["box-ceiling", "marker-layer", "clamp-bar"] {
        assert!(finding.bodies.iter().any(|name| name == body), "{body}: {finding:#?}");
    }
}
