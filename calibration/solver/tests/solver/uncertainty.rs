//! Propagated uncertainty compared with the scatter of simulated calibrations.

use crate::support::{assembled, camera, captures, pins, with_interface};
use fabkit_calibration::extrinsics::{Loss, refine};
use fabkit_calibration::model::{FitParameter, Model};
use fabkit_calibration::synthetic::SyntheticSensor;
use fabkit_calibration::uncertainty::surface_sigma;
use fabkit_camera::{FlatInterface, Interface};
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Point3, Vector3};

/// Calibrates the same sensor 400 times, and intersects the true pixel's ray with the dome each time.
#[test]
fn depth_scatters_as_predicted() {
    let pins = pins(&[("a", 0.0)]);
    let truth = Model::new(camera(), assembled(20.0));
    let captures = captures(&pins, 6, 5, &mut SplitMix64::new(1));
    let parameters = [&FitParameter::POSE[..], &[FitParameter::FocalScale]].concat();
    let mut bench = SyntheticSensor::new(truth.clone(), 2);
    let fits: Vec<_> = (0..400)
        .map(|_| {
            let observations = bench.observe(&captures, 0.3).unwrap();
            refine(&truth, &parameters, &observations, Loss::Squares).unwrap()
        })
        .collect();
    let centre = Point3::new(0.0, 0.0, 6.0);
    for (polar_deg, azimuth) in [(5.0f64, 0.3f64), (40.0, 2.0), (65.0, 4.0)] {
        let (s, c) = polar_deg.to_radians().sin_cos();
        let outward = Vector3::new(s * azimuth.cos(), s * azimuth.sin(), c);
        let place = centre + outward * 15.0;
        let seen = truth.camera_from_sensor.point(place);
        let pixel = truth.camera.project(&seen).unwrap();
        let (mut depth, mut pixels, mut points) = (0.0, 0.0, 0.0);
        for fit in &fits {
            let ray = fit.model.camera.unproject(&pixel).unwrap();
            let centre = fit.model.camera_from_sensor.point(centre);
            // From within the ball: the far crossing.
            let b = ray.direction.dot(&(centre - ray.origin_in_camera));
            let closest = (centre - ray.origin_in_camera).norm_squared() - b * b;
            let found = ray.at(b + (15.0f64.powi(2) - closest).sqrt());
            depth += (found.z - seen.z).powi(2) / 400.0;
            let found = fit.model.camera_from_sensor.inverse().point(found);
            points += (found - place).norm_squared() / 400.0;
            let point = fit.model.camera_from_sensor.point(place);
            pixels += (fit.model.camera.project(&point).unwrap() - pixel).norm_squared() / 400.0;
        }
        let fit = &fits[0];
        let predicted =
            surface_sigma(&fit.model, &parameters, &fit.covariance, place, outward).unwrap();
        // A standard deviation from 400 trials is known to 3.5 %: four of those.
        let ratio = depth.sqrt() / predicted.depth_z_mm;
        assert!((ratio - 1.0).abs() < 0.15, "depth at {polar_deg} degrees: {ratio}");
        let ratio = pixels.sqrt() / predicted.pixel_px;
        assert!((ratio - 1.0).abs() < 0.15, "pixel at {polar_deg} degrees: {ratio}");
        let ratio = points.sqrt() / predicted.point_mm;
        assert!((ratio - 1.0).abs() < 0.15, "point at {polar_deg} degrees: {ratio}");
        assert!(predicted.depth_range_mm > 0.0);
    }
}

#[test]
fn a_place_out_of_sight_or_edge_on_has_no_depth() {
    let gel = with_interface(Interface::Flat(FlatInterface::bare_in_air(4.0, 1.41)));
    let model = Model::new(gel, assembled(0.0));
    let covariance = nalgebra::DMatrix::identity(6, 6);
    let sigma =
        |place, normal| surface_sigma(&model, &FitParameter::POSE, &covariance, place, normal);
    let before_gel = model.camera_from_sensor.inverse().point(Point3::new(0.0, 0.0, 2.0));
    assert!(sigma(before_gel, Vector3::z()).is_none());
    let ahead = model.camera_from_sensor.inverse().point(Point3::new(0.0, 0.0, 20.0));
    let across = model.camera_from_sensor.inverse().vector(Vector3::x());
    assert!(sigma(ahead, across).is_none_or(|s| s.depth_z_mm > 1e6));
}
