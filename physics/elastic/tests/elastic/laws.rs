//! Presses with closed-form solutions.

use crate::support::{layer, press_down, stack};
use fabkit_elastic::{ElasticMaterial, LayeredBody, MeshDensity};

/// Hertz contact of a ball on a half space, approximated by a large pad (Johnson, "Contact mechanics", 1985, section
/// 4.2).
///
/// The pad is 200 contact radii thick and as wide. A bonded floor at depth t adds about `1.5 a / t` to the force (the
/// first term of Hayes' expansion for an incompressible layer is 1.13 a / t): 0.8 %. The parabolic approximation
/// differs from the ball by `(a / 2R)^2`, 0.0002. The contact's edge lies between nodes a fortieth of the radius apart:
/// half of that, 1.3 %.
#[test]
fn a_small_ball_on_a_thick_gel_is_hertz() {
    for poisson in [0.3, 0.495] {
        let material = ElasticMaterial::new(0.2, poisson).unwrap();
        let (radius_mm, a_mm) = (4.0, 0.1);
        let body = LayeredBody::pad(20.0, vec![(layer(0.2, poisson), 20.0)]);
        let depth_mm = a_mm * a_mm / radius_mm;
        let plane_mpa = material.young_mpa() / (1.0 - poisson * poisson);
        let force_n = 4.0 / 3.0 * plane_mpa * f64::sqrt(radius_mm) * depth_mm.powf(1.5);
        for (nodes, max_harmonic) in [(40.0, 0), (20.0, 16)] {
            let fine = MeshDensity::around_pole(a_mm / nodes, 1.5 * a_mm, max_harmonic);
            let outcome = press_down(&stack(&body, fine), radius_mm, depth_mm);
            let of_force = -outcome.force_n.z / force_n - 1.0;
            let of_radius = outcome.contact_radius_mm / a_mm - 1.0;
            println!(
                "nu {poisson}, m <= {max_harmonic}: force {of_force:+.4}, radius {of_radius:+.4}"
            );
            assert!(of_force.abs() < 0.012, "{of_force}");
            assert!(of_radius.abs() < 0.015, "{of_radius}");
            // Pressures along the radius: p0 sqrt(1 - r^2 / a^2).
            let peak_mpa = 1.5 * force_n / (std::f64::consts::PI * a_mm * a_mm);
            for node in outcome.nodes.iter().filter(|node| node.place_mm.x < 0.8 * a_mm) {
                let part = node.place_mm.coords.xy().norm() / a_mm;
                if part < 0.8 {
                    let law = (1.0 - part * part).sqrt();
                    assert!((node.pressure_mpa / peak_mpa - law).abs() < 0.03, "{part}");
                }
            }
        }
    }
}

/// Modified Bessel functions of the first kind, orders 0 and 1, by their series.
fn bessel(x: f64) -> [f64; 2] {
    let (mut term, mut sums) = (1.0, [0.0, 0.0]);
    for k in 0..400 {
        let k = f64::from(k);
        sums[0] += term;
        sums[1] += term * (x / 2.0) / (k + 1.0);
        term *= (x / 2.0).powi(2) / (k + 1.0).powi(2);
    }
    sums
}

/// Depth and force of a ball on a thin bonded layer, by its contact radius.
///
/// The layer yields by flow between a bonded floor and a frictionless surface, and by compression: `t^3 / (3 G) (p'' +
/// p' / r) - t p / M = -(d - r^2 / 2R)`, where p and p' vanish at the edge (Barber, "Contact mechanics", 2018, chapter
/// on thin layers; Johnson, 1985, section 5.8). Without compression the solution is `d = a^2 / 4R`, `F = 2 pi G R^2 d^3
/// / t^3`.
fn thin_layer(
    material: &ElasticMaterial,
    thickness_mm: f64,
    radius_mm: f64,
    a_mm: f64,
) -> [f64; 2] {
    let (shear, poisson) = (material.shear_modulus_mpa(), material.poisson());
    let oedometer = 2.0 * shear * (1.0 - poisson) / (1.0 - 2.0 * poisson);
    let alpha = (3.0 * shear / oedometer).sqrt() / thickness_mm;
    let flow = 3.0 * shear / thickness_mm.powi(3);
    let by_square = -flow / (2.0 * radius_mm * alpha * alpha);
    let [i0, i1] = bessel(alpha * a_mm);
    let edge = -2.0 * by_square * a_mm / (alpha * i1);
    let even = -by_square * a_mm * a_mm - edge * i0;
    let depth_mm = (alpha * alpha * even - 4.0 * by_square) / flow;
    let force =
        even * a_mm.powi(2) / 2.0 + by_square * a_mm.powi(4) / 4.0 + edge * a_mm * i1 / alpha;
    [depth_mm, 2.0 * std::f64::consts::PI * force]
}

#[test]
fn the_thin_layers_law_has_both_limits() {
    let (t, ball, a) = (0.1, 500.0, 2.0);
    let closed = ElasticMaterial::new(1.0, 0.499_899_999).unwrap();
    let [depth, force] = thin_layer(&closed, t, ball, a / 100.0);
    let law = 2.0
        * std::f64::consts::PI
        * closed.shear_modulus_mpa()
        * (ball / t.powf(1.5)).powi(2)
        * depth.powi(3);
    assert!((force / law - 1.0).abs() < 1e-3, "{}", force / law);
    let open = ElasticMaterial::new(1.0, 0.2).unwrap();
    let [depth, force] = thin_layer(&open, t, ball, a);
    let oedometer = 2.0 * open.shear_modulus_mpa() * 0.8 / 0.6;
    let law = std::f64::consts::PI * oedometer * ball * depth.powi(2) / t;
    assert!((force / law - 1.0).abs() < 0.1, "{}", force / law);
}

/// Comparison with the thin-layer law, which neglects a zone about a thickness wide at the edge.
///
/// Pressure and its slope vanish there, so the error of the force is a few times `(t / a)^2`: 4 of it at 15 thicknesses
/// is 2 %, at most 20 of it for nearly incompressible materials, and 0.6 % at 60. Contact ends about a thickness early,
/// where pressures are tiny.
#[test]
fn a_thin_bonded_layer_flows_aside() {
    for poisson in [0.3, 0.495, 0.4999] {
        let material = ElasticMaterial::new(0.5, poisson).unwrap();
        let (t, ball) = (0.1, 500.0);
        let mut errors = Vec::new();
        for thicknesses in [15.0, 30.0, 60.0] {
            let a_mm = thicknesses * t;
            let [depth_mm, force_n] = thin_layer(&material, t, ball, a_mm);
            let body = LayeredBody::pad(1.3 * a_mm, vec![(layer(0.5, poisson), t)]);
            let outcome =
                press_down(&stack(&body, MeshDensity::uniform(0.25 * t, 0)), ball, depth_mm);
            let of_force = -outcome.force_n.z / force_n - 1.0;
            let of_radius = outcome.contact_radius_mm / a_mm - 1.0;
            println!(
                "nu {poisson}, a / t {thicknesses}: force {of_force:+.4}, radius {of_radius:+.4}"
            );
            errors.push(of_force.abs());
            assert!(of_radius.abs() < 1.5 / thicknesses, "{of_radius}");
        }
        assert!(errors[2] < 0.006, "{errors:?}");
        assert!(errors[0] > 2.0 * errors[1] && errors[1] > 2.0 * errors[2], "{errors:?}");
    }
}
