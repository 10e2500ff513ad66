//! Light sources of a sensor with up to three bodies.

use fabkit_geometry::{
    Angle, Assembly, Body, Lighting, MaterialProperties, NominalCamera, NominalLens,
    OpticalClarity, Placement, Point3, Pose, Process, Sensor, Solid, Vector3, VisibleEffect,
};
use fabkit_light::{Emitters, LightingError};

/// Builds a sensor with a light source of 0.2 x 0.2 mm at the origin that shines upwards, and other bodies.
fn sensor(lamps: bool, others: Vec<Body>) -> Sensor {
    let camera = NominalCamera {
        // Beside the light source, so that the camera sees past it.
        sensor_from_camera: Pose::translation(0.0, 5.0, -30.0),
        width_px: 640,
        height_px: 480,
        field_of_view: Angle::from_deg(90.0).unwrap(),
        lens: NominalLens::default(),
    };
    let in_use = || [Placement::in_place(Assembly::sensor())];
    let lamp = Body::bought("lamp", "an LED", Solid::cuboid(0.2, 0.2, 0.1).at_z(-0.1));
    let lamp = if lamps { lamp.as_light_source() } else { lamp }.placed(in_use());
    let others = others.into_iter().map(|body| body.placed(in_use()));
    Sensor::new("try", "", "", camera, std::iter::once(lamp).chain(others))
}

fn emitters(sensor: &Sensor) -> Result<Emitters, LightingError> {
    Emitters::new(
        sensor,
        &Lighting::from_body("white", "lamp", VisibleEffect::Thickness { layers: Vec::new() }),
    )
}

fn on_axis_and_aside(emitters: &Emitters) -> [f64; 2] {
    let down = -Vector3::z();
    let places = [(Point3::new(0.0, 0.0, 10.0), down), (Point3::new(10.0, 0.0, 10.0), down)];
    let light = emitters.irradiance(&places);
    [light[0][1], light[1][1]]
}

#[test]
fn light_falls_with_both_cosines_and_the_square_of_the_distance() {
    let emitters = emitters(&sensor(true, Vec::new())).unwrap();
    let [on_axis, aside] = on_axis_and_aside(&emitters);
    // 0.04 mm2 at 10 mm; the finite size changes this by the relative order of (0.2 mm / 10 mm)^2.
    assert!((on_axis / (0.04 / 100.0) - 1.0).abs() < 1e-3, "{on_axis}");
    // Twice the square of the distance, and a cosine of 45 degrees at both ends.
    assert!((aside / on_axis - 0.25).abs() < 1e-3, "{aside}");
    // A surface that faces away receives nothing.
    assert_eq!(emitters.irradiance(&[(Point3::new(0.0, 0.0, 10.0), Vector3::z())]), [[0.0; 3]]);
}

#[test]
fn opaque_bodies_cast_shadows_and_clear_ones_do_not() {
    let plate = |clarity| {
        let solid = Solid::cuboid(2.0, 2.0, 0.5).at_z(4.0);
        let mut plate =
            Body::made("plate", "in the way", Process::Laser, solid).with_clarity(clarity);
        plate.substance.refractive_index = Some(1.0);
        plate
    };
    let lit = |clarity| {
        let emitters = emitters(&sensor(true, vec![plate(clarity)])).unwrap();
        on_axis_and_aside(&emitters)
    };
    let [on_axis, aside] = lit(OpticalClarity::Opaque);
    assert!(on_axis == 0.0 && aside > 0.0);
    assert!(lit(OpticalClarity::Clear)[0] > 0.0);
}

#[test]
fn a_diffuser_shines_instead_of_the_lamps() {
    let solid = Solid::cuboid(6.0, 6.0, 1.0).at_z(2.0);
    let diffuser = Body::made("diffuser", "frosted", Process::Laser, solid)
        .with_clarity(OpticalClarity::Translucent);
    let emitters = emitters(&sensor(true, vec![diffuser])).unwrap();
    assert!(emitters.description.contains("diffuser"), "{}", emitters.description);
    let [on_axis, aside] = on_axis_and_aside(&emitters);
    // From the diffuser's centre, 7 mm below, the fourth power of the cosine is 0.108. Parts of it are closer to the
    // point aside, which also sees its side face.
    assert!((0.12..0.2).contains(&(aside / on_axis)), "{}", aside / on_axis);
}

#[test]
fn without_lamps_there_is_no_light() {
    assert!(matches!(emitters(&sensor(false, Vec::new())), Err(LightingError::NoLamps { .. })));
}

#[test]
fn light_below_a_plate_is_bent_into_it() {
    // A wide glass plate from 4 mm on: light arrives more steeply than along the straight line.
    let solid = Solid::cuboid(200.0, 200.0, 100.0).at_z(4.0);
    let glass = MaterialProperties { refractive_index: Some(1.5), ..MaterialProperties::default() };
    let mut plate =
        Body::made("plate", "clear", Process::Laser, solid).with_clarity(OpticalClarity::Clear);
    plate.substance = glass;
    let emitters = emitters(&sensor(true, vec![plate])).unwrap();
    let place = Point3::new(10.0, 0.0, 10.0);
    let piece = emitters.pieces()[0];
    let found = emitters.arrival(&piece, &place, &mut emitters.tracer()).unwrap();
    let straight = (place - piece.place).normalize();
    assert!(found.arrival_direction.z > straight.z + 0.05, "{}", found.arrival_direction);
    let sines = [found.departure_direction.x / found.arrival_direction.x, 1.5];
    assert!((sines[0] - sines[1]).abs() < 1e-9, "{sines:?}");
}

#[test]
fn light_from_aside_goes_a_longer_way_through_a_layer() {
    let lit = |clear: Vec<Body>, index: f64| {
        let emitters = emitters(&sensor(true, clear)).unwrap();
        let places = [0.0, 10.0].map(|x| (Point3::new(x, 0.0, 10.0), -Vector3::z()));
        let [slanted, lit] =
            [emitters.irradiance_times_path(&places, index), emitters.irradiance(&places)];
        [0, 1].map(|place| slanted[place][1] / lit[place][1])
    };
    // The path is 1 straight through and sqrt(2) at 45 degrees; the size of the source changes this by the relative
    // order of (0.2 mm / 10 mm)^2.
    let [above, aside] = lit(Vec::new(), 1.0);
    assert!((above - 1.0).abs() < 1e-3 && (aside - f64::sqrt(2.0)).abs() < 1e-3, "{above} {aside}");
    // In silicone the sine of 45 degrees is divided by 1.41, which gives about 1/2.
    let sine = f64::sqrt(0.5) / 1.41;
    let [above, aside] = lit(Vec::new(), 1.41);
    assert!((above - 1.0).abs() < 1e-3, "{above}");
    assert!((aside - (1.0 - sine * sine).sqrt().recip()).abs() < 1e-3, "{aside}");
    // Light that a plate has refracted is not refracted again.
    let solid = Solid::cuboid(200.0, 200.0, 100.0).at_z(4.0);
    let mut plate =
        Body::made("plate", "clear", Process::Laser, solid).with_clarity(OpticalClarity::Clear);
    plate.substance.refractive_index = Some(1.41);
    let [once, again] = [1.0, 1.41].map(|index| lit(vec![plate.clone()], index)[1]);
    assert!(once == again && once < f64::sqrt(2.0), "{once} {again}");
}
