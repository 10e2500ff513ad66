//! Lenses that no finger turns, pins that none pulls, bolts and dowels without room, and steps that cannot
//! overlap: each is found, and what ships has no such finding.

use fabkit_checks::{Finding, Rule, check_manual_steps};
use fabkit_geometry::{
    Action, Assembly, Body, CompiledSolid, Cure, Occasion, Placement, Sensor, Solid, Step,
};
use fabkit_tests::{build_design, motions, sample_cases};
use rayon::prelude::*;

fn access(sensor: &Sensor) -> Vec<Finding> {
    let mut found = motions(sensor).unwrap();
    found.retain(|finding| finding.rule == Rule::Access);
    found
}

fn step<'a>(sensor: &'a mut Sensor, name: &str) -> &'a mut Step {
    sensor.chain.iter_mut().find(|step| step.name == name).unwrap()
}

/// Sensor, what is set, and what is in the way of what turns the lens.
const UNTURNED: [(&str, &[&str], &str); 8] = [
    // Less than a finger's hold stands out of the holder.
    ("tactip", &["camera.holder_height=18 mm", "camera.holder_size=15 mm"], "camera"),
    ("tactip", &["camera.lens_height=13 mm", "camera.holder_size=15 mm"], "camera"),
    ("fluidic", &["camera.holder_height=18 mm"], "camera"),
    ("fluidic", &["camera.lens_height=11 mm"], "camera"),
    ("shadowtac", &["camera.lens_protrusion=2 mm"], "camera"),
    // Level with the holder: tweezers find no rim.
    ("9dtact", &["camera.holder_height=4.4 mm", "camera.lens_height=4.4 mm"], "camera"),
    ("digit-like", &["camera.holder_height=4 mm"], "camera"),
    ("gelsight-like", &["camera.holder_height=4 mm"], "camera"),
];

#[test]
fn lenses_that_nothing_turns_are_found() {
    sample_cases(&UNTURNED).par_iter().for_each(|(name, set, by)| {
        let found = access(&build_design(name, set).sensor);
        let is_it =
            |f: &&Finding| f.bodies == ["camera", by] && f.message.contains("turn the lens");
        assert!(found.iter().any(|f| is_it(&f)), "{name} {set:?}: {found:#?}");
    });
}

/// Sensor, and the step that focuses its camera.
const FOCUSED: [(&str, &str); 8] = [
    ("rtac0", "focus"),
    ("shadowtac", "assemble"),
    ("tactip", "focus-lens"),
    ("fluidic", "focus-box-camera"),
    ("fluidic", "raise-display-camera"),
    ("9dtact", "fit-camera"),
    ("digit-like", "fit-camera"),
    ("gelsight-like", "fit-camera"),
];

#[test]
fn what_is_put_in_front_of_a_lens_keeps_fingers_from_it() {
    sample_cases(&FOCUSED).par_iter().for_each(|(name, focused)| {
        let mut sensor = build_design(name, &[]).sensor;
        let camera = sensor.body("camera").unwrap();
        let reach = camera.reach.iter().find(|reach| reach.occasion == Occasion::Adjustment);
        let bounds = CompiledSolid::new(&reach.unwrap().solid).unwrap().bounds();
        let at = step(&mut sensor, focused).assembly.clone().unwrap();
        // A block before every place of the lens, wider than the window for two fingers.
        let (z, side) = ((bounds.min.z + bounds.max.z) / 2.0, bounds.max.x - bounds.min.x);
        let block = Solid::cuboid(side, side, 8.0).at_z(z - 4.0);
        let block = block.minus(Solid::cylinder(3.0, 40.0).at_z(z - 20.0));
        let camera = sensor.body("camera").unwrap();
        let places = camera.placements.iter().filter(|place| place.assembly == at);
        let places: Vec<Placement> = places.cloned().collect();
        sensor.bodies.push(Body::bought("block", "in the way", block).placed(places));
        step(&mut sensor, focused).bodies.push("block".into());
        let found = motions(&sensor).unwrap();
        let is_it = |f: &&Finding| f.bodies == ["camera", "block"] && f.rule == Rule::Access;
        assert!(found.iter().any(|f| is_it(&f)), "{name} {focused}: {found:#?}");
    });
}

#[test]
fn lenses_that_are_forgotten_are_found() {
    for (name, focused) in FOCUSED {
        let mut sensor = build_design(name, &[]).sensor;
        assert_eq!(check_manual_steps(&sensor), [], "{name}");
        sensor.chain.iter_mut().for_each(|step| step.adjustments.clear());
        let found = check_manual_steps(&sensor);
        assert_eq!(
            (found[0].rule, &found[0].bodies[..]),
            (Rule::Access, &["camera".to_owned()][..])
        );
        // Something without a lens, and a lens of another step.
        for (body, rule) in [("screw", Rule::Chain), ("camera", Rule::Chain)] {
            let mut sensor = build_design(name, &[]).sensor;
            let other =
                sensor.bodies.iter().find(|b| b.name.starts_with(body)).map(|b| b.name.clone());
            let Some(other) = other else { continue };
            let at = sensor.chain.iter().position(|step| step.name == focused).unwrap();
            let at = if body == "camera" { 0 } else { at };
            sensor.chain[at] = sensor.chain[at].clone().with_adjustment(other);
            assert!(check_manual_steps(&sensor).iter().any(|f| f.rule == rule), "{name} {body}");
        }
    }
}

#[test]
fn a_gauge_around_the_lens_is_turned_in_only_through_its_windows() {
    let mut sensor = build_design("tactip", &[]).sensor;
    let gauge = sensor.body_mut("focus-gauge").unwrap();
    let bounds = CompiledSolid::new(&gauge.solid).unwrap().bounds();
    let (radius, height) = (bounds.max.x, bounds.max.z - bounds.min.z);
    let bore = Solid::cylinder(radius - 2.0, height).at_z(bounds.min.z - 1.0);
    gauge.solid = Solid::cylinder(radius, height).at_z(bounds.min.z).minus(bore);
    let found = access(&sensor);
    assert!(found.iter().any(|f| f.bodies == ["camera", "focus-gauge"]), "{found:#?}");
}

#[test]
fn pins_that_no_finger_pulls_are_found() {
    let load = |name: &str, settings: &[&str]| {
        let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
        let yaml = fabkit_designs::builtin_yaml(name).unwrap();
        fabkit_fixtures::load(name, yaml, &settings).unwrap()
    };
    for (name, kit, set) in [
        ("tactip", "pin-dome", "fixtures.pin_dome.pins.head_height=2.8 mm"),
        ("digit-like", "pin-plate", "fixtures.pin_plate.pins.head_height=2.8 mm"),
    ] {
        let found = access(&load(name, &[set]).fixture(kit).unwrap().sensor);
        let is_it = |f: &&Finding| f.bodies[0].starts_with("pin-") && f.message.contains("pull");
        assert!(found.iter().any(|f| is_it(&f)), "{name} {set}: {found:#?}");
    }
}

const ISO: &str = "adapter.pattern=iso-9409-1-50-4-m6";

#[test]
fn robots_bolts_need_their_key() {
    // A cable over a head; as the flange was turned before.
    let found =
        motions(&build_design("shadowtac", &[ISO, "adapter.flange_angle=0 deg"]).sensor).unwrap();
    assert!(found.iter().any(|f| f.bodies == ["bolt-m6", "camera-cable"]), "{found:#?}");
    let found = access(&build_design("shadowtac", &[ISO, "adapter.flange_angle=10 deg"]).sensor);
    assert!(found.iter().any(|f| f.bodies == ["bolt-m6", "camera-cable"]), "{found:#?}");
    // A shelf over the heads: neither upright nor leaning.
    for name in sample_cases(&["shadowtac", "9dtact", "digit-like", "gelsight-like"]) {
        let mut sensor = build_design(name, &[ISO]).sensor;
        assert_eq!(motions(&sensor).unwrap(), [], "{name}");
        let head = sensor.body("bolt-m6").unwrap().placements[0].assembly_from_body;
        let at = head.translation_mm();
        let shelf = Solid::cuboid(80.0, 80.0, 4.0).at(at.x, at.y, at.z + 30.0);
        let place = Placement::in_place(Assembly::sensor());
        sensor.bodies.push(Body::bought("shelf", "over the heads", shelf).placed([place]));
        let found = motions(&sensor).unwrap();
        assert!(found.iter().any(|f| f.bodies == ["bolt-m6", "shelf"]), "{name}: {found:#?}");
    }
}

#[test]
fn dowels_need_what_presses_them_in() {
    for (name, assembly) in [("9dtact", "gel-mold"), ("digit-like", "gel-mold")] {
        let mut sensor = build_design(name, &[]).sensor;
        let dowels = sensor.body("dowel").unwrap();
        let place = dowels.placements.iter().find(|place| place.assembly.0 == assembly).unwrap();
        let at = place.assembly_from_body.translation_mm();
        let half = CompiledSolid::new(&dowels.solid).unwrap().bounds().max.z;
        // A bridge of the floor, nearer than a jaw, with a hole for the dowel alone.
        let way = Solid::cylinder(1.6, 100.0).at(at.x, at.y, at.z - 50.0);
        let bridge = Solid::cuboid(12.0, 12.0, 3.0).at(at.x, at.y, at.z + half + 5.0).minus(way);
        let floor = sensor.body_mut("mold-floor").unwrap();
        floor.solid = floor.solid.clone().plus(bridge);
        // The floor lies there, and the dowel comes to it.
        let at = sensor.chain.iter().position(|step| step.name == "release").unwrap();
        let first = Step { name: "first".into(), ..sensor.chain[at].clone() };
        sensor.chain.insert(at, Step { bodies: vec!["mold-floor".into()], ..first });
        let found = access(&sensor);
        assert!(found.iter().any(|f| f.bodies[0] == "dowel"), "{name}: {found:#?}");
    }
}

/// Sensor, the step that is said to be done during which other one, and what is said of it.
const OVERLAPS: [(&str, &str, &str, &str); 14] = [
    ("rtac0", "cut-tube", "cast-translucent-mold", "no earlier step"),
    ("rtac0", "prime", "cast-transparent-mold", "comes in between"),
    ("rtac0", "open-transparent-form", "cast-transparent-mold", "is handled while it cures"),
    ("rtac0", "cut-tube", "make", "nothing cures"),
    ("rtac0", "mount-leds", "pour-locking-gel", "comes in between"),
    ("tactip", "fill", "glue-lens", "is handled while it cures"),
    ("tactip", "focus-lens", "fill", "comes in between"),
    ("tactip", "close-holes", "fill", "is handled while it cures"),
    ("shadowtac", "glue-skin", "paint", "is handled while it cures"),
    ("shadowtac", "open-mold", "pour-skin", "is handled while it cures"),
    ("fluidic", "glue-tubes-right", "cement-display", "take 48 h"),
    ("fluidic", "glue-needles", "cement-display", "comes in between"),
    ("uvdtact", "peel-silicone-core", "pour-silicone-core", "comes in between"),
    ("uvdtact", "peel-inner-elastomer", "pour-inner-elastomer", "is handled while it cures"),
];

#[test]
fn steps_that_cannot_overlap_are_found() {
    for (name, late, early, says) in OVERLAPS {
        let mut sensor = build_design(name, &[]).sensor;
        let names: Vec<String> = sensor.chain.iter().map(|step| step.name.clone()).collect();
        assert!(names.iter().any(|step| step == late), "{name}: {names:?}");
        step(&mut sensor, late).during_cure_of = Some(early.into());
        let found = check_manual_steps(&sensor);
        let is_it = |f: &&Finding| f.step.as_deref() == Some(late) && f.message.contains(says);
        assert!(found.iter().any(|f| is_it(&f)), "{name} {late} during {early}: {found:#?}");
    }
}

#[test]
fn what_cures_longer_than_what_it_waits_for_is_found() {
    let mut sensor = build_design("shadowtac", &[]).sensor;
    step(&mut sensor, "glue-leds").action = Action::Bond(Cure { hours: 3.0, celsius: 23.0 });
    let found = check_manual_steps(&sensor);
    let limit = found[0].measured.map(|measured| measured.limit);
    assert!(found[0].message.contains("take 3 h") && limit == Some(1.0), "{found:#?}");
}

#[test]
fn what_ships_overlaps_as_it_can() {
    for (name, least) in
        [("rtac0", 1), ("tactip", 1), ("shadowtac", 1), ("fluidic", 1), ("uvdtact", 1)]
    {
        let sensor = build_design(name, &[]).sensor;
        assert_eq!(check_manual_steps(&sensor), [], "{name}");
        let count = sensor.chain.iter().filter(|step| step.during_cure_of.is_some()).count();
        assert!(count >= least, "{name} has {count}");
    }
}
