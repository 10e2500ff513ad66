//! What a plan promises, and what a calibration says of a unit that is not the drawn one, against calibrations of captures
//! that were drawn at random: simulated.
//!
//! `FABKIT_TRIALS=200 cargo test --release -p fabkit-tests --test calibration planning:: -- --nocapture` does more of them.

mod bench;

use bench::{Bench, Trial, Wrong};
use fabkit_application::source::Source;
use fabkit_calibration::model::{MarkOffset, MarkOffsets};
use fabkit_calibration::planning::{CapturePlan, PlanInputs};
use fabkit_camera::{CameraEstimate, Vector2};
use fabkit_fixtures::{DrawnBodies, Project};

fn project(settings: &[&str]) -> Project {
    let settings: Vec<String> = settings.iter().map(|s| (*s).to_owned()).collect();
    Source::find("rtac0").unwrap().load(&settings).unwrap()
}

/// How far from what it promises a plan may be.
const PROMISED: f64 = 0.2;
/// Trials in the gate of the first case alone: each calibrates with every explanation.
const TRIALS: u64 = 6;

#[test]
fn plans_promise_what_simulated_calibrations_come_to() {
    let wanted = std::env::var("FABKIT_TRIALS").ok().and_then(|n| n.parse().ok());
    let trials: u64 = wanted.unwrap_or(TRIALS);
    let one = "fixtures.pin_dome.pins.lengths=[6mm]";
    let cases = if wanted.is_some() { 3 } else { 1 };
    for (name, settings, has_marks) in [
        ("two lengths, marks", &[][..], true),
        ("two lengths", &[], false),
        ("one length", &[one], false),
    ]
    .into_iter()
    .take(cases)
    {
        let project = project(settings);
        let sensor = &project.design.sensor;
        let forecast = project.pin_forecast().unwrap().unwrap();
        let lens = CameraEstimate::from(forecast.model.camera.without_interface());
        // Outwards, more for longer pins; known to a twentieth of a pixel and more.
        let marks = forecast.landmarks.pins.iter().map(|pin| {
            let place = pin.contact_in_sensor_mm;
            let out = if pin.kind == "long" { 0.3 } else { 0.1 };
            let by_px = out * Vector2::new(place.x, place.y);
            let sigma_px = 0.05 + 0.06 * by_px.norm();
            (
                place,
                MarkOffset {
                    offset_px: by_px,
                    by_depth: Vector2::zeros(),
                    by_light: [Vector2::zeros(); 2],
                    sigma_px,
                },
            )
        });
        let marks = MarkOffsets::new(marks.filter(|_| has_marks));
        let mut model = forecast.model.clone();
        model.mark_offsets = marks.clone();
        let plan = CapturePlan::new(&PlanInputs { model: &model, ..forecast.setup(&lens) });
        let captures = forecast.plan_in_turn(30, 5);
        let expected = plan.predict(&captures).unwrap();
        let bodies = DrawnBodies::new(sensor, lens.camera()).unwrap();
        let bench = Bench {
            touch: sensor.touch.as_ref().unwrap(),
            forecast: &forecast,
            bodies,
            marks,
            wrong: Wrong::Nothing,
        };
        let all: Vec<Trial> = (0..trials).filter_map(|seed| bench.trial(&captures, seed)).collect();
        let count = all.len() as f64;
        let found_mm = (all.iter().map(|trial| trial.square_mm2).sum::<f64>() / count).sqrt();
        let scatter = all.iter().filter_map(|trial| trial.scatter_px).sum::<f64>() / count;
        let mut models: Vec<&str> = all.iter().map(|trial| trial.model.as_str()).collect();
        models.sort_unstable();
        println!(
            "{name}: expected {:.4} mm and {:.2} px, {count} of {trials} calibrations {found_mm:.4} mm and {scatter:.2} px; ratio {:.2}; {models:?}",
            expected.surface_mm,
            expected.scatter_px,
            found_mm / expected.surface_mm,
        );
        assert_eq!(all.len() as u64, trials);
        assert!((scatter / expected.scatter_px - 1.0).abs() < 0.1, "{scatter}");
        // As if four unknowns counted: 1 / 8n of variance of a root mean square over n trials; three of its deviations.
        let chance = 3.0 * (8.0 * count).sqrt().recip();
        let ratio = found_mm / expected.surface_mm;
        assert!((ratio - 1.0).abs() < PROMISED.max(chance), "{name}: {ratio}");
    }
}

/// A unit that is not the drawn one is said to be another, or does no harm.
#[test]
fn wrong_hypotheses_are_flagged_or_harmless() {
    const HARMLESS_MM: f64 = 0.1;
    let wanted = std::env::var("FABKIT_TRIALS").ok().and_then(|n| n.parse().ok());
    let trials: u64 = wanted.unwrap_or(1);
    let project = project(&[]);
    let sensor = &project.design.sensor;
    let forecast = project.pin_forecast().unwrap().unwrap();
    let captures = forecast.plan_in_turn(30, 5);
    let all = [
        Wrong::Index(-0.08),
        Wrong::Ridge { px: 4.0, at: [420.0, 240.0], wide: 40.0 },
        Wrong::Nothing,
        Wrong::Index(0.08),
        Wrong::Face(1.0),
        Wrong::Face(-1.0),
    ];
    let cases = if wanted.is_some() { all.len() } else { 2 };
    for wrong in all.into_iter().take(cases) {
        let bodies = DrawnBodies::new(sensor, &forecast.model.camera.without_interface()).unwrap();
        let touch = sensor.touch.as_ref().unwrap();
        let marks = MarkOffsets::default();
        let bench = Bench { touch, forecast: &forecast, bodies, marks, wrong };
        let all: Vec<Trial> = (0..trials).filter_map(|seed| bench.trial(&captures, seed)).collect();
        let flagged = all.iter().filter(|trial| !trial.within_tolerances).count();
        let is_well =
            |trial: &&Trial| !trial.within_tolerances || trial.square_mm2 < HARMLESS_MM.powi(2);
        let well = all.iter().filter(is_well).count();
        let mean = all.iter().map(|trial| trial.square_mm2).sum::<f64>() / all.len() as f64;
        println!(
            "{wrong:?}: flagged in {flagged}, flagged or harmless in {well} of {trials}; surface {:.3} mm rms",
            mean.sqrt(),
        );
        assert!(well as f64 >= 0.95 * trials as f64, "{wrong:?}");
        if matches!(wrong, Wrong::Nothing) {
            assert!(flagged as f64 <= 0.05 * trials as f64, "the drawn unit is called another");
        }
    }
}
