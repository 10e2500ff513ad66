//! Molds that no screwdriver pries open and no syringe fills: each is found by the rule `access`.

use fabkit_checks::{Finding, Rule};
use fabkit_geometry::{Assembly, Body, Occasion, Placement, Sensor, Solid};
use fabkit_tests::{build_design, motions, sample_cases};
use rayon::prelude::*;

/// Sensor, what is set, and whose tool has no room.
const WRONG: [(&str, &str, &str); 8] = [
    // A blade is 0.8 mm thick and 4 mm wide.
    ("9dtact", "mold.pry_gap=0.6 mm", "mold-floor"),
    ("digit-like", "mold.pry_gap=0.6 mm", "mold-floor"),
    ("gelsight-like", "mold.pry_gap=0.6 mm", "mold-floor"),
    ("shadowtac", "mold.pry_gap=0.6 mm", "mold-skin-block"),
    ("rtac0", "mold.pry_gap=0.8 mm", "lid-transparent-gel"),
    ("9dtact", "mold.pry_width=3 mm", "mold-floor"),
    ("shadowtac", "mold.pry_width=3 mm", "mold-skin-block"),
    ("rtac0", "mold.pry_length=3 mm", "lid-transparent-gel"),
];

fn access(sensor: &Sensor) -> Vec<Finding> {
    let mut found = motions(sensor).unwrap();
    found.retain(|finding| finding.rule == Rule::Access);
    found
}

#[test]
fn slots_that_no_blade_enters_are_found() {
    sample_cases(&WRONG).par_iter().for_each(|(name, set, blamed)| {
        let found = access(&build_design(name, &[set]).sensor);
        let is_it = |f: &&Finding| f.bodies[0] == *blamed && f.message.contains("pries");
        assert!(found.iter().any(|f| is_it(&f)), "{name} {set}: {found:#?}");
    });
}

/// Something that stands in an assembly from the beginning, around a point.
fn beside(sensor: &mut Sensor, assembly: &str, at: [f64; 3]) {
    let block = Solid::cuboid(6.0, 6.0, 6.0).at(at[0], at[1], at[2] - 3.0);
    let place = Placement::in_place(Assembly(assembly.into()));
    sensor.bodies.push(Body::bought("block", "in the way", block).placed([place]));
}

/// The places where tools of an occasion work: body, assembly, and a point of their room far from the body.
fn rooms(sensor: &Sensor, occasion: Occasion) -> Vec<(String, String, [f64; 3])> {
    let mut rooms = Vec::new();
    for body in &sensor.bodies {
        for reach in body.reach.iter().filter(|reach| reach.occasion == occasion) {
            let room = fabkit_geometry::CompiledSolid::new(&reach.solid).unwrap().bounds().centre();
            for place in &body.placements {
                let at = place.assembly_from_body.point(room);
                rooms.push((body.name.clone(), place.assembly.0.clone(), [at.x, at.y, at.z]));
            }
        }
    }
    rooms
}

#[test]
fn what_stands_beside_a_mold_is_in_the_way_of_its_tools() {
    for (name, occasion, least) in [
        ("rtac0", Occasion::Removal, 6),
        ("shadowtac", Occasion::Removal, 2),
        ("9dtact", Occasion::Removal, 2),
        ("uvdtact", Occasion::Pour, 2),
    ] {
        let sensor = build_design(name, &[]).sensor;
        let rooms = rooms(&sensor, occasion);
        assert!(rooms.len() >= least, "{name}: {rooms:?}");
        let found = rooms.iter().filter(|(body, assembly, at)| {
            let mut sensor = sensor.clone();
            beside(&mut sensor, assembly, *at);
            access(&sensor).iter().any(|f| f.bodies == [body.as_str(), "block"])
        });
        // In some assemblies the body stands, and nothing is poured or taken off.
        assert!(found.count() >= least, "{name}: {rooms:?}");
    }
}
