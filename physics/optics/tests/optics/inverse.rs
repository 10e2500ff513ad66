//! Rays to given points, and back.

use fabkit_geometry::{
    Angle, Assembly, Body, MaterialProperties, NominalCamera, OpticalClarity, Placement, Point3,
    Pose, Process, Ray, Sensor, Solid, Vector3,
};
use fabkit_optics::{OpticalStack, RayEnd, SightLine, Tracer, ViewStacks};
use proptest::prelude::*;

fn placed(body: Body) -> Body {
    body.placed([Placement::in_place(Assembly::sensor())])
}

fn medium(name: &str, index: f64, solid: Solid) -> Body {
    let mut body = placed(
        Body::cast(name, "", solid).with_material("jelly").with_clarity(OpticalClarity::Clear),
    );
    body.substance =
        MaterialProperties { refractive_index: Some(index), ..MaterialProperties::default() };
    body
}

fn sights(bodies: impl IntoIterator<Item = Body>) -> ViewStacks {
    let camera = NominalCamera {
        sensor_from_camera: Pose::identity(),
        width_px: 128,
        height_px: 96,
        field_of_view: Angle::from_deg(120.0).unwrap(),
        lens: Default::default(),
    };
    ViewStacks::new(
        OpticalStack::from_sensor(&Sensor::new("test", "", "", camera, bodies)).unwrap(),
    )
}

/// Builds a pane, a ball of gel above it, then air.
fn pane_and_ball(index: f64) -> ViewStacks {
    let pane = medium("pane", 1.5, Solid::cylinder(40.0, 2.0).at(0.0, 0.0, 3.0));
    let ball = medium("ball", index, Solid::sphere(15.0).at(0.0, 0.0, 25.0));
    sights([pane, ball])
}

proptest! {
    /// A point of a ray that went through pane and ball is seen along that ray.
    #[test]
    fn a_point_of_a_ray_is_seen_along_it(
        x in -0.5..0.5f64, y in -0.5..0.5f64, share in 0.02..0.98f64, index in 1.05..2.0f64,
    ) {
        let sights = pane_and_ball(index);
        let ray = Ray { origin: Point3::origin(), direction: Vector3::new(x, y, 1.0).normalize() };
        let mut tracer = Tracer::new(sights.stack());
        tracer.follow(&ray);
        // Inside the ball: after two refractions at the pane and one at the ball.
        let [from, to] = match tracer.corners() {
            [_, _, _, from, to, ..] => [*from, *to],
            _ => return Ok(()),
        };
        let place = from + share * (to - from);
        let found = sights.sight_line_solver().find_sight_line(&ray.origin, &place);
        let sight = found.expect("the ray that was followed is one");
        // Spheres focus: another ray may lead to the point as well, and must then pass through it.
        let way_mm: f64 = tracer.corners()[..4].windows(2).map(|p| (p[1] - p[0]).norm()).sum();
        let way_mm = way_mm + (place - from).norm();
        if (sight.direction - ray.direction).norm() > 1e-9 {
            let other = Ray { direction: sight.direction, ..ray };
            tracer.follow(&other);
            let near = tracer.corners().windows(2).map(|pair| {
                let along = (pair[1] - pair[0]).normalize();
                (place - pair[0]).cross(&along).norm()
            });
            prop_assert!(near.fold(f64::INFINITY, f64::min) < 1e-9);
        } else {
            prop_assert!((sight.way_mm - way_mm).abs() < 1e-9);
        }
    }

    /// Derivatives equal differences between points half a micrometre to either side.
    #[test]
    fn the_derivative_is_that_of_differences(
        x in -6.0..6.0f64, y in -6.0..6.0f64, z in 12.0..24.0f64,
    ) {
        let sights = pane_and_ball(1.41);
        let (pupil, place) = (Point3::origin(), Point3::new(x, y, z));
        let mut seeker = sights.sight_line_solver();
        let sight = seeker.find_sight_line(&pupil, &place).unwrap();
        let across = SightLine::transverse_axes(&sight.direction);
        let by_place = seeker.direction_by_point(&pupil, &place, &sight).unwrap();
        for axis in 0..3 {
            let by = Vector3::ith(axis, 5e-4);
            let [before, after] =
                [place - by, place + by].map(|place| seeker.find_sight_line(&pupil, &place).unwrap().direction);
            let expected = across.transpose() * (after - before) / 1e-3;
            let error = (by_place.column(axis) - expected).norm();
            prop_assert!(error < 1e-6 * by_place.norm(), "{error}");
        }
    }
}

/// At a flat face the solution is known: Snell's law, and the point where the ray meets the face.
#[test]
fn a_ray_to_a_point_behind_a_flat_face_obeys_snells_law() {
    let gel = medium("gel", 1.41, Solid::cylinder(100.0, 30.0).at(0.0, 0.0, 4.0));
    let place = Point3::new(9.0, 0.0, 12.0);
    let sight =
        sights([gel]).sight_line_solver().find_sight_line(&Point3::origin(), &place).unwrap();
    let tangent = |sine: f64| sine / (1.0 - sine * sine).sqrt();
    let sine = sight.direction.x;
    let reached = 4.0 * tangent(sine) + 8.0 * tangent(sine / 1.41);
    assert!((reached - 9.0).abs() < 1e-10, "{reached}");
}

#[test]
fn hiding_bodies_are_named() {
    let gel = medium("gel", 1.41, Solid::cylinder(100.0, 30.0).at(0.0, 0.0, 4.0));
    let wall = placed(Body::made(
        "wall",
        "",
        Process::Fdm,
        Solid::cuboid(2.0, 2.0, 1.0).at(0.0, 0.0, 2.0),
    ));
    let sights = sights([gel, wall]);
    let mut seeker = sights.sight_line_solver();
    let hidden = seeker.find_sight_line(&Point3::origin(), &Point3::new(0.5, 0.0, 20.0)).unwrap();
    let wall = sights.stack().names().iter().position(|name| name == "wall").unwrap();
    assert_eq!(hidden.hidden_by(0.0), Some(RayEnd::Body(wall as u8)));
    // Beside the wall.
    let seen = seeker.find_sight_line(&Point3::origin(), &Point3::new(15.0, 0.0, 20.0)).unwrap();
    assert_eq!(seen.hidden_by(0.0), None);
}

/// From a dense to a thin medium, light beyond the critical angle does not get out.
#[test]
fn points_beyond_the_critical_angle_have_no_ray() {
    let around = medium("oil", 1.8, Solid::sphere(5.0));
    let gap = sights([around]);
    // From a pupil off the centre, the far side of the ball is met beyond the critical angle.
    let pupil = Point3::new(4.9, 0.0, 0.0);
    let mut tracer = Tracer::new(gap.stack());
    let grazing = Ray { origin: pupil, direction: Vector3::new(-0.6, 0.8, 0.0) };
    assert!(matches!(tracer.follow(&grazing).end, RayEnd::TotalReflection(_)));
    let mut seeker = gap.sight_line_solver();
    let mut none = 0;
    for number in 0..200 {
        let angle = f64::from(number) * std::f64::consts::TAU / 200.0;
        let place = Point3::new(5.2 * angle.cos(), 5.2 * angle.sin(), 0.0);
        match seeker.find_sight_line(&pupil, &place) {
            None => none += 1,
            Some(sight) => {
                // A found ray does pass through the point.
                let path = tracer.follow(&Ray { origin: pupil, direction: sight.direction });
                let off = (place - path.last.origin).cross(&path.last.direction).norm();
                assert!(off < 1e-9, "{place} {off}");
            }
        }
    }
    // All but the two caps around the near point and the far one.
    assert!((100..190).contains(&none), "{none}");
}

/// In the plane of pupil, ball and point a ray has one angle: where its offset changes sign, a ray passes through the
/// point. Counted in steps of a thousandth of a degree with traced rays.
#[test]
fn every_ray_to_a_place_behind_a_ball_is_found() {
    let ball = medium("ball", 1.5, Solid::sphere(2.0).at(0.0, 0.0, 6.0));
    let sights = sights([ball]);
    let pupil = Point3::origin();
    for (x, expected) in [(0.6, 1), (2.0, 1), (14.0, 2), (30.0, 2)] {
        let place = Point3::new(x, 0.0, 30.0);
        let mut tracer = sights.media_tracer();
        let mut miss = |number: i32| {
            let angle = (f64::from(number) * 1e-3_f64).to_radians();
            let path = tracer.follow(&Ray {
                origin: pupil,
                direction: Vector3::new(angle.sin(), 0.0, angle.cos()),
            });
            let (to, along) = (place - path.last.origin, path.last.direction);
            // The number of refractions: a change of sign means something only between rays past the same faces.
            (path.bends, to.x * along.z - to.z * along.x)
        };
        let mut before = miss(-60_000);
        let mut counted = 0;
        for number in -59_999..60_000 {
            let now = miss(number);
            counted += usize::from(now.0 == before.0 && now.1.signum() != before.1.signum());
            before = now;
        }
        let every = sights.sight_line_solver().find_all_sight_lines(&pupil, &place);
        assert_eq!((every.len(), counted), (expected, expected), "{x}: {every:?}");
        assert!(every.windows(2).all(|pair| pair[0].way_mm <= pair[1].way_mm));
        // The result of the search for one ray is among them.
        let one = sights.sight_line_solver().find_sight_line(&pupil, &place).unwrap();
        assert!(every.iter().any(|sight| (sight.direction - one.direction).norm() < 1e-9));
    }
}
