//! Adapters between sensors and robots: what goes below every sensor, the measured patterns, and ways that
//! are closed, found by the rule and the body that are to blame.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_geometry::{Assembly, Body, CompiledSolid, Pose, Sensor, Solid, has_lettering};
use fabkit_tests::find_findings;
use rayon::prelude::*;

const ISO: &str = "adapter.pattern=iso-9409-1-50-4-m6";
const RECTANGLE: &str = "adapter.pattern=rectangle";
const ROBOTIQ: &str = "adapter.pattern=robotiq-2f-85";
const FRANKA: &str = "adapter.pattern=franka-hand";

fn loaded(name: &str, settings: &[&str]) -> Result<Sensor, Vec<(String, String)>> {
    let yaml = fabkit_designs::builtin_yaml(name).unwrap();
    let settings: Vec<String> = settings.iter().map(|set| (*set).to_owned()).collect();
    let loaded = fabkit_designs::load(name, yaml, &settings, &["fixtures"]);
    loaded.map(|design| design.sensor).map_err(|error| {
        let told = |p: fabkit_designs::parameters::Problem| (p.message, p.hint.unwrap_or_default());
        error.problems.into_iter().map(told).collect()
    })
}

fn sensor(name: &str, settings: &[&str]) -> Sensor {
    loaded(name, settings).unwrap_or_else(|error| panic!("{name} {settings:?}: {error:?}"))
}

/// Those that ask about what a mount adds: liquids, light and circuits are as without it.
const RULES: [Rule; 9] = [
    Rule::Chain,
    Rule::Interference,
    Rule::Leak,
    Rule::Motion,
    Rule::Access,
    Rule::Retention,
    Rule::Labels,
    Rule::Standing,
    Rule::Overhang,
];

/// What is worse than a note.
fn wrong(sensor: &Sensor) -> Vec<Finding> {
    let findings = find_findings(sensor, &RULES).unwrap();
    findings.into_iter().filter(|finding| finding.severity != Severity::Note).collect()
}

/// Every sensor with a mounting face, and the patterns that are looked at.
const FIT: [(&str, &[&str]); 7] = [
    ("rtac0", &[ISO, RECTANGLE, ROBOTIQ, FRANKA]),
    ("uvdtact", &[ISO, RECTANGLE]),
    ("shadowtac", &[ISO, RECTANGLE, ROBOTIQ, FRANKA]),
    ("9dtact", &[ISO, RECTANGLE, ROBOTIQ, FRANKA]),
    ("digit-like", &[ISO, RECTANGLE, ROBOTIQ, FRANKA]),
    ("gelsight-like", &[ISO, RECTANGLE, ROBOTIQ, FRANKA]),
    ("fluidic", &[ISO, RECTANGLE]),
];

#[test]
fn every_adapter_goes_below_every_sensor_with_a_mounting_face() {
    let all: Vec<(&str, &str)> =
        FIT.iter().flat_map(|(name, patterns)| patterns.iter().map(move |p| (*name, *p))).collect();
    all.into_par_iter().for_each(|(name, pattern)| {
        let sensor = sensor(name, &[pattern]);
        let plate = sensor.body("robot-adapter").expect("it is made");
        assert!(has_lettering(&plate.solid), "{name} {pattern}");
        let last = sensor.chain.last().expect("a chain");
        assert!(last.bodies.iter().any(|body| body == "robot-adapter"), "{name} {pattern}");
        let found = wrong(&sensor);
        assert!(found.is_empty(), "{name} {pattern}: {found:#?}");
        let bounds = CompiledSolid::new(&plate.solid).unwrap().bounds();
        assert!(bounds.size_mm()[0] > 20.0 && bounds.size_mm()[2] > 7.0, "{name} {pattern}");
    });
}

/// Where a body's middle is in the sensor, for each of its places.
fn places(sensor: &Sensor, name: &str) -> Vec<[f64; 2]> {
    let body = sensor.body(name).unwrap_or_else(|| panic!("{name}"));
    let here = body.placements.iter().filter(|place| place.assembly == Assembly::sensor());
    here.map(|place| place.assembly_from_body.translation_mm().xy().into()).collect()
}

#[test]
fn patterns_are_as_measured() {
    let apart = |pattern: &str, name: &str| {
        let [a, b] = places(&sensor("rtac0", &[pattern]), name)[..] else { panic!("two") };
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9, "{value}");
    near(apart(ROBOTIQ, "robot-adapter-insert-m3"), 16.0);
    near(apart(FRANKA, "bolt-m4"), 12.0);
    for [x, y] in places(&sensor("rtac0", &[ISO]), "bolt-m6") {
        near(x.hypot(y), 25.0);
    }
}

/// Reports that name the rule and all of the bodies.
fn is_found(sensor: &Sensor, rule: Rule, bodies: &[&str]) -> bool {
    let found = find_findings(sensor, &[rule]).unwrap();
    let is_it = |finding: &Finding| {
        finding.severity != Severity::Note
            && finding.rule == rule
            && bodies.iter().all(|body| finding.bodies.iter().any(|b| b == body))
    };
    let is = found.iter().any(is_it);
    assert!(is, "{rule:?} {bodies:?}: {found:#?}");
    is
}

/// The plate with something more.
fn filled(mut sensor: Sensor, more: Solid) -> Sensor {
    let plate = sensor.body_mut("robot-adapter").unwrap();
    *plate = Body { solid: plate.solid.clone().plus(more), ..plate.clone() };
    sensor
}

#[test]
fn closed_ways_are_found() {
    // The window that the wires of UVDtact leave through, filled again.
    let uvdtact = sensor("uvdtact", &[ISO]);
    let [x, y] = places(&uvdtact, "led-wire")[0];
    let bounds =
        CompiledSolid::new(&uvdtact.body("robot-adapter").unwrap().solid).unwrap().bounds();
    let heights = [bounds.min.z + 1.0, bounds.max.z - 1.0];
    let closed = filled(uvdtact.clone(), Solid::rod(0.9, heights).at(x, y, 0.0).named("plug"));
    assert!(is_found(&closed, Rule::Interference, &["robot-adapter", "led-wire"]));
    let closed = filled(uvdtact, Solid::rod(0.9, heights).named("plug"));
    assert!(is_found(&closed, Rule::Interference, &["robot-adapter", "camera"]));
    // The bolts of the flange, turned to where R-Tac0's cable leaves.
    let mut turned = sensor("rtac0", &[ISO]);
    let back = Pose::rotation_z(fabkit_geometry::Angle::from_deg(45.0).unwrap());
    for place in &mut turned.body_mut("bolt-m6").unwrap().placements {
        place.assembly_from_body = back.then_in(place.assembly_from_body);
    }
    assert!(is_found(&turned, Rule::Interference, &["camera-cable", "bolt-m6"]));
    // The pocket above a head below the fluidic sensor's floor.
    let fluidic = sensor("fluidic", &[ISO]);
    let bounds =
        CompiledSolid::new(&fluidic.body("robot-adapter").unwrap().solid).unwrap().bounds();
    let top = bounds.max.z;
    let plug = Solid::rod(2.0, [top - 3.0, top - 0.2]).at(17.0, 17.0, 0.0).named("plug");
    assert!(is_found(&filled(fluidic, plug), Rule::Interference, &["robot-adapter"]));
    // Nothing holds the sensor on a plate whose screws are not in.
    let mut loose = sensor("rtac0", &[ISO]);
    for place in &mut loose.body_mut("screw-m3x8").unwrap().placements {
        place.assembly_from_body =
            Pose::translation(0.0, 0.0, -40.0).then_in(place.assembly_from_body);
    }
    assert!(is_found(&loose, Rule::Retention, &["base"]));
}

/// Sensor, what is set, and what the message says first.
const NO_ADAPTER: [(&str, &[&str], &str); 12] = [
    ("tactip", &[ISO], "no mounting holes in a flat face"),
    ("fluidic", &[ROBOTIQ], "too wide for a finger"),
    ("fluidic", &[FRANKA], "too wide for a finger"),
    ("rtac0", &[RECTANGLE, "adapter.width=22mm"], "adapter.width is 22 mm"),
    ("rtac0", &[ISO, "adapter.flange_angle=0 deg"], "beside an M6 head"),
    ("rtac0", &[FRANKA, "adapter.angle=-90 deg"], "beside the gripper's carriage"),
    ("9dtact", &[ISO, "adapter.flange_angle=0 deg"], "beside an M6 head"),
    ("uvdtact", &[ISO, "adapter.cable_angle=-60 deg"], "adapter.cable_angle is -60 deg"),
    ("uvdtact", &[ISO, "adapter.cable_angle=90 deg"], "adapter.cable_angle is 90 deg"),
    ("uvdtact", &[ISO, "adapter.cable_width=1mm"], "need a slot of"),
    ("9dtact", &[ISO, "mount.hold=through"], "nothing holds them"),
    ("shadowtac", &[ISO, "holder.width=42mm"], "between the M6 heads"),
];

#[test]
fn adapters_that_do_not_fit_are_refused() {
    let mut tried = 0;
    for (name, settings, says) in NO_ADAPTER {
        let Err(problems) = loaded(name, settings) else { panic!("{name} {settings:?} fits") };
        let help = problems.iter().find(|(message, _)| message.contains(says));
        let (_, help) = help.unwrap_or_else(|| panic!("{name} {settings:?}: {problems:?}"));
        // What the hint says to fit does.
        if let Some(set) = help.strip_suffix("` fits").and_then(|help| help.strip_prefix('`')) {
            let (path, value) = set.split_once(": ").expect("a path and a value");
            let others = settings.iter().copied().filter(|other| !other.starts_with(path));
            let set = format!("{path}={value}");
            sensor(name, &others.chain([set.as_str()]).collect::<Vec<_>>());
            tried += 1;
        }
    }
    assert!(tried >= 5, "{tried}");
}

#[test]
fn an_m12_camera_goes_below_the_led_board() {
    // Its holder, 16 mm wide, ends below the board, and the barrel alone passes that.
    let wide = "camera.module=ov9281-uvc-38";
    let found = wrong(&sensor("rtac0", &[wide]));
    assert!(found.is_empty(), "{found:#?}");
    // A higher one, or a lens that stands lower in it, has to pass.
    for higher in ["camera.holder_height=14mm", "camera.lens_height=16mm"] {
        let Err(problems) = loaded("rtac0", &[wide, higher]) else { panic!("{higher} fits") };
        let told = |(message, _): &(String, String)| message.contains("wire_hole_diameter is");
        assert!(problems.iter().any(told), "{higher}: {problems:?}");
    }
    assert!(loaded("rtac0", &[wide, "camera.barrel_diameter=17mm"]).is_err());
}
