//! Sensors that daylight gets into: each is found by the rule `leak`, and what ships is dark inside.

use fabkit_checks::{Finding, Rule};
use fabkit_geometry::{CompiledSolid, OpticalClarity, Sensor, Solid};
use fabkit_tests::{build_design, find_findings, sample_cases};
use rayon::prelude::*;

/// How a sensor is spoiled.
#[derive(Clone, Copy, Debug)]
enum Spoil {
    /// A window of 6 x 6 mm towards +x, at that share of the body's height.
    Window(f64),
    /// Light passes it, and is spread.
    Translucent,
    /// It is left out.
    Without,
}

fn spoiled(sensor: &str, body: &str, spoil: Spoil) -> Sensor {
    let mut sensor = build_design(sensor, &[]).sensor;
    match spoil {
        Spoil::Translucent => {
            sensor.body_mut(body).unwrap().set_clarity(OpticalClarity::Translucent)
        }
        Spoil::Without => sensor.bodies.retain(|other| other.name != body),
        Spoil::Window(share) => {
            let of = sensor.body_mut(body).unwrap();
            let bounds = CompiledSolid::new(&of.solid).unwrap().bounds();
            let z = bounds.min.z + share * (bounds.max.z - bounds.min.z);
            let window = Solid::cuboid(200.0, 6.0, 6.0).at(100.0, 0.0, z);
            of.solid = of.solid.clone().minus(window);
        }
    }
    sensor
}

/// Sensor, body, what becomes of it, and what is blamed.
const WRONG: [(&str, &str, Spoil, &str); 20] = [
    ("rtac0", "shell", Spoil::Window(0.5), "shell"),
    ("rtac0", "shell", Spoil::Window(0.8), "shell"),
    ("rtac0", "shell", Spoil::Translucent, "shell"),
    ("rtac0-published-2025", "shell", Spoil::Window(0.8), "shell"),
    ("9dtact", "shell", Spoil::Window(0.2), "shell"),
    ("9dtact", "shell", Spoil::Window(0.5), "shell"),
    ("digit-like", "shell", Spoil::Window(0.2), "shell"),
    ("digit-like", "base", Spoil::Translucent, "base"),
    ("gelsight-like", "shell", Spoil::Window(0.5), "shell"),
    ("gelsight-like", "base", Spoil::Translucent, "base"),
    ("shadowtac", "holder", Spoil::Window(0.2), "holder"),
    ("shadowtac", "base", Spoil::Translucent, "base"),
    ("tactip", "skin", Spoil::Window(0.2), "skin"),
    ("tactip", "ring", Spoil::Window(0.5), "body"),
    ("tactip", "body", Spoil::Translucent, "body"),
    ("tactip", "body", Spoil::Without, "ring"),
    ("uvdtact", "shell-holder", Spoil::Window(0.5), "shell-holder"),
    ("uvdtact", "shell-holder", Spoil::Without, "black-gel"),
    ("fluidic", "box-wall", Spoil::Translucent, "box-wall"),
    ("fluidic", "box-floor", Spoil::Translucent, "box-floor"),
];

/// Sensor, what is set, and the body that daylight passes.
const SET: [(&str, &str, &str); 6] = [
    ("rtac0", "shell.material=transparent PETG", "shell"),
    ("9dtact", "shell.material=translucent PLA", "shell"),
    ("digit-like", "shell.material=clear resin", "shell"),
    ("shadowtac", "holder.material=clear standard resin", "holder"),
    ("tactip", "body.material=clear cast acrylic", "body"),
    ("fluidic", "housing.material=clear acrylic", "box-wall"),
];

fn told(sensor: &Sensor) -> Option<Finding> {
    let found = find_findings(sensor, &[Rule::Leak]).unwrap();
    assert!(found.len() <= 1, "{found:#?}");
    found.into_iter().next()
}

#[test]
fn daylight_is_found() {
    sample_cases(&WRONG).par_iter().for_each(|(name, body, spoil, blamed)| {
        let finding = told(&spoiled(name, body, *spoil));
        let finding = finding.unwrap_or_else(|| panic!("{name} {body} {spoil:?}: dark inside"));
        assert_eq!(finding.rule, Rule::Leak);
        assert_eq!(finding.bodies[0], *blamed, "{name} {body} {spoil:?}: {finding:#?}");
        assert!(finding.place.is_some(), "{finding:#?}");
    });
}

#[test]
fn materials_that_light_passes_are_found() {
    sample_cases(&SET).par_iter().for_each(|(name, set, blamed)| {
        let finding = told(&build_design(name, &[set]).sensor);
        let finding = finding.unwrap_or_else(|| panic!("{name} {set}: dark inside"));
        assert_eq!(finding.bodies[0], *blamed, "{name} {set}: {finding:#?}");
        assert!(finding.message.contains("through"), "{finding:#?}");
    });
}

#[test]
fn what_ships_is_dark_inside() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        assert_eq!(told(&build_design(name, &[]).sensor), None, "{name}");
    });
}

#[test]
fn a_hole_that_no_line_leads_through_lets_nothing_in() {
    // Beside the base, that fills the shell there.
    assert_eq!(told(&spoiled("rtac0", "shell", Spoil::Window(0.2))), None);
}

#[test]
fn the_place_is_in_the_window() {
    let finding = told(&spoiled("rtac0", "shell", Spoil::Window(0.8))).unwrap();
    let place = finding.place.unwrap();
    assert!(place.x > 12.0 && place.y.abs() < 3.0, "{place:?}");
    let share = finding.measured.unwrap();
    assert!(share.value > share.limit && share.value < 0.02, "{share:?}");
}
