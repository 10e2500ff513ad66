//! Each rule passes what is right and finds, by name, what was made wrong on purpose.

use fabkit_checks::example::{GATE_RADIUS_MM, HEIGHT_MM, MOLD, RADIUS_MM, puck};
use fabkit_checks::{
    CheckReport, Finding, Memo, Rule, Severity, check, check_motions, check_rules,
};
use fabkit_geometry::{
    Action, Assembly, Body, CUT_OVERLAP_MM, Opening, Placement, Point3, Pose, Pour, PressFit,
    Sensor, Solid, Vector3,
};

fn report(sensor: &Sensor) -> CheckReport {
    check(sensor).unwrap()
}

/// The one finding of a rule.
fn only(sensor: &Sensor, rule: Rule) -> Finding {
    let report = report(sensor);
    let found: Vec<&Finding> = report.for_rule(rule).collect();
    assert_eq!(found.len(), 1, "{:#?}", report.findings);
    found[0].clone()
}

fn pour(sensor: &mut Sensor) -> &mut Pour {
    match &mut sensor.chain[0].action {
        Action::Pour(pour) => pour,
        other => panic!("{other:?}"),
    }
}

fn puck_area_mm2() -> f64 {
    std::f64::consts::PI * RADIUS_MM.powi(2)
}

#[test]
fn a_sound_sensor_has_no_findings() {
    let report = report(&puck());
    assert_eq!(report.findings, []);
    let examined = report.examined.iter().filter(|examined| examined.count > 0);
    let examined: Vec<_> = examined.map(|examined| (examined.rule, examined.count)).collect();
    // Nobody touches it, no camera looks at it, and no light comes from outside.
    let expected = [
        (Rule::Chain, 2),
        (Rule::Interference, 3),
        (Rule::Casting, 1),
        (Rule::TrappedAir, 1),
        (Rule::Demolding, 2),
        (Rule::Flow, 1),
        // Two bodies come to a third, without tools.
        (Rule::Motion, 2),
        // Against two walls, of unknown stuff.
        (Rule::Bonding, 1),
        (Rule::Chemistry, 2),
        (Rule::Labels, 2),
        (Rule::Standing, 2),
    ];
    for one in expected {
        assert!(examined.contains(&one), "{one:?}: {examined:?}");
    }
    let rules: Vec<Rule> = report.examined.iter().map(|examined| examined.rule).collect();
    assert_eq!(rules, Rule::ALL);
}

#[test]
fn cached_clean_results_change_no_finding() {
    let memo = Memo::default();
    let moved = |body: usize, z_mm: f64| {
        let mut sensor = puck();
        let place = &mut sensor.bodies[body].placements[0].assembly_from_body;
        *place = Pose::translation(0.0, 0.0, z_mm).then_in(*place);
        sensor
    };
    let wrong = [moved(0, -0.1), moved(0, 0.1), moved(1, 0.1), moved(2, -0.1)];
    // Each after all that are clean, and after itself.
    for sensor in [&puck()].into_iter().chain(&wrong).chain(&wrong) {
        let all = check_rules(sensor, &Rule::ALL, &memo).unwrap();
        assert_eq!(all, check(sensor).unwrap());
        // One rule alone says what it says among others.
        for rule in Rule::ALL {
            let alone = check_rules(sensor, &[rule], &memo).unwrap().findings;
            assert!(all.for_rule(rule).all(|finding| alone.contains(finding)), "{rule:?}");
        }
        let moved = check_rules(sensor, &[Rule::Motion], &memo).unwrap().findings;
        assert_eq!(moved, check_motions(sensor).unwrap());
    }
}

#[test]
fn a_dish_that_is_too_low_leaves_a_gap_of_its_volume() {
    let mut sensor = puck();
    sensor.bodies[0].placements[0].assembly_from_body = Pose::translation(0.0, 0.0, -0.1);
    let report = report(&sensor);
    let found = |wall: &str| {
        let finding = report.for_rule(Rule::Casting).find(|f| f.bodies == ["puck", wall]).unwrap();
        (finding, finding.measured.unwrap().value)
    };
    // Below the puck, a tenth of a millimetre in two; and a slit has opened under the lid.
    let (finding, fraction) = found("dish");
    assert_eq!(finding.severity, Severity::Error);
    assert!(found("lid").1 < 0.01);
    assert!((fraction - 0.05).abs() < 0.002, "{fraction}");
    let place = finding.place.unwrap();
    assert!((place.z + 0.05).abs() < 1e-3, "{place}");
    assert!(finding.message.contains("up to 0.1000 mm"), "{}", finding.message);
}

#[test]
fn a_dish_that_is_too_high_overlaps_the_layer() {
    let mut sensor = puck();
    sensor.bodies[0].placements[0].assembly_from_body = Pose::translation(0.0, 0.0, 0.1);
    let finding = only(&sensor, Rule::Casting);
    assert_eq!(finding.bodies, ["puck", "dish"]);
    let fraction = finding.measured.unwrap().value;
    assert!((fraction - 0.05).abs() < 0.002, "{fraction}");
}

#[test]
fn a_gap_of_a_tenth_of_a_nanometre_is_none() {
    let mut sensor = puck();
    sensor.bodies[0].placements[0].assembly_from_body = Pose::translation(0.0, 0.0, -1e-7);
    assert_eq!(report(&sensor).for_rule(Rule::Casting).count(), 0);
}

#[test]
fn a_hole_that_nobody_declared_is_a_leak() {
    let mut sensor = puck();
    let drain = Solid::cylinder(0.5, 3.0).at(5.0, 0.0, -3.0 + CUT_OVERLAP_MM);
    sensor.bodies[0].solid = sensor.bodies[0].solid.clone().minus(drain);
    // Lines that meet the hole's side find a wall that is too far away as well.
    let report = report(&sensor);
    let finding = report.for_rule(Rule::Casting).find(|f| f.message.contains("is open")).unwrap();
    assert_eq!(finding.bodies, ["puck"]);
    let area_mm2 = finding.measured.unwrap().value;
    let hole_mm2 = std::f64::consts::PI * 0.25;
    assert!((0.5 * hole_mm2..1.05 * hole_mm2).contains(&area_mm2), "{area_mm2} of {hole_mm2}");
    let place = finding.place.unwrap();
    assert!((place.x - 5.0).hypot(place.y) < 0.51 && place.z.abs() < 1e-3, "{place}");
}

#[test]
fn a_wall_that_was_forgotten_is_named() {
    let mut sensor = puck();
    pour(&mut sensor).walls.pop();
    let finding = only(&sensor, Rule::Casting);
    assert_eq!(finding.bodies, ["puck", "lid"]);
    assert!(finding.fix.contains("lid stands there"), "{}", finding.fix);
}

#[test]
fn without_its_vent_a_cavity_traps_all_its_air() {
    let mut sensor = puck();
    pour(&mut sensor).openings.clear();
    let finding = only(&sensor, Rule::TrappedAir);
    assert_eq!(finding.bodies, ["puck"]);
    let all_mm3 = puck_area_mm2() * HEIGHT_MM;
    let volume_mm3 = pocket_mm3(&finding);
    assert!((volume_mm3 / all_mm3 - 1.0).abs() < 0.01, "{volume_mm3} of {all_mm3}");
}

/// The volume that a message about trapped air states.
fn pocket_mm3(finding: &Finding) -> f64 {
    let words: Vec<&str> = finding.message.split(' ').collect();
    let unit = words.iter().position(|word| *word == "mm3,").unwrap();
    words[unit - 1].parse().unwrap()
}

/// The puck with a boss of radius 2 and height 1 on top, off the middle; the lid has its negative.
fn with_boss() -> Sensor {
    let mut sensor = puck();
    let boss = |from: f64, to: f64| Solid::cylinder(2.0, to - from).at(6.0, 0.0, from);
    let top = HEIGHT_MM + 1.0;
    sensor.bodies[2].solid =
        sensor.bodies[2].solid.clone().plus(boss(HEIGHT_MM - CUT_OVERLAP_MM, top));
    sensor.bodies[1].solid =
        sensor.bodies[1].solid.clone().minus(boss(HEIGHT_MM - CUT_OVERLAP_MM, top));
    sensor
}

#[test]
fn a_pocket_above_the_vent_traps_its_own_air() {
    let sensor = with_boss();
    let finding = only(&sensor, Rule::TrappedAir);
    let place = finding.place.unwrap();
    assert!((place.x - 6.0).hypot(place.y) < 2.0, "{place}");
    assert!((place.z - HEIGHT_MM - 1.0).abs() < 1e-9, "{place}");
    assert!((finding.measured.unwrap().value - 1.0).abs() < 1e-9);
    // pi 2^2 1 = 12.566 mm3, to the width of a column along the boss's edge.
    let volume_mm3 = pocket_mm3(&finding);
    assert!((volume_mm3 - 4.0 * std::f64::consts::PI).abs() < 0.3, "{volume_mm3}");
    assert_eq!(report(&sensor).errors(), 1);
}

#[test]
fn a_vent_in_the_pocket_frees_it_and_turned_over_it_needs_none() {
    let mut vented = with_boss();
    let vent = Opening {
        name: "vent".into(),
        point: Point3::new(6.0, 0.0, HEIGHT_MM + 1.0),
        axis: Vector3::z(),
        radius_mm: 0.02,
    };
    pour(&mut vented).openings.push(vent);
    assert_eq!(report(&vented).for_rule(Rule::TrappedAir).count(), 0);

    let mut turned = with_boss();
    pour(&mut turned).up = -Vector3::z();
    let finding = only(&turned, Rule::TrappedAir);
    assert!(finding.place.unwrap().z.abs() < 1e-9, "the air is now below the dish");
}

#[test]
fn an_undercut_holds_a_rigid_tool_back() {
    let mut sensor = puck();
    // A bead of the gel, 0.5 mm out, in a groove halfway up the dish's wall.
    let bead = |inner: f64| {
        Solid::cylinder(RADIUS_MM + 0.5, 0.6)
            .minus(Solid::cylinder(inner, 2.0).at(0.0, 0.0, -0.5))
            .at(0.0, 0.0, 0.7)
    };
    sensor.bodies[2].solid = sensor.bodies[2].solid.clone().plus(bead(RADIUS_MM - CUT_OVERLAP_MM));
    sensor.bodies[0].solid = sensor.bodies[0].solid.clone().minus(bead(RADIUS_MM - CUT_OVERLAP_MM));
    assert_eq!(report(&sensor).for_rule(Rule::Casting).count(), 0);

    // Down comes the dish, and its wall above the bead is held by the bead.
    let finding = only(&sensor, Rule::Demolding);
    assert_eq!(finding.bodies, ["dish", "puck"]);
    let ring_mm2 = std::f64::consts::PI * ((RADIUS_MM + 0.5).powi(2) - RADIUS_MM.powi(2));
    let area_mm2 = finding.measured.unwrap().value;
    assert!((area_mm2 / ring_mm2 - 1.0).abs() < 0.02, "{area_mm2} of {ring_mm2}");

    // Of silicone, the dish gives way by half a millimetre at ten: five per cent.
    let soft = |limit: f64| {
        let mut sensor = sensor.clone();
        if let Action::Demold(pulls) = &mut sensor.chain[1].action {
            pulls[1].strain_limit = Some(limit);
        }
        only(&sensor, Rule::Demolding)
    };
    let bears = soft(2.0);
    assert_eq!(bears.severity, Severity::Note);
    let strain = bears.measured.unwrap().value;
    assert!((strain - 0.05).abs() < 0.006, "{strain}");
    assert_eq!(soft(0.03).severity, Severity::Error);
}

#[test]
fn a_tool_pulled_through_its_cast_is_held() {
    let mut sensor = puck();
    if let Action::Demold(pulls) = &mut sensor.chain[1].action {
        pulls[0].direction = -Vector3::z();
    }
    let finding = only(&sensor, Rule::Demolding);
    assert_eq!(finding.bodies, ["lid", "puck"]);
    let area_mm2 = finding.measured.unwrap().value;
    let under_lid_mm2 = puck_area_mm2() - std::f64::consts::PI * GATE_RADIUS_MM.powi(2);
    assert!((area_mm2 / under_lid_mm2 - 1.0).abs() < 0.01, "{area_mm2} of {under_lid_mm2}");
}

/// The puck with a steel pin of radius 1.02 in a hole of radius 1 in the dish's floor.
fn with_pin(interference_mm: Option<f64>) -> Sensor {
    let mut sensor = puck();
    let hole = Solid::cylinder(1.0, 1.5).at(5.0, 0.0, -2.0 - CUT_OVERLAP_MM);
    sensor.bodies[0].solid = sensor.bodies[0].solid.clone().minus(hole);
    sensor.bodies.push(
        Body::bought("pin", String::new(), Solid::cylinder(1.02, 3.0))
            .placed([Placement::at(Assembly(MOLD.into()), Pose::translation(5.0, 0.0, -4.0))])
            .colored([0; 3]),
    );
    sensor.chain[0].bodies.push("pin".into());
    sensor.press_fits.extend(interference_mm.map(|interference_mm| PressFit {
        inner: "pin".into(),
        outer: "dish".into(),
        interference_mm,
        reason: String::new(),
    }));
    sensor
}

#[test]
fn overlaps_must_be_declared() {
    let finding = only(&with_pin(None), Rule::Interference);
    assert_eq!(finding.bodies, ["dish", "pin"]);
    // A ring 0.02 mm thick; the pin reaches 1 mm into the dish.
    let pi = std::f64::consts::PI;
    let expected_mm3 = pi * (1.02f64.powi(2) - 1.0) * 1.0;
    let volume_mm3 = finding.measured.unwrap().value;
    assert!((volume_mm3 / expected_mm3 - 1.0).abs() < 0.05, "{volume_mm3} of {expected_mm3}");
    assert!((finding.place.unwrap() - Point3::new(5.0, 0.0, -1.5)).norm() < 1.2);
}

#[test]
fn declared_fits_are_met_and_not_exceeded() {
    assert_eq!(report(&with_pin(Some(0.02))).findings, []);

    let finding = only(&with_pin(Some(0.01)), Rule::Interference);
    assert_eq!(finding.bodies, ["pin", "dish"]);
    let measured = finding.measured.unwrap();
    assert!((measured.value - 0.02).abs() < 1e-6 && measured.limit == 0.01, "{measured:?}");

    let mut loose = with_pin(Some(0.02));
    loose.bodies[3].solid = Solid::cylinder(1.0, 3.0);
    let finding = only(&loose, Rule::Interference);
    assert!(finding.message.contains("overlaps it nowhere"), "{}", finding.message);
}

#[test]
fn the_chain_is_complete_and_in_order() {
    type Change = fn(&mut Sensor);
    let cases: [(&str, Change); 11] = [
        ("no step pours or sprays the puck", |s| {
            s.chain.remove(0);
        }),
        ("has been cast before", |s| s.chain.insert(1, s.chain[0].clone())),
        ("two steps have this name", |s| s.chain[1].name = "pour".into()),
        ("there is no body `lidd`", |s| s.chain[1].bodies.push("lidd".into())),
        ("the assembly `none` is empty", |s| {
            s.chain[1].assembly = Some(Assembly("none".into()));
        }),
        ("gate does not lie on the surface", |s| {
            pour(s).openings[0].point.z += 0.01;
        }),
        ("fabkit knows no mixture", |s| pour(s).mix.by_mass.clear()),
        ("up is not a unit vector", |s| pour(s).up *= 2.0),
        ("the cure has no time", |s| pour(s).cure.hours = f64::NAN),
        ("no opening to be poured through", |s| pour(s).openings.clear()),
        ("the wall skin has not been cast yet", |s| {
            let mut skin = s.bodies[2].clone();
            skin.name = "skin".into();
            skin.solid = skin.solid.at(0.0, 0.0, 50.0);
            s.bodies.push(skin);
            pour(s).walls.push("skin".into());
        }),
    ];
    for (expected, change) in cases {
        let mut sensor = puck();
        change(&mut sensor);
        let report = report(&sensor);
        let found = report.for_rule(Rule::Chain).any(|finding| finding.message.contains(expected));
        assert!(found, "{expected}: {:#?}", report.findings);
        assert!(report.errors() > 0);
    }
}

#[test]
fn what_no_step_needs_is_a_warning() {
    let mut sensor = puck();
    if let Action::Demold(pulls) = &mut sensor.chain[1].action {
        pulls.remove(0);
    }
    pour(&mut sensor).walls.pop();
    let report = report(&sensor);
    let warning = report.for_rule(Rule::Chain).next().unwrap();
    assert_eq!(
        (warning.severity, warning.bodies.as_slice()),
        (Severity::Warning, &["lid".into()][..])
    );
}

#[test]
fn findings_do_not_depend_on_the_number_of_threads() {
    let mut sensor = with_boss();
    sensor.bodies[0].placements[0].assembly_from_body = Pose::translation(0.03, 0.0, -0.1);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| report(&sensor))
    };
    let (one, three) = (with(1), with(3));
    assert!(!one.findings.is_empty());
    assert_eq!(one, three);
}

#[test]
fn the_table_of_rules_says_what_they_declare() {
    let page = include_str!("../../../../docs/reference/rules.md");
    let said: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    let row = |rule: Rule| {
        let [finds, limit] = rule.description_and_limit().unwrap();
        format!("| `{rule}` | {finds} | {limit} |")
    };
    let declared = Rule::ALL.map(row);
    assert_eq!(said, declared, "docs/reference/rules.md should say\n{}\n", declared.join("\n"));
}
