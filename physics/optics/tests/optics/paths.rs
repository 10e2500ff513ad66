//! Paths compared with independent results: the camera's own interfaces, formulas, and the reversed path.

use fabkit_camera::{
    Camera, FlatInterface, Interface, Intrinsics, KannalaBrandt, Lens, Point2, SphericalInterface,
};
use fabkit_geometry::{
    Angle, Assembly, Body, DomeSurface, EllipsoidOffset, FixtureGrip, MaterialProperties,
    NominalCamera, OpticalClarity, Path, Placement, Point3, Pose, Process, Ray, Sensor, Solid,
    TouchSurface, Vector3,
};
use fabkit_optics::{
    InvalidStack, LightPath, OpticalStack, RayEnd, TILE, TileTracing, Tracer, refract,
};
use proptest::prelude::*;

fn medium(name: &str, index: f64, solid: Solid) -> Body {
    let mut body = Body::cast(name, "", solid)
        .with_material("jelly")
        .with_clarity(OpticalClarity::Clear)
        .placed([Placement::in_place(Assembly::sensor())]);
    body.substance =
        MaterialProperties { refractive_index: Some(index), ..MaterialProperties::default() };
    body
}

fn wall(name: &str, solid: Solid) -> Body {
    Body::made(name, "", Process::Fdm, solid).placed([Placement::in_place(Assembly::sensor())])
}

fn skin(name: &str, solid: Solid) -> Body {
    Body::cast(name, "", solid).placed([Placement::in_place(Assembly::sensor())])
}

/// The camera looks from the origin along z.
fn sensor(bodies: impl IntoIterator<Item = Body>) -> Sensor {
    let camera = NominalCamera {
        sensor_from_camera: Pose::identity(),
        width_px: 128,
        height_px: 96,
        field_of_view: Angle::from_deg(120.0).unwrap(),
        lens: Default::default(),
    };
    Sensor::new("test", "", "", camera, bodies)
}

fn ray(x: f64, y: f64, z: f64) -> Ray {
    Ray { origin: Point3::origin(), direction: Vector3::new(x, y, z).normalize() }
}

fn camera(interface: Interface) -> Camera {
    let intrinsics = Intrinsics { fx_px: 60.0, fy_px: 60.0, cx_px: 63.5, cy_px: 47.5 };
    let lens = Lens::KannalaBrandt(KannalaBrandt::new(intrinsics, [0.0; 4]).unwrap());
    Camera::new(128, 96, lens, interface).unwrap()
}

/// Compares every pixel's ray in the gel, by the camera's interface and through the drawn bodies, which refract it
/// `bends` times before.
fn compare_with_interface(interface: Interface, bodies: Vec<Body>, bends: usize) {
    let (seeing, bare) = (camera(interface), camera(Interface::None));
    let stack = OpticalStack::from_sensor(&sensor(bodies)).unwrap();
    let mut tracer = Tracer::new(&stack);
    let mut compared = 0;
    for (column, row) in (0..96).flat_map(|row| (0..128).map(move |column| (column, row))) {
        let pixel = Point2::new(f64::from(column), f64::from(row));
        let direction = bare.unproject(&pixel).unwrap().direction;
        tracer.follow(&Ray { origin: Point3::origin(), direction });
        // Grazing rays would pass the rim of the pane.
        let [from, to] = match tracer.corners().get(bends..bends + 2) {
            Some(&[from, to]) if direction.z > 0.2 => [from, to],
            _ => continue,
        };
        compared += 1;
        let expected = seeing.unproject(&pixel).unwrap();
        assert!((from - expected.origin_in_camera).norm() < 1e-9, "{pixel}");
        assert!(((to - from).normalize() - expected.direction).norm() < 1e-9, "{pixel}");
    }
    assert!(compared > 8_000, "{compared}");
}

#[test]
fn a_drawn_pane_is_the_cameras_flat_interface() {
    let flat = FlatInterface {
        glass_thickness_mm: 2.0,
        index_glass: 1.5,
        ..FlatInterface::bare_in_air(3.0, 1.41)
    };
    let pane = medium("pane", 1.5, Solid::cylinder(500.0, 2.0).at(0.0, 0.0, 3.0));
    let gel = medium("gel", 1.41, Solid::cylinder(500.0, 20.0).at(0.0, 0.0, 5.0));
    // Denser than the gel, so that nothing is totally reflected.
    let beyond = medium("beyond", 1.45, Solid::cylinder(900.0, 50.0).at(0.0, 0.0, 25.0));
    compare_with_interface(Interface::Flat(flat), vec![pane, gel, beyond.clone()], 2);
    let bare = FlatInterface::bare_in_air(3.0, 1.41);
    let gel = medium("gel", 1.41, Solid::cylinder(500.0, 22.0).at(0.0, 0.0, 3.0));
    compare_with_interface(Interface::Flat(bare), vec![gel, beyond], 1);
}

#[test]
fn a_drawn_ball_is_the_cameras_spherical_interface() {
    // The camera sits in a ball of air in the gel, off its centre.
    let centre = Point3::new(0.3, -0.2, 0.5);
    let sphere = SphericalInterface {
        radius_mm: 4.0,
        centre_in_camera: centre,
        index_inside: 1.0,
        index_outside: 1.41,
        has_drawn_bodies_behind: false,
    };
    let gel = Solid::sphere(30.0).minus(Solid::sphere(4.0).at(centre.x, centre.y, centre.z));
    compare_with_interface(Interface::Sphere(sphere), vec![medium("gel", 1.41, gel)], 1);
}

/// A dome of layers whose boundaries are concentric spheres, which touch without a gap.
fn dome(radii: &[f64], indices: &[f64], centre_z: f64) -> Vec<Body> {
    let ball = |r: f64| Solid::sphere(r).at(0.0, 0.0, centre_z);
    radii
        .windows(2)
        .zip(indices)
        .enumerate()
        .map(|(i, (r, index))| medium(&format!("layer-{i}"), *index, ball(r[1]).minus(ball(r[0]))))
        .collect()
}

/// Computes the largest deviation from Bouguer's formula: in concentric spheres, index times distance from the centre
/// times sine is constant along a ray.
fn bouguer(path: &[Point3<f64>], centre: Point3<f64>, indices: &[f64]) -> f64 {
    let moment = |pair: &[Point3<f64>], index: f64| {
        index * (pair[0] - centre).cross(&(pair[1] - pair[0]).normalize()).norm()
    };
    let all: Vec<f64> = path.windows(2).zip(indices).map(|(p, i)| moment(p, *i)).collect();
    all.iter().map(|m| (m - all[0]).abs()).fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn in_concentric_layers_the_moment_is_kept(
        widths in prop::collection::vec(0.2..3.0f64, 1..6),
        indices in prop::collection::vec(1.3..1.6f64, 6),
        centre_z in -1.5..1.5f64,
        aim in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
    ) {
        prop_assume!(Vector3::new(aim.0, aim.1, aim.2).norm() > 0.1);
        let mut radii = vec![3.0];
        widths.iter().for_each(|width| radii.push(radii.last().unwrap() + width));
        let stack = OpticalStack::from_sensor(&sensor(dome(&radii, &indices, centre_z))).unwrap();
        let mut tracer = Tracer::new(&stack);
        let path = tracer.follow(&ray(aim.0, aim.1, aim.2));
        let along: Vec<f64> = std::iter::once(1.0).chain(indices).collect();
        let centre = Point3::new(0.0, 0.0, centre_z);
        prop_assert!(bouguer(tracer.corners(), centre, &along) < 1e-11);
        // Each corner lies on a boundary.
        for (corner, radius) in tracer.corners()[1..].iter().zip(&radii) {
            prop_assert!(((corner - centre).norm() - radius).abs() < 1e-11);
        }
        prop_assert!(matches!(path.end, RayEnd::Nothing | RayEnd::TotalReflection(_)));
    }

    /// Paths are reversible.
    #[test]
    fn a_path_runs_backwards(
        indices in prop::collection::vec(1.3..1.6f64, 3),
        aim in (-1.0..1.0f64, -1.0..1.0f64, 0.3..1.0f64),
    ) {
        let stack = OpticalStack::from_sensor(&sensor(dome(&[3.0, 4.0, 6.0, 7.0], &indices, 0.7))).unwrap();
        let mut tracer = Tracer::new(&stack);
        let path = tracer.follow(&ray(aim.0, aim.1, aim.2));
        prop_assume!(path.end == RayEnd::Nothing);
        let there: Vec<Point3<f64>> = tracer.corners().to_vec();
        let back = Ray { origin: path.last.at(5.0), direction: -path.last.direction };
        tracer.follow(&back);
        for (a, b) in there[1..].iter().rev().zip(&tracer.corners()[1..]) {
            prop_assert!((a - b).norm() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn refraction_keeps_the_sine_and_the_plane(
        a in (-1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64),
        n in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
        ratio in 0.5..2.0f64,
    ) {
        let (d, n) = (Vector3::new(a.0, a.1, a.2), Vector3::new(n.0, n.1, n.2));
        prop_assume!(n.norm() > 0.1);
        let (d, n) = (d.normalize(), n.normalize());
        prop_assume!(d.dot(&n).abs() > 1e-3);
        match refract(&d, &n, ratio) {
            Some(bent) => {
                prop_assert!((bent.norm() - 1.0).abs() < 1e-14);
                prop_assert!((bent.cross(&n) - ratio * d.cross(&n)).norm() < 1e-12);
                prop_assert!(bent.dot(&n) * d.dot(&n) > 0.0);
            }
            None => prop_assert!(ratio * d.cross(&n).norm() > 1.0 - 1e-12),
        }
    }
}

/// Builds a dome of gel with a coat, on a ring that stands in the camera's way.
fn tip() -> Sensor {
    let above = || Solid::cylinder(20.0, 20.0).at(0.0, 0.0, 2.0);
    let ball = |r: f64| Solid::intersection([Solid::sphere(r).at(0.0, 0.0, 4.0), above()]);
    let gel = medium("gel", 1.41, ball(10.0));
    let coat = skin("coat", ball(10.5).minus(ball(10.0)));
    let ring = Solid::cylinder(12.0, 0.8).minus(Solid::cylinder(2.5, 3.0).at(0.0, 0.0, -1.0));
    let mut sensor = sensor([gel, coat, wall("ring", ring.at(0.0, 0.0, 1.0))]);
    sensor.visible_bodies = vec!["coat".into()];
    sensor.touch = Some(TouchSurface::Dome(DomeSurface {
        dome: EllipsoidOffset { equatorial_mm: 10.5, polar_mm: 10.5, offset_mm: 0.0 },
        centre_z_mm: 4.0,
        foot_z_mm: 2.0,
        max_indentation_mm: 2.0,
        grip: FixtureGrip {
            outline: Path::from([12.0, 0.0]).arc([-12.0, 0.0], [0.0, 0.0], true).arc(
                [12.0, 0.0],
                [0.0, 0.0],
                true,
            ),
            top_z_mm: 2.0,
            bottom_z_mm: 1.0,
            clear_radius_mm: 5.0,
            key: None,
            threads: Vec::new(),
        },
    }));
    sensor
}

#[test]
fn opaque_bodies_end_rays_and_skin_shows_the_surface() {
    let stack = OpticalStack::from_sensor(&tip()).unwrap();
    let mut tracer = Tracer::new(&stack);
    let path = tracer.follow(&ray(0.2, 0.0, 1.0));
    assert_eq!((path.end, path.bends), (RayEnd::Surface, 1));
    let point = path.last.at(path.end_mm);
    assert!(((point - Point3::new(0.0, 0.0, 4.0)).norm() - 10.5).abs() < 1e-12);
    let hidden = tracer.follow(&ray(3.0, 0.0, 1.0));
    let RayEnd::Body(body) = hidden.end else { panic!("{hidden:?}") };
    assert_eq!(stack.names()[usize::from(body)], "ring");
    assert!((hidden.last.at(hidden.end_mm).z - 1.0).abs() < 1e-12);
}

#[test]
fn rays_beyond_the_critical_angle_are_totally_reflected() {
    // From within glass, whose face the camera meets at 60 degrees.
    let glass =
        medium("glass", 1.5, Solid::cuboid_between([-50.0, -50.0, -5.0], [50.0, 50.0, 5.0]));
    let stack = OpticalStack::from_sensor(&sensor([glass])).unwrap();
    let path = Tracer::new(&stack).follow(&ray(3f64.sqrt(), 0.0, 1.0));
    assert_eq!(path.end, RayEnd::TotalReflection(0));
    assert!((path.end_mm - 10.0).abs() < 1e-9);
}

#[test]
fn bad_stacks_are_refused_with_the_place() {
    let ball = |r: f64, z: f64| Solid::sphere(r).at(0.0, 0.0, z);
    let refused = |bodies: Vec<Body>| OpticalStack::from_sensor(&sensor(bodies)).unwrap_err();
    for index in [0.9, f64::NAN, 5.0] {
        let error = refused(vec![medium("gel", index, ball(2.0, 5.0))]);
        assert!(matches!(error, InvalidStack::Index { .. }), "{error}");
    }
    let mut unknown = medium("gel", 1.4, ball(2.0, 5.0));
    unknown.substance.refractive_index = None;
    let error = refused(vec![unknown]);
    assert_eq!(
        error.to_string(),
        "gel: light passes it, but the refractive index of jelly is not known"
    );
    assert!(error.hint().contains("refractive_index"));
    let error = refused(vec![medium("a", 1.4, ball(2.0, 5.0)), medium("b", 1.5, ball(2.0, 7.0))]);
    let InvalidStack::Overlap { bodies, place_in_sensor, depth_mm } = &error else {
        panic!("{error}")
    };
    assert_eq!(bodies, &["a".to_owned(), "b".to_owned()]);
    assert!((place_in_sensor.z - 5.0).abs() < 0.1 && (depth_mm - 2.0).abs() < 0.1, "{error}");
    let error = refused(vec![wall("box", ball(2.0, 1.0))]);
    assert!(error.to_string().contains("lies inside box"), "{error}");
}

/// Traces all rays of a camera over the dome, singly and in tiles.
#[test]
fn tiles_give_the_same_paths_as_single_rays() {
    let pins = (0..40).map(|i| {
        let (sin, cos) = (f64::from(i) * 2.4).sin_cos();
        let out = 1.0 + 0.15 * f64::from(i);
        Solid::sphere(0.3).at(out * cos, out * sin, 7.0)
    });
    let mut with_pins = tip();
    let pins = Solid::Union(pins.collect());
    with_pins.bodies[1].solid = with_pins.bodies[1].solid.clone().minus(pins.clone());
    let pins = wall("pins", pins);
    let order: Vec<Body> = with_pins.bodies.drain(..).chain([pins]).collect();
    with_pins.bodies = fabkit_geometry::sort_by_kind(order);
    for sensor in [tip(), with_pins] {
        // Fails if the pins overlap the gel.
        let stack = OpticalStack::from_sensor(&sensor);
        let stack = stack.unwrap_or_else(|error| panic!("{error}"));
        let bundles = TileTracing::new(&stack);
        let (mut together, mut alone) = (bundles.tracer(), Tracer::new(&stack));
        let ray = |column: u32, row: u32| {
            let [x, y] = [f64::from(column) - 160.0, f64::from(row) - 120.0];
            // Some pixels have no ray.
            (x.hypot(y) < 190.0).then(|| self::ray(x / 80.0, y / 80.0, 1.0))
        };
        let mut seen = vec![0u32; 320 * 240];
        let mut compared = 0;
        for (left, top) in (0..240)
            .step_by(TILE as usize)
            .flat_map(|top| (0..320).step_by(TILE as usize).map(move |left| (left, top)))
        {
            let (right, bottom) = ((left + TILE).min(320), (top + TILE).min(240));
            together.cast(left..right, top..bottom, &ray, &mut |column, row, path| {
                seen[(row * 320 + column) as usize] += 1;
                let expected: LightPath = alone.follow(&ray(column, row).unwrap());
                assert_eq!((path.end, path.bends), (expected.end, expected.bends));
                if path.end_mm.is_finite() {
                    let apart = path.last.at(path.end_mm) - expected.last.at(expected.end_mm);
                    assert!(apart.norm() < 1e-9, "{column} {row} {path:?} {expected:?}");
                    assert!((path.lead_mm - expected.lead_mm).abs() < 1e-9);
                }
                compared += 1;
            });
        }
        let rays = (0..320 * 240).filter(|i| ray(i % 320, i / 320).is_some()).count();
        assert_eq!(compared, rays);
        assert!(seen.iter().all(|count| *count <= 1));
        // Most rays must not be traced singly, otherwise the test is void.
        assert!(
            together.single_ray_count() < rays / 3,
            "{} of {rays}",
            together.single_ray_count()
        );
    }
}
