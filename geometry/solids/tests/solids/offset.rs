//! Comparison of an ellipsoid's parallel surface with distances found by search.

use std::f64::consts::TAU;

use fabkit_geometry::{CompiledSolid, Point3, Ray, Solid, Vector3};
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
        let ray =
            Ray { origin: Point3::new(0.3, y, 9.0), direction: Vector3::new(-0.01, 0.0, -1.0) };
        let (a, b) = (body.crossings(&ray), ball.crossings(&ray));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!((a.t - b.t).abs() < 1e-12 && (a.normal - b.normal).norm() < 1e-12);
        }
    }
}

/// Draws a solid with its two half axes and its offset.
fn solids() -> impl Strategy<Value = (CompiledSolid, [f64; 3])> {
    (1.0f64..8.0, 1.0f64..8.0, -0.99f64..3.0).prop_map(|(equatorial, polar, depth)| {
        let (long, short) = (equatorial.max(polar), equatorial.min(polar));
        let offset = if depth < 0.0 { depth * short * short / long } else { depth };
        let solid = Solid::ellipsoid_offset(equatorial, polar, offset);
        (CompiledSolid::new(&solid).unwrap(), [equatorial, polar, offset])
    })
}

/// Returns the point of the surface with this normal, in closed form.
fn touched([equatorial, polar, offset]: [f64; 3], normal: Vector3<f64>) -> Point3<f64> {
    let squares = Vector3::new(equatorial * equatorial, equatorial * equatorial, polar * polar);
    let by_square = normal.component_mul(&squares);
    Point3::from(by_square / by_square.dot(&normal).sqrt() + offset * normal)
}

/// Draws unit vectors of all directions, and often ones along or across the axis.
fn normals() -> impl Strategy<Value = Vector3<f64>> {
    let part = || prop_oneof![4 => -1.0f64..1.0, 1 => Just(0.0), 1 => -1e-7f64..1e-7];
    let long_enough = |v: &Vector3<f64>| v.norm() > 1e-3;
    (part(), part(), part())
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("has a direction", long_enough)
        .prop_map(|v| v.normalize())
}

proptest! {
    #![proptest_config(cases(4000))]

    /// A line through two points of a convex surface meets it there and nowhere else.
    #[test]
    fn crossings_of_a_line_through_two_points_are_these(
        (body, sizes) in solids(),
        one in normals(),
        other in normals(),
        // Covers lines through the middle up to grazing ones.
        nearness in prop_oneof![2 => Just(0.0), 1 => 0.0f64..7.0],
        mirrored in prop_oneof![4 => Just(None), 1 => (0usize..3).prop_map(Some)],
    ) {
        let other = match mirrored {
            // Along an axis.
            Some(axis) => { let mut v = one; v[axis] = -v[axis]; v }
            None => one.lerp(&other, 10.0f64.powf(-nearness)),
        };
        prop_assume!(other.norm() > 1e-3);
        let (from, to) = (touched(sizes, one), touched(sizes, other.normalize()));
        let chord = to - from;
        let (length, size) = (chord.norm(), sizes.iter().sum::<f64>());
        prop_assume!(length > 1e-6);
        let direction = chord / length;
        let ray = Ray { origin: from - 2.0 * size * direction, direction };
        let crossings = body.crossings(&ray);
        prop_assert_eq!(crossings.len(), 2, "{:?} {} mm", sizes, length);
        // The points are rounded, which shifts crossings more where the line grazes.
        let slope = crossings.iter().map(|c| c.normal.normalize().dot(&direction).abs());
        let allowed = 2e-14 * size / slope.fold(1.0, f64::min);
        for (crossing, known) in crossings.iter().zip([2.0 * size, 2.0 * size + length]) {
            prop_assert!(
                (crossing.t - known).abs() < allowed,
                "{:?} {} mm: {:e}, {:e} allowed", sizes, length, crossing.t - known, allowed,
            );
        }
    }

    /// Tests lines slightly outside and inside of a tangent.
    #[test]
    fn lines_beside_a_tangent_miss_or_meet(
        (body, sizes) in solids(),
        normal in normals(),
        other in normals(),
        exponent in 1.0f64..12.0,
    ) {
        let along = normal.cross(&other);
        prop_assume!(along.norm() > 1e-3);
        let direction = along.normalize();
        let size = sizes.iter().sum::<f64>();
        let beside = size * 10.0f64.powf(-exponent);
        let ray = |out: f64| Ray {
            origin: touched(sizes, normal) + out * normal - 2.0 * size * direction,
            direction,
        };
        prop_assert_eq!(body.crossings(&ray(beside)).len(), 0);
        let within = body.crossings(&ray(-beside.min(1e-3 * sizes[0].min(sizes[1]))));
        prop_assert_eq!(within.len(), 2, "{:?}", sizes);
        prop_assert!(within[0].t < 2.0 * size && 2.0 * size < within[1].t);
    }
}
