//! Properties that hold for any material and shape.

use std::f64::consts::PI;

use crate::support::{ball_over, down, press_down, round_layer, stack, two_layers};
use fabkit_elastic::{
    BoundaryCondition, ElasticError, LayeredBody, MeshDensity, Press, PressOutcome, SolidIndenter,
};
use fabkit_geometry::{CompiledSolid, Point3, Pose, Solid, Vector3};

#[test]
fn compliance_is_reciprocal() {
    let stack = stack(&round_layer(0.4999), MeshDensity::uniform(0.5, 12));
    // Rounding is amplified by the bulk stiffness, 5,000 times the shear stiffness.
    let asymmetry = stack.asymmetry().unwrap();
    assert!(asymmetry < 1e-11, "{asymmetry:e}");
}

#[test]
fn a_press_at_the_pole_needs_no_harmonics() {
    for body in [two_layers(), round_layer(0.495)] {
        let even = press_down(&stack(&body, MeshDensity::uniform(0.25, 0)), 4.0, 0.6);
        let all = press_down(&stack(&body, MeshDensity::uniform(0.25, 30)), 4.0, 0.6);
        // Both stop when nodes are within 1e-7 of the depth of their targets.
        let close = |a: f64, b: f64| (a - b).abs() < 1e-6 * b.abs();
        assert!(close(even.force_n.z, all.force_n.z), "{} {}", even.force_n, all.force_n);
        assert!(close(even.contact_area_mm2, all.contact_area_mm2));
        assert!(close(even.bulge_mm, all.bulge_mm));
        for (i, &s) in even.columns().iter().enumerate() {
            for azimuth in [0.0, 1.0, 4.0] {
                let [a, b] = [&even, &all].map(|o| o.displacement_mm(0, azimuth, s));
                assert!((a - b).norm() < 1e-6, "column {i}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_flat_pad_is_the_same_everywhere() {
    let stack = stack(&two_layers(), MeshDensity::around_pole(0.125, 5.5, 90));
    let press = Press::along(down(), 0.6).unwrap();
    let at = |x: f64, y: f64| stack.press(&ball_over(x, y, 4.0), &press).unwrap();
    let centre = at(0.0, 0.0);
    for (x, y) in [(0.3, 0.1), (1.9, 0.0), (-1.1, 1.7)] {
        let there = at(x, y);
        // Node spacing is a sixteenth of the contact radius: (h / a)^2 is 0.4 %; the edge falls between nodes.
        let close = |a: f64, b: f64, part: f64| (a / b - 1.0).abs() < part;
        assert!(
            close(there.force_n.z, centre.force_n.z, 0.004),
            "{} {}",
            there.force_n,
            centre.force_n
        );
        assert!(close(there.contact_area_mm2, centre.contact_area_mm2, 0.06));
        assert!(close(there.bulge_mm, centre.bulge_mm, 0.02));
        // The force acts through the ball's centre.
        let about = Vector3::new(y * there.force_n.z, -x * there.force_n.z, 0.0);
        assert!((there.moment_nmm - about).norm() < 0.01 * 0.52, "{} {about}", there.moment_nmm);
    }
}

#[test]
fn a_round_layer_is_the_same_in_all_directions() {
    let stack = stack(&round_layer(0.495), MeshDensity::uniform(0.15, 90));
    let mut forces = Vec::new();
    for (tilt, azimuth) in [(0.0_f64, 0.0_f64), (0.1, 2.0), (0.35, 0.7), (0.5, -2.2)] {
        let outward =
            Vector3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
        let ball = fabkit_elastic::BallIndenter::new(Point3::from(30.0 * outward), 4.0).unwrap();
        let outcome = stack.press(&ball, &Press::along(-outward, 0.5).unwrap()).unwrap();
        let along = -outcome.force_n.dot(&outward);
        // Transversely, only the rim, 9 mm away, breaks the symmetry.
        assert!((outcome.force_n + along * outward).norm() < 0.01 * along, "{}", outcome.force_n);
        assert!(outcome.moment_nmm.norm() < 0.01 * along * 12.0);
        forces.push(along);
    }
    println!("{forces:?}");
    for force in &forces {
        // Node spacing is a ninth of the contact radius: the error is about half of (h / a)^2 = 1.2 %.
        assert!((force / forces[0] - 1.0).abs() < 0.01, "{forces:?}");
    }
}

/// Volume swept by an interface's displacement, mm3, integrated over its own field.
fn flux(outcome: &PressOutcome, interface: usize) -> f64 {
    let (around, along) = (240, 800);
    let mut sum = 0.0;
    for j in 0..around {
        let azimuth = 2.0 * PI * f64::from(j) / f64::from(around);
        for i in 0..along {
            let at = |k: i32| outcome.place_mm(interface, azimuth, f64::from(k) / f64::from(along));
            let middle = (f64::from(i) + 0.5) / f64::from(along);
            let (step, place) = (at(i + 1) - at(i), outcome.place_mm(interface, azimuth, middle));
            let round = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0) * place.coords.xy().norm();
            let area = step.cross(&round) * (2.0 * PI / f64::from(around));
            sum += outcome.displacement_mm(interface, azimuth, middle).dot(&area);
        }
    }
    sum
}

#[test]
fn incompressible_layers_keep_their_volume() {
    let stack = stack(&round_layer(0.4999), MeshDensity::uniform(0.25, 60));
    let tilted = Vector3::new(0.3, 0.2, 1.0).normalize();
    let ball = fabkit_elastic::BallIndenter::new(Point3::from(30.0 * tilted), 4.0).unwrap();
    let outcome = stack.press(&ball, &Press::along(-tilted, 0.5).unwrap()).unwrap();
    let pushed_in: f64 = outcome
        .nodes
        .iter()
        .map(|node| (-node.displacement_mm.dot(&node.outward)).max(0.0) * node.area_mm2)
        .sum();
    let change = outcome.volume_change_mm3[0];
    println!("{change} of {pushed_in}");
    assert!(change.abs() < 0.005 * pushed_in, "{change} of {pushed_in}");
    // Rim and floor are bonded: volume pushed in at one part of the surface comes out at another. Midpoint integration
    // over 800 by 240 pieces is within 1e-4 of the volume pushed in.
    let through_surface = flux(&outcome, 0);
    assert!((through_surface - change).abs() < 1e-3 * pushed_in, "{through_surface} {change}");
}

#[test]
fn any_solid_presses_as_the_same_ball() {
    let stack = stack(&two_layers(), MeshDensity::around_pole(0.25, 5.0, 40));
    let press = Press::along(down(), 0.6).unwrap();
    let closed = stack.press(&ball_over(1.0, 0.5, 4.0), &press).unwrap();
    let solid = CompiledSolid::new(&Solid::sphere(4.0)).unwrap();
    let solid = SolidIndenter::new(&solid, &Pose::translation(1.0, 0.5, 54.0));
    let cast = stack.press(&solid, &press).unwrap();
    // Crossings are exact to 1e-10 mm, the contact to 1e-7 of its depth.
    assert!((closed.force_n - cast.force_n).norm() < 1e-6, "{} {}", closed.force_n, cast.force_n);
}

#[test]
fn threads_do_not_change_bytes() {
    let body = round_layer(0.45);
    let press = Press::along(down(), 0.4).unwrap();
    let bytes: Vec<Vec<u64>> = [1, 2, 8]
        .iter()
        .map(|&threads| {
            let stack =
                fabkit_elastic::ElasticStack::new(&body, &MeshDensity::uniform(0.4, 20), threads)
                    .unwrap();
            let outcome = stack.press(&ball_over(0.0, 0.0, 4.0), &press).unwrap();
            let nodes = outcome.nodes.iter();
            nodes
                .flat_map(|n| n.displacement_mm.iter().map(|d| d.to_bits()).collect::<Vec<_>>())
                .collect()
        })
        .collect();
    assert_eq!(bytes[0], bytes[1]);
    assert_eq!(bytes[0], bytes[2]);
}

#[test]
fn earlier_presses_do_not_change_bytes() {
    let (body, division) = (round_layer(0.45), MeshDensity::uniform(0.4, 20));
    let new = || fabkit_elastic::ElasticStack::new(&body, &division, 1).unwrap();
    let outwards = Vector3::new(0.5, 0.0, 0.75_f64.sqrt());
    let ball = fabkit_elastic::BallIndenter::new(Point3::from(30.0 * outwards), 4.0).unwrap();
    let press = Press::along(-outwards, 0.4).unwrap();
    let dragged = press.with_shear(0.5, Vector3::new(0.0, 0.1, 0.0), 2).unwrap();
    let bytes = |stack: &fabkit_elastic::ElasticStack, press: &Press| {
        let outcome = stack.press(&ball, press).unwrap();
        let forces = outcome.force_n.iter().chain(outcome.moment_nmm.iter());
        let moved = outcome.nodes.iter().flat_map(|node| node.displacement_mm.iter());
        forces.chain(moved).map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    for press in [&press, &dragged] {
        let alone = bytes(&new(), press);
        // At the tip, where other rings are touched.
        let elsewhere = new();
        elsewhere.press(&ball_over(0.0, 0.0, 4.0), &Press::along(down(), 0.4).unwrap()).unwrap();
        assert!(bytes(&elsewhere, press) == alone);
        for is_dragged in [false, true] {
            assert!(bytes(&new().solve_everywhere(is_dragged).unwrap(), press) == alone);
        }
    }
}

#[test]
fn what_cannot_be_pressed_is_refused_with_its_numbers() {
    let stack = stack(&two_layers(), MeshDensity::around_pole(0.4, 5.0, 8));
    let ball = ball_over(0.0, 0.0, 4.0);
    let message = |press: Result<Press, ElasticError>| {
        press.and_then(|press| stack.press(&ball, &press).map(|_| ())).unwrap_err().to_string()
    };
    assert!(message(Press::along(down(), 3.2)).contains("3.200 mm"));
    assert!(message(Press::along(down(), f64::NAN)).contains("NaN"));
    assert!(message(Press::along(down(), -0.1)).contains("-0.1"));
    assert!(message(Press::along(Vector3::zeros(), 0.1)).contains("direction"));
    assert!(message(Press::along(Vector3::z(), 0.1)).contains("starts"));
    assert!(message(Ok(Press::in_place())).contains("47 mm away"));

    let off_axis = stack_without_harmonics()
        .press(&ball_over(1.0, 0.0, 4.0), &Press::along(down(), 0.2).unwrap());
    assert!(matches!(off_axis, Err(ElasticError::Press { .. })), "{off_axis:?}");
    for (radius, hint) in [(-1.0, "-1"), (f64::NAN, "NaN")] {
        let refused =
            fabkit_elastic::BallIndenter::new(Point3::origin(), radius).unwrap_err().to_string();
        assert!(refused.contains(hint));
    }
}

fn stack_without_harmonics() -> fabkit_elastic::ElasticStack {
    stack(&two_layers(), MeshDensity::uniform(0.4, 0))
}

#[test]
fn invalid_bodies_are_refused() {
    let refused = |change: &dyn Fn(&mut LayeredBody), division: MeshDensity| {
        let mut body = two_layers();
        change(&mut body);
        fabkit_elastic::ElasticStack::new(&body, &division, 1).unwrap_err().to_string()
    };
    let even = MeshDensity::uniform(0.5, 0);
    assert!(refused(&|b| b.interfaces.truncate(2), even).contains("3 interfaces"));
    assert!(refused(&|b| b.interfaces.swap(0, 1), even).contains("no thickness"));
    assert!(
        refused(&|b| b.inner = fabkit_elastic::BoundaryCondition::Free, even)
            .contains("nothing holds")
    );
    assert!(refused(&|b| b.kinks = vec![1.5], even).contains("1.5"));
    assert!(refused(&|_| {}, MeshDensity::uniform(-0.5, 0)).contains("-0.5"));
    assert!(refused(&|_| {}, MeshDensity::uniform(f64::NAN, 0)).contains("NaN"));
    assert!(refused(&|_| {}, MeshDensity::uniform(1e-4, 0)).contains("2,000 rings"));
    let shifted = |b: &mut LayeredBody| {
        b.interfaces[1] = fabkit_elastic::MeridianCurve::new(|s| [s * 12.0 + 0.1, 1.5]);
    };
    assert!(refused(&shifted, even).contains("radius 0.1 mm"));
}

#[test]
fn fewer_bonds_make_a_body_softer() {
    let depth_mm = 0.4;
    let force = |inner: BoundaryCondition| {
        let body = LayeredBody { inner, ..round_layer(0.49) };
        -press_down(&stack(&body, MeshDensity::uniform(0.25, 0)), 4.0, depth_mm).force_n.z
    };
    let forces = [
        BoundaryCondition::Bonded,
        BoundaryCondition::BondedBeyond(0.1),
        BoundaryCondition::BondedBeyond(0.4),
        BoundaryCondition::Free,
    ]
    .map(force);
    println!("{forces:?}");
    assert!(forces.windows(2).all(|pair| pair[0] > 1.01 * pair[1]), "{forces:?}");
}

#[test]
fn any_gap_function_is_an_indenter() {
    // An inclined plane touches a dome where the dome faces it.
    let lean = Vector3::new(0.2, 0.0, 1.0).normalize();
    let plane = |place: &Point3<f64>, outward: &Vector3<f64>, _: f64| {
        let towards = outward.dot(&lean);
        if towards > 0.0 { (12.5 - place.coords.dot(&lean)) / towards } else { f64::INFINITY }
    };
    let stack = stack(&round_layer(0.495), MeshDensity::uniform(0.2, 60));
    let outcome = stack.press(&plane, &Press::along(-lean, 0.3).unwrap()).unwrap();
    let along = -outcome.force_n.dot(&lean);
    assert!(along > 0.0 && (outcome.force_n + along * lean).norm() < 0.01 * along);
    // A round layer pressed by a plane: the moment about the ball's centre vanishes.
    assert!(outcome.moment_nmm.norm() < 0.01 * along * 12.0, "{}", outcome.moment_nmm);
}

#[test]
fn a_holder_behind_the_ball_does_not_matter() {
    let stack = stack(&round_layer(0.495), MeshDensity::uniform(0.25, 70));
    // Deep beside the tip, so that some lines past the ball meet the holder and others do not.
    let outward = Vector3::new(0.5, 0.0, 0.75_f64.sqrt());
    let centre = Point3::origin() + (12.0 + 2.5 - 1.0) * outward;
    let ball = fabkit_elastic::BallIndenter::new(centre, 2.5).unwrap();
    let alone = stack.press(&ball, &Press::in_place()).unwrap();
    let holder = |place: &Point3<f64>, out: &Vector3<f64>, reach_mm: f64| {
        let to_plane = (centre + 1.0 * outward - place).dot(&outward) / out.dot(&outward);
        // The holder stands on this side of the dome only.
        let holder_mm = if out.dot(&outward) > 0.5 { to_plane } else { f64::INFINITY };
        fabkit_elastic::Indenter::gap_mm(&ball, place, out, reach_mm).min(holder_mm)
    };
    let held = stack.press(&holder, &Press::in_place()).unwrap();
    assert!((held.force_n - alone.force_n).norm() < 1e-9 * alone.force_n.norm());
    assert_eq!(held.contact_area_mm2, alone.contact_area_mm2);
    // Surface in contact lies on the ball; at the edge, nodes stand for their surroundings.
    for node in alone.nodes.iter().filter(|node| node.pressure_mpa > 0.0) {
        let gap_mm = fabkit_elastic::Indenter::gap_mm(&ball, &node.place_mm, &node.outward, 3.0);
        let moved_mm = node.displacement_mm.dot(&node.outward);
        assert!((moved_mm - gap_mm).abs() < 0.05, "{gap_mm} {moved_mm}");
    }
}
