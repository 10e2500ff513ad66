//! Designs that nobody could use, though every shape in them is sound: each is found, by the rule and
//! the body that are to blame, and what ships has no such finding.

use fabkit_checks::{Finding, Rule};
use fabkit_tests::sample_cases;
use rayon::prelude::*;

fn unseen(sensor: &str, settings: &[&str]) -> Vec<Finding> {
    let yaml = fabkit_designs::builtin_yaml(sensor).unwrap();
    let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
    let design = fabkit_designs::load(sensor, yaml, &settings, &["fixtures"])
        .unwrap_or_else(|error| panic!("{sensor} {settings:?}: {error:?}"));
    fabkit_checks::check_camera_view(&design.sensor).unwrap()
}

const BLACK: &str = "Smooth-On Ecoflex 00-30 with black Silc-Pig";
const WHITE: &str = "Smooth-On Psycho Paint, white";
const CLEAR: &str = "Smooth-On Solaris";

/// Sensor, what is set, and what the finding blames first.
const WRONG_SIGHT: [(&str, &str, &str, &str); 17] = [
    ("rtac0", "camera.field_of_view", "40deg", "translucent-gel"),
    ("rtac0", "camera.field_of_view", "10deg", "translucent-gel"),
    ("rtac0", "filling_gel.material", BLACK, "locking-gel"),
    ("rtac0", "filling_gel.material", WHITE, "locking-gel"),
    ("rtac0", "transparent_gel.material", BLACK, "transparent-gel"),
    ("rtac0", "coat.material", CLEAR, "translucent-gel"),
    ("rtac0", "diffuser.bore_radius", "4.5mm", "diffuser"),
    ("uvdtact", "camera.field_of_view", "20deg", "inner-elastomer"),
    ("uvdtact", "shell.material", "black resin", "shell"),
    ("uvdtact", "black_gel.material", CLEAR, "inner-elastomer"),
    ("shadowtac", "plate.material", "black acrylic", "plate"),
    ("shadowtac", "skin.material", BLACK, "skin"),
    ("tactip", "fill.material", BLACK, "gel"),
    ("tactip", "camera.pixels", "8", "dots"),
    ("tactip", "lens.material", "frosted acrylic", "lens"),
    ("9dtact", "plate.material", "white acrylic", "plate"),
    ("digit-like", "coat.material", CLEAR, "gel"),
];

#[test]
fn a_camera_that_cannot_see_is_found() {
    sample_cases(&WRONG_SIGHT).par_iter().for_each(|(sensor, path, value, blamed)| {
        let set = format!("{path}={value}");
        let found = unseen(sensor, &[&set]);
        // One cause, one finding.
        let [finding] = &found[..] else { panic!("{sensor} --set {set}: {found:#?}") };
        assert_eq!(finding.rule, Rule::Sight);
        assert_eq!(
            finding.bodies.first().map(String::as_str),
            Some(*blamed),
            "{set}: {finding:#?}"
        );
    });
}

#[test]
fn what_ships_is_seen() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|sensor| {
        let found = unseen(sensor, &[]);
        assert!(found.is_empty(), "{sensor}: {found:#?}");
    });
}

#[test]
fn three_small_dots_are_seen_as_well_as_many() {
    let few = ["pins.pattern=list", "pins.polar=[0 deg, 30 deg, 30 deg]"];
    let few = [&few[..], &["pins.azimuth=[0 deg, 0 deg, 120 deg]"]].concat();
    assert_eq!(unseen("tactip", &few), []);
}
