//! Markers that hang in gel: rays end on them, and without them go on as if gel filled their places.

use fabkit_geometry::{
    Angle, Assembly, Body, DomeSurface, EllipsoidOffset, FixtureGrip, Lighting, MaterialProperties,
    NominalCamera, OpticalClarity, Path, Placement, Point3, Pose, Ray, Sensor, Solid, TouchSurface,
    Vector3, VisibleEffect,
};
use fabkit_optics::{OpticalStack, RayEnd, TILE, TileTracing, Tracer};

/// Radius of the gel, and of the skin on it, mm.
const RADII_MM: [f64; 2] = [20.0, 21.0];
/// Height of the sphere's centre and of the flat face at which the camera meets the gel, mm.
const FOOT_MM: f64 = 10.0;
/// Distances of the ends of pins and markers from the sphere's centre, mm.
const ENDS_MM: [f64; 3] = [20.5, 18.5, 18.0];

/// Cylinders along radii, one along the camera's axis and others around it. They may reach into each other's bodies only
/// where those are cut.
fn pins(from_mm: f64, to_mm: f64) -> Solid {
    let column = || Solid::cylinder(0.5, from_mm - to_mm).at_z(to_mm);
    let tilted = [[0.0, 0.0], [15.0, 0.0], [15.0, 120.0], [15.0, 240.0], [30.0, 45.0]];
    Solid::union(tilted.map(|[tilt, turn]| {
        let angle = |deg| Angle::from_deg(deg).unwrap();
        column().turned_y(angle(tilt)).turned_z(angle(turn)).at_z(FOOT_MM)
    }))
}

fn above(radius_mm: f64) -> Solid {
    let half = Solid::cylinder(30.0, 30.0).at_z(FOOT_MM);
    Solid::intersection([Solid::sphere(radius_mm).at_z(FOOT_MM), half])
}

/// A tip like that of a pin sensor: gel with a flat face to the camera, skin around it with pins that hang into the gel,
/// and a marker on the end of each.
fn tip() -> Sensor {
    let camera = NominalCamera {
        sensor_from_camera: Pose::identity(),
        width_px: 64,
        height_px: 64,
        field_of_view: Angle::from_deg(90.0).unwrap(),
        lens: Default::default(),
    };
    let [root, pin_end, dot_end] = ENDS_MM;
    let placed = |body: Body| body.placed([Placement::in_place(Assembly::sensor())]);
    let mut gel = placed(Body::cast("gel", "", above(RADII_MM[0]).minus(pins(root, dot_end))))
        .with_clarity(OpticalClarity::Clear);
    gel.substance =
        MaterialProperties { refractive_index: Some(1.425), ..MaterialProperties::default() };
    let shell = above(RADII_MM[1]).minus(Solid::sphere(RADII_MM[0]).at_z(FOOT_MM));
    let skin = placed(Body::cast("skin", "", Solid::union([shell, pins(root, pin_end)])));
    let dots = placed(Body::cast("dots", "", pins(pin_end, dot_end)));
    let mut sensor = Sensor::new("tip", "", "", camera, [gel, skin, dots]);
    sensor.visible_bodies = vec!["dots".into()];
    let effect = VisibleEffect::Markers { marks: "dots".into() };
    sensor.lightings = vec![Lighting::from_body("white", "led", effect)];
    let outline = [21.0, -21.0, 21.0];
    sensor.touch = Some(TouchSurface::Dome(DomeSurface {
        dome: EllipsoidOffset { equatorial_mm: RADII_MM[1], polar_mm: RADII_MM[1], offset_mm: 0.0 },
        centre_z_mm: FOOT_MM,
        foot_z_mm: FOOT_MM,
        max_indentation_mm: 2.0,
        grip: FixtureGrip {
            outline: Path::from([outline[0], 0.0]).arc([outline[1], 0.0], [0.0, 0.0], true).arc(
                [outline[2], 0.0],
                [0.0, 0.0],
                true,
            ),
            top_z_mm: FOOT_MM,
            bottom_z_mm: FOOT_MM - 1.0,
            clear_radius_mm: 5.0,
            key: None,
            threads: Vec::new(),
        },
    }));
    sensor
}

/// Rays whose middle one runs along the axis, and those around it, 1/64 apart.
fn ray(column: u32, row: u32) -> Ray {
    let [x, y] = [column, row].map(|px| (f64::from(px) - 64.0) / 64.0);
    Ray { origin: Point3::origin(), direction: Vector3::new(x, y, 1.0).normalize() }
}

/// Traces all rays in tiles and compares them with single ones. Returns column and row, end, bends and place of the end.
fn trace(stack: &OpticalStack) -> Vec<([u32; 2], RayEnd, u32, Point3<f64>)> {
    let tracing = TileTracing::new(stack);
    let (mut tiles, mut single) = (tracing.tracer(), Tracer::new(stack));
    let mut found = Vec::new();
    for (left, top) in (0..4).flat_map(|row| (0..4).map(move |column| (column * TILE, row * TILE)))
    {
        let one = |column: u32, row: u32| Some(ray(column, row));
        tiles.cast(left..left + TILE, top..top + TILE, &one, &mut |column, row, path| {
            let expected = single.follow(&ray(column, row));
            assert_eq!((path.end, path.bends), (expected.end, expected.bends), "{column} {row}");
            found.push(([column, row], path.end, path.bends, path.last.at(path.end_mm)));
        });
    }
    found
}

/// The end of each ray that meets a marker's solid first is the marker, also where only pin and skin lie behind it.
#[test]
fn rays_end_on_markers_whatever_lies_behind_them() {
    let stack = OpticalStack::from_sensor(&tip()).unwrap();
    let [_, pin_end, dot_end] = ENDS_MM;
    let dots = fabkit_geometry::CompiledSolid::new(&pins(pin_end, dot_end)).unwrap();
    let mut on_markers = 0;
    for (pixel, end, _, place) in trace(&stack) {
        // The marker's solid, entered by the ray's last piece: one step behind its end is within.
        let is_on = |place: &Point3<f64>| {
            let steps = [Vector3::x(), Vector3::y(), Vector3::z()];
            steps.iter().flat_map(|step| [*step, -step]).any(|step| {
                dots.contains(&(place + 1e-6 * step)) && !dots.contains(&(place - 1e-6 * step))
            })
        };
        if place.coords.iter().all(|value| value.is_finite()) && is_on(&place) {
            assert_eq!(stack.name_of(end), "dots", "{pixel:?}");
            on_markers += 1;
        }
    }
    // 5 discs of radius 0.5 mm, seen from about 28 mm in steps of 1/64 of the distance: 4 pixels each at least.
    assert!(on_markers > 20, "{on_markers}");
    // On the axis: the marker's face at z = 10 mm + 18 mm.
    let path = Tracer::new(&stack).follow(&ray(64, 64));
    assert_eq!(stack.name_of(path.end), "dots");
    assert!((path.last.at(path.end_mm).z - 28.0).abs() < 1e-9);
}

/// Without markers a ray is refracted once, at the gel's flat face, and goes on to pins and skin as if nothing had been
/// there: it starts far before the places of the markers.
#[test]
fn the_place_of_a_marker_is_no_hole_in_the_gel() {
    let stack = OpticalStack::from_sensor(&tip()).unwrap().without_body("dots");
    let mut whole = tip();
    let [root, pin_end, _] = ENDS_MM;
    // Gel that only the pins are cut out of.
    whole.body_mut("gel").unwrap().solid = above(RADII_MM[0]).minus(pins(root, pin_end));
    whole.bodies.retain(|body| body.name != "dots");
    let whole = OpticalStack::from_sensor(&whole).unwrap();
    let mut expected = Tracer::new(&whole);
    let mut reached = 0;
    for (pixel, end, bends, place) in trace(&stack) {
        let path = expected.follow(&ray(pixel[0], pixel[1]));
        assert_eq!(stack.name_of(end), whole.name_of(path.end), "{pixel:?}");
        assert_eq!(bends, path.bends, "{pixel:?}");
        if path.end_mm.is_finite() {
            assert!((place - path.last.at(path.end_mm)).norm() < 1e-9, "{pixel:?}");
            reached += usize::from(bends == 1);
        }
    }
    assert!(reached > 8_000, "{reached}");
}
