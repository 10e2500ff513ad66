//! The hierarchy finds the same as a test of every body.

use fabkit_depth::{Hit, Scene, SceneScratch};
use fabkit_geometry::{CompiledSolid, Point3, Pose, Ray, Solid, Vector3};
use proptest::prelude::*;

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-size..size, -size..size, -size..size].prop_map(|[x, y, z]| Vector3::new(x, y, z))
}

fn pose() -> impl Strategy<Value = Pose> {
    let axis = vector(1.0).prop_filter("a direction", |axis| axis.norm() > 0.1);
    (axis, vector(20.0)).prop_map(|(axis, shift)| Pose::z_to(axis, Point3::from(shift)))
}

fn body() -> impl Strategy<Value = CompiledSolid> {
    let solid = prop_oneof![
        (0.5..4.0f64).prop_map(Solid::sphere),
        (0.5..4.0f64, 0.5..9.0f64).prop_map(|(r, h)| Solid::cylinder(r, h)),
        (1.5..5.0f64, 0.2..1.0f64).prop_map(|(ring, tube)| Solid::torus(ring, tube)),
        (2.0..6.0f64).prop_map(|a| Solid::cuboid(a, a, a).minus(Solid::sphere(0.8 * a))),
    ];
    solid.prop_map(|solid| CompiledSolid::new(&solid).expect("a solid"))
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(20),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_hierarchy_loses_nothing(
        placed in prop::collection::vec((body(), pose()), 1..12),
        origin in vector(30.0),
        target in vector(10.0),
        from_t in -10.0..40.0f64,
        length in 0.0..40.0f64,
    ) {
        prop_assume!((target - origin).norm() > 0.1);
        let ray = Ray { origin: Point3::from(origin), direction: (target - origin).normalize() };
        let scene = Scene::new(placed.iter().map(|(body, pose)| (body, *pose)));
        let mut scratch = SceneScratch::default();

        let mut expected = Vec::new();
        for (index, (body, pose)) in placed.iter().enumerate() {
            let inverse = pose.inverse();
            let in_body =
                Ray { origin: inverse.point(ray.origin), direction: inverse.vector(ray.direction) };
            for mut crossing in body.crossings(&in_body) {
                crossing.normal = pose.vector(crossing.normal);
                expected.push(Hit { body: index as u32, crossing });
            }
        }
        let mut found = Vec::new();
        scene.visit_crossings(&ray, &mut scratch, |body, crossings| {
            found.extend(crossings.iter().map(|&crossing| Hit { body, crossing }));
            f64::INFINITY
        });
        found.sort_by_key(|hit| hit.body);
        prop_assert_eq!(&found, &expected);

        let range = from_t..from_t + length;
        let first = expected
            .iter()
            .filter(|hit| hit.crossing.entering && range.contains(&hit.crossing.t))
            .min_by(|a, b| a.crossing.t.total_cmp(&b.crossing.t))
            .copied();
        prop_assert_eq!(scene.first_hit(&ray, range, &mut scratch), first);
    }
}
