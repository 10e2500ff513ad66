//! Retention, cure, hardness and flow, tested with toy sensors whose figures are known.

use fabkit_checks::example::puck;
use fabkit_checks::{CheckReport, Finding, Rule, Severity, check};
use fabkit_geometry::{
    Action, Adhesion, Angle, Assembly, Body, CureMechanism, FixtureGrip, MaterialClass,
    MaterialProperties, NominalCamera, Path, Placement, PlaneSurface, Pose, PressFit, Process,
    Sensor, Shore, Solid, Step,
};

/// Length and width of the pad, mm.
const PAD_MM: [f64; 2] = [20.0, 10.0];

fn here() -> [Placement; 1] {
    [Placement::in_place(Assembly::sensor())]
}

fn base() -> Body {
    Body::made("base", "", Process::Fdm, Solid::cuboid(40.0, 40.0, 10.0).at_z(-10.0)).placed(here())
}

fn pad(solid: Solid) -> Body {
    Body::cast("pad", "", solid).placed(here())
}

/// Bodies, what presses on the first 3 mm above z = 0, and no chain.
fn sensor(bodies: impl IntoIterator<Item = Body>) -> Sensor {
    let outline = Path::rectangle([0.0; 2], PAD_MM, 0.0);
    let grip = FixtureGrip {
        outline: outline.clone(),
        top_z_mm: 0.0,
        bottom_z_mm: -10.0,
        clear_radius_mm: 1.0,
        key: None,
        threads: Vec::new(),
    };
    let camera = NominalCamera {
        sensor_from_camera: Pose::identity(),
        width_px: 640,
        height_px: 480,
        field_of_view: Angle::from_deg(90.0).unwrap(),
        lens: Default::default(),
    };
    let touch =
        PlaneSurface { outline, top_z_mm: 3.0, foot_z_mm: 0.0, max_indentation_mm: 1.0, grip };
    Sensor {
        touch: Some(fabkit_geometry::TouchSurface::Plane(touch)),
        required_load_n: Some(10.0),
        ..Sensor::new("toy", "", "", camera, bodies)
    }
}

fn glued(mut sensor: Sensor, shear_mpa: f64, pull_mpa: f64) -> Sensor {
    sensor.adhesions.push(Adhesion {
        bodies: ["pad", "base"].map(String::from),
        by: "glue".into(),
        reach_mm: 0.01,
        shear_mpa,
        pull_mpa,
    });
    sensor
}

fn flat_pad() -> Body {
    pad(Solid::cuboid(PAD_MM[0], PAD_MM[1], 3.0))
}

fn of(sensor: &Sensor, rule: Rule) -> Vec<Finding> {
    let report: CheckReport = check(sensor).unwrap();
    report.for_rule(rule).cloned().collect()
}

fn near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 0.02, "{found} is not {expected}");
}

#[test]
fn a_glued_pad_bears_its_area_times_the_strength() {
    let area_mm2 = PAD_MM[0] * PAD_MM[1];
    // 20 N of shear, 40 N of pull.
    let toy = glued(sensor([base(), flat_pad()]), 0.1, 0.2);
    let [note] = &of(&toy, Rule::Retention)[..] else { panic!() };
    assert_eq!(note.severity, Severity::Note);
    near(note.measured.unwrap().value, 0.1 * area_mm2);

    for (load_n, words) in [(30.0, vec!["shear"]), (50.0, vec!["pull", "shear"])] {
        let toy = Sensor { required_load_n: Some(load_n), ..toy.clone() };
        let found = of(&toy, Rule::Retention);
        assert_eq!(found.len(), words.len(), "{found:#?}");
        for (finding, word) in found.iter().zip(words) {
            assert!(finding.message.contains(word), "{}", finding.message);
            assert_eq!(finding.bodies, ["pad", "base"]);
            let strength = if word == "pull" { 0.2 } else { 0.1 };
            near(finding.measured.unwrap().value, strength * area_mm2);
        }
    }
}

#[test]
fn unheld_bodies_leave_along_unblocked_directions() {
    let ways = |sensor: &Sensor| {
        let found = of(sensor, Rule::Retention);
        let leaving = found.iter().find(|f| f.message.contains("can leave")).cloned();
        leaving.map(|f| (f.bodies.clone(), f.message.clone()))
    };
    // It only lies there.
    let (bodies, message) = ways(&sensor([base(), flat_pad()])).unwrap();
    assert_eq!(bodies, ["pad"]);
    assert!(message.contains("+x, -x, +y, -y, +z:"), "{message}");

    // In a recess that is 0.2 mm wider all around.
    let recess = Solid::cuboid(20.4, 10.4, 2.0).at_z(-1.0);
    let base_with_recess = Body { solid: base().solid.minus(recess), ..base() };
    let sunk = pad(Solid::cuboid(20.0, 10.0, 4.0).at_z(-1.0));
    let (_, message) = ways(&sensor([base_with_recess, sunk])).unwrap();
    assert!(message.contains("along +z:"), "{message}");

    // Floating: it meets nothing.
    let floating = pad(Solid::cuboid(20.0, 10.0, 1.0).at_z(2.0));
    let (bodies, message) = ways(&sensor([base(), floating])).unwrap();
    assert_eq!(bodies, ["pad"]);
    assert!(message.contains("-z"), "{message}");
}

/// A frame over the flange of a pad, on the base; a screw through both.
fn clamped(has_thread: bool) -> Sensor {
    let flanged = Solid::cuboid(24.0, 14.0, 1.0).plus(Solid::cuboid(20.0, 10.0, 3.0));
    let room = Solid::cuboid(24.4, 14.4, 2.0).at_z(-1.0);
    let window = Solid::cuboid(20.4, 10.4, 4.0);
    let hole = Solid::cylinder(1.6, 9.0).at(16.0, 0.0, -4.0);
    let frame = Solid::cuboid(40.0, 40.0, 2.0).minus(room).minus(window).minus(hole);
    let pilot = Solid::cylinder(1.4, 7.0).at(16.0, 0.0, -6.0);
    let below = Body { solid: base().solid.minus(pilot), ..base() };
    let shaft = Solid::cylinder(1.5, 7.0).at(16.0, 0.0, -5.0);
    let head = Solid::cylinder(2.5, 1.5).at(16.0, 0.0, 2.0);
    let screw = Body::bought("screw-m3x7", "", shaft.plus(head)).placed(here()).as_fastener();
    let frame = Body::made("frame", "", Process::Fdm, frame).placed(here()).with_handles(2);
    let mut toy = sensor([below, pad(flanged), frame, screw]);
    let fit = PressFit {
        inner: "screw-m3x7".into(),
        outer: "base".into(),
        interference_mm: 0.1,
        reason: String::new(),
    };
    toy.press_fits.extend(has_thread.then_some(fit));
    toy
}

#[test]
fn a_screw_holds_where_it_has_a_thread() {
    let found = of(&clamped(true), Rule::Retention);
    assert!(found.iter().all(|f| f.severity == Severity::Note), "{found:#?}");
    let found = of(&clamped(false), Rule::Retention);
    let leaving = found.iter().find(|f| f.message.contains("can leave")).unwrap();
    let mut bodies = leaving.bodies.clone();
    bodies.sort();
    assert!(
        bodies.contains(&"frame".to_owned()) && bodies.contains(&"pad".to_owned()),
        "{leaving:#?}"
    );
}

/// The puck of platinum silicone.
fn platinum(change: impl Fn(&mut Sensor)) -> Vec<Finding> {
    let mut sensor = puck();
    let gel = MaterialProperties {
        class: Some(MaterialClass::Silicone),
        cure_mechanism: Some(CureMechanism::Platinum),
        ..MaterialProperties::default()
    };
    sensor.body_mut("puck").unwrap().substance = gel;
    change(&mut sensor);
    check(&sensor).unwrap().for_rule(Rule::Chemistry).cloned().collect()
}

fn bare(sensor: &mut Sensor) {
    sensor.body_mut("dish").unwrap().substance.inhibited_cures =
        Some(vec![CureMechanism::Platinum]);
}

fn says(sensor: &mut Sensor, instruction: &str) {
    let step = Step {
        name: "prepare".into(),
        instruction: instruction.into(),
        assembly: None,
        bodies: vec!["dish".into(), "lid".into()],
        motions: Vec::new(),
        fixings: Vec::new(),
        adjustments: Vec::new(),
        during_cure_of: None,
        action: Action::Prepare,
        source: String::new(),
    };
    sensor.chain.insert(0, step);
}

#[test]
fn silicone_does_not_cure_against_what_inhibits_it() {
    assert_eq!(platinum(|_| ()), []);
    let found = platinum(bare);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!((&found[0].bodies[0], found[0].step.as_deref()), (&"dish".into(), Some("pour")));

    // Sealed, but no step does it.
    let sealed = |sensor: &mut Sensor| {
        bare(sensor);
        sensor.body_mut("dish").unwrap().sealed_by = Some("varnish");
    };
    assert_eq!(platinum(sealed).len(), 1);
    let done = platinum(|sensor| {
        sealed(sensor);
        says(sensor, "Varnish the dish");
    });
    assert_eq!(done, []);
    // Tin silicone minds nothing of it.
    let tin = platinum(|sensor| {
        bare(sensor);
        sensor.body_mut("puck").unwrap().substance.cure_mechanism = Some(CureMechanism::Tin);
    });
    assert_eq!(tin, []);
}

#[test]
fn silicone_grows_together_with_a_silicone_mold_without_release_agent() {
    let soft = |sensor: &mut Sensor| {
        let dish = sensor.body_mut("dish").unwrap();
        dish.substance = MaterialProperties {
            class: Some(MaterialClass::Silicone),
            shore: Some(Shore::A(30.0)),
            ..MaterialProperties::default()
        };
    };
    let found = platinum(soft);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].message.contains("grows together"), "{}", found[0].message);
    let released = platinum(|sensor| {
        soft(sensor);
        says(sensor, "spray both with release agent");
    });
    assert_eq!(released, []);
}

#[test]
fn surplus_leaves_through_openings_that_are_wide_enough() {
    let slow = |radius_mm: f64, pa_s: f64| {
        let mut sensor = puck();
        sensor.body_mut("puck").unwrap().substance.viscosity_pa_s = Some(pa_s);
        for step in &mut sensor.chain {
            if let Action::Pour(pour) = &mut step.action {
                pour.openings[0].radius_mm = radius_mm;
            }
        }
        let found = check(&sensor).unwrap();
        found.for_rule(Rule::Flow).next().and_then(|finding| finding.measured).map(|m| m.value)
    };
    assert_eq!(slow(1.0, 3.0), None);
    // pi r^3 p / (80 mu) = 1.06 mm3/s, for half of 628 mm3.
    near(slow(0.3, 10.0).unwrap(), 314.16 / 1.0603);
}

#[test]
fn hardness_limits_are_checked() {
    let with = |spoil: fn(&mut Sensor)| {
        let mut toy = glued(sensor([base(), flat_pad()]), 1.0, 1.0);
        spoil(&mut toy);
        of(&toy, Rule::Softness).iter().map(|f| f.bodies[0].clone()).collect::<Vec<_>>()
    };
    fn set(sensor: &mut Sensor, name: &str, shore: Shore) {
        sensor.body_mut(name).unwrap().substance.shore = Some(shore);
    }
    assert_eq!(with(|s| set(s, "base", Shore::D(70.0))), [""; 0]);
    assert_eq!(with(|s| set(s, "base", Shore::A(40.0))), ["base"]);
    assert_eq!(with(|s| set(s, "base", Shore::OO(90.0))), ["base"]);
    let touched = |s: &mut Sensor| {
        let base = s.body_mut("base").unwrap();
        base.is_deformable = true;
        base.substance.shore = Some(Shore::D(70.0));
    };
    assert_eq!(with(touched), ["base"]);
}
