//! Pixel to ray to point to pixel, and point to pixel to ray.

use crate::common;
use crate::common::camera_and_pixel;
use fabkit_camera::{Camera, Interface, Point2, Point3};
use proptest::prelude::*;

proptest! {
    #![proptest_config(common::cases(20_000))]

    #[test]
    fn a_point_of_a_pixels_ray_is_seen_at_that_pixel(
        (name, camera, pixel) in camera_and_pixel(),
        distance_mm in prop_oneof![Just(1e-3), 0.1..50.0f64],
    ) {
        let ray = camera.unproject(&pixel).unwrap();
        prop_assert!((ray.direction.norm() - 1.0).abs() < 1e-14);
        let again = camera.project(&ray.at(distance_mm)).unwrap();
        let error_px = (again - pixel).norm();
        prop_assert!(error_px < 1e-9, "{name} at {pixel}: {error_px:e} px");
    }

    #[test]
    fn the_ray_of_a_points_pixel_passes_the_point(
        (name, camera, pixel) in camera_and_pixel(),
        distance_mm in 1.0..50.0f64,
        sideways_mm in prop::array::uniform3(-0.3..0.3f64),
    ) {
        let near = camera.unproject(&pixel).unwrap().at(distance_mm);
        let point = near + fabkit_camera::Vector3::from(sideways_mm);
        let Ok(pixel) = camera.project(&point) else {
            return Ok(()); // moved beyond the limit or in front of the interface
        };
        let ray = camera.unproject(&pixel).unwrap();
        let to_point = point - ray.origin_in_camera;
        let miss = to_point.cross(&ray.direction).norm() / point.coords.norm();
        prop_assert!(miss < 1e-12, "{name} at {pixel}: passes {miss:e} beside");
    }
}

#[test]
fn fisheyes_see_behind_themselves() {
    for (name, lens, most_rad) in common::lenses().into_iter().skip(3) {
        assert!(most_rad > 99.9f64.to_radians(), "{name} ends at {most_rad}");
        let camera = Camera::new(640, 480, lens, Interface::None).unwrap();
        let (sin, cos) = most_rad.sin_cos();
        let pixel = camera.project(&Point3::new(7.0 * sin, 0.0, 7.0 * cos)).unwrap();
        let ray = camera.unproject(&pixel).unwrap();
        assert!(ray.direction.z < -0.17, "{name}: {}", ray.direction);
        assert!((ray.direction.z - cos).abs() < 1e-12, "{name}: {}", ray.direction);
    }
}

#[test]
fn pixels_up_to_the_limit_have_rays() {
    for (name, lens, _) in common::lenses() {
        let camera = Camera::new(640, 480, lens, Interface::None).unwrap();
        let limit_rad = camera.angle_limit_rad();
        // In 72 directions, as tangential terms make the limit matter in one of them.
        for (step, fraction) in (0..72).zip([0.9, 0.99, 0.999, 0.9999].into_iter().cycle()) {
            let azimuth = f64::from(step).to_radians() * 5.0;
            let (sin, cos) = (fraction * limit_rad).sin_cos();
            let direction = Point3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
            let pixel: Point2<f64> = camera.project(&direction).unwrap();
            let ray = camera.unproject(&pixel).unwrap();
            // The pixel hardly depends on the angle here: 1e-16 px of 1e3 px, over the slope.
            let angle = ray.direction.dot(&direction.coords).min(1.0).acos();
            assert!(angle < 1e-7, "{name} at {fraction} of the limit: {angle:e}");
            let again = camera.project(&Point3::from(ray.direction)).unwrap();
            let scale = pixel.coords.norm().max(1e3);
            assert!((again - pixel).norm() < 1e-12 * scale, "{name}: {again} {pixel}");
        }
    }
}
