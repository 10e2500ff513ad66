//! The surface that fixtures press is the outside of the sensor: what they are made from and what is cast are
//! stated in two places of a design, and here they are held against each other.

use fabkit_geometry::{Assembly, CompiledSolid, Point3, Ray, Vector3};

/// Directions in which each sensor is looked at.
const LOOKS: u32 = 2_000;

/// Far outside of every sensor, mm.
const FAR_MM: f64 = 500.0;

/// Surfaces parallel to an ellipsoid are solved to this, mm; everything else is exact to rounding.
const SAME_MM: f64 = 1e-6;

#[test]
fn what_fixtures_press_is_what_the_sensor_ends_in() {
    let mut sensors = 0;
    for design in fabkit_tests::builtin_designs() {
        let sensor = &design.sensor;
        let Some(touch) = &sensor.touch else { continue };
        let in_use = sensor.bodies.iter().flat_map(|body| {
            let used = body.placements.iter().filter(|p| p.assembly == Assembly::sensor());
            used.map(|place| {
                CompiledSolid::new(&body.solid.clone().placed(place.assembly_from_body)).unwrap()
            })
        });
        let in_use: Vec<CompiledSolid> = in_use.collect();
        let surface = CompiledSolid::new(&touch.solid(0.0, touch.foot_z_mm())).unwrap();
        // From all around and above: what is wider than the surface lies below its middle.
        let middle = Point3::new(0.0, 0.0, (touch.foot_z_mm() + touch.apex_z_mm()) / 2.0);
        let mut worst_mm = 0.0_f64;
        for k in 0..LOOKS {
            let azimuth = std::f64::consts::TAU * (f64::from(k) * 0.618_033_988_75).fract();
            let up = (f64::from(k) + 0.5) / f64::from(LOOKS);
            let across = (1.0 - up * up).sqrt();
            let out = Vector3::new(across * azimuth.cos(), across * azimuth.sin(), up);
            let ray = Ray { origin: middle + out * FAR_MM, direction: -out };
            let first = |body: &CompiledSolid| body.crossings(&ray).first().map(|c| c.t);
            let Some(expected) = first(&surface) else { panic!("{}: missed", sensor.name) };
            let found = in_use.iter().filter_map(first).fold(f64::INFINITY, f64::min);
            worst_mm = worst_mm.max((found - expected).abs());
        }
        assert!(worst_mm < SAME_MM, "{}: {worst_mm:.3e} mm", sensor.name);
        sensors += 1;
    }
    // All but the fluidic sensor, whose family states no such surface.
    assert_eq!(sensors, fabkit_tests::tested_sensors().len() - 1);
}
