//! Plans compared with fits of captures that follow them.

use crate::support::{assembled, camera, pins};
use fabkit_calibration::extrinsics::{Loss, refine};
use fabkit_calibration::landmarks::PinLandmark;
use fabkit_calibration::model::{FitParameter, Model};
use fabkit_calibration::planning::{CapturePlan, PinTolerances, PlanInputs};
use fabkit_calibration::synthetic::SyntheticSensor;
use fabkit_calibration::uncertainty::surface_sigma;
use fabkit_camera::{CameraEstimate, DMatrix};
use fabkit_geometry::sequences::SplitMix64;
use fabkit_geometry::{Point3, Vector3};

const NOISE_PX: f64 = 0.3;

fn places(pins: &[PinLandmark]) -> Vec<(Point3<f64>, Vector3<f64>)> {
    pins.iter().map(|pin| (pin.contact_in_sensor_mm, -pin.axis_in_sensor.unwrap())).collect()
}

fn in_turn(pins: usize, captures: usize) -> Vec<Vec<usize>> {
    (0..captures).map(|c| (0..5).map(|k| (3 * c + 11 * k) % pins).collect()).collect()
}

struct Case {
    pins: Vec<PinLandmark>,
    model: Model,
    lens: CameraEstimate,
    looseness: PinTolerances,
}

impl Case {
    fn new() -> Self {
        let pins = pins(&[("short", 0.7), ("long", 1.35)]);
        let model = Model::new(camera(), assembled(0.0));
        Self { pins, model, lens: camera().into(), looseness: PinTolerances::default() }
    }

    fn plan(&self) -> CapturePlan {
        CapturePlan::new(&PlanInputs {
            model: &self.model,
            parameters: &FitParameter::POSE,
            lens: &self.lens,
            pins: &self.pins,
            is_seen: &vec![true; self.pins.len()],
            looseness: self.looseness,
            noise_px: NOISE_PX,
            places: &places(&self.pins),
        })
    }
}

/// With noise alone, a plan predicts the covariance of a fit.
#[test]
fn noise_alone_is_what_a_fit_says() {
    let case = Case::new();
    let captures = in_turn(case.pins.len(), 10);
    let expected = case.plan().predict(&captures).unwrap();
    let pressed: Vec<Vec<&PinLandmark>> =
        captures.iter().map(|c| c.iter().map(|pin| &case.pins[*pin]).collect()).collect();
    let seen = SyntheticSensor::new(case.model.clone(), 1).observe(&pressed, NOISE_PX).unwrap();
    let fit = refine(&case.model, &FitParameter::POSE, &seen, Loss::Squares).unwrap();
    let of = |(place, normal): &(Point3<f64>, Vector3<f64>)| {
        let sigma =
            surface_sigma(&fit.model, &FitParameter::POSE, &fit.covariance, *place, *normal);
        sigma.unwrap().point_mm.powi(2)
    };
    let places = places(&case.pins);
    let surface_mm = (places.iter().map(of).sum::<f64>() / places.len() as f64).sqrt();
    // The fit stands a noise away from where the plan does.
    assert!((expected.surface_mm / surface_mm - 1.0).abs() < 0.02, "{expected:?} {surface_mm}");
    assert!(!expected.seating_solved && expected.worst_mm >= expected.surface_mm);
}

#[test]
fn all_that_is_loose_makes_it_worse_and_captures_make_it_better() {
    let tight = Case::new();
    let captures = in_turn(tight.pins.len(), 10);
    let of = |case: &Case| case.plan().predict(&captures).unwrap().surface_mm;
    let least = of(&tight);
    let loosened: [fn(&mut PinTolerances); 5] = [
        |l| l.across_mm = 0.1,
        |l| l.along_mm = 0.1,
        |l| l.seating_mm = 0.1,
        |l| l.dome_mm = [0.1; 3],
        |l| l.dome_rad = [0.005; 3],
    ];
    for (i, loosen) in loosened.into_iter().enumerate() {
        let mut case = Case::new();
        loosen(&mut case.looseness);
        assert!(of(&case) > 1.01 * least, "{i}");
    }
    // A lens that errs.
    let count = camera().parameters().len();
    let mut covariance = DMatrix::zeros(count, count);
    covariance[(0, 0)] = 1.0;
    covariance[(1, 1)] = 1.0;
    let lens = CameraEstimate::new(camera(), Some(covariance)).unwrap();
    assert!(of(&Case { lens, ..Case::new() }) > 1.01 * least);
    // Four times as many: half of it.
    let [few, many] =
        [10, 40].map(|n| tight.plan().predict(&in_turn(tight.pins.len(), n)).unwrap());
    assert!((few.surface_mm / many.surface_mm - 2.0).abs() < 0.1, "{few:?} {many:?}");
}

/// The depth of the pins is solved for if two lengths of pins determine it, even if it is far off.
#[test]
fn seating_is_solved_for_where_that_helps() {
    let mut case = Case::new();
    case.looseness.seating_mm = 2.0;
    let captures = in_turn(case.pins.len(), 40);
    let two = case.plan().predict(&captures).unwrap();
    assert!(two.seating_solved, "{two:?}");
    case.pins.retain(|pin| pin.kind == "long");
    let one = case.plan().predict(&in_turn(case.pins.len(), 40)).unwrap();
    assert!(!one.seating_solved && one.surface_mm > 1.5 * two.surface_mm, "{one:?} {two:?}");
}

#[test]
fn what_is_pressed_next_is_better_than_anything_at_random() {
    let mut case = Case::new();
    case.looseness =
        PinTolerances { across_mm: 0.05, dome_mm: [0.05; 3], ..PinTolerances::default() };
    let plan = case.plan();
    let hole = |pin: usize| case.pins[pin].hole;
    let may = |pin: usize, chosen: &[usize]| chosen.iter().all(|other| hole(*other) != hole(pin));
    let mut chosen = Vec::new();
    for _ in 0..4 {
        let (next, _) = plan.choose_next_capture(&chosen, 5, may);
        assert_eq!(next.len(), 5);
        chosen.push(next);
    }
    let best = plan.predict(&chosen).unwrap().surface_mm;
    let mut random = SplitMix64::new(1);
    for _ in 0..100 {
        let captures: Vec<Vec<usize>> =
            (0..4).map(|_| (0..5).map(|_| random.below(case.pins.len())).collect()).collect();
        if let Some(other) = plan.predict(&captures) {
            assert!(best < other.surface_mm, "{best} {other:?}");
        }
    }
}
