//! Which mark is which hole.
//!
//! Labels say which holes had pins, not which mark is which, and may be wrong. Sorting marks by
//! their distance from the centre, as is often done, mixes up the holes of one ring. Here the
//! holes are projected and each mark goes to the nearest one; the pose that this gives is fitted
//! robustly, and all is repeated until nothing changes. The start is the design's pose, turned
//! about the sensor's axis as the marks want it: cameras get mounted in any of several turns.

use std::f64::consts::TAU;

use fabkit_camera::Camera;
use fabkit_geometry::{Angle, Pose};
use nalgebra::Point2;

use crate::extrinsics::{Loss, refine};
use crate::landmarks::PinLandmark;
use crate::model::{Contact, FitParameter, Model, Observation};

/// Turns tried about the sensor's axis where labels tell them apart.
const TURNS: usize = 24;
/// Farthest a mark may be from where the design's pose puts its hole, in parts of the picture's
/// shorter side.
const FIRST_GATE: f64 = 0.2;
/// Once fitted, a mark belongs to no hole if it is this many times the typical distance away.
const GATE: f64 = 5.0;
/// Or less than this, px.
const MIN_GATE_PX: f64 = 8.0;
/// Rounds of assigning and fitting.
const ROUNDS: usize = 10;
/// Robust limit of the fits between rounds, in units of [`PROVISIONAL_SIGMA_PX`].
const HUBER: f64 = 1.5;
/// Standard deviation assumed while assigning: pins play, and the camera is not yet refined.
const PROVISIONAL_SIGMA_PX: f64 = 4.0;

/// A mark as detected, or measured by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Its centre, px.
    pub pixel: Point2<f64>,
    /// Standard deviation of each coordinate, px.
    pub sigma_px: f64,
}

/// What is known of one capture.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkedCapture<'a> {
    /// All marks, pins or not.
    pub marks: Vec<Mark>,
    /// The pins that may have made them.
    pub pins: Vec<&'a PinLandmark>,
    /// Whether `pins` is a label, which should be complete; otherwise it is all that exist.
    pub labelled: bool,
}

/// The result.
#[derive(Clone, Debug)]
pub struct Assignment {
    /// Marks with their holes, by capture and then hole.
    pub observations: Vec<Observation>,
    /// What did not fit.
    pub discrepancies: Vec<Discrepancy>,
    /// The pose that the assignment implies.
    pub model: Model,
}

/// Something about a capture that is not as its label says.
#[derive(Clone, Debug, PartialEq)]
pub enum Discrepancy {
    /// A labelled pin has no mark.
    Missing {
        /// Counts from 0.
        capture: usize,
        /// Number of the hole.
        hole: u32,
    },
    /// A mark is not where a labelled pin would be.
    Spurious {
        /// Counts from 0.
        capture: usize,
        /// Where.
        pixel: Point2<f64>,
    },
    /// A labelled hole has no mark, but another one has.
    Mislabelled {
        /// Counts from 0.
        capture: usize,
        /// What the label says.
        labelled: u32,
        /// Where the mark is.
        found: u32,
    },
}

/// Assigns marks to holes.
///
/// `all` are the pins of the whole fixture, among which the true hole of a mislabelled pin is
/// looked for. Without a single label the turn about the sensor's axis is taken from `nominal`:
/// a dome's rings look the same under some turns.
///
/// `None` where fewer than three marks find a hole from any turn.
pub fn assign(
    camera: &Camera,
    nominal: &Pose,
    captures: &[MarkedCapture<'_>],
    all: &[PinLandmark],
) -> Option<Assignment> {
    let side_px = f64::from(camera.width_px().min(camera.height_px()));
    let first_gate_px = FIRST_GATE * side_px;
    let turns = if captures.iter().any(|c| c.labelled) { TURNS } else { 1 };
    let mut best: Option<(f64, Model, Vec<Observation>)> = None;
    for turn in 0..turns {
        let angle = Angle::from_rad(TAU * turn as f64 / turns as f64)?;
        let start = Model::new(*camera, nominal.then_in(Pose::rotation_z(angle)));
        let Some((model, observations, cost)) = settle(start, captures, first_gate_px) else {
            continue;
        };
        if best.as_ref().is_none_or(|(lowest, ..)| cost < *lowest) {
            best = Some((cost, model, observations));
        }
    }
    let (_, model, observations) = best?;
    let discrepancies = discrepancies(&model, captures, &observations, all);
    Some(Assignment { observations, discrepancies, model })
}

/// Assigns and fits in turns. The cost counts each mark by its squared distance up to the gate, so
/// that turns which leave marks over are not preferred.
fn settle(
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
        if let Ok(fit) = refine(&model, &FitParameter::POSE, &provisional, Loss::Huber(HUBER)) {
            model = fit.model;
        }
        let mut distances = distances_px(&model, &observations);
        distances.sort_by(f64::total_cmp);
        let typical_px = distances[distances.len() / 2];
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

/// Pairs of mark and pin, the nearest first, each used once and none farther than the gate.
fn match_marks(model: &Model, captures: &[MarkedCapture<'_>], gate_px: f64) -> Vec<Observation> {
    let mut observations = Vec::new();
    for (index, capture) in captures.iter().enumerate() {
        let contacts: Vec<Contact> =
            capture.pins.iter().map(|pin| contact_of(pin, index)).collect();
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
            // Two kinds of pin may stand in the list for one hole; only one was in it.
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

fn discrepancies(
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
        let missing = capture
            .pins
            .iter()
            .map(|pin| pin.hole)
            .filter(|hole| capture.labelled && !here.iter().any(|o| o.contact.hole == *hole));
        let mut missing: Vec<u32> = missing.collect();
        missing.dedup();
        for mark in &capture.marks {
            if here.iter().any(|o| o.pixel == mark.pixel) {
                continue;
            }
            let distance = |pin: &PinLandmark| {
                let pixel = model.project(&contact_of(pin, index)).ok()?;
                Some(((pixel - mark.pixel).norm(), pin.hole)).filter(|(d, _)| *d < gate_px)
            };
            let nearest = all.iter().filter_map(distance).min_by(|a, b| a.0.total_cmp(&b.0));
            let labelled = |hole: u32| capture.pins.iter().any(|pin| pin.hole == hole);
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

fn contact_of(pin: &PinLandmark, capture: usize) -> Contact {
    Contact {
        capture,
        hole: pin.hole,
        contact_in_sensor_mm: pin.contact_in_sensor_mm,
        axis_in_sensor: pin.axis_in_sensor,
    }
}
