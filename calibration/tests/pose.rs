//! The pose solver on simulated pins: accuracy, honesty of its covariance, speed.

use fabkit_calibration::extrinsics::{Loss, solve_pose};
use fabkit_calibration::model::{Contact, Observation, Parameter};
use fabkit_camera::{Camera, Interface, Intrinsics, KannalaBrandt, Lens};
use fabkit_geometry::{Angle, Point3, Pose};
use nalgebra::{Vector2, Vector6};

/// Numbers that look random and are the same everywhere (splitmix64).
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Box and Muller's method.
    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx_px: 180.0, fy_px: 180.0, cx_px: 320.0, cy_px: 240.0 };
    let lens = KannalaBrandt::new(intrinsics, [0.01, -0.002, 0.0, 0.0]).unwrap();
    Camera::new(640, 480, Lens::KannalaBrandt(lens), Interface::None).unwrap()
}

/// 40 points spread over a 15 mm half sphere in a sunflower's spiral.
fn dome() -> Vec<Point3<f64>> {
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

struct Outcome {
    median_mm: f64,
    mean_nees: f64,
    coverage: f64,
    micros: f64,
}

/// 1,000 trials with the camera `depth_mm` below the dome's base, so that its rim is seen at
/// `atan2(15, depth)`.
fn trials(depth_mm: f64) -> Outcome {
    let camera = camera();
    let mut noise = Noise(7);
    let mut errors_mm = Vec::new();
    let (mut nees, mut covered, mut total) = (0.0, 0, 0);
    let mut elapsed = std::time::Duration::ZERO;
    for _ in 0..1000 {
        let degrees = |x: f64| Angle::from_deg(x).unwrap();
        let truth = Pose::translation(noise.normal() * 0.5, noise.normal() * 0.5, depth_mm)
            .then_in(Pose::rotation_x(degrees(2.0 * noise.normal())))
            .then_in(Pose::rotation_y(degrees(2.0 * noise.normal())))
            .then_in(Pose::rotation_z(degrees(360.0 * noise.uniform())));
        let observations: Vec<Observation> = dome()
            .into_iter()
            .map(|point| {
                let pixel = camera.project(&truth.point(point)).unwrap();
                let contact = Contact {
                    capture: 0,
                    hole: 1,
                    contact_in_sensor_mm: point,
                    axis_in_sensor: None,
                };
                let pixel = pixel + Vector2::new(noise.normal(), noise.normal()) * 0.3;
                Observation { contact, pixel, sigma_px: 0.3 }
            })
            .collect();
        let start = std::time::Instant::now();
        let fit = solve_pose(&camera, &observations, None, Loss::Squares).unwrap();
        elapsed += start.elapsed();
        assert_eq!(fit.parameters, Parameter::POSE);
        let found = fit.model.camera_from_sensor;
        let position = |pose: &Pose| *pose.inverse().translation_mm();
        errors_mm.push((position(&found) - position(&truth)).norm());
        // The step from what was found to the truth, in the fit's own parameters.
        let turn = truth.rotation() * found.rotation().transpose();
        let turn = nalgebra::Rotation3::from_matrix_unchecked(turn).scaled_axis();
        let shift = truth.translation_mm() - found.translation_mm();
        let error = Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z);
        let whitened = fit.covariance.clone().cholesky().unwrap().solve(&error);
        nees += error.dot(&whitened) / 1000.0;
        for i in 0..6 {
            total += 1;
            covered += usize::from(error[i].abs() < 1.959964 * fit.covariance[(i, i)].sqrt());
        }
    }
    errors_mm.sort_by(f64::total_cmp);
    Outcome {
        median_mm: errors_mm[500],
        mean_nees: nees,
        coverage: covered as f64 / total as f64,
        micros: elapsed.as_secs_f64() * 1e6 / 1000.0,
    }
}

/// The normalised estimation error squared of six parameters has mean 6 and variance 12: over
/// 1,000 trials its mean is within 0.3 by 2.7 standard deviations.
#[test]
fn forty_points_on_a_dome_give_an_accurate_pose_with_an_honest_covariance() {
    println!("rim at   median      NEES   95 %    one solve");
    for (depth_mm, limit_mm) in [(17.25, 0.062), (4.3, 0.016), (-3.46, 0.008)] {
        let outcome = trials(depth_mm);
        let angle_deg = 15f64.atan2(depth_mm).to_degrees();
        let Outcome { median_mm, mean_nees, coverage, micros } = outcome;
        println!(
            "{angle_deg:5.1} deg {median_mm:.4} mm  {mean_nees:.2}  {:.1} %  {micros:.0} us",
            100.0 * coverage
        );
        assert!(median_mm <= limit_mm, "{median_mm} mm at {angle_deg} degrees");
        assert!((5.7..=6.3).contains(&mean_nees), "{mean_nees} at {angle_deg} degrees");
        assert!((0.93..=0.97).contains(&coverage), "{coverage} at {angle_deg} degrees");
    }
}
