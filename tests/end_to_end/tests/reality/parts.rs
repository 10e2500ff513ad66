//! Prints that come off the bed, keep resin, cannot be told apart or leak at their letters: each is
//! found, by the rule and the body that are to blame, and what ships has no such finding.

use fabkit_checks::{Finding, Rule, Severity};
use fabkit_designs::blocks::label::Label;
use fabkit_geometry::{
    Angle, Body, CompiledSolid, Placement, Pose, Process, Ray, Sensor, Shells, Solid, Vector3,
    has_lettering,
};
use fabkit_tests::{find_findings, sample_cases};
use rayon::prelude::*;

fn sensor(name: &str, settings: &[&str]) -> Sensor {
    let yaml = fabkit_designs::builtin_yaml(name).unwrap();
    // Molds in halves have twins.
    let printed = (name == "rtac0").then_some(&"molds.route=printed");
    let settings = settings.iter().chain(printed);
    let settings: Vec<String> = settings.map(|set| (*set).to_owned()).collect();
    fabkit_designs::load(name, yaml, &settings, &["fixtures"])
        .unwrap_or_else(|error| panic!("{name} {settings:?}: {error:?}"))
        .sensor
}

/// What is worse than a note.
fn wrong(findings: Vec<Finding>) -> Vec<Finding> {
    findings.into_iter().filter(|finding| finding.severity != Severity::Note).collect()
}

#[test]
fn what_ships_is_labelled_and_stands() {
    fabkit_tests::sampled_sensors().into_par_iter().for_each(|name| {
        let sensor = sensor(name, &[]);
        let found = find_findings(&sensor, &[Rule::Labels, Rule::Standing]).unwrap();
        let found = wrong(found);
        assert!(found.is_empty(), "{name}: {found:#?}");
    });
}

/// Sensor, and the parts that carry no label: too small, or printed in one piece with another.
const BARE: [(&str, &[&str]); 5] = [
    ("rtac0", &[]),
    ("9dtact", &[]),
    ("tactip", &["skin", "dots"]),
    ("shadowtac", &["mold-skin-spacer"]),
    ("uvdtact", &["shell-holder", "diffusion-ring", "camera-holder"]),
];

#[test]
fn every_other_printed_part_carries_its_label() {
    for (name, expected) in BARE {
        let sensor = sensor(name, &[]);
        let is_printed = |part: &&Body| {
            matches!(part.process(), Some(Process::Fdm | Process::Sla | Process::PolyJet))
        };
        let bare = sensor.parts().filter(is_printed).filter(|part| !has_lettering(&part.solid));
        let bare: Vec<&Body> = bare.collect();
        let names: Vec<&str> = bare.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, expected, "{name}");
        let says_why = |part: &&Body| part.notes.iter().any(|n| n.starts_with("carries no label"));
        assert!(bare.iter().all(says_why), "{name}");
    }
}

#[test]
fn twins_without_labels_are_found() {
    let found =
        wrong(find_findings(&sensor("rtac0", &["labels.style=none"]), &[Rule::Labels]).unwrap());
    let blamed: Vec<&[String]> = found.iter().map(|finding| finding.bodies.as_slice()).collect();
    let halves = ["mold-transparent-gel-a", "mold-transparent-gel-b"];
    assert!(
        blamed.iter().any(|bodies| bodies.starts_with(&halves.map(str::to_owned))),
        "{found:#?}"
    );
    assert!(
        blamed.iter().flat_map(|bodies| bodies.iter()).any(|body| body == "lid-transparent-gel")
    );
    assert!(found.iter().all(|f| f.rule == Rule::Labels && f.severity == Severity::Error));
    // One label is enough to tell two parts apart.
    let parts = "labels.parts=[mold-transparent-gel-a,mold-translucent-gel-a,lid-transparent-gel]";
    let told =
        wrong(fabkit_tests::find_findings(&sensor("rtac0", &[parts]), &[Rule::Labels]).unwrap());
    assert!(told.len() < found.len(), "{told:#?}");
}

/// Where a face of one body lies against another, with some of it around; the z axis out of the first.
fn contact(sensor: &Sensor, [name, other]: [&str; 2]) -> Pose {
    let [body, beside] = [name, other].map(|name| sensor.body(name).expect(name));
    let [own, against] = [body, beside].map(|body| CompiledSolid::new(&body.solid).unwrap());
    let both = |place: &Placement| {
        let beside = beside.placements.iter().find(|p| p.assembly == place.assembly)?;
        Some(beside.assembly_from_body.inverse().then_in(place.assembly_from_body))
    };
    let other_from_own = body.placements.iter().find_map(both).expect("they stand together");
    let bounds = own.bounds();
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for step in 0..40 * 40 {
            let mut from = bounds.min;
            from[u] += bounds.size_mm()[u] * (f64::from(step % 40) + 0.4) / 40.0;
            from[v] += bounds.size_mm()[v] * (f64::from(step / 40) + 0.4) / 40.0;
            from[axis] -= 1.0;
            for crossing in own.crossings(&Ray { origin: from, direction: axes[axis] }) {
                let out = crossing.normal;
                let point = from + crossing.t * axes[axis];
                let side = axes[u] - out * out.dot(&axes[u]);
                let touches = |mm: f64| {
                    let place = point + mm * side + 0.01 * out;
                    let inside = point + mm * side - 0.5 * out;
                    against.contains(&other_from_own.point(place)) && own.contains(&inside)
                };
                if out[axis].abs() > 0.999 && [-1.0, 0.0, 1.0].into_iter().all(touches) {
                    return Pose::z_to(out, point);
                }
            }
        }
    }
    panic!("{name} and {other} do not touch");
}

/// Sensor, the part whose label is put there, and what lies against that face.
const SEALED: [(&str, [&str; 2]); 9] = [
    ("rtac0", ["mold-transparent-gel-a", "mold-transparent-gel-b"]),
    ("rtac0", ["lid-transparent-gel", "mold-transparent-gel-a"]),
    ("rtac0", ["lid-translucent-gel", "mold-translucent-gel-b"]),
    ("9dtact", ["mold-gel", "mold-floor"]),
    ("9dtact", ["mold-coat", "mold-floor"]),
    ("digit-like", ["shell", "base"]),
    ("shadowtac", ["holder", "base"]),
    ("shadowtac", ["mold-skin-lid", "mold-skin-spacer"]),
    ("gelsight-like", ["mold-gel", "mold-floor"]),
];

#[test]
fn labels_where_bodies_touch_are_found() {
    sample_cases(&SEALED).par_iter().for_each(|(name, [part, other])| {
        for is_sunken in [true, false] {
            let mut sensor = sensor(name, &["labels.style=none"]);
            let pose = contact(&sensor, [part, other]);
            let label = Label::new("i", 2.5, pose).unwrap();
            let body = sensor.body_mut(part).unwrap();
            *body = if is_sunken {
                body.clone().cut(label.sunken())
            } else {
                Body { solid: body.solid.clone().plus(label.raised()), ..body.clone() }
            };
            let found = wrong(find_findings(&sensor, &[Rule::Labels]).unwrap());
            let blamed = found.iter().find(|finding| finding.message.contains("the label of"));
            let blamed = blamed.unwrap_or_else(|| panic!("{name} {part} {other}: {found:#?}"));
            assert_eq!((blamed.rule, blamed.severity), (Rule::Labels, Severity::Error));
            assert_eq!(blamed.bodies[0], *part);
        }
    });
}

fn alone(part: Body) -> Vec<Finding> {
    let mut kit = sensor("rtac0", &["labels.style=none"]);
    kit.bodies = vec![part];
    find_findings(&kit, &[Rule::Standing]).unwrap()
}

#[test]
fn what_topples_is_found() {
    // On its bed as it is drawn: 79.0 mm on 49 mm2.
    let mut body = sensor("tactip", &[]).body("body").unwrap().clone();
    assert_eq!(alone(body.clone()), []);
    body.notes.retain(|note| !note.contains("brim"));
    let [finding] = &alone(body.clone())[..] else { panic!("one finding") };
    assert_eq!((finding.rule, finding.severity), (Rule::Standing, Severity::Warning));
    assert!(finding.message.starts_with("body stands 79.0 mm high on"), "{}", finding.message);
    body.notes.push("no brim".into());
    assert_eq!(alone(body).len(), 1);
    let made = |solid| Body::made("post", "a post", Process::Fdm, solid);
    // A pole, a blade, and a sign that stands on a narrow foot.
    let sign = Solid::cuboid(4.0, 4.0, 10.0).plus(Solid::cuboid(30.0, 8.0, 20.0).at_z(9.0));
    for solid in [Solid::cylinder(3.0, 45.0), Solid::cuboid(40.0, 3.0, 25.0), sign] {
        let found = alone(made(solid.clone()));
        assert_eq!(found.len(), 1, "{solid:?}");
        assert_eq!(alone(made(solid.clone()).note("on a brim")), []);
        // Whoever prints resin glues it to the plate.
        assert_eq!(alone(made(solid).made_by(Process::Sla)), []);
    }
    // The pole lies well.
    let laid = Pose::rotation_x(Angle::from_deg(90.0).unwrap());
    assert_eq!(alone(made(Solid::cuboid(6.0, 6.0, 45.0)).with_bed_orientation(laid)), []);
    // What is low does not topple.
    assert_eq!(alone(made(Solid::cylinder(1.0, 12.0))), []);
}

#[test]
fn resin_that_stays_is_found() {
    let resin = |solid| Body::made("cup", "a cup", Process::Sla, solid);
    let block = || Solid::cuboid(20.0, 20.0, 12.0);
    let closed = || block().minus(Solid::cuboid(10.0, 10.0, 6.0).at_z(3.0));
    let shells = Shells { pieces: 1, voids: 1 };
    let [finding] = &alone(resin(closed()).with_shells(shells))[..] else { panic!("one finding") };
    assert_eq!((finding.rule, finding.severity), (Rule::Standing, Severity::Error));
    let volume_mm3 = finding.measured.unwrap().value;
    assert!((volume_mm3 - 600.0).abs() < 40.0, "{volume_mm3}");
    // In filament it is air.
    assert_eq!(alone(resin(closed()).made_by(Process::Fdm)), []);
    // A hole of 3 mm in its top or side lets it out; one that the plate closes does not.
    let drain = |z_mm: f64| Solid::cylinder(1.5, 6.0).at_z(z_mm);
    assert_eq!(alone(resin(closed().minus(drain(7.0)))), []);
    let [finding] = &alone(resin(closed().minus(drain(-1.0))))[..] else { panic!("one finding") };
    assert!(finding.message.contains("the plate closes"), "{}", finding.message);
}

#[test]
fn cups_on_the_plate_are_found() {
    let resin = |solid| Body::made("cup", "a cup", Process::Sla, solid);
    let cup = || Solid::cuboid(20.0, 20.0, 12.0).minus(Solid::cuboid(10.0, 10.0, 7.0).at_z(-1.0));
    let [finding] = &alone(resin(cup()))[..] else { panic!("one finding") };
    assert_eq!(finding.severity, Severity::Warning);
    assert!(finding.message.contains("the plate closes"), "{}", finding.message);
    // Turned over it is open; on supports, and with a hole in its side, it drains.
    let over = Pose::rotation_x(Angle::from_deg(180.0).unwrap());
    assert_eq!(alone(resin(cup()).with_bed_orientation(over)), []);
    assert_eq!(alone(resin(cup()).note("print it on supports")), []);
    let side = Solid::cuboid(3.0, 30.0, 3.0).at(0.0, 15.0, 1.0);
    assert_eq!(alone(resin(cup().minus(side))), []);
    // Supports of a jetted print are washed out of it.
    assert_eq!(alone(resin(cup()).made_by(Process::PolyJet)), []);
}
