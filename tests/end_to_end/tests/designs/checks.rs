//! Every built-in sensor can be built as described, and what is made wrong on purpose is caught.

use std::collections::BTreeMap;
use std::time::Instant;

use fabkit_checks::{CheckReport, Finding, Rule};
use fabkit_geometry::{Action, Body, Pose, Pour, Sensor, Solid};
use fabkit_tests::{build_design, check, fabkit};

/// With molds in halves, which can be off and undercut.
fn rtac0() -> Sensor {
    let yaml = fabkit_designs::builtin_yaml("rtac0").unwrap();
    let settings = ["molds.route=printed".to_owned()];
    fabkit_designs::load("rtac0", yaml, &settings, &["fixtures"]).unwrap().sensor
}

fn report(sensor: &Sensor) -> CheckReport {
    check(sensor).unwrap()
}

fn pour<'a>(sensor: &'a mut Sensor, step: &str) -> &'a mut Pour {
    let step = sensor.chain.iter_mut().find(|s| s.name == step).unwrap();
    match &mut step.action {
        Action::Pour(pour) => pour,
        other => panic!("{other:?}"),
    }
}

fn part<'a>(sensor: &'a mut Sensor, name: &str) -> &'a mut Body {
    sensor.body_mut(name).unwrap()
}

#[test]
fn every_built_in_sensor_passes() {
    let mut examined = BTreeMap::new();
    // All of them even where other tests look at a sample.
    for design in fabkit_designs::builtin_names().into_iter().map(|name| build_design(name, &[])) {
        let start = Instant::now();
        let report = report(&design.sensor);
        let counts: Vec<String> =
            report.examined.iter().map(|e| format!("{} {}", e.count, e.what)).collect();
        println!("{:12} {:.2?}: {}", design.sensor.name, start.elapsed(), counts.join(", "));
        let errors: Vec<&Finding> = report
            .findings
            .iter()
            .filter(|f| f.severity == fabkit_checks::Severity::Error)
            .collect();
        assert!(errors.is_empty(), "{}: {errors:#?}", design.sensor.name);
        for rule in report.examined {
            *examined.entry(rule.what).or_insert(0) += rule.count;
        }
    }
    // Nothing passes because nothing was looked at. (A printed skin has nothing to demold.)
    assert!(examined.values().all(|&count| count > 0), "{examined:?}");
}

#[test]
fn built_in_sensors_leave_at_most_five_properties_open() {
    let names = fabkit_designs::builtin_names();
    // Presets share the materials of the sensor that they vary.
    let sensors = names.iter().filter(|name| !name.contains("-published"));
    let open: Vec<String> = sensors
        .flat_map(|name| report(&build_design(name, &[]).sensor).not_known)
        .map(|unknown| {
            assert!(!unknown.remedy.is_empty() && !unknown.rules.is_empty(), "{unknown:?}");
            unknown.subject()
        })
        .collect();
    assert!(open.len() <= 5, "{open:#?}");
}

#[test]
fn every_fixture_passes_the_rules_for_any_kit() {
    for design in fabkit_tests::builtin_fixtures() {
        let report = report(&design.sensor);
        assert_eq!(report.errors(), 0, "{}: {:#?}", design.sensor.name, report.findings);
    }
}

#[test]
fn a_preset_is_a_built_in_sensor_of_that_name() {
    let root = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| fabkit(root.path(), arguments);
    let long = run(&["check", "rtac0-published-2025/pin-dome", "--json"]);
    let short = run(&["check", "rtac0/pin-dome", "--preset", "published-2025", "--json"]);
    assert_eq!((long.code, &long.stdout), (Some(1), &short.stdout));
    let unknown = run(&["check", "rtac0/pin-dome", "--preset", "published-2052"]);
    assert_eq!(unknown.code, Some(2));
    assert!(unknown.stderr.contains("did you mean `published-2025`?"), "{}", unknown.stderr);
    let none = run(&["show", "tactip", "--preset", "published"]);
    assert!(none.stderr.contains("tactip has no presets"), "{}", none.stderr);
}

#[test]
fn a_mold_that_is_off_by_a_tenth_of_a_millimetre_is_named() {
    let mut sensor = rtac0();
    let mold = part(&mut sensor, "mold-transparent-gel-a");
    mold.solid = mold.solid.clone().placed(Pose::translation(-0.1, 0.0, 0.0));
    let report = report(&sensor);
    let finding = report
        .for_rule(Rule::Casting)
        .find(|f| f.bodies == ["transparent-gel", "mold-transparent-gel-a"])
        .unwrap();
    assert_eq!(finding.step.as_deref(), Some("pour-transparent-gel"));
    // Half the gel's shadow across x, a tenth of a millimetre thick, over the gel's volume.
    let fraction = finding.measured.unwrap().value;
    assert!((1e-3..5e-2).contains(&fraction), "{fraction}");
    assert!(finding.message.contains("up to 0.1"), "{}", finding.message);
}

#[test]
fn a_lid_without_vents_traps_air_and_a_vent_that_was_not_drilled_is_closed() {
    let mut sensor = rtac0();
    pour(&mut sensor, "pour-translucent-gel").openings.clear();
    let report = report(&sensor);
    let trapped: Vec<&Finding> = report.for_rule(Rule::TrappedAir).collect();
    assert_eq!(trapped.len(), 1, "{trapped:#?}");
    assert_eq!(trapped[0].step.as_deref(), Some("pour-translucent-gel"));
    assert_eq!(trapped[0].bodies, ["translucent-gel"]);
    // The foot of the gel is its highest place, under the lid.
    assert!(trapped[0].place.unwrap().z.abs() < 1e-9);
    // And the holes that are still in the lid are leaks now.
    assert!(report.for_rule(Rule::Casting).any(|f| f.message.contains("open") || f.bodies.contains(&"lid-translucent-gel".into())));
}

#[test]
fn an_undercut_keeps_a_mold_half_from_coming_off() {
    let mut sensor = rtac0();
    // Half a goes on behind the gel: a mold that nobody divided.
    let behind = part(&mut sensor, "mold-transparent-gel-b").solid.clone();
    let mold = part(&mut sensor, "mold-transparent-gel-a");
    mold.solid = mold.solid.clone().plus(behind);
    let report = report(&sensor);
    let finding = report.for_rule(Rule::Demolding).next().unwrap();
    assert_eq!(finding.bodies[..2], ["mold-transparent-gel-a", "transparent-gel"]);
    assert_eq!(finding.step.as_deref(), Some("open-transparent-mold"));
    // The gel's shadow along the pull: half a disc on a rectangle, to the width of a line.
    let (radius_mm, wall_mm) = (13.5, 6.0);
    let shadow_mm2 = 0.5 * std::f64::consts::PI * radius_mm * radius_mm + 2.0 * radius_mm * wall_mm;
    let area_mm2 = finding.measured.unwrap().value;
    assert!((area_mm2 / shadow_mm2 - 1.0).abs() < 0.02, "{area_mm2} of {shadow_mm2}");
}

#[test]
fn a_part_in_the_wrong_place_and_a_loose_fit_are_found() {
    let mut sensor = rtac0();
    sensor.press_fits.retain(|fit| fit.inner != "led-board");
    let found = report(&sensor);
    let finding = found.for_rule(Rule::Interference).next().unwrap();
    assert_eq!(finding.bodies, ["shell", "led-board"]);

    let mut sensor = rtac0();
    let board = part(&mut sensor, "led-board");
    board.solid = Solid::cylinder(5.0, 1.0).at(0.0, 0.0, -12.0);
    let report = report(&sensor);
    let loose = |f: &Finding| f.bodies == ["led-board", "shell"] && f.message.contains("nowhere");
    assert!(report.for_rule(Rule::Interference).any(loose));
}

#[test]
fn the_command_says_what_is_wrong_and_leaves_with_1() {
    let root = tempfile::tempdir().unwrap();
    let passed = fabkit(root.path(), &["check", "rtac0", "--json"]).ok().json();
    assert_eq!((&passed["format"], &passed["passed"]), (&"fabkit-check".into(), &true.into()));
    assert_eq!(passed["rules"].as_array().unwrap().len(), Rule::ALL.len());
    assert_eq!(fabkit(root.path(), &["check", "tactip", "--quiet"]).ok().stdout, "");

    // A lens holder so high that it reaches into a narrow diffuser: each value is allowed.
    let settings = [
        "camera.depth=2mm",
        "camera.lens_height=15mm",
        "camera.holder_height=14.5mm",
        "diffuser.bore_radius=5mm",
        "diffuser.notch_radius=6mm",
        "diffuser.notch_width=2mm",
    ];
    let mut clash = vec!["check", "rtac0"];
    clash.extend(settings.iter().flat_map(|setting| ["--set", setting]));
    let run = fabkit(root.path(), &clash);
    assert_eq!(run.code, Some(1), "{run:?}");
    assert!(run.stdout.contains("error[interference]: "), "{}", run.stdout);
    // The gel has no room to lock the dome then: it does not bear its load either.
    assert!(run.stdout.contains("3 errors\n"), "{}", run.stdout);
    let run = fabkit(root.path(), &[&clash[..], &["--json"]].concat());
    assert_eq!(run.code, Some(1), "{run:?}");
    let document = run.json();
    let finding = &document["findings"][0];
    assert_eq!(finding["bodies"], serde_json::json!(["diffuser", "camera"]));
}

#[test]
fn show_prints_the_chain_with_masses() {
    let root = tempfile::tempdir().unwrap();
    let shown = fabkit(root.path(), &["show", "rtac0", "--chain"]).ok().stdout;
    assert!(shown.contains("pour-transparent-gel: "), "{shown}");
    let document = fabkit(root.path(), &["show", "rtac0", "--chain", "--json"]).ok().json();
    let steps = document["steps"].as_array().unwrap();
    let poured = steps.iter().find(|s| s["name"] == "pour-transparent-gel").unwrap();
    let components = poured["batch"]["components"].as_array().unwrap();
    let mass_g: Vec<f64> = components.iter().map(|c| c["mass_g"].as_f64().unwrap()).collect();
    // Sylgard 184 is mixed 10 : 1.
    assert!((mass_g[0] / mass_g[1] - 10.0).abs() < 1e-9, "{mass_g:?}");
}
