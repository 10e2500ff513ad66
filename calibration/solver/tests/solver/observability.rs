//! Predictions against numbers that follow by other means.

use fabkit_calibration::landmarks::PinLandmark;
use fabkit_calibration::model::{Axis, Contact, FitParameter, Model};
use fabkit_calibration::observability::{PressPlan, predict};
use fabkit_camera::{Camera, FlatInterface, Interface};
use fabkit_geometry::{Point3, Pose, Vector3};
use nalgebra::Vector2;

const EFFORT: PressPlan = PressPlan { captures: 30, pins_per_capture: 5, sigma_px: 0.3 };

/// Pins of the given reach short of a 15 mm dome about (0, 0, 6), 29 holes on four rings.
fn pins(reaches_mm: &[(&str, f64)]) -> Vec<PinLandmark> {
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

fn camera() -> Camera {
    Camera::equidistant(640, 480, 160f64.to_radians()).unwrap()
}

fn pose() -> Pose {
    Pose::translation(0.3, -0.2, 7.0)
}

fn with_seating() -> Vec<FitParameter> {
    [&FitParameter::POSE[..], &[FitParameter::SeatingOffset]].concat()
}

#[test]
fn one_length_of_pins_does_not_show_its_offset() {
    let prediction = predict(&camera(), &pose(), &pins(&[("a", 0.5)]), EFFORT, &with_seating());
    assert!(!prediction.is_observable(FitParameter::SeatingOffset));
    assert_eq!(prediction.unobservable.len(), 1, "{prediction:?}");
    let singular = &prediction.unobservable[0];
    let names: Vec<FitParameter> = singular.terms.iter().map(|(parameter, _)| *parameter).collect();
    assert_eq!(names, [FitParameter::SeatingOffset, FitParameter::Translation(Axis::Z)]);
    // Scaling about the dome's centre at distance d in front of the camera: a seating offset s
    // scales by 1 - s / 14.5 and hides behind a camera that comes closer by d s / 14.5.
    let [(_, by_seating), (_, by_z)] = [singular.terms[0], singular.terms[1]];
    let ratio = (by_z * FitParameter::Translation(Axis::Z).prior_sigma())
        / (by_seating * FitParameter::SeatingOffset.prior_sigma());
    assert!((ratio + 13.0 / 14.5).abs() < 1e-6, "{ratio}");
    // Exactly singular: nothing but the prior is known, and no number of captures helps.
    assert!(singular.remaining > 1.0 - 1e-9);
    let many = PressPlan { captures: 1_000_000, ..EFFORT };
    let prediction = predict(&camera(), &pose(), &pins(&[("a", 0.5)]), many, &with_seating());
    assert!(!prediction.is_observable(FitParameter::SeatingOffset));
}

#[test]
fn pins_of_two_lengths_tell_the_seating_offset() {
    let prediction =
        predict(&camera(), &pose(), &pins(&[("a", 0.5), ("b", 2.5)]), EFFORT, &with_seating());
    assert!(prediction.unobservable.is_empty(), "{prediction:?}");
    let sigma_mm = prediction.sigma(FitParameter::SeatingOffset).unwrap();
    assert!(sigma_mm < 0.2, "{sigma_mm}");
    // Rays meet at the camera. The offset moves the tips of both lengths by the same amount, so that only the
    // difference of 2 mm in 13.5 mm separates it from scale: about seven times worse than a position along the rays.
    let known = predict(&camera(), &pose(), &pins(&[("a", 0.5)]), EFFORT, &FitParameter::POSE);
    let z_mm = known.sigma(FitParameter::Translation(Axis::Z)).unwrap();
    assert!((2.0..40.0).contains(&(sigma_mm / z_mm)), "{sigma_mm} {z_mm}");
}

#[test]
fn more_captures_help_by_their_square_root() {
    let pins = pins(&[("a", 0.5)]);
    let few = predict(&camera(), &pose(), &pins, EFFORT, &FitParameter::POSE);
    let effort = PressPlan { captures: 120, ..EFFORT };
    let many = predict(&camera(), &pose(), &pins, effort, &FitParameter::POSE);
    // Up to the prior, which is 1e-4 of the information or less here.
    assert!((few.position_sigma_mm / many.position_sigma_mm - 2.0).abs() < 1e-3);
    assert!((few.rotation_sigma_deg / many.rotation_sigma_deg - 2.0).abs() < 1e-3);
}

#[test]
fn holes_that_the_camera_cannot_see_are_named() {
    let narrow = Camera::equidistant(640, 480, 50f64.to_radians()).unwrap();
    let prediction = predict(&narrow, &pose(), &pins(&[("a", 0.5)]), EFFORT, &FitParameter::POSE);
    assert!(prediction.invisible_holes.contains(&29) && !prediction.invisible_holes.contains(&1));
    let nothing = predict(&narrow, &pose(), &[], EFFORT, &FitParameter::POSE);
    assert_eq!(nothing.unobservable.len(), 6);
    assert_eq!(nothing.sigma(FitParameter::Rotation(Axis::X)), Some(0.1));
}

/// All derivatives of the model against central differences, with refraction and reseating.
#[test]
fn derivatives_agree_with_differences() {
    let plain = camera();
    let interface = Interface::Flat(FlatInterface::bare_in_air(5.0, 1.41));
    let camera =
        Camera::new(plain.width_px(), plain.height_px(), *plain.lens(), interface).unwrap();
    let mut model = Model::new(camera, pose());
    model.seating_offset_mm = 0.4;
    model.lean_mm = 0.3;
    model.reseatings = vec![[0.1, -0.2, 0.01]; 2];
    let mut parameters = with_seating();
    parameters.extend([FitParameter::Lean, FitParameter::FocalScale]);
    parameters.extend([FitParameter::Camera("k1"), FitParameter::Camera("interface_distance_mm")]);
    use fabkit_calibration::model::MountingError;
    parameters.extend(
        [MountingError::ShiftX, MountingError::ShiftY, MountingError::Turn]
            .map(|s| FitParameter::Reseating(1, s)),
    );
    parameters.push(FitParameter::Reseating(0, MountingError::Turn));
    let mut columns = vec![Vector2::zeros(); parameters.len()];
    for pin in pins(&[("a", 0.5)]).iter().step_by(5) {
        let contact = Contact {
            capture: 1,
            hole: pin.hole,
            contact_in_sensor_mm: pin.contact_in_sensor_mm,
            axis_in_sensor: pin.axis_in_sensor,
        };
        let pixel = model.differentiate(&contact, &parameters, &mut columns).unwrap();
        assert!((pixel - model.project(&contact).unwrap()).norm() < 1e-9);
        for (parameter, column) in parameters.iter().zip(&columns) {
            let step = 1e-5;
            let at = |step| model.stepped(&[*parameter], &[step]).unwrap().project(&contact);
            let difference = (at(step).unwrap() - at(-step).unwrap()) / (2.0 * step);
            // Central differences: curvature times step squared, and rounding of 1e-13 / 1e-5.
            let error = (difference - column).norm();
            assert!(error < 1e-6 * (1.0 + column.norm()), "{parameter}: {difference} {column}");
        }
    }
}
