//! Sensors whose every part fits where it is, and cannot get there: each is found, by the rule and the
//! body that are to blame, and what ships has no such finding.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_geometry::{Angle, Body, MotionLeg, Placement, Pose, Sensor, Solid, Step, Vector3};
use fabkit_tests::{build_design, motions, sample_cases};
use rayon::prelude::*;

fn step<'a>(sensor: &'a mut Sensor, name: &str) -> &'a mut Step {
    sensor.chain.iter_mut().find(|step| step.name == name).unwrap()
}

/// Puts the first step after the second.
fn swapped(sensor: &mut Sensor, first: &str, second: &str) {
    let at =
        |sensor: &Sensor, name| sensor.chain.iter().position(|step| step.name == name).unwrap();
    let moved = at(sensor, first);
    let moved = sensor.chain.remove(moved);
    let after = at(sensor, second) + 1;
    sensor.chain.insert(after, moved);
}

/// Lets a step bring a body no more; the last one of its assembly brings it.
fn late(sensor: &mut Sensor, from: &str, body: &str) {
    let step = step(sensor, from);
    step.bodies.retain(|name| name != body);
    let last = Step {
        name: "late".into(),
        bodies: vec![body.into()],
        motions: Vec::new(),
        fixings: Vec::new(),
        adjustments: Vec::new(),
        during_cure_of: None,
        action: fabkit_geometry::Action::Assemble,
        ..step.clone()
    };
    sensor.chain.push(last);
}

/// Stands something around the axis of each place of a body, from a height of its own upwards.
fn surrounded(sensor: &mut Sensor, body: &str, [inner, outer]: [f64; 2], from_z: f64) {
    let ring = Solid::cylinder(outer, 10.0).minus(Solid::cylinder(inner, 12.0).at_z(-1.0));
    let place = sensor.body(body).unwrap().placements[0].clone();
    let place = Placement::at(place.assembly, place.assembly_from_body);
    sensor.bodies.push(Body::bought("fence", "in the way", ring.at_z(from_z)).placed([place]));
}

fn turned(sensor: &mut Sensor, step_name: &str, share: f64) {
    for leg in &mut step(sensor, step_name).motions[0].legs {
        if let MotionLeg::Turn { angle, .. } = leg {
            *angle = Angle::from_rad(share * angle.rad()).unwrap();
        }
    }
}

type Change = fn(&mut Sensor);

/// Sensor, what is changed, the rule that finds it, and the body that it blames.
const WRONG: [(&str, Change, Rule, &str); 15] = [
    // As they were before the rule.
    (
        "uvdtact",
        |sensor| sensor.chain.retain(|step| step.name != "glue-holder"),
        Rule::Motion,
        "shell-holder",
    ),
    (
        "rtac0-published-2025",
        |sensor| step(sensor, "spray-coat").bodies.retain(|name| name != "dowel"),
        Rule::Motion,
        "dowel",
    ),
    // Bayonets that are pushed, not turned; or not far enough, or the wrong way.
    ("tactip", |sensor| step(sensor, "lock-tip").motions.clear(), Rule::Motion, "ring"),
    ("tactip", |sensor| step(sensor, "mount").motions.clear(), Rule::Motion, "robot-mount"),
    ("tactip", |sensor| turned(sensor, "lock-tip", 0.5), Rule::Motion, "skin"),
    ("tactip", |sensor| turned(sensor, "lock-tip", -1.0), Rule::Motion, "skin"),
    ("tactip", |sensor| turned(sensor, "mount", -1.0), Rule::Motion, "robot-mount"),
    // Orders of steps and of bodies that do not work.
    ("tactip", |sensor| late(sensor, "assemble-body", "led-board"), Rule::Motion, "led-board"),
    ("tactip", |sensor| late(sensor, "assemble-body", "screw-m3x6"), Rule::Motion, "screw-m3x6"),
    ("9dtact", |sensor| late(sensor, "fit-camera", "camera"), Rule::Motion, "camera"),
    ("digit-like", |sensor| swapped(sensor, "fit-light", "close"), Rule::Motion, "led"),
    ("shadowtac", |sensor| late(sensor, "glue-leds", "led"), Rule::Motion, "led"),
    ("rtac0", |sensor| late(sensor, "mount-leds", "led-board"), Rule::Motion, "led-board"),
    // What does not give way, and what stands where a screwdriver has to be.
    (
        "rtac0",
        |sensor| sensor.body_mut("o-ring").unwrap().assembly_compliance_mm = 0.0,
        Rule::Motion,
        "o-ring",
    ),
    (
        "digit-like",
        |sensor| surrounded(sensor, "screw-m1-6x6", [4.0, 7.0], 65.0),
        Rule::Access,
        "screw-m1-6x6",
    ),
];

#[test]
fn what_cannot_get_to_its_place_is_found() {
    let failures: Vec<String> = sample_cases(&WRONG)
        .par_iter()
        .enumerate()
        .filter_map(|(row, (name, change, rule, blamed))| {
            let mut sensor = build_design(name, &[]).sensor;
            change(&mut sensor);
            let found = motions(&sensor).unwrap();
            let is_it = |finding: &Finding| {
                finding.rule == *rule
                    && finding.severity == Severity::Error
                    && finding.bodies[0] == *blamed
                    && finding.step.is_some()
                    && finding.place.is_some()
            };
            let said: Vec<_> = found.iter().map(|f| format!("{}: {}", f.rule, f.message)).collect();
            (!found.iter().any(is_it)).then(|| format!("row {row}, {name} {blamed}: {said:#?}"))
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn what_ships_gets_to_its_place() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        let found = motions(&build_design(name, &[]).sensor).unwrap();
        assert!(found.is_empty(), "{name}: {found:#?}");
    });
}

/// A post that stands on a plate below a hood with a hole above it.
fn hooded(hole_mm: f64, hood_comes_first: bool) -> Sensor {
    let mut sensor = build_design("shadowtac", &[]).sensor;
    let here = || [Placement::at(fabkit_geometry::Assembly::sensor(), Pose::identity())];
    let bought = |name: &str, solid: Solid| Body::bought(name, "", solid).placed(here());
    let hood = Solid::cuboid(20.0, 20.0, 12.0)
        .minus(Solid::cuboid(16.0, 16.0, 11.0).at_z(-1.0))
        .minus(Solid::cylinder(hole_mm, 20.0));
    sensor.bodies = vec![
        bought("plate", Solid::cuboid(20.0, 20.0, 1.0).at_z(-1.0)),
        bought("post", Solid::cylinder(3.0, 8.0)),
        bought("hood", hood),
    ];
    let step = |name: &str, bodies: &[&str]| Step {
        name: name.into(),
        bodies: bodies.iter().map(|name| (*name).to_owned()).collect(),
        instruction: String::new(),
        source: String::new(),
        assembly: Some(fabkit_geometry::Assembly::sensor()),
        motions: Vec::new(),
        fixings: Vec::new(),
        adjustments: Vec::new(),
        during_cure_of: None,
        action: fabkit_geometry::Action::Assemble,
    };
    sensor.chain = if hood_comes_first {
        vec![step("first", &["plate", "hood"]), step("then", &["post"])]
    } else {
        vec![step("first", &["plate", "post"]), step("then", &["hood"])]
    };
    (sensor.press_fits, sensor.print_groups) = (Vec::new(), Vec::new());
    sensor
}

#[test]
fn depths_and_orders_are_those_of_a_toy() {
    let found = |hole_mm, hood_comes_first| motions(&hooded(hole_mm, hood_comes_first)).unwrap();
    // A post of 3 mm comes through a hole of 3.1 mm, and under a hood that comes later.
    assert_eq!(found(3.1, true), []);
    assert_eq!(found(2.5, false), []);
    // Through a hole of 2.5 mm it does not; half a millimetre all around is in its way.
    let found = found(2.5, true);
    let [finding] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(finding.bodies, ["post", "hood"]);
    assert_eq!(finding.step.as_deref(), Some("then"));
    let depth_mm = finding.measured.unwrap().value;
    assert!((depth_mm - 0.5).abs() < 2.0 * 6.0 / 160.0, "{depth_mm}");
    let place = finding.place.unwrap();
    assert!((place.z - 10.0).abs() < 1.0 + 1e-9 && place.x.hypot(place.y) > 2.5, "{place:?}");
    assert!(finding.message.contains("along -z"), "{}", finding.message);
}

#[test]
fn a_stated_way_is_followed_and_no_other_is_tried() {
    let mut sensor = hooded(3.1, true);
    let aside = fabkit_geometry::Motion::new(["post".into()], [MotionLeg::from_afar(Vector3::x())]);
    step(&mut sensor, "then").motions.push(aside);
    let found = motions(&sensor).unwrap();
    let [finding] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(finding.bodies, ["post", "hood"]);
    // In from the side above all, then down through the hole.
    let legs = [
        MotionLeg::from_afar(Vector3::x()),
        MotionLeg::Straight { along: -Vector3::z(), length_mm: Some(13.0) },
    ];
    step(&mut sensor, "then").motions[0].legs = legs.into();
    assert_eq!(motions(&sensor).unwrap(), []);
}

fn project(sensor: &str) -> fabkit_fixtures::Project {
    let yaml = fabkit_designs::builtin_yaml(sensor).unwrap();
    fabkit_fixtures::load(sensor, yaml, &[]).unwrap()
}

/// What keeps a fixture from the whole sensor, as said.
fn kept(project: &fabkit_fixtures::Project, fixture: &str) -> Vec<Finding> {
    project.check_mounting(fixture).unwrap().unwrap()
}

#[test]
fn fixtures_are_mounted_on_whole_sensors() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        let project = project(name);
        for fixture in project.fixture_names() {
            let found = kept(&project, fixture);
            assert!(found.is_empty(), "{name}/{fixture}: {found:#?}");
        }
    });
}

#[test]
fn a_fixture_that_does_not_pass_what_is_behind_the_tip_is_found() {
    for fixture in sample_cases(&["pin-dome", "semi-domes"]) {
        // As it was: the whole sensor goes in from above, though its housing is twice as wide.
        let mut whole = project("tactip");
        whole.design.sensor.detachable = None;
        // The tip alone goes in, but the foot's bore is as wide as the shaft, and not as its lugs.
        let mut narrow = project("tactip");
        if let Some(fabkit_geometry::TouchSurface::Dome(dome)) = &mut narrow.design.sensor.touch {
            dome.grip.clear_radius_mm = 11.5;
        }
        for project in [whole, narrow] {
            let found = kept(&project, fixture);
            let is_it = |finding: &&Finding| {
                finding.rule == Rule::Motion
                    && finding.bodies.iter().any(|body| body.starts_with("sensor/"))
            };
            assert!(found.iter().any(|finding| is_it(&finding)), "{fixture}: {found:#?}");
        }
    }
}
