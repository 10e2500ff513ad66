//! Poses from domes that are seated differently in each capture, and pins with play: checks that the covariance
//! predicts their errors.
//!
//! `FABKIT_TRIALS=200 cargo test --release -p fabkit-calibration --test solver reseated:: -- --nocapture` runs more
//! trials.

use crate::support::{assembled, camera, captures, nominal, pins};
use fabkit_calibration::extrinsics::{CalibrationOptions, Medium, calibrate};
use fabkit_calibration::model::{Contact, Model, Observation};
use fabkit_geometry::sequences::SplitMix64;
use nalgebra::{DVector, Rotation3, Vector2, Vector3};

/// Standard deviations of the play and of the dome's seat.
const PLAY_MM: f64 = 0.15;
const SHIFT_MM: f64 = 0.1;
const TURN_RAD: f64 = 0.3 * std::f64::consts::PI / 180.0;
const NOISE_PX: f64 = 0.1;
/// Offset of a mark from its pin's tip in all presses of that pin, each coordinate, if it is unknown to the fit.
const MARK_PX: f64 = 4.0;
/// Centre of the dome's turns, sensor frame, mm.
const SEAT: Vector3<f64> = Vector3::new(0.0, 0.0, 6.0);

/// Returns the squared error of a pose relative to its covariance (NEES), and the ratios of jackknife to claimed
/// standard deviations; `None` if the choice changed lens or gel, which is not tested here.
fn trial(lengths: &[(&str, f64)], mark_px: f64, seed: u64) -> Option<(f64, [f64; 6])> {
    let all = pins(lengths);
    let mut random = SplitMix64::new(seed);
    let truth = Model::new(camera(), assembled(0.0));
    let mut observations = Vec::new();
    let mut of_marks = SplitMix64::new(!seed);
    let marks: Vec<Vector2<f64>> =
        all.iter().map(|_| mark_px * Vector2::from_fn(|_, _| of_marks.normal())).collect();
    for (capture, pins) in captures(&all, 30, 5, &mut random).iter().enumerate() {
        let mut motion = |sigma: f64| sigma * Vector3::from_fn(|_, _| random.normal());
        let (shift, turn) = (motion(SHIFT_MM), Rotation3::new(motion(TURN_RAD)));
        for pin in pins {
            let place = pin.contact_in_sensor_mm + motion(PLAY_MM);
            let place = SEAT + turn * (place.coords - SEAT) + shift;
            let seen = truth.camera.project(&truth.camera_from_sensor.point(place.into())).ok()?;
            let noise: Vector3<f64> = motion(NOISE_PX);
            let contact = Contact {
                capture,
                hole: pin.hole,
                contact_in_sensor_mm: pin.contact_in_sensor_mm,
                axis_in_sensor: pin.axis_in_sensor,
            };
            let mark = all.iter().zip(&marks).find(|(other, _)| other == pin).map(|(_, mark)| mark);
            let pixel = seen + mark.unwrap() + Vector2::new(noise.x, noise.y);
            observations.push(Observation { contact, pixel, sigma_px: NOISE_PX });
        }
    }
    let start = assembled(0.0);
    let options = CalibrationOptions::default();
    let result =
        calibrate(&camera().into(), &observations, &start, Some(&nominal()), &options).ok()?;
    let optics = result.chosen_trial().candidate.optics;
    if optics.radial_terms > 0 || optics.medium != Medium::Given {
        return None;
    }
    let (found, drawn) = (&result.model().camera_from_sensor, &truth.camera_from_sensor);
    let turn = Rotation3::from_matrix_unchecked(found.rotation() * drawn.rotation().transpose());
    let (turn, shift) = (turn.scaled_axis(), found.translation_mm() - drawn.translation_mm());
    let error = DVector::from_iterator(6, turn.iter().chain(shift.iter()).copied());
    let covariance = result.covariance.view((0, 0), (6, 6)).into_owned();
    let nees = error.dot(&covariance.cholesky()?.solve(&error));
    Some((nees, result.jackknife_ratio()?))
}

#[test]
fn covariances_know_of_reseated_domes() {
    let trials = std::env::var("FABKIT_TRIALS").ok().and_then(|n| n.parse().ok()).unwrap_or(6u32);
    let two = &[("short", 0.7), ("long", 1.35)][..];
    for (lengths, mark_px) in [(two, 0.0), (&two[1..], 0.0), (two, MARK_PX)] {
        let all: Vec<_> =
            (0..trials).filter_map(|seed| trial(lengths, mark_px, seed.into())).collect();
        let count = all.len() as f64;
        let nees = all.iter().map(|(nees, _)| nees).sum::<f64>() / count;
        let ratios: [f64; 6] =
            std::array::from_fn(|i| all.iter().map(|(_, ratio)| ratio[i]).sum::<f64>() / count);
        println!(
            "{} lengths, marks off by {mark_px} px: NEES {nees:.2} in {count} of {trials}, jackknife {ratios:.2?}",
            lengths.len()
        );
        assert!(
            count == f64::from(trials),
            "another lens or gel in {} trials",
            trials - all.len() as u32
        );
        // Chi squared of six freedoms: 12 / n of variance over n trials. Three of its deviations.
        assert!((nees - 6.0).abs() < 3.0 * (12.0 / count).sqrt(), "{nees}");
        // What marks share all captures share: leaving one out shows little of it.
        let as_claimed = |ratio: &f64| (0.9..1.1).contains(ratio) || mark_px > 0.0;
        assert!(ratios.iter().all(as_claimed), "{ratios:?}");
    }
}
