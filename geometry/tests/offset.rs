//! The parallel surface of an ellipsoid against the distance by search.

use std::f64::consts::TAU;

use fabkit_geometry::{CompiledSolid, Point3, Solid};
use fabkit_geometry_testing::{cases, rays};
use proptest::prelude::*;

/// Distance from the ellipsoid's surface, by search along its meridian: the nearest point of a
/// surface of revolution lies in the same half plane or in the opposite one.
fn distance_by_search(equatorial: f64, polar: f64, p: Point3<f64>) -> f64 {
    let (r, z) = (p.x.hypot(p.y), p.z);
    let distance = |a: f64| (r - equatorial * a.cos()).hypot(z - polar * a.sin());
    let step = TAU / 2000.0;
    let angles = (0..2000).map(|i| step * f64::from(i));
    let mut best = angles.min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap();
    let mut width = step;
    for _ in 0..80 {
        let (a, b) = (best - width / 3.0, best + width / 3.0);
        best =
            [a, b, best].into_iter().min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap();
        width *= 0.75;
    }
    distance(best)
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn crossings_lie_at_the_offset(
        equatorial in 1.0f64..8.0,
        polar in 1.0f64..8.0,
        depth in -0.99f64..3.0,
        rays in prop::collection::vec(rays(6.0), 10),
    ) {
        let (long, short) = (equatorial.max(polar), equatorial.min(polar));
        let offset = if depth < 0.0 { depth * short * short / long } else { depth };
        let body = CompiledSolid::new(&Solid::ellipsoid_offset(equatorial, polar, offset)).unwrap();
        for ray in rays {
            let crossings = body.crossings(&ray);
            for c in &crossings {
                let distance = distance_by_search(equatorial, polar, ray.at(c.t));
                prop_assert!((distance - offset.abs()).abs() < 1e-9, "{} {}", distance, offset);
            }
            // Nothing missed: the same intervals by sampling the searched distance.
            let ellipsoid = CompiledSolid::new(&Solid::ellipsoid([equatorial, equatorial, polar])).unwrap();
            let foot = -ray.origin.coords.dot(&ray.direction) / ray.direction.norm_squared();
            for i in 0..20 {
                let p = ray.at(foot + (f64::from(i) - 9.5) / ray.direction.norm());
                let outside = if ellipsoid.contains(&p) { -1.0 } else { 1.0 };
                let signed = outside * distance_by_search(equatorial, polar, p);
                if (signed - offset).abs() > 1e-9 {
                    prop_assert_eq!(body.contains(&p), signed < offset);
                }
            }
        }
    }
}

#[test]
fn equal_half_axes_make_a_sphere() {
    let body = CompiledSolid::new(&Solid::ellipsoid_offset(3.0, 3.0, 1.0)).unwrap();
    let ball = CompiledSolid::new(&Solid::sphere(4.0)).unwrap();
    for y in [0.0, 1.0, 2.5, 3.999] {
        let ray = fabkit_geometry::Ray {
            origin: Point3::new(0.3, y, 9.0),
            direction: fabkit_geometry::Vector3::new(-0.01, 0.0, -1.0),
        };
        let (a, b) = (body.crossings(&ray), ball.crossings(&ray));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!((a.t - b.t).abs() < 1e-12 && (a.normal - b.normal).norm() < 1e-12);
        }
    }
}
