//! Properties that hold for every solid and every line.

use fabkit_geometry::{CompiledSolid, Crossing, Path, Point3, Ray, Solid};
use fabkit_geometry_testing::{cases, poses, primitives, rays, trees};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;

/// Length inside, in lengths of the ray's direction.
fn length_inside(crossings: &[Crossing]) -> f64 {
    crossings.chunks(2).map(|pair| pair[1].t - pair[0].t).sum()
}

/// Order, alternation, normals, and agreement with `contains`.
fn check(body: &CompiledSolid, ray: &Ray) -> TestCaseResult {
    let crossings = body.crossings(ray);
    let speed = ray.direction.norm();
    prop_assert!(crossings.len().is_multiple_of(2));
    let bounds = body.bounds().grown(1e-7);
    for (i, c) in crossings.iter().enumerate() {
        prop_assert_eq!(c.entering, i % 2 == 0);
        prop_assert!((c.normal.norm() - 1.0).abs() < 1e-12);
        let along = c.normal.dot(&ray.direction) / speed;
        prop_assert!(if c.entering { along < 1e-6 } else { along > -1e-6 }, "{:?} {}", c, along);
        prop_assert!(bounds.contains(&ray.at(c.t)), "{:?} outside {:?}", ray.at(c.t), bounds);
        prop_assert!((c.leaf as usize) < body.leaves().len());
    }
    let ts: Vec<f64> = crossings.iter().map(|c| c.t).collect();
    prop_assert!(ts.windows(2).all(|w| w[0] < w[1]));
    // Middles of stretches and gaps, and points beyond both ends.
    let (first, last) = (ts.first().copied().unwrap_or(0.0), ts.last().copied().unwrap_or(0.0));
    let mut middles = vec![(first - 1.0, false), (last + 1.0, false)];
    for (i, w) in ts.windows(2).enumerate() {
        if (w[1] - w[0]) * speed > 1e-7 {
            middles.push((0.5 * (w[0] + w[1]), i % 2 == 0));
        }
    }
    for (t, inside) in middles {
        prop_assert_eq!(body.contains(&ray.at(t)), inside, "at {} of {:?}", t, ts);
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn crossings_alternate_and_agree_with_contains(
        solid in trees(),
        rays in prop::collection::vec(rays(5.0), 40),
    ) {
        let body = CompiledSolid::new(&solid).unwrap();
        for ray in &rays {
            check(&body, ray)?;
        }
    }

    #[test]
    fn primitives_cross_as_they_contain(
        solid in primitives(),
        rays in prop::collection::vec(rays(5.0), 40),
    ) {
        let body = CompiledSolid::new(&solid).unwrap();
        for ray in &rays {
            check(&body, ray)?;
        }
    }

    #[test]
    fn axis_parallel_lines_are_no_exception(
        solid in primitives(),
        at in prop::collection::vec((-8i32..=8, -8i32..=8), 20),
    ) {
        // On a coarse grid many of these run through axes, apexes, vertices, and along faces,
        // where `contains` may say either; the order of crossings must hold all the same.
        let body = CompiledSolid::new(&solid).unwrap();
        for (i, j) in at {
            let (u, v) = (f64::from(i) * 0.5, f64::from(j) * 0.5);
            for (origin, direction) in [
                (Point3::new(u, v, -20.0), fabkit_geometry::Vector3::z()),
                (Point3::new(u, -20.0, v), fabkit_geometry::Vector3::y()),
                (Point3::new(30.0, u, v), -fabkit_geometry::Vector3::x()),
            ] {
                let crossings = body.crossings(&Ray { origin, direction });
                prop_assert!(crossings.len().is_multiple_of(2));
                prop_assert!(crossings.windows(2).all(|w| w[0].t < w[1].t));
                for pair in crossings.chunks(2) {
                    let middle = origin + 0.5 * (pair[0].t + pair[1].t) * direction;
                    let nudged = middle + fabkit_geometry::Vector3::new(1.7e-9, -1.1e-9, 1.3e-9);
                    prop_assert!(body.contains(&middle) || body.contains(&nudged));
                }
            }
        }
    }

    #[test]
    fn normals_point_out(solid in primitives(), rays in prop::collection::vec(rays(4.0), 10)) {
        let body = CompiledSolid::new(&solid).unwrap();
        for ray in &rays {
            for c in body.crossings(ray) {
                // A line along the normal leaves the solid here, through the same face.
                let out = Ray { origin: ray.at(c.t), direction: c.normal };
                let nearest = body
                    .crossings(&out)
                    .into_iter()
                    .min_by(|a, b| a.t.abs().total_cmp(&b.t.abs()))
                    .unwrap();
                prop_assert!(nearest.t.abs() < 1e-8, "{:?} but {:?}", c, nearest);
                prop_assert!(!nearest.entering);
                prop_assert_eq!(nearest.face, c.face);
                prop_assert!(nearest.normal.dot(&c.normal) > 1.0 - 1e-9);
            }
        }
    }

    #[test]
    fn quartic_crossings_lie_on_the_torus(
        ring in 2.0f64..5.0,
        tube in 0.001f64..0.99,
        rays in prop::collection::vec(rays(5.0), 20),
    ) {
        let tube = tube * ring;
        let disc = Path::circle([ring, 0.0], tube);
        // The special case and the general one.
        for solid in [Solid::torus(ring, tube), Solid::revolution(disc)] {
            let body = CompiledSolid::new(&solid).unwrap();
            for ray in &rays {
                for c in body.crossings(ray) {
                    let p = ray.at(c.t);
                    let off = (p.x.hypot(p.y) - ring).hypot(p.z) - tube;
                    // Rays start up to 60 mm away: a few units in the last place of that.
                    prop_assert!(off.abs() < 1e-13, "{}", off);
                }
            }
        }
    }

    #[test]
    fn a_moved_ray_meets_a_moved_solid_at_the_same_places(
        solid in trees(),
        pose in poses(50.0),
        rays in prop::collection::vec(rays(5.0), 10),
    ) {
        let body = CompiledSolid::new(&solid).unwrap();
        let moved = CompiledSolid::new(&solid.placed(pose)).unwrap();
        for ray in &rays {
            let there = Ray { origin: pose.point(ray.origin), direction: pose.vector(ray.direction) };
            let (here, there) = (body.crossings(ray), moved.crossings(&there));
            let speed = ray.direction.norm();
            // Rounding shifts a surface by about 1e-13 mm; a line that grazes a surface of radius
            // 5 mm sees sqrt(8 * 5 * 1e-13) = 2e-6 mm of that.
            prop_assert!((length_inside(&here) - length_inside(&there)).abs() * speed < 5e-6);
            if here.len() == there.len() {
                for (a, b) in here.iter().zip(&there) {
                    let steepness = a.normal.dot(&ray.direction).abs();
                    prop_assert!((a.t - b.t).abs() * steepness < 1e-9);
                    prop_assert_eq!((a.leaf, a.face), (b.leaf, b.face));
                }
            }
        }
    }

}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn bounds_of_placed_primitives_are_tight(solid in primitives(), pose in poses(5.0)) {
        // Independent of the support functions: no point above the box, some point just below
        // its top, found by climbing from crossing to crossing in ever smaller steps.
        let body = CompiledSolid::new(&solid.placed(pose)).unwrap();
        let bounds = body.bounds();
        for axis in 0..3 {
            let (mut best, mut at) = (f64::NEG_INFINITY, bounds.centre());
            let mut size = bounds.size_mm();
            size[axis] = 0.0;
            for _ in 0..24 {
                let middle = at;
                for i in -12..=12 {
                    for j in -12..=12 {
                        let mut origin = middle;
                        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                        origin[u] += size[u] * f64::from(i) / 24.0;
                        origin[v] += size[v] * f64::from(j) / 24.0;
                        let mut direction = fabkit_geometry::Vector3::zeros();
                        direction[axis] = 1.0;
                        let ray = Ray { origin, direction };
                        if let Some(last) = body.crossings(&ray).last() {
                            let point = ray.at(last.t);
                            if point[axis] > best {
                                (best, at) = (point[axis], point);
                            }
                        }
                    }
                }
                size = size.map(|s| 0.6 * s);
            }
            prop_assert!(best <= bounds.max[axis] + 1e-9);
            prop_assert!(best >= bounds.max[axis] - 5e-3 * bounds.size_mm()[axis],
                "axis {} reaches {} of {:?}", axis, best, bounds);
        }
    }
}

#[test]
fn a_half_space_has_crossings_at_infinity() {
    let body = CompiledSolid::new(&Solid::below(2.0)).unwrap();
    let up = Ray { origin: Point3::origin(), direction: fabkit_geometry::Vector3::z() };
    let ts: Vec<f64> = body.crossings(&up).iter().map(|c| c.t).collect();
    assert_eq!(ts, [f64::NEG_INFINITY, 2.0]);
    let down = Ray { origin: Point3::origin(), direction: -2.0 * fabkit_geometry::Vector3::z() };
    let ts: Vec<f64> = body.crossings(&down).iter().map(|c| c.t).collect();
    assert_eq!(ts, [-1.0, f64::INFINITY]);
    assert!(body.contains(&Point3::new(9.0, 9.0, 1.9)));
    assert_eq!(body.bounds().max.z, 2.0);
}

#[test]
fn touching_solids_are_one_and_common_faces_leave_no_sliver() {
    let along_z = |x: f64| Ray {
        origin: Point3::new(x, 0.3, -5.0),
        direction: fabkit_geometry::Vector3::new(0.01, 0.0, 1.0),
    };
    let stack = Solid::union(
        (0..10).map(|i| Solid::cuboid(4.0, 4.0, 0.1).at(0.0, 0.0, 0.1 * f64::from(i))),
    );
    let stack = CompiledSolid::new(&stack).unwrap();
    assert_eq!(stack.crossings(&along_z(0.7)).len(), 2);
    let third = 1.0 / 3.0;
    let block = Solid::cuboid(4.0, 4.0, 1.0);
    let cut = Solid::cuboid(4.0, 4.0, third).at(0.0, 0.0, 1.0 - third);
    let rest = CompiledSolid::new(&block.clone().minus(cut.clone())).unwrap();
    assert_eq!(rest.crossings(&along_z(0.7)).len(), 2);
    let nothing = CompiledSolid::new(&block.clone().minus(block.clone())).unwrap();
    assert_eq!(nothing.crossings(&along_z(0.7)).len(), 0);
    let common = CompiledSolid::new(&cut.and(Solid::cuboid(4.0, 4.0, 1.0 - third))).unwrap();
    assert_eq!(common.crossings(&along_z(0.7)).len(), 0);
}

#[test]
fn a_distant_ray_loses_no_digits() {
    // A thin torus from 10 km away.
    let body = CompiledSolid::new(&Solid::torus(10.0, 0.001)).unwrap();
    let ray = Ray { origin: Point3::new(-1e7, 0.0, 0.0), direction: fabkit_geometry::Vector3::x() };
    let xs: Vec<f64> = body.crossings(&ray).iter().map(|c| c.t - 1e7).collect();
    // One unit in the last place of 1e7 is 2e-9.
    for (x, expected) in xs.iter().zip([-10.001, -9.999, 9.999, 10.001]) {
        assert!((x - expected).abs() < 4e-9, "{xs:?}");
    }
}
