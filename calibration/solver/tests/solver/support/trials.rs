//! Poses of a camera that sees 40 points on a dome.

use fabkit_calibration::model::{Contact, Observation};
use fabkit_camera::{Camera, Interface, Intrinsics, KannalaBrandt, Lens};
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Angle, Point3, Pose};
use nalgebra::Vector2;

/// Standard deviation of each pixel coordinate, px.
pub const SIGMA_PX: f64 = 0.3;

/// Distances of the camera below the dome's base, so that its rim is seen at `atan2(15, depth)`: 41, 74 and 103
/// degrees; each with the largest accepted median position error, mm.
pub const RANGES: [(f64, f64); 3] = [(17.25, 0.062), (4.3, 0.016), (-3.46, 0.008)];

/// Returns a fisheye camera that sees beyond 103 degrees.
pub fn camera() -> Camera {
    let intrinsics = Intrinsics { fx_px: 180.0, fy_px: 180.0, cx_px: 320.0, cy_px: 240.0 };
    let lens = KannalaBrandt::new(intrinsics, [0.01, -0.002, 0.0, 0.0]).unwrap();
    Camera::new(640, 480, Lens::KannalaBrandt(lens), Interface::None).unwrap()
}

/// Returns 40 points spread over a 15 mm half sphere in a sunflower's spiral.
pub fn dome() -> Vec<Point3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..40)
        .map(|k| {
            let z = 1.0 - f64::from(k) / 39.0;
            let (s, c) = (golden * f64::from(k)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Point3::new(15.0 * r * c, 15.0 * r * s, 15.0 * z)
        })
        .collect()
}

/// Draws a pose near `depth_mm` with any turn, and observations from it.
pub fn trial(camera: &Camera, depth_mm: f64, noise: &mut SplitMix64) -> (Pose, Vec<Observation>) {
    let degrees = |x: f64| Angle::from_deg(x).unwrap();
    let truth = Pose::translation(noise.normal() * 0.5, noise.normal() * 0.5, depth_mm)
        .then_in(Pose::rotation_x(degrees(2.0 * noise.normal())))
        .then_in(Pose::rotation_y(degrees(2.0 * noise.normal())))
        .then_in(Pose::rotation_z(degrees(360.0 * noise.unit())));
    let observe = |point: Point3<f64>| {
        let pixel = camera.project(&truth.point(point)).unwrap();
        let contact =
            Contact { capture: 0, hole: 1, contact_in_sensor_mm: point, axis_in_sensor: None };
        let pixel = pixel + Vector2::new(noise.normal(), noise.normal()) * SIGMA_PX;
        Observation { contact, pixel, sigma_px: SIGMA_PX }
    };
    (truth, dome().into_iter().map(observe).collect())
}

/// Returns the camera's position, sensor frame, mm.
pub fn position(camera_from_sensor: &Pose) -> nalgebra::Vector3<f64> {
    *camera_from_sensor.inverse().translation_mm()
}
