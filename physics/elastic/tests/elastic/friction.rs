//! Presses with shear.

use crate::support::{ball_over, down, layer, round_layer, stack, two_layers};
use fabkit_elastic::{
    ContactState, ElasticMaterial, ElasticStack, LayeredBody, MeshDensity, Press, PressOutcome,
};
use fabkit_geometry::Vector3;

const BALL_MM: f64 = 4.0;

fn sheared(
    stack: &ElasticStack,
    depth_mm: f64,
    friction: f64,
    way_mm: Vector3<f64>,
    steps: usize,
) -> PressOutcome {
    let press =
        Press::along(down(), depth_mm).unwrap().with_shear(friction, way_mm, steps).unwrap();
    stack.press(&ball_over(0.0, 0.0, BALL_MM), &press).unwrap()
}

/// Cattaneo's and Mindlin's solution of a ball on a half space, sheared until its edge slips (Cattaneo 1938, Mindlin
/// 1949; Johnson, "Contact mechanics", 1985, section 7.2).
///
/// A disc of radius c sticks, `c = a (1 - Q / (mu P))^(1/3)`, and the ball moves by `3 (2 - nu) mu P / (16 G a) (1 - (c
/// / a)^2)`, half of what two equal bodies would. The solution takes all slip to be along the shear and neglects that
/// shear lifts the surface; for nearly incompressible materials neither matters. A floor 100 radii below adds about 1 %
/// to the stiffness; the edge of the stick region lies between nodes a twenty-fifth of the radius apart.
#[test]
fn a_sheared_ball_sticks_in_the_middle() {
    let (a_mm, friction, poisson) = (0.1, 0.5, 0.49);
    let body = LayeredBody::pad(10.0, vec![(layer(0.2, poisson), 10.0)]);
    let stack = stack(&body, MeshDensity::around_pole(a_mm / 25.0, 1.3 * a_mm, 70));
    let depth_mm = a_mm * a_mm / BALL_MM;
    let shear_mpa = ElasticMaterial::new(0.2, poisson).unwrap().shear_modulus_mpa();
    let push_n = 8.0 / 3.0 * shear_mpa / (1.0 - poisson) * BALL_MM.sqrt() * depth_mm.powf(1.5);
    let full_mm = 3.0 * (2.0 - poisson) * friction * push_n / (16.0 * shear_mpa * a_mm);
    for part in [0.3, 0.6, 0.9] {
        // Fraction of the friction that is used.
        let stick = f64::cbrt(1.0 - part);
        let way_mm = full_mm * (1.0 - stick * stick);
        let outcome = sheared(&stack, depth_mm, friction, Vector3::new(way_mm, 0.0, 0.0), 1);
        let of_force = outcome.force_n.x / (part * friction * push_n) - 1.0;
        let radius = (outcome.stick_area_mm2 / std::f64::consts::PI).sqrt() / a_mm;
        println!("{part}: force {of_force:+.4}, stick radius {radius:.4}, by law {stick:.4}");
        assert!(of_force.abs() < 0.05, "{part}: {of_force}");
        assert!((radius / stick - 1.0).abs() < 0.05, "{part}: {radius} {stick}");
        assert!(outcome.force_n.y.abs() < 1e-3 * outcome.force_n.x, "{}", outcome.force_n);
    }
}

#[test]
fn slipping_traction_is_friction_times_pressure() {
    let stack = stack(&two_layers(), MeshDensity::around_pole(0.2, 5.0, 40));
    let way_mm = Vector3::new(0.0, 3.0, 0.0);
    let outcome = sheared(&stack, 0.4, 0.1, way_mm, 3);
    assert!(outcome.stick_area_mm2 == 0.0, "{}", outcome.stick_area_mm2);
    let ratio = outcome.force_n.y / -outcome.force_n.z;
    // All of it slips, nearly everywhere straight along the shear.
    assert!((ratio - 0.1).abs() < 0.001, "{ratio}");
    for node in outcome.nodes.iter().filter(|node| node.touch != ContactState::Free) {
        assert!(node.shear_mpa.norm() < 0.1 * node.pressure_mpa * (1.0 + 1e-9));
        assert!(node.shear_mpa.dot(&node.outward).abs() < 1e-12);
    }
}

#[test]
fn what_sticks_moves_with_the_indenter() {
    for body in [two_layers(), round_layer(0.495)] {
        let stack = stack(&body, MeshDensity::uniform(0.25, 40));
        let way_mm = Vector3::new(0.03, 0.02, 0.0);
        let still = sheared(&stack, 0.4, 1.0, Vector3::zeros(), 1);
        let outcome = sheared(&stack, 0.4, 1.0, way_mm, 2);
        let sticking: Vec<_> = outcome
            .nodes
            .iter()
            .zip(&still.nodes)
            .filter(|(n, _)| n.touch == ContactState::Sticking)
            .collect();
        assert!(outcome.stick_area_mm2 > 0.6 * outcome.contact_area_mm2);
        let inside = 0.75 * outcome.contact_radius_mm;
        for (after, before) in
            sticking.iter().filter(|(n, _)| n.place_mm.coords.xy().norm() < inside)
        {
            let moved = after.displacement_mm - before.displacement_mm;
            // Nodes follow the mean of their surroundings, which near slipping nodes differs from their own
            // displacement.
            assert!(
                (moved - way_mm).norm() < 0.03 * way_mm.norm(),
                "{moved} at {}",
                after.place_mm
            );
        }
        // The force points along the shear, and reverses with it.
        let along = outcome.force_n.xy().dot(&way_mm.xy()) / way_mm.norm();
        assert!(along > 0.0 && (outcome.force_n.xy().norm() / along - 1.0).abs() < 0.01);
        let back = sheared(&stack, 0.4, 1.0, -way_mm, 2);
        assert!((outcome.force_n.xy() + back.force_n.xy()).norm() < 0.01 * along);
    }
}

#[test]
fn shear_turns_with_its_direction() {
    let stack = stack(&round_layer(0.49), MeshDensity::uniform(0.25, 40));
    let force = |angle: f64| {
        let way_mm = Vector3::new(0.1 * angle.cos(), 0.1 * angle.sin(), 0.0);
        let force_n = sheared(&stack, 0.4, 0.6, way_mm, 2).force_n;
        (force_n.x * angle.cos() + force_n.y * angle.sin(), force_n)
    };
    let (first, _) = force(0.0);
    for angle in [0.5, 2.0, -1.2] {
        let (along, force_n) = force(angle);
        assert!((along / first - 1.0).abs() < 0.005, "{along} {first}");
        assert!(force_n.xy().norm() / along < 1.005);
    }
}

#[test]
fn without_friction_a_shear_is_a_press_elsewhere() {
    let stack = stack(&two_layers(), MeshDensity::around_pole(0.2, 5.0, 40));
    let outcome = sheared(&stack, 0.5, 0.0, Vector3::new(0.7, 0.0, 0.0), 1);
    let press = Press::along(down(), 0.5).unwrap();
    let there = stack.press(&ball_over(0.7, 0.0, BALL_MM), &press).unwrap();
    assert!((outcome.force_n - there.force_n).norm() < 1e-5 * there.force_n.norm());
    assert!(outcome.force_n.x.abs() < 1e-9);
}

#[test]
fn invalid_shears_are_refused() {
    let press = || Press::along(down(), 0.3).unwrap();
    let x = Vector3::x();
    let said =
        |friction, way, steps| press().with_shear(friction, way, steps).unwrap_err().to_string();
    assert!(said(-0.1, x, 1).contains("-0.1"));
    assert!(said(f64::NAN, x, 1).contains("NaN"));
    assert!(said(0.5, x * f64::INFINITY, 1).contains("shear"));
    assert!(said(0.5, x, 0).contains("steps"));
    let even = stack(&two_layers(), MeshDensity::uniform(0.5, 0));
    let refused =
        even.press(&ball_over(0.0, 0.0, BALL_MM), &press().with_shear(0.5, x, 1).unwrap());
    assert!(refused.unwrap_err().to_string().contains("harmonics"));
}
