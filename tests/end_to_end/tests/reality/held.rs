//! Designs that come apart, stay sticky, sag or do not fill: each is found by the rule and the body that are
//! to blame, and what ships has no such finding.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_designs::Design;
use fabkit_geometry::Sensor;
use fabkit_tests::{build_design, find_findings, sample_cases};
use rayon::prelude::*;

const RULES: [Rule; 5] =
    [Rule::Chemistry, Rule::Softness, Rule::Flow, Rule::Retention, Rule::Sight];

fn errors(sensor: &Sensor, rules: &[Rule]) -> Vec<Finding> {
    let mut errors = find_findings(sensor, rules).unwrap();
    errors.retain(|f| f.severity == Severity::Error);
    errors
}

const SOFT: &str = "Smooth-On Ecoflex 00-10";

/// Sensor, what is set, the rule that finds it, and what it blames first.
const WRONG: [(&str, &[&str], Rule, &str); 24] = [
    ("rtac0", &["mold.material=bare SLA resin"], Rule::Chemistry, "form-cup"),
    ("rtac0", &["mold.material=clear standard resin"], Rule::Chemistry, "form-cup"),
    (
        "rtac0",
        &["mold.material=bare resin", "molds.route=printed"],
        Rule::Chemistry,
        "mold-transparent-gel-a",
    ),
    (
        "rtac0",
        &["form.silicone_material=Smooth-On Ecoflex 00-10"],
        Rule::Softness,
        "silicone-mold-transparent-gel",
    ),
    ("rtac0", &["coat.thickness=0.75mm"], Rule::Softness, "black-coat"),
    ("rtac0", &["loads.touch=100 N"], Rule::Retention, "black-coat"),
    (
        "rtac0",
        &["surface.radius=10mm", "shell.outer_diameter=40mm"],
        Rule::Sight,
        "translucent-gel",
    ),
    ("uvdtact", &["tooling.resin=bare SLA resin"], Rule::Chemistry, "negative-cup-inner"),
    ("uvdtact", &["tooling.resin=uncoated Formlabs Clear"], Rule::Chemistry, "negative-cup-inner"),
    (
        "uvdtact",
        &["tooling.silicone_material=Smooth-On Ecoflex 00-10"],
        Rule::Softness,
        "silicone-core",
    ),
    ("uvdtact", &["diffuser.material=Tango Black+"], Rule::Softness, "diffusion-ring"),
    ("shadowtac", &["mold.vents=2", "mold.vent_diameter=0.6mm"], Rule::Flow, "skin"),
    ("shadowtac", &["mold.material=uncoated resin"], Rule::Chemistry, "mold-skin-block"),
    ("shadowtac", &["holder.material=TPU"], Rule::Softness, "holder"),
    (
        "tactip",
        &["tip.soft_material=Vero White", "tip.rigid_material=Tango Black+"],
        Rule::Softness,
        "skin",
    ),
    ("tactip", &["tip.soft_material=ABS"], Rule::Softness, "skin"),
    ("tactip", &["tip.rigid_material=Agilus"], Rule::Softness, "dots"),
    ("tactip", &["body.material=Tango Black+"], Rule::Softness, "body"),
    (
        "fluidic",
        &["markers.paint_material=Smooth-On Psycho Paint, black"],
        Rule::Sight,
        "marker-paint",
    ),
    ("fluidic", &["marker_layer.pigment=Silc Pig white"], Rule::Sight, "marker-paint"),
    ("fluidic", &["molds.marker_material=bare plywood"], Rule::Chemistry, "mold-floor"),
    ("fluidic", &["molds.channel_material=bare resin"], Rule::Chemistry, "mold-channel-comb"),
    ("9dtact", &["mold.material=untreated resin"], Rule::Chemistry, "mold-floor"),
    ("digit-like", &["loads.touch=60 N"], Rule::Retention, "gel"),
];

#[test]
fn each_wrong_design_is_found() {
    sample_cases(&WRONG).par_iter().for_each(|(sensor, settings, rule, blamed)| {
        let errors = errors(&build_design(sensor, settings).sensor, &[*rule]);
        let first = errors.iter().find(|finding| finding.rule == *rule);
        let first = first.unwrap_or_else(|| panic!("{sensor} {settings:?}: {errors:#?}"));
        assert_eq!(
            first.bodies.first().map(String::as_str),
            Some(*blamed),
            "{settings:?}: {first:#?}"
        );
    });
}

/// Sensor, what is taken from the finished design, and what the rule `held` blames.
type Spoil = fn(&mut Design);

fn without(design: &mut Design, name: &str) {
    design.sensor.bodies.retain(|body| body.name != name);
    design.sensor.adhesions.retain(|one| one.bodies.iter().all(|body| body != name));
}

fn unglued(design: &mut Design, name: &str) {
    design.sensor.adhesions.retain(|one| one.bodies.iter().all(|body| body != name));
}

const LOOSE: [(&str, Spoil, &str); 6] = [
    // As it was: what fills the tube ends level with it, and meets nothing but the diffuser.
    ("rtac0", |design| without(design, "locking-gel"), "filling-gel"),
    ("digit-like", |design| unglued(design, "gel"), "gel"),
    ("gelsight-like", |design| unglued(design, "plate"), "gel"),
    ("shadowtac", |design| unglued(design, "skin"), "skin"),
    ("shadowtac", |design| without(design, "screw-m2x16"), "holder"),
    ("tactip", |design| without(design, "ring"), "skin"),
];

#[test]
fn what_nothing_holds_is_found() {
    sample_cases(&LOOSE).par_iter().for_each(|(sensor, spoil, blamed)| {
        let mut design = build_design(sensor, &[]);
        spoil(&mut design);
        let held = errors(&design.sensor, &[Rule::Retention]);
        let names = |finding: &Finding| finding.bodies.iter().any(|body| body == blamed);
        assert!(held.iter().any(names), "{sensor} without what holds {blamed}: {held:#?}");
    });
}

#[test]
fn what_ships_holds_cures_and_bears_its_load() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        let design = build_design(name, &[]);
        let found = find_findings(&design.sensor, &RULES).unwrap();
        let is_error = |finding: &&Finding| finding.severity == Severity::Error;
        assert_eq!(found.iter().find(is_error), None, "{name}");
        if design.sensor.touch.is_none() {
            return;
        }
        let held = found.iter().filter(|finding| finding.rule == Rule::Retention);
        let bears = held.filter_map(|finding| finding.measured).next().unwrap();
        assert_eq!(bears.limit, 10.0, "{name}");
        assert!(bears.value >= 20.0, "{name} bears {} N", bears.value);
    });
}

#[test]
fn soft_gel_of_a_mold_is_no_mold() {
    // The same silicone is right as a gel.
    let pad = build_design("9dtact", &[&format!("pad.material={SOFT}")]);
    assert_eq!(find_findings(&pad.sensor, &[Rule::Softness]).unwrap(), []);
}

#[test]
fn leds_do_not_touch_the_plate() {
    let yaml = fabkit_designs::builtin_yaml("shadowtac").unwrap();
    let set = ["leds.below_plate=0 mm".to_owned()];
    let refused = fabkit_designs::load("shadowtac", yaml, &set, &["fixtures"]).unwrap_err();
    assert!(refused.problems[0].message.contains("touches the plate"), "{refused:?}");
}

fn fixture(sensor: &str, fixture: &str, settings: &[&str]) -> Vec<Finding> {
    let yaml = fabkit_designs::builtin_yaml(sensor).unwrap();
    let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
    let project = fabkit_fixtures::load(sensor, yaml, &settings).unwrap();
    let report = project.check_fixture(fixture, &|_, _| ()).unwrap().unwrap();
    report.findings.into_iter().filter(|f| f.severity == Severity::Error).collect()
}

/// What is set of R-Tac0's pin dome, and the rule that refuses it.
const USELESS_DOMES: [(&[&str], Rule); 4] = [
    (&["fixtures.pin_dome.pins.lengths=[5 mm, 8 mm]"], Rule::Seating),
    (&["fixtures.pin_dome.holes.diameter=1.5 mm"], Rule::Fit),
    (&["fixtures.pin_dome.holes.diameter=1.95 mm"], Rule::Fit),
    (
        &["fixtures.pin_dome.captures.count=1", "fixtures.pin_dome.captures.pins=2"],
        Rule::Observability,
    ),
];

#[test]
fn fixtures_that_nobody_could_use_are_errors() {
    sample_cases(&USELESS_DOMES).par_iter().for_each(|(settings, rule)| {
        let found = fixture("rtac0", "pin-dome", settings);
        assert!(found.iter().any(|finding| finding.rule == *rule), "{settings:?}: {found:#?}");
    });
    assert_eq!(fixture("rtac0", "pin-dome", &[]), []);
}

#[test]
fn halves_keep_close_to_what_they_press() {
    let yaml = fabkit_designs::builtin_yaml("rtac0").unwrap();
    let set = ["fixtures.semi_domes.clearance=3 mm".to_owned()];
    let project = fabkit_fixtures::load("rtac0", yaml, &set).unwrap();
    let refused = format!("{:?}", project.fixture("semi-domes").unwrap_err());
    assert!(refused.contains("bend aside"), "{refused}");
}
