//! Calibration dome for the tests.

pub mod trials;

use fabkit_calibration::landmarks::PinLandmark;
use fabkit_camera::{Camera, Interface, Intrinsics, KannalaBrandt, Lens};
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Angle, Point3, Pose, Vector3};

/// Returns pins in 29 holes on four rings and the tip of a 15 mm dome about (0, 0, 6). Each kind reaches its number of
/// mm inside the dome.
pub fn pins(reaches_mm: &[(&str, f64)]) -> Vec<PinLandmark> {
    let centre = Point3::new(0.0, 0.0, 6.0);
    let mut pins = Vec::new();
    let mut hole = 0;
    for (polar_deg, count) in [(0.0f64, 1), (18.0, 4), (36.0, 8), (54.0, 8), (72.0, 8)] {
        for k in 0..count {
            hole += 1;
            let (s, c) = polar_deg.to_radians().sin_cos();
            let (sa, ca) = (f64::from(k) * std::f64::consts::TAU / f64::from(count)).sin_cos();
            let outward = Vector3::new(s * ca, s * sa, c);
            for (kind, reach_mm) in reaches_mm {
                pins.push(PinLandmark {
                    hole,
                    kind: (*kind).into(),
                    tip_centre_in_sensor_mm: centre + outward * (16.0 - reach_mm),
                    contact_in_sensor_mm: centre + outward * (15.0 - reach_mm),
                    axis_in_sensor: Some(-outward),
                });
            }
        }
    }
    pins
}

/// Returns a camera with 640 x 480 px and 200 px per radian, without interface.
pub fn camera() -> Camera {
    with_interface(Interface::None)
}

/// Returns the same camera behind an interface.
pub fn with_interface(interface: Interface) -> Camera {
    let intrinsics = Intrinsics { fx_px: 200.0, fy_px: 200.0, cx_px: 322.0, cy_px: 238.0 };
    let lens = KannalaBrandt::new(intrinsics, [0.01, -0.002, 0.0, 0.0]).unwrap();
    Camera::new(640, 480, Lens::KannalaBrandt(lens), interface).unwrap()
}

/// Returns the designed pose of the camera, 7 mm below the sensor's origin.
pub fn nominal() -> Pose {
    Pose::translation(0.0, 0.0, 7.0)
}

/// Returns the true pose: slightly off the design, and turned as mounted.
pub fn assembled(turn_deg: f64) -> Pose {
    let degrees = |x: f64| Angle::from_deg(x).unwrap();
    Pose::translation(0.4, -0.3, 7.6)
        .then_in(Pose::rotation_x(degrees(1.2)))
        .then_in(Pose::rotation_y(degrees(-0.8)))
        .then_in(Pose::rotation_z(degrees(turn_deg)))
}

/// Draws captures of `per_capture` pins in different holes, of any kind, at random.
pub fn captures<'a>(
    pins: &'a [PinLandmark],
    count: usize,
    per_capture: usize,
    noise: &mut SplitMix64,
) -> Vec<Vec<&'a PinLandmark>> {
    let capture = |noise: &mut SplitMix64| {
        let mut chosen: Vec<&PinLandmark> = Vec::new();
        while chosen.len() < per_capture {
            let pin = &pins[noise.below(pins.len())];
            if chosen.iter().all(|other| other.hole != pin.hole) {
                chosen.push(pin);
            }
        }
        chosen.sort_by_key(|pin| pin.hole);
        chosen
    };
    (0..count).map(|_| capture(noise)).collect()
}
