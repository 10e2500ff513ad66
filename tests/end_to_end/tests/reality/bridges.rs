//! Flat ceilings between two walls: what spans more than its printer bridges is found, with the span, and
//! what ships prints without, or says where its supports go.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_geometry::{Machine, Process, Sensor};
use fabkit_tests::{build_design, find_findings, sample_cases};
use rayon::prelude::*;

/// What hangs over of one part, whatever its notes say of supports.
fn unsaid(mut sensor: Sensor, part: &str) -> Vec<Finding> {
    sensor.bodies.retain(|body| body.name == part);
    sensor.bodies.iter_mut().for_each(|body| body.notes.clear());
    find_findings(&sensor, &[Rule::Overhang]).unwrap()
}

/// Sensor, what is set, the part to blame, and how far its printer has to bridge, mm.
const WIDE: [(&str, &str, &str, f64); 5] = [
    ("shadowtac", "base.window_width=16mm", "base", 16.0),
    ("9dtact", "shell.cable_width=14mm", "shell", 14.0),
    ("digit-like", "shell.cable_width=13mm", "shell", 13.0),
    ("gelsight-like", "shell.cable_width=14mm", "shell", 14.0),
    // The shaft's wall is round: its slot is narrower inside than outside, by the sagitta.
    ("tactip", "body.cable_slot_width=18mm", "body", 17.4),
];

#[test]
fn a_bridge_that_sags_is_found() {
    sample_cases(&WIDE).par_iter().for_each(|(name, set, part, span_mm)| {
        let found = unsaid(build_design(name, &[set]).sensor, part);
        let [finding] = &found[..] else { panic!("{name} --set {set}: {found:#?}") };
        assert_eq!((finding.rule, finding.severity), (Rule::Overhang, Severity::Note));
        assert_eq!(finding.bodies, [*part]);
        let measured = finding.measured.unwrap();
        assert_eq!((measured.limit, measured.unit), (10.0, "mm"), "{name}: {finding:#?}");
        assert!((measured.value - span_mm).abs() < 1.0, "{name}: {finding:#?}");
        assert!(finding.place.is_some());
    });
}

#[test]
fn a_bridge_depends_on_the_process_and_on_the_machine() {
    // 8 mm: every filament printer spans it.
    let shell = |process: Process, overhang_deg: Option<f64>, bridge_mm: Option<f64>| {
        let mut sensor = build_design("9dtact", &["shell.cable_width=8mm"]).sensor;
        let body = sensor.bodies.iter_mut().find(|body| body.name == "shell").unwrap();
        *body = body.clone().made_by(process);
        let name = "own".to_owned();
        body.machine = Some(Machine { name, overhang_deg, bridge_mm, ..Machine::default() });
        unsaid(sensor, "shell")
    };
    assert_eq!(shell(Process::Fdm, None, None), []);
    assert_eq!(shell(Process::Fdm, None, Some(5.0)).len(), 1);
    // Whoever slices for resin sees to its supports, unless the machine's figures are given; then nothing
    // is bridged that they do not name.
    assert_eq!(shell(Process::Sla, None, None), []);
    assert_eq!(shell(Process::Sla, Some(45.0), None).len(), 1);
    assert_eq!(shell(Process::Sla, Some(45.0), Some(10.0)), []);
}

#[test]
fn what_ships_bridges_or_says_where_supports_go() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        let found = find_findings(&build_design(name, &[]).sensor, &[Rule::Overhang]).unwrap();
        assert!(found.is_empty(), "{name}: {found:#?}");
    });
    // The note follows the window.
    let notes =
        |set: &[&str]| build_design("shadowtac", set).sensor.body("base").unwrap().notes.join("; ");
    assert!(notes(&[]).contains("upper edge spans 16 mm"), "{}", notes(&[]));
}
