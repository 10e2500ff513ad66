//! LEDs, needles and tubes that nothing stands in the way of: no step that fixes them, or nothing beside
//! them, is found, and what ships says of each how it stays.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_geometry::{FixingMeans, MechanicalRole, Pose, Sensor};
use fabkit_tests::{build_design, find_findings, sample_cases};
use rayon::prelude::*;

fn errors(sensor: &Sensor) -> Vec<Finding> {
    let found = find_findings(sensor, &[Rule::Retention]).unwrap();
    found.into_iter().filter(|finding| finding.severity == Severity::Error).collect()
}

/// Sensor, what is set, and a small body of it.
const SMALL: [(&str, &[&str], &str); 11] = [
    ("rtac0", &[], "led"),
    ("tactip", &[], "led"),
    ("shadowtac", &[], "led"),
    ("9dtact", &[], "led"),
    ("digit-like", &[], "led"),
    ("gelsight-like", &[], "led"),
    ("uvdtact", &[], "white-led"),
    ("uvdtact", &[], "uv-led"),
    ("fluidic", &[], "led-strip"),
    ("fluidic", &[], "needle"),
    ("fluidic", &[], "tube"),
];

#[test]
fn what_no_step_fixes_is_found() {
    sample_cases(&SMALL).par_iter().for_each(|(name, set, small)| {
        let mut sensor = build_design(name, set).sensor;
        assert_eq!(sensor.body(small).unwrap().duty, MechanicalRole::Attached, "{name}/{small}");
        for fixing in sensor.chain.iter_mut().flat_map(|step| &mut step.fixings) {
            fixing.bodies.retain(|body| body != small);
        }
        let found = errors(&sensor);
        let [finding] = &found[..] else { panic!("{name}/{small}: {found:#?}") };
        assert_eq!(
            (finding.rule, &finding.bodies[..]),
            (Rule::Retention, &[(*small).to_owned()][..])
        );
        assert!(finding.message.contains("no step solders"), "{}", finding.message);
    });
}

#[test]
fn what_is_fixed_in_the_air_is_found() {
    // One of several, a millimetre off what it is soldered or glued to.
    for (name, small, off, others) in [
        ("rtac0", "led", [0.0, 0.0, 1.0], &[][..]),
        ("tactip", "led", [0.0, 0.0, 1.0], &[][..]),
        ("uvdtact", "uv-led", [0.0, 0.0, 1.0], &[][..]),
        ("fluidic", "led-strip", [0.0, 0.0, 300.0], &[][..]),
        // The tube that was plugged onto it has lost it as well.
        ("fluidic", "needle", [0.0, 0.0, 40.0], &["tube"][..]),
    ] {
        let mut sensor = build_design(name, &[]).sensor;
        let body = sensor.body_mut(small).unwrap();
        let place = &mut body.placements[0];
        place.assembly_from_body =
            Pose::translation(off[0], off[1], off[2]).then_in(place.assembly_from_body);
        let found = errors(&sensor);
        let is_it = |finding: &&Finding| finding.message.contains("does not touch");
        let blamed: Vec<_> = found.iter().filter(is_it).map(|finding| &finding.bodies[0]).collect();
        assert_eq!(blamed, [&[small], others].concat(), "{name}: {found:#?}");
    }
}

/// What a step says of each way, so that data and sentence do not part.
fn words(by: FixingMeans) -> &'static [&'static str] {
    match by {
        FixingMeans::Solder => &["solder"],
        FixingMeans::Glue => &["glue", "adhesive"],
        FixingMeans::Tape => &["stick"],
        FixingMeans::Push => &["push", "plug"],
    }
}

#[test]
fn what_ships_is_fixed_and_its_steps_say_so() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        let sensor = build_design(name, &[]).sensor;
        let mut fixings = 0;
        for step in &sensor.chain {
            for fixing in &step.fixings {
                let says = |word: &&str| step.instruction.contains(*word);
                assert!(words(fixing.means).iter().any(says), "{name}: {step:#?}");
                let bodies = fixing.bodies.iter().map(|body| sensor.body(body).unwrap());
                bodies.for_each(|body| {
                    assert_eq!(body.duty, MechanicalRole::Attached, "{}", body.name)
                });
                fixings += fixing.bodies.len();
            }
        }
        let small =
            sensor.bodies.iter().filter(|body| body.duty == MechanicalRole::Attached).count();
        assert!(fixings >= small && small > 0, "{name}: {fixings} of {small}");
        assert_eq!(errors(&sensor), [], "{name}");
    });
}
