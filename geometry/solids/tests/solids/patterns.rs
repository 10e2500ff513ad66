//! Places, order and spacing of patterns, and refused patterns.

use std::f64::consts::{FRAC_PI_2, PI};

use fabkit_geometry::{
    CompiledSolid, EllipsoidOffset, InvalidPattern, MAX_FEATURES, Pattern, Point3, Pose, Ray,
    Solid, Vector3,
};
use fabkit_geometry_testing::cases;
use proptest::prelude::*;

fn points(pattern: &Pattern) -> Vec<Point3<f64>> {
    pattern.poses().unwrap().iter().map(|pose| pose.point(Point3::origin())).collect()
}

fn nearest_neighbours(points: &[Point3<f64>]) -> Vec<f64> {
    let nearest = |p: &Point3<f64>| {
        let others = points.iter().filter(|q| *q != p).map(|q| (p - q).norm());
        others.fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).collect()
}

fn sphere(radius_mm: f64) -> EllipsoidOffset {
    EllipsoidOffset { equatorial_mm: radius_mm, polar_mm: radius_mm, offset_mm: 0.0 }
}

#[test]
fn hexagonal_rings_count_like_hexagonal_numbers() {
    let pattern = Pattern::six_per_ring(4, 2.5);
    let places = points(&pattern);
    assert_eq!(places.len(), 1 + 6 + 12 + 18 + 24);
    assert_eq!(places[0], Point3::origin());
    assert!((places[1].x, places[1].y) == (2.5, 0.0));
    for distance in nearest_neighbours(&places) {
        // Neighbours on one ring and on adjacent rings are about one spacing apart.
        assert!(distance > 0.9 * 2.5, "{distance}");
    }
}

#[test]
fn a_grid_is_centred_and_listed_from_the_centre() {
    let pattern = Pattern::Grid { counts: [3, 2], spacing_mm: [2.0, 1.0] };
    let places: Vec<_> = points(&pattern).iter().map(|p| (p.x, p.y)).collect();
    let expected = [(0.0, -0.5), (0.0, 0.5), (-2.0, -0.5), (2.0, -0.5), (-2.0, 0.5), (2.0, 0.5)];
    assert_eq!(places, expected);
}

#[test]
fn a_fibonacci_lattice_gives_each_place_the_same_area() {
    let (count, radius_mm, half_angle_rad) = (400, 15.0, 1.2);
    let pattern = Pattern::Fibonacci { count, radius_mm, half_angle_rad };
    let places = points(&pattern);
    for (place, pose) in places.iter().zip(pattern.poses().unwrap()) {
        assert!((place.coords.norm() - radius_mm).abs() < 1e-12);
        assert!((pose.vector(Vector3::z()) - place.coords / radius_mm).norm() < 1e-12);
        assert!(place.z > radius_mm * half_angle_rad.cos());
    }
    // Any smaller cap holds its share of places, to one.
    for part in [0.1, 0.35, 0.8] {
        let height = radius_mm * (1.0 - (1.0 - half_angle_rad.cos()) * part);
        let within = places.iter().filter(|p| p.z > height).count();
        assert_eq!(within, (part * f64::from(count)).round() as usize);
    }
    let mean_area = 2.0 * PI * radius_mm * radius_mm * (1.0 - half_angle_rad.cos()) / 400.0;
    let nearest = nearest_neighbours(&places).into_iter().fold(f64::INFINITY, f64::min);
    assert!(nearest > 0.75 * mean_area.sqrt(), "{nearest} of {}", mean_area.sqrt());
}

#[test]
fn rings_on_a_sphere_lie_at_equal_arcs() {
    let surface = sphere(10.0);
    let pattern = Pattern::SurfaceRings { surface, spacing_mm: 2.0, counts: vec![1, 5, 9, 12] };
    let places = points(&pattern);
    assert_eq!(places.len(), 27);
    let ring_of = |i: usize| [0, 1, 6, 15, 27].iter().filter(|&&start| start <= i).count() - 1;
    for (i, place) in places.iter().enumerate() {
        let arc_mm = 10.0 * (place.z / 10.0).min(1.0).acos();
        assert!((arc_mm - 2.0 * ring_of(i) as f64).abs() < 1e-6, "{i}: {arc_mm}");
    }
}

#[test]
fn even_rings_keep_their_spacing() {
    for surface in [
        sphere(15.0),
        EllipsoidOffset { equatorial_mm: 15.0, polar_mm: 8.0, offset_mm: 1.5 },
        EllipsoidOffset { equatorial_mm: 8.0, polar_mm: 15.0, offset_mm: -0.7 },
    ] {
        let pattern = Pattern::even_surface_rings(surface, 9, 1.5).unwrap();
        let places = points(&pattern);
        assert!(places.len() > 100);
        for distance in nearest_neighbours(&places) {
            assert!(distance > 0.85 * 1.5 && distance < 1.2 * 1.5, "{distance}");
        }
    }
}

#[test]
fn features_are_named_from_the_centre() {
    let hole = Solid::cylinder(0.5, 2.0);
    let holes = Pattern::six_per_ring(1, 3.0).features("hole", &hole).unwrap();
    let body = CompiledSolid::new(&Solid::cuboid(20.0, 20.0, 1.0).minus_all(holes)).unwrap();
    assert_eq!(body.leaves().len(), 8);
    assert_eq!((body.feature_of(0), body.feature_of(1)), ("", "hole 1"));
    assert_eq!(body.feature_of(7), "hole 7");
    assert!(body.leaves()[7].is_tool && !body.leaves()[0].is_tool);
}

#[test]
fn refuses_what_is_no_pattern() {
    let ring = |count, radius_mm| Pattern::Ring { count, radius_mm, phase_rad: 0.0 };
    assert_eq!(ring(0, 1.0).poses(), Err(InvalidPattern::Empty));
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = ring(3, radius).poses().unwrap_err();
        assert!(matches!(error, InvalidPattern::OutOfRange { name: "radius", .. }));
    }
    let counts = [200, 101];
    let grid = Pattern::Grid { counts, spacing_mm: [1.0, 1.0] };
    assert_eq!(grid.poses(), Err(InvalidPattern::TooMany { count: 20_200 }));
    let huge = Pattern::Grid { counts: [u32::MAX; 2], spacing_mm: [1.0, 1.0] };
    assert!(matches!(huge.poses(), Err(InvalidPattern::TooMany { .. })));
    assert_eq!(ring(MAX_FEATURES as u32, 9.0).poses().unwrap().len(), MAX_FEATURES);
    let crowded = Pattern::Rings { spacing_mm: 1.0, counts: vec![2, 6] };
    assert_eq!(crowded.poses(), Err(InvalidPattern::CrowdedCentre { count: 2 }));
    let beyond =
        Pattern::SurfaceRings { surface: sphere(1.0), spacing_mm: 2.0, counts: vec![1, 2, 3] };
    assert!(matches!(beyond.poses(), Err(InvalidPattern::BeyondSurface { .. })));
    let evolute = EllipsoidOffset { equatorial_mm: 4.0, polar_mm: 2.0, offset_mm: -1.0 };
    assert!(Pattern::even_surface_rings(evolute, 2, 1.0).is_err());
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn surface_places_stand_on_the_surface_along_its_normal(
        equatorial_mm in 2.0f64..10.0, polar_mm in 2.0f64..10.0, offset_mm in 0.0f64..2.0,
        count in 1u32..9,
    ) {
        let surface = EllipsoidOffset { equatorial_mm, polar_mm, offset_mm };
        let pattern = Pattern::SurfaceRings {
            surface: surface.clone(), spacing_mm: 1.1, counts: vec![1, count, count + 3],
        };
        // Independent: the ray caster's crossing and normal.
        let body = CompiledSolid::new(&Solid::EllipsoidOffset(surface)).unwrap();
        for pose in pattern.poses().unwrap() {
            let ray = Ray { origin: pose.point(Point3::origin()), direction: pose.vector(Vector3::z()) };
            let exit = body.crossings(&ray)[1];
            prop_assert!(exit.t.abs() < 1e-9, "{}", exit.t);
            prop_assert!((exit.normal - ray.direction).norm() < 1e-7);
            prop_assert!(pose.is_rigid());
            // x points away from the centre line.
            let x = pose.vector(Vector3::x());
            prop_assert!(x.xy().dot(&ray.origin.coords.xy()) >= -1e-9);
        }
    }

    #[test]
    fn patterns_survive_json(count in 1u32..50, a in 0.1f64..9.0, b in 0.1f64..1.5) {
        for pattern in [
            Pattern::Ring { count, radius_mm: a, phase_rad: b },
            Pattern::six_per_ring(count % 5, a),
            Pattern::Grid { counts: [count, 3], spacing_mm: [a, b] },
            Pattern::Fibonacci { count, radius_mm: a, half_angle_rad: b },
            Pattern::even_surface_rings(sphere(10.0 * a), 3, a).unwrap(),
        ] {
            let text = serde_json::to_string(&pattern).unwrap();
            prop_assert_eq!(serde_json::from_str::<Pattern>(&text).unwrap(), pattern);
        }
    }
}

#[test]
fn a_quarter_turn_is_exact() {
    let ring = Pattern::Ring { count: 4, radius_mm: 7.0, phase_rad: FRAC_PI_2 };
    let places = points(&ring);
    assert_eq!(places[0], Point3::new(0.0, 7.0, 0.0));
    assert_eq!(ring.poses().unwrap()[3].rotation(), Pose::identity().rotation());
}
