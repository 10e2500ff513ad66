//! Cameras with the first drawn interface in their own model, as calibration writes them, and the bodies behind that.

use std::sync::Arc;

use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::ground_truth::probes::sample_probes;
use fabkit_camera::files::{self, CameraFormat};
use fabkit_camera::{Camera, CameraEstimate, DMatrix, JointEstimate};

use fabkit_application::depth::ground_truth::{PixelRays, ReferenceSurface, Uncertainty};
use fabkit_geometry::{NominalCamera, Sensor};
use fabkit_optics::{FirstInterface, OpticalStack, ViewStacks};
use fabkit_tests::{build_design, tested_sensors};

/// A small image of a sensor; what its camera is, by file, if it has the first interface in its own model, and whether
/// bodies bend light again behind that.
fn with_interface(sensor: &Sensor) -> Option<(String, bool)> {
    let nominal = &sensor.camera;
    let viewpoint = Viewpoint::new(nominal, None, None).unwrap();
    let lens = viewpoint.camera();
    let sights = ViewStacks::new(OpticalStack::from_sensor(sensor).unwrap());
    let window = FirstInterface::from_camera(lens, &nominal.sensor_from_camera, &sights);
    let FirstInterface::Single { interface, again, .. } = window else { return None };
    assert_eq!(again, interface.has_drawn_bodies_behind());
    let camera = Camera::new(lens.width_px(), lens.height_px(), *lens.lens(), interface).ok()?;
    Some((files::write(&camera.into(), CameraFormat::Fabkit).unwrap(), again))
}

/// Where the drawn camera sees a place of the surface, and a probe, there that camera sees it.
#[test]
fn light_goes_on_behind_the_interface_as_drawn() {
    let mut count = 0;
    for name in tested_sensors() {
        let mut sensor = build_design(name, &[]).sensor;
        sensor.camera = NominalCamera { width_px: 64, height_px: 48, ..sensor.camera };
        let Some((file, again)) = with_interface(&sensor) else { continue };
        let drawn = Viewpoint::new(&sensor.camera, None, None).unwrap();
        let own = Viewpoint::new(&sensor.camera, Some(&file), None).unwrap();
        assert_eq!(file.contains("behind: drawn"), again, "{name}");
        if !again {
            continue;
        }
        count += 1;
        let touch = sensor.touch.as_ref().unwrap();
        let of = |viewpoint: &Viewpoint| {
            let sights = Arc::new(ViewStacks::new(viewpoint.stack(&sensor).unwrap()));
            let rays = viewpoint.rays(1).traced_through(&sights);
            let surface = ReferenceSurface::cast(touch, &rays).unwrap();
            let points: Vec<_> = surface.map_without_contact().point_in_sensor().collect();
            (points, sample_probes(touch, viewpoint, &sights, 300, 0.5, 1).unwrap())
        };
        let ((expected, tips), (found, own_tips)) = (of(&drawn), of(&own));
        let seen = expected.iter().filter(|point| point.x.is_finite()).count();
        assert!(seen > 500, "{name}: {seen}");
        let mut astray = 0;
        for (expected, found) in expected.iter().zip(&found) {
            let off_mm = (expected - found).norm();
            // At the very edge of a body a ray may pass that rounding stops.
            astray += usize::from(expected.x.is_finite() != found.x.is_finite());
            assert!(off_mm.is_nan() || off_mm < 1e-9, "{name}: {off_mm:.1e} mm");
        }
        assert!(astray <= 2, "{name}: {astray}");
        assert!(
            tips.visible_tips > 100 && tips.visible_tips.abs_diff(own_tips.visible_tips) <= 2,
            "{name}"
        );
        let numbers = |csv: &str| -> Vec<Vec<Option<f64>>> {
            let of = |line: &str| line.split(',').map(|cell| cell.parse().ok()).collect();
            csv.lines().skip(1).map(of).collect()
        };
        for (expected, found) in numbers(&tips.csv).iter().zip(&numbers(&own_tips.csv)) {
            for (expected, found) in expected.iter().zip(found) {
                let (Some(expected), Some(found)) = (expected, found) else { continue };
                // Numbers are written with six digits and more.
                assert!((expected - found).abs() < 2e-6, "{name}: {expected} {found}");
            }
        }
    }
    assert!(count > 0);
}

/// The sigma of a place by each parameter of the camera, and of its pose, alone is what it moves by.
#[test]
fn sigma_is_by_how_much_what_is_before_the_interface_moves_the_place() {
    const STEP: f64 = 1e-4;
    let mut sensor = build_design("rtac0", &[]).sensor;
    sensor.camera = NominalCamera { width_px: 64, height_px: 48, ..sensor.camera };
    let (file, _) = with_interface(&sensor).unwrap();
    let touch = sensor.touch.as_ref().unwrap();
    let viewpoint = Viewpoint::new(&sensor.camera, Some(&file), None).unwrap();
    let sights = Arc::new(ViewStacks::new(viewpoint.stack(&sensor).unwrap()));
    let (camera, pose) = (viewpoint.camera(), &viewpoint.sensor_from_camera);
    let rays = PixelRays::new(camera, pose).traced_through(&sights);
    let surface = ReferenceSurface::cast(touch, &rays).unwrap();
    let values: Vec<f64> = camera.parameters().into_iter().map(|(_, value)| value).collect();
    for (parameter, (name, _)) in camera.parameters().into_iter().enumerate() {
        let count = values.len();
        let mut covariance = DMatrix::zeros(count, count);
        covariance[(parameter, parameter)] = 1.0;
        let estimate = CameraEstimate::new(*camera, Some(covariance)).unwrap();
        let joint = JointEstimate::independent(&estimate, None).unwrap();
        let uncertainty = Uncertainty { joint: Some(joint), shape_mm: 0.0 };
        let sigma_mm: Vec<f64> = surface
            .map_without_contact()
            .compute_standard_deviations(&uncertainty)
            .point_mm()
            .collect();
        let moved = |by: f64| {
            let mut values = values.clone();
            values[parameter] += by;
            let camera = camera.with_parameters(&values).unwrap();
            let rays = PixelRays::new(&camera, pose).traced_through(&sights);
            let surface = ReferenceSurface::cast(touch, &rays).unwrap();
            surface.map_without_contact().point_in_sensor().collect::<Vec<_>>()
        };
        let (before, after) = (moved(-STEP), moved(STEP));
        let expected = before.iter().zip(&after).map(|(b, a)| (a - b).norm() / (2.0 * STEP));
        let pairs = expected.zip(&sigma_mm).filter(|(e, s)| e.is_finite() && s.is_finite());
        let agree = pairs.filter(|(expected, s)| (*s - expected).abs() < 2e-3 * (1e-2 + expected));
        // All but those at creases of the surface and of the gel.
        let (agree, seen) = (agree.count(), surface.visible_pixels());
        assert!(agree * 100 > seen * 95, "{name}: {agree} of {seen}");
    }
}

/// Where the design draws no such interface, a camera that says so is refused, with what to do.
#[test]
fn an_interface_that_is_not_drawn_is_refused() {
    let sensor = build_design("rtac0", &[]).sensor;
    let (file, _) = with_interface(&sensor).unwrap();
    let mut other = sensor.clone();
    other.bodies.retain(|body| body.substance.refractive_index.is_none());
    let viewpoint = Viewpoint::new(&other.camera, Some(&file), None).unwrap();
    let error = viewpoint.stack(&other).unwrap_err();
    assert!(error.to_string().contains("none is drawn"), "{error}");
    assert!(error.hint().contains("remove `behind`"), "{}", error.hint());
    // What the hint says.
    let without = file.replace("  behind: drawn\n", "");
    let viewpoint = Viewpoint::new(&other.camera, Some(&without), None).unwrap();
    viewpoint.stack(&other).unwrap();
}
