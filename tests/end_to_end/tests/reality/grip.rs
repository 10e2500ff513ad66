//! Molds that stick to what they cast: tools with neither a slot for a screwdriver nor an edge for two fingers
//! are found, and what ships comes apart.

use fabkit_checks::{Finding, Rule};
use fabkit_geometry::{Body, Occasion, Sensor};
use fabkit_tests::{build_design, motions, sample_cases};
use rayon::prelude::*;

/// What nothing takes off.
fn stuck(sensor: &Sensor) -> Vec<Finding> {
    let mut found = motions(sensor).unwrap();
    found.retain(|f| f.rule == Rule::Access && f.message.contains("takes"));
    found
}

fn unslotted(sensor: &mut Sensor) {
    let not_pried = |body: &mut Body| body.reach.retain(|r| r.occasion != Occasion::Removal);
    sensor.bodies.iter_mut().for_each(not_pried);
}

/// Sensor, what is set, and the tools that stick where no screwdriver has a slot.
const WRONG: [(&str, &[&str], &[&str]); 8] = [
    ("9dtact", &[], &["mold-gel", "mold-coat"]),
    ("digit-like", &[], &["mold-gel"]),
    ("rtac0", &[], &["lid-transparent-gel", "lid-translucent-gel", "collar"]),
    // A lid of 3 mm is held by its edge; one of 2.5 mm is not.
    ("shadowtac", &[], &["mold-skin-spacer"]),
    ("shadowtac", &["mold.lid_thickness=2.5 mm"], &["mold-skin-lid", "mold-skin-spacer"]),
    ("fluidic", &[], &[]),
    ("fluidic", &["molds.floor=2.5 mm"], &["mold-floor", "mold-floor"]),
    // Blocks that two hands pull apart, and a sleeve around silicone.
    ("uvdtact", &[], &[]),
];

#[test]
fn molds_without_slots_and_edges_are_found() {
    sample_cases(&WRONG).par_iter().for_each(|(name, settings, blamed)| {
        let mut sensor = build_design(name, settings).sensor;
        // Its own slots are enough.
        assert_eq!(stuck(&sensor), [], "{name} {settings:?}");
        unslotted(&mut sensor);
        let found = stuck(&sensor);
        let bodies: Vec<&str> = found.iter().map(|f| f.bodies[0].as_str()).collect();
        assert_eq!(bodies, *blamed, "{name} {settings:?}: {found:#?}");
        for finding in &found {
            let measured = finding.measured.unwrap();
            assert!(measured.value < measured.limit && measured.limit == 3.0, "{finding:#?}");
        }
    });
}

#[test]
fn what_ships_comes_apart() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        assert_eq!(stuck(&build_design(name, &[]).sensor), [], "{name}");
    });
    assert_eq!(stuck(&build_design("rtac0", &["molds.route=printed"]).sensor), []);
    // The blade goes between the sheets that the notches part.
    let fluidic = build_design("fluidic", &[]).sensor;
    for sheet in ["mold-channel-comb", "mold-marker-plate"] {
        let reach = &fluidic.body(sheet).unwrap().reach;
        assert_eq!(reach.len(), 2, "{sheet}");
    }
    let access = motions(&fluidic).unwrap();
    assert!(access.is_empty(), "{access:#?}");
}
