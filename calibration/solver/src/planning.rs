//! Planning of captures: predicts the error of the surface before anything is pressed, from the play of the pins, the
//! reseating of the dome, and the uncertainty of marks and lens.
//!
//! The solver weighs pins independently (`W`) and uses priors `P`. The true covariance `S` of the pins' errors
//! correlates the pins of a capture through the dome's seat, and all presses of one pin through the uncertainty of its
//! mark. With the derivatives `X` of the pixels by the solved parameters, and `B` by the fixed ones, which have the
//! covariance `C`, to first order
//!
//! ```text
//! A = X'WX + P        covariance = A^-1 (X'W S WX + P) A^-1 + G C G'        G = -A^-1 X'WB
//! ```
//!
//! A point of the surface moves with all parameters as in [`crate::uncertainty`]. Fixed are the lens and the depth of
//! all pins in their holes, unless solving for the depth is better. Simulated calibrations check these formulas (`cargo
//! test --release -p fabkit-tests --test calibration planning::`).

use fabkit_camera::CameraEstimate;
use fabkit_geometry::{Point3, Vector3};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x6, Matrix3, Vector2};

use crate::information::ScaledCholesky;
use crate::landmarks::PinLandmark;
use crate::model::{Contact, FitParameter, Model};
use crate::observability::position_covariance;
use crate::uncertainty::surface_derivatives;

/// Tolerances of pins and their dome, one standard deviation each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PinTolerances {
    /// Deviation of a tip across its pin, along each of two axes, mm.
    pub across_mm: f64,
    /// Deviation of a tip along its pin, mm.
    pub along_mm: f64,
    /// Common deviation of all tips along their pins, the same in all captures, mm.
    pub seating_mm: f64,
    /// Shift of the dome in a capture, along the sensor's axes, mm.
    pub dome_mm: [f64; 3],
    /// Turn of the dome in a capture, about axes parallel to the sensor's through the mean contact of its pins, rad.
    pub dome_rad: [f64; 3],
}

/// Inputs of a plan.
#[derive(Clone, Copy, Debug)]
pub struct PlanInputs<'a> {
    /// Model with camera, pose, and offsets of marks from tips.
    pub model: &'a Model,
    /// Parameters that will be solved for.
    pub parameters: &'a [FitParameter],
    /// Model's lens with the covariance of its own calibration.
    pub lens: &'a CameraEstimate,
    /// Pins that may be pressed.
    pub pins: &'a [PinLandmark],
    /// True for each pin that nothing hides.
    pub is_seen: &'a [bool],
    /// Tolerances of the pins.
    pub looseness: PinTolerances,
    /// Standard deviation of a mark's position in an image, each coordinate, px.
    pub noise_px: f64,
    /// Points of the surface with their outward unit normals, sensor frame, mm.
    pub places: &'a [(Point3<f64>, Vector3<f64>)],
}

/// Pins that may be pressed, with their contributions to the information.
///
/// ```
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::{FitParameter, Model};
/// use fabkit_calibration::planning::{CapturePlan, PinTolerances, PlanInputs};
/// use fabkit_camera::Camera;
/// use fabkit_geometry::{Point3, Pose, Vector3};
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9], "6": [12, 0, 9], "7": [-12, 0, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let camera = Camera::equidistant(640, 480, 2.8)?;
/// let plan = CapturePlan::new(&PlanInputs {
///     model: &Model::new(camera, Pose::translation(0.0, 0.0, 7.0)),
///     parameters: &FitParameter::POSE,
///     lens: &camera.into(),
///     pins: &landmarks.pins,
///     is_seen: &[true; 7],
///     looseness: PinTolerances { across_mm: 0.1, ..PinTolerances::default() },
///     noise_px: 0.3,
///     places: &[(Point3::new(0.0, 0.0, 15.0), Vector3::z())],
/// });
/// let surface_mm = |captures| plan.predict(&vec![vec![0, 1, 2, 3, 4]; captures]).unwrap().surface_mm;
/// // Four times as many captures halve the error; two pins do not determine a pose.
/// assert!((surface_mm(4) / surface_mm(16) - 2.0).abs() < 1e-6);
/// assert!(plan.predict(&[vec![0, 1]]).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CapturePlan {
    /// All parameters: those solved for, the seating offset, and the lens.
    parameters: Vec<FitParameter>,
    /// Number of parameters that are solved for; they come first.
    solved: usize,
    model: Model,
    /// Prior information of each solved parameter, one over the variance, or 0.
    priors: Vec<f64>,
    /// Covariance of the remaining parameters.
    fixed_covariance: DMatrix<f64>,
    pins: Vec<Pin>,
    /// Mean of `places`.
    surface: DMatrix<f64>,
    /// Matrix `D'D` of each place of the surface, where `D` are the derivatives of its point by all parameters, mm2 per
    /// unit squared.
    places: Vec<DMatrix<f64>>,
}

/// Pin in a hole that the camera sees.
#[derive(Clone, Debug)]
struct Pin {
    /// Index among the given pins.
    index: usize,
    /// Derivative of the pixel by all parameters.
    pixel_by_parameters: DMatrix<f64>,
    by_dome: Matrix2x6<f64>,
    /// Covariance of the pin's own error, independent in each press, px2.
    own_covariance_px2: Matrix2<f64>,
    /// Covariance of the mark's offset, the same error in each press, px2.
    mark_covariance_px2: Matrix2<f64>,
    /// Variance that the detector states, px2.
    stated: f64,
}

/// Expected result of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedErrors {
    /// Standard deviation of a surface point that a pixel shows, root mean square over the surface, mm.
    pub surface_mm: f64,
    /// Standard deviation of the surface point where it is largest, mm.
    pub worst_mm: f64,
    /// Standard deviation of the camera's position, root of the sum of squares over the axes, mm.
    pub position_mm: f64,
    /// Scatter of one pin's mark from capture to capture, root mean square distance, px.
    pub scatter_px: f64,
    /// True if solving for the depth of all pins is better than fixing it as drawn.
    pub seating_solved: bool,
}

impl CapturePlan {
    /// Computes the contribution of each pin and the surface's derivatives.
    pub fn new(setup: &PlanInputs<'_>) -> Self {
        let PlanInputs { model, parameters, lens, pins, .. } = *setup;
        let covariance = lens.covariance();
        let names = lens.names();
        let held = (0..if covariance.is_some() { names.len() } else { 0 })
            .map(|i| FitParameter::Camera(names[i]))
            .filter(|held| !parameters.contains(held));
        let place = |held: &FitParameter| match held {
            FitParameter::Camera(name) => names.iter().position(|found| found == name),
            _ => None,
        };
        let rest: Vec<FitParameter> =
            std::iter::once(FitParameter::SeatingOffset).chain(held).collect();
        // The seating offset comes first and is independent of the lens.
        let fixed_covariance = DMatrix::from_fn(rest.len(), rest.len(), |r, c| {
            let both = place(&rest[r]).zip(place(&rest[c]));
            let of_seating =
                if r == 0 && c == 0 { setup.looseness.seating_mm.powi(2) } else { 0.0 };
            covariance.zip(both).map_or(of_seating, |(matrix, at)| matrix[at])
        });
        let all = [parameters, &rest[..]].concat();
        // The dome turns about the middle of its pins.
        let middle = pins.iter().map(|pin| pin.contact_in_sensor_mm.coords).sum::<Vector3<f64>>()
            / pins.len().max(1) as f64;
        let seen = pins.iter().enumerate().zip(setup.is_seen).filter(|(_, is_seen)| **is_seen);
        let of_pin = |((index, pin), _): ((usize, &PinLandmark), &bool)| {
            Pin::new(index, pin, setup, &all, &middle)
        };
        let places: Vec<DMatrix<f64>> = setup
            .places
            .iter()
            .filter_map(|(place, normal)| surface_derivatives(model, &all, *place, *normal))
            .map(|by| by.point_mm_by_parameters.transpose() * &by.point_mm_by_parameters)
            .collect();
        let mut surface = DMatrix::zeros(all.len(), all.len());
        for place in &places {
            surface += place / places.len() as f64;
        }
        let prior = |parameter: &FitParameter| {
            model.prior(*parameter).map_or(0.0, |(_, sigma)| sigma.powi(-2))
        };
        Self {
            solved: parameters.len(),
            model: model.clone(),
            priors: parameters.iter().map(prior).collect(),
            fixed_covariance,
            pins: seen.filter_map(of_pin).collect(),
            surface,
            places,
            parameters: all,
        }
    }

    /// Returns the indices, among the given pins, of those that the camera sees.
    pub fn visible_pins(&self) -> impl Iterator<Item = usize> + '_ {
        self.pins.iter().map(|pin| pin.index)
    }

    /// Predicts the result of captures with these pins; `None` if they do not determine all solved parameters.
    pub fn predict(&self, captures: &[Vec<usize>]) -> Option<ExpectedErrors> {
        let captures = self.find_pins(captures);
        let of = |place: &DMatrix<f64>, covariance: &DMatrix<f64>| {
            trace_of_product(place, covariance).max(0.0)
        };
        let surface = |covariance: &DMatrix<f64>| of(&self.surface, covariance);
        // Once with the depth of all pins fixed, once with it solved for.
        let with = |also: usize| Some((also, self.covariance(&captures, self.solved + also)?));
        let both = [0, 1].into_iter().filter_map(with);
        let (also, covariance) = both.min_by(|a, b| surface(&a.1).total_cmp(&surface(&b.1)))?;
        let worst = self.places.iter().map(|place| of(place, &covariance)).fold(0.0, f64::max);
        let pose = &self.model.camera_from_sensor;
        let position = position_covariance(&covariance, &self.parameters, pose);
        Some(ExpectedErrors {
            surface_mm: surface(&covariance).sqrt(),
            worst_mm: worst.sqrt(),
            position_mm: position.trace().max(0.0).sqrt(),
            scatter_px: std::f64::consts::SQRT_2 * repeatability_px(&captures),
            seating_solved: also > 0,
        })
    }

    /// Chooses the pins of the next capture after `done`, greedily: each time the pin, among those that `may` accept
    /// next to the pins chosen before, that gives the surface the smallest error. Also returns that error, root mean
    /// square, mm, if only pins err.
    pub fn choose_next_capture(
        &self,
        done: &[Vec<usize>],
        count: usize,
        may: impl Fn(usize, &[usize]) -> bool,
    ) -> (Vec<usize>, f64) {
        // Without pins the information is singular; weak priors allow a start.
        // Only for the choice of pins; `predict` works without it.
        let vague: Vec<f64> =
            self.solved().iter().map(|parameter| parameter.prior_sigma().powi(-2)).collect();
        let vague = DMatrix::from_diagonal(&DVector::from_vec(vague));
        let before = vague + self.information(&self.find_pins(done));
        let size = self.solved;
        let surface = self.surface.view((0, 0), (size, size)).into_owned();
        let value = |pins: &[usize]| {
            let information = &before + self.information(&self.find_pins(&[pins.to_vec()]));
            let factor = ScaledCholesky::new(&information)?;
            Some(trace_of_product(&surface, &factor.inverse()).max(0.0).sqrt())
        };
        let (mut chosen, mut surface_mm) = (Vec::new(), f64::INFINITY);
        while chosen.len() < count {
            let with = |pin: usize| [&chosen[..], &[pin]].concat();
            let candidates = self.visible_pins().filter(|pin| may(*pin, &chosen));
            let best = candidates
                .filter_map(|pin| Some((pin, value(&with(pin))?)))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((pin, mm)) = best else { break };
            chosen.push(pin);
            surface_mm = mm;
        }
        (chosen, surface_mm)
    }

    fn find_pins(&self, captures: &[Vec<usize>]) -> Vec<Vec<&Pin>> {
        let find = |index: &usize| self.pins.iter().find(|pin| pin.index == *index);
        captures.iter().map(|capture| capture.iter().filter_map(find).collect()).collect()
    }

    /// Computes the information of captures if each is weighed by its true covariance.
    fn information(&self, captures: &[Vec<&Pin>]) -> DMatrix<f64> {
        let count = self.solved;
        let mut information = DMatrix::zeros(count, count);
        for capture in captures.iter().filter(|capture| !capture.is_empty()) {
            let (by, noise) = stacked(capture, count);
            let Some(factor) = noise.cholesky() else { continue };
            information += by.transpose() * factor.solve(&by);
        }
        information
    }

    fn solved(&self) -> &[FitParameter] {
        &self.parameters[..self.solved]
    }

    /// Computes the covariance of all parameters if the first `count` are solved for.
    fn covariance(&self, captures: &[Vec<&Pin>], count: usize) -> Option<DMatrix<f64>> {
        let all = self.parameters.len();
        let held = all - count;
        // If the seating offset is solved for, the first row of `of_held` is left out.
        let from = self.fixed_covariance.nrows() - held;
        let of_held = self.fixed_covariance.view((from, from), (held, held));
        // As the solver does: no pin counts as better than pins repeat.
        let floor = repeatability_px(captures).powi(2);
        let weight = |pin: &Pin| pin.stated.max(floor).recip();
        let mut information = DMatrix::zeros(count, all);
        let mut noise = DMatrix::zeros(count, count);
        for capture in captures {
            // Effect of the dome's seat in this capture on the solved parameters.
            let mut seat = DMatrix::zeros(count, 6);
            for pin in capture {
                let by_fit = pin.pixel_by_parameters.columns(0, count);
                let weighted = by_fit.transpose() * weight(pin);
                information += &weighted * &pin.pixel_by_parameters;
                noise += &weighted * pin.own_covariance_px2 * weighted.transpose();
                seat += &weighted * pin.by_dome;
            }
            noise += &seat * seat.transpose();
        }
        // All presses of a pin share the error of its mark's offset, so that their effects add up.
        for pin in &self.pins {
            let pressed = captures.iter().flatten().filter(|found| found.index == pin.index);
            let weighted = pin.pixel_by_parameters.columns(0, count).transpose() * weight(pin);
            let times = pressed.count() as f64;
            noise += &weighted * pin.mark_covariance_px2 * weighted.transpose() * times.powi(2);
        }
        let mut of_fit = information.columns(0, count).into_owned();
        for (i, prior) in self.priors.iter().enumerate() {
            of_fit[(i, i)] += prior;
            noise[(i, i)] += prior;
        }
        let inverse = ScaledCholesky::new(&of_fit)?.inverse();
        let mut by_held = DMatrix::identity(all, all).columns(count, held).into_owned();
        // The matrix G of the module's formula, above an identity for the fixed parameters themselves.
        by_held.rows_mut(0, count).copy_from(&(-&inverse * information.columns(count, held)));
        let mut covariance = &by_held * of_held * by_held.transpose();
        let mut of_pixels = covariance.view_mut((0, 0), (count, count));
        of_pixels += &inverse * noise * &inverse;
        Some(covariance)
    }
}

impl Pin {
    /// Computes a pin's derivatives and error covariances; `None` if the camera does not see it.
    fn new(
        index: usize,
        pin: &PinLandmark,
        setup: &PlanInputs<'_>,
        parameters: &[FitParameter],
        middle: &Vector3<f64>,
    ) -> Option<Self> {
        let PlanInputs { model, looseness, noise_px, .. } = *setup;
        // An index without reseating: the dome is at its nominal place.
        let contact = Contact {
            capture: usize::MAX,
            hole: pin.hole,
            contact_in_sensor_mm: pin.contact_in_sensor_mm,
            axis_in_sensor: pin.axis_in_sensor,
        };
        let mut columns = vec![Vector2::zeros(); parameters.len()];
        let pixel = model.differentiate(&contact, parameters, &mut columns).ok()?;
        if !model.camera.is_in_image(&pixel) {
            return None;
        }
        let by_place = model.pixel_by_contact(&contact).ok()?;
        let axis = pin.axis_in_sensor.unwrap_or_default();
        let along = axis * axis.transpose();
        let of_tip = (Matrix3::identity() - along) * looseness.across_mm.powi(2)
            + along * looseness.along_mm.powi(2);
        let by_turn = -by_place * (pin.contact_in_sensor_mm.coords - middle).cross_matrix();
        let by_dome = Matrix2x6::from_fn(|r, c| match c {
            0..3 => by_place[(r, c)] * looseness.dome_mm[c],
            _ => by_turn[(r, c - 3)] * looseness.dome_rad[c - 3],
        });
        let of_mark = model.mark_offsets.offset_at(&pin.contact_in_sensor_mm);
        let of_mark = of_mark.map_or(0.0, |mark| mark.sigma_px.powi(2));
        Some(Self {
            index,
            pixel_by_parameters: DMatrix::from_fn(2, columns.len(), |r, c| columns[c][r]),
            by_dome,
            own_covariance_px2: by_place * of_tip * by_place.transpose()
                + Matrix2::identity() * noise_px.powi(2),
            mark_covariance_px2: Matrix2::identity() * of_mark,
            stated: noise_px.powi(2) + of_mark,
        })
    }
}

/// Stacks the derivatives of a capture's pixels by the solved parameters, and computes the pixels' covariance.
fn stacked(capture: &[&Pin], count: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let rows = 2 * capture.len();
    let mut by = DMatrix::zeros(rows, count);
    let mut by_dome = DMatrix::zeros(rows, 6);
    let mut noise = DMatrix::zeros(rows, rows);
    for (i, pin) in capture.iter().enumerate() {
        by.rows_mut(2 * i, 2).copy_from(&pin.pixel_by_parameters.columns(0, count));
        by_dome.rows_mut(2 * i, 2).copy_from(&pin.by_dome);
        noise
            .view_mut((2 * i, 2 * i), (2, 2))
            .copy_from(&(pin.own_covariance_px2 + pin.mark_covariance_px2));
    }
    noise += &by_dome * by_dome.transpose();
    (by, noise)
}

/// Computes the repeatability of pins for each coordinate, px: the solver finds this value and takes it as the smallest
/// error of any pin.
fn repeatability_px(captures: &[Vec<&Pin>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for pin in captures.iter().flatten() {
        sum += 0.5
            * (pin.own_covariance_px2.trace() + (pin.by_dome * pin.by_dome.transpose()).trace());
        count += 1.0;
    }
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

fn trace_of_product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    a.iter().zip(b.transpose().iter()).map(|(a, b)| a * b).sum()
}
