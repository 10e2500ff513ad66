//! The pose solver on simulated pins: accuracy, honesty of its covariance, speed.

use crate::support::trials::{RANGES, camera, position, trial};
use fabkit_calibration::extrinsics::{Loss, solve_pose};
use fabkit_calibration::model::FitParameter;
use fabkit_geometry::sequences::SplitMix64;
use nalgebra::Vector6;

struct Outcome {
    median_mm: f64,
    mean_nees: f64,
    coverage: f64,
    micros: f64,
}

/// 1,000 trials.
fn outcome(depth_mm: f64) -> Outcome {
    let camera = camera();
    let mut noise = SplitMix64::new(7);
    let mut errors_mm = Vec::new();
    let (mut nees, mut covered, mut total) = (0.0, 0, 0);
    let mut elapsed = std::time::Duration::ZERO;
    for _ in 0..1000 {
        let (truth, observations) = trial(&camera, depth_mm, &mut noise);
        let start = std::time::Instant::now();
        let fit = solve_pose(&camera, &observations, None, Loss::Squares).unwrap();
        elapsed += start.elapsed();
        assert_eq!(fit.parameters, FitParameter::POSE);
        let found = fit.model.camera_from_sensor;
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
    for (depth_mm, limit_mm) in RANGES {
        let outcome = outcome(depth_mm);
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
