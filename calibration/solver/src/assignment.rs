//! Assignment of marks to holes.
//!
//! Labels say which holes had pins, not which mark belongs to which hole, and they may be wrong. Sorting marks by their
//! distance from the centre, as is often done, confuses the holes of one ring. Here the holes are projected, and each
//! mark is assigned to the nearest one. The resulting pose is fitted robustly, and both steps are repeated until
//! nothing changes. The start is the designed pose, turned about the sensor's axis by the angle that fits the marks
//! best, because cameras are mounted at any of several angles.

use std::f64::consts::TAU;

use fabkit_camera::Camera;
use fabkit_geometry::{Angle, Pose};
use nalgebra::Point2;

use crate::extrinsics::{Loss, refine};
use crate::landmarks::PinLandmark;
use crate::model::{Contact, FitParameter, Model, Observation};

/// Number of turns about the sensor's axis that are tried if labels can distinguish them.
const TURNS: usize = 24;
/// Largest distance between a mark and its hole, projected with the designed pose, as a fraction of the image's shorter
/// side.
const FIRST_GATE: f64 = 0.2;
/// Largest distance between a mark and its hole after a fit, as a multiple of the median distance.
const GATE: f64 = 5.0;
/// Lower bound of that distance, px.
const MIN_GATE_PX: f64 = 8.0;
/// Largest number of rounds of assigning and fitting.
const ROUNDS: usize = 10;
/// Huber threshold of the fits between rounds, in units of [`PROVISIONAL_SIGMA_PX`].
const HUBER: f64 = 1.5;
/// Standard deviation assumed while assigning, px: pins have play, and the camera is not yet refined.
const PROVISIONAL_SIGMA_PX: f64 = 4.0;

/// Mark that was detected, or measured by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Centre of the mark, px.
    pub pixel: Point2<f64>,
    /// Standard deviation of each coordinate, px.
    pub sigma_px: f64,
}

/// Marks of one capture, with the pins that may have made them.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkedCapture<'a> {
    /// All marks, including those that no pin made.
    pub marks: Vec<Mark>,
    /// Pins that may have made the marks.
    pub pins: Vec<&'a PinLandmark>,
    /// True if `pins` comes from a label, which should be complete; otherwise it lists all pins that exist.
    pub is_labelled: bool,
}

/// Result of an assignment.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// Marks with their contacts, sorted by capture and then hole.
    pub observations: Vec<Observation>,
    /// Marks and labels that do not fit together.
    pub discrepancies: Vec<Discrepancy>,
    /// Model with the pose that the assignment implies.
    pub model: Model,
}

/// Difference between a capture and its label.
///
/// ```
/// use fabkit_calibration::assignment::{Discrepancy, Mark, MarkedCapture, assign};
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9], "6": [12, 0, 9], "7": [-12, 0, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let (camera, pose) = (Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// // Seven pins on the label, but only six marks.
/// let tips = landmarks.pins[..6].iter().map(|pin| pose.point(pin.contact_in_sensor_mm));
/// let pixels = tips.map(|tip| camera.project(&tip)).collect::<Result<Vec<_>, _>>()?;
/// let marks = pixels.into_iter().map(|pixel| Mark { pixel, sigma_px: 0.3 }).collect();
/// let pins = landmarks.pins.iter().collect();
/// let capture = MarkedCapture { marks, pins, is_labelled: true };
/// let assignment = assign(&camera, &pose, &[capture], &landmarks.pins).unwrap();
/// assert_eq!(assignment.discrepancies, [Discrepancy::Missing { capture: 0, hole: 7 }]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Discrepancy {
    /// A labelled pin has no mark.
    Missing {
        /// Index of the capture, from 0.
        capture: usize,
        /// Number of the hole.
        hole: u32,
    },
    /// A mark is at no labelled pin.
    Spurious {
        /// Index of the capture, from 0.
        capture: usize,
        /// Position of the mark, px.
        pixel: Point2<f64>,
    },
    /// A labelled hole has no mark, but a hole without label has one.
    Mislabelled {
        /// Index of the capture, from 0.
        capture: usize,
        /// Hole of the label.
        labelled: u32,
        /// Hole of the mark.
        found: u32,
    },
}

/// Assigns marks to holes.
///
/// `all` are the pins of the whole fixture, among which the true hole of a mislabelled pin is searched. If no capture
/// has a label, the turn about the sensor's axis is taken from `nominal`, because a dome's rings look the same under
/// some turns.
///
/// Returns `None` if from no turn three marks can be assigned to holes.
///
/// ```
/// use fabkit_calibration::assignment::{Mark, MarkedCapture, assign};
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::{Angle, Pose};
///
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let (camera, designed) = (Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// // The camera was mounted a quarter turn off its design, and the marks come in any order.
/// let mounted = designed.then_in(Pose::rotation_z(Angle::from_deg(90.0).unwrap()));
/// let seen = landmarks.pins.iter().rev().map(|pin| {
///     let pixel = camera.project(&mounted.point(pin.contact_in_sensor_mm))?;
///     Ok(Mark { pixel, sigma_px: 0.3 })
/// });
/// let marks = seen.collect::<Result<Vec<_>, fabkit_camera::OutsideDomain>>()?;
/// let pins = landmarks.pins.iter().collect();
/// let capture = MarkedCapture { marks, pins, is_labelled: true };
/// let found = assign(&camera, &designed, &[capture], &landmarks.pins).unwrap();
/// let holes: Vec<u32> = found.observations.iter().map(|o| o.contact.hole).collect();
/// assert_eq!(holes, [1, 2, 3, 4, 5]);
/// assert!((found.model.camera_from_sensor.rotation() - mounted.rotation()).norm() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn assign(
    camera: &Camera,
    nominal: &Pose,
    captures: &[MarkedCapture<'_>],
    all: &[PinLandmark],
) -> Option<Assignment> {
    let side_px = f64::from(camera.width_px().min(camera.height_px()));
    let first_gate_px = FIRST_GATE * side_px;
    let turns = if captures.iter().any(|c| c.is_labelled) { TURNS } else { 1 };
    let mut best: Option<(f64, Model, Vec<Observation>)> = None;
    for turn in 0..turns {
        let angle = Angle::from_rad(TAU * turn as f64 / turns as f64)?;
        let start = Model::new(*camera, nominal.then_in(Pose::rotation_z(angle)));
        let Some((model, observations, cost)) = assign_and_fit(start, captures, first_gate_px)
        else {
            continue;
        };
        if best.as_ref().is_none_or(|(lowest, ..)| cost < *lowest) {
            best = Some((cost, model, observations));
        }
    }
    let (_, model, observations) = best?;
    let discrepancies = find_discrepancies(&model, captures, &observations, all);
    Some(Assignment { observations, discrepancies, model })
}

/// Assigns and fits alternately. The returned cost adds each mark's squared distance, or that of the first gate for an
/// unassigned mark, so that turns with unassigned marks are not preferred.
fn assign_and_fit(
    mut model: Model,
    captures: &[MarkedCapture<'_>],
    first_gate_px: f64,
) -> Option<(Model, Vec<Observation>, f64)> {
    let marks: usize = captures.iter().map(|c| c.marks.len()).sum();
    let mut gate_px = first_gate_px;
    let mut previous = Vec::new();
    for _ in 0..ROUNDS {
        let observations = match_marks(&model, captures, gate_px);
        if observations.len() < 3 || observations == previous {
            break;
        }
        let provisional: Vec<Observation> = observations
            .iter()
            .map(|o| Observation { sigma_px: PROVISIONAL_SIGMA_PX, ..o.clone() })
            .collect();
        // If the fit fails, the next round still has a smaller gate.
        if let Ok(fit) = refine(&model, &FitParameter::POSE, &provisional, Loss::Huber(HUBER)) {
            model = fit.model;
        }
        let mut distances = distances_px(&model, &observations);
        distances.sort_by(f64::total_cmp);
        let typical_px = distances[distances.len() / 2];
        // The gate shrinks as the fit improves, but never below the play of pins or above the start.
        gate_px = (GATE * typical_px).clamp(MIN_GATE_PX, first_gate_px);
        previous = observations;
    }
    if previous.len() < 3 {
        return None;
    }
    let squares: f64 = distances_px(&model, &previous).iter().map(|d| d * d).sum();
    let unmatched = (marks - previous.len()) as f64;
    let cost = squares + unmatched * first_gate_px.powi(2);
    Some((model, previous, cost))
}

/// Pairs marks with pins, nearest first. Each is used once, and no pair is farther apart than `gate_px`.
fn match_marks(model: &Model, captures: &[MarkedCapture<'_>], gate_px: f64) -> Vec<Observation> {
    let mut observations = Vec::new();
    for (index, capture) in captures.iter().enumerate() {
        let contacts: Vec<Contact> =
            capture.pins.iter().map(|pin| contact_from_pin(pin, index)).collect();
        let projected: Vec<Option<Point2<f64>>> =
            contacts.iter().map(|contact| model.project(contact).ok()).collect();
        let mut pairs = Vec::new();
        for (p, pixel) in projected.iter().enumerate() {
            let Some(pixel) = pixel else { continue };
            for (m, mark) in capture.marks.iter().enumerate() {
                let distance_px = (mark.pixel - pixel).norm();
                if distance_px < gate_px {
                    pairs.push((distance_px, p, m));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut free_marks = vec![true; capture.marks.len()];
        let mut taken_holes = std::collections::BTreeSet::new();
        let mut found = Vec::new();
        for (_, p, m) in pairs {
            // The list may have two kinds of pin for one hole, but only one was in it.
            if free_marks[m] && taken_holes.insert(contacts[p].hole) {
                free_marks[m] = false;
                let Mark { pixel, sigma_px } = capture.marks[m];
                found.push(Observation { contact: contacts[p].clone(), pixel, sigma_px });
            }
        }
        found.sort_by_key(|o| o.contact.hole);
        observations.extend(found);
    }
    observations
}

/// Compares the assignment with the labels.
fn find_discrepancies(
    model: &Model,
    captures: &[MarkedCapture<'_>],
    observations: &[Observation],
    all: &[PinLandmark],
) -> Vec<Discrepancy> {
    let mut distances = distances_px(model, observations);
    distances.sort_by(f64::total_cmp);
    let typical_px = distances.get(distances.len() / 2).copied().unwrap_or(0.0);
    let gate_px = (GATE * typical_px).max(MIN_GATE_PX);
    let mut discrepancies = Vec::new();
    for (index, capture) in captures.iter().enumerate() {
        let here: Vec<&Observation> =
            observations.iter().filter(|o| o.contact.capture == index).collect();
        let missing =
            capture.pins.iter().map(|pin| pin.hole).filter(|hole| {
                capture.is_labelled && !here.iter().any(|o| o.contact.hole == *hole)
            });
        let mut missing: Vec<u32> = missing.collect();
        // Several kinds of pin may be listed for one hole.
        missing.dedup();
        for mark in &capture.marks {
            if here.iter().any(|o| o.pixel == mark.pixel) {
                continue;
            }
            let distance = |pin: &PinLandmark| {
                let pixel = model.project(&contact_from_pin(pin, index)).ok()?;
                Some(((pixel - mark.pixel).norm(), pin.hole)).filter(|(d, _)| *d < gate_px)
            };
            let nearest = all.iter().filter_map(distance).min_by(|a, b| a.0.total_cmp(&b.0));
            let labelled = |hole: u32| capture.pins.iter().any(|pin| pin.hole == hole);
            // A mark at an unlabelled hole explains a missing label, as long as one is left.
            match (nearest.filter(|(_, hole)| !labelled(*hole)), missing.is_empty()) {
                (Some((_, found)), false) => {
                    let labelled = missing.remove(0);
                    discrepancies.push(Discrepancy::Mislabelled {
                        capture: index,
                        labelled,
                        found,
                    });
                }
                _ => {
                    discrepancies.push(Discrepancy::Spurious { capture: index, pixel: mark.pixel })
                }
            }
        }
        discrepancies
            .extend(missing.into_iter().map(|hole| Discrepancy::Missing { capture: index, hole }));
    }
    discrepancies
}

fn distances_px(model: &Model, observations: &[Observation]) -> Vec<f64> {
    let distance = |o: &Observation| {
        model.project(&o.contact).map_or(f64::INFINITY, |pixel| (pixel - o.pixel).norm())
    };
    observations.iter().map(distance).collect()
}

/// Creates the contact of a pin in a capture.
fn contact_from_pin(pin: &PinLandmark, capture: usize) -> Contact {
    Contact {
        capture,
        hole: pin.hole,
        contact_in_sensor_mm: pin.contact_in_sensor_mm,
        axis_in_sensor: pin.axis_in_sensor,
    }
}
