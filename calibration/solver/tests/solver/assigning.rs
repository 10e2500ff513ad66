//! Assignment of marks to holes, with labels that may be wrong.

use crate::support::{assembled, camera, captures, nominal, pins};
use fabkit_calibration::assignment::{Assignment, Discrepancy, Mark, MarkedCapture, assign};
use fabkit_calibration::landmarks::PinLandmark;
use fabkit_calibration::model::{Model, Observation};
use fabkit_calibration::synthetic::SyntheticSensor;
use fabkit_geometry::sequences::SplitMix64;
use nalgebra::Point2;
use proptest::prelude::*;

struct Case<'a> {
    truth: Vec<Observation>,
    captures: Vec<MarkedCapture<'a>>,
}

/// Returns captures with 0.15 mm of play, and marks in random order.
fn case<'a>(pins: &'a [PinLandmark], turn_deg: f64, seed: u64, labelled: bool) -> Case<'a> {
    let mut noise = SplitMix64::new(seed);
    let chosen = captures(pins, 8, 5, &mut noise);
    let mut bench = SyntheticSensor::new(Model::new(camera(), assembled(turn_deg)), seed + 1000);
    bench.play_mm = 0.15;
    let truth = bench.observe(&chosen, 0.1).unwrap();
    let captures = (0..chosen.len())
        .map(|i| {
            let here = truth.iter().filter(|o| o.contact.capture == i);
            let mut marks: Vec<Mark> =
                here.map(|o| Mark { pixel: o.pixel, sigma_px: 0.1 }).collect();
            let turn = noise.below(marks.len());
            marks.rotate_left(turn);
            let pins = if labelled { chosen[i].clone() } else { pins.iter().collect() };
            MarkedCapture { marks, pins, is_labelled: labelled }
        })
        .collect();
    Case { truth, captures }
}

fn holes(observations: &[Observation]) -> Vec<(usize, u32, Point2<f64>)> {
    observations.iter().map(|o| (o.contact.capture, o.contact.hole, o.pixel)).collect()
}

fn assigned(case: &Case, pins: &[PinLandmark]) -> Assignment {
    assign(&camera(), &nominal(), &case.captures, pins).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    /// The camera may be turned by any angle in its holder.
    #[test]
    fn labelled_marks_find_their_holes(turn_deg in 0.0..360.0f64, seed in 0u64..1000) {
        let pins = pins(&[("a", 0.5)]);
        let case = case(&pins, turn_deg, seed, true);
        let assignment = assigned(&case, &pins);
        prop_assert_eq!(holes(&assignment.observations), holes(&case.truth));
        prop_assert!(assignment.discrepancies.is_empty(), "{:?}", assignment.discrepancies);
    }

    /// Without labels the turn must be near the design's, because the rings look the same under some turns.
    #[test]
    fn unlabelled_marks_find_their_holes_too(turn_deg in -10.0..10.0f64, seed in 0u64..1000) {
        let pins = pins(&[("a", 0.5)]);
        let case = case(&pins, turn_deg, seed, false);
        let assignment = assigned(&case, &pins);
        prop_assert_eq!(holes(&assignment.observations), holes(&case.truth));
        prop_assert!(assignment.discrepancies.is_empty(), "{:?}", assignment.discrepancies);
    }
}

#[test]
fn a_missing_pin_a_speck_and_a_wrong_label_are_named() {
    let pins = pins(&[("a", 0.5)]);
    let mut case = case(&pins, 90.0, 5, true);
    let gone = &case.truth[2];
    assert_eq!(gone.contact.capture, 0);
    case.captures[0].marks.retain(|mark| mark.pixel != gone.pixel);
    // A speck far from all holes of the fixture: between the rings.
    let speck = Point2::new(60.0, 60.0);
    case.captures[1].marks.push(Mark { pixel: speck, sigma_px: 0.1 });
    let found = case.captures[2].pins[3].hole;
    let labelled = (20..).find(|h| case.captures[2].pins.iter().all(|pin| pin.hole != *h)).unwrap();
    case.captures[2].pins[3] = pins.iter().find(|pin| pin.hole == labelled).unwrap();
    let assignment = assigned(&case, &pins);
    assert_eq!(
        assignment.discrepancies,
        [
            Discrepancy::Missing { capture: 0, hole: gone.contact.hole },
            Discrepancy::Spurious { capture: 1, pixel: speck },
            Discrepancy::Mislabelled { capture: 2, labelled, found },
        ]
    );
    let right: Vec<_> = holes(&case.truth)
        .into_iter()
        .filter(|(c, h, _)| (*c, *h) != (0, gone.contact.hole) && (*c, *h) != (2, found))
        .collect();
    assert_eq!(holes(&assignment.observations), right);
}

#[test]
fn no_marks_give_no_assignment() {
    let pins = pins(&[("a", 0.5)]);
    let empty =
        MarkedCapture { marks: Vec::new(), pins: pins.iter().collect(), is_labelled: false };
    assert!(assign(&camera(), &nominal(), &[empty], &pins).is_none());
}
