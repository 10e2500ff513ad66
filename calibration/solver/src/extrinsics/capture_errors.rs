//! Errors that all pins of a capture share, because the dome is taken off and put on again, and never sits the same.
//!
//! The residuals of a capture are modelled as independent errors of its pins and six small motions of the whole dome.
//! The variances of both maximise the likelihood of the residuals, corrected for the degrees of freedom that the fit
//! has taken up (restricted maximum likelihood: Patterson and Thompson 1971). The covariance of the fit, which weighs
//! pins independently, follows from both.
//!
//! A mark whose offset is wrong in the model is off in every press of its pin. An analysis of variance separates the
//! error that presses of one pin share from the rest (R. Fisher 1925; the unequal numbers as in S. Searle, Linear
//! Models, 1971).

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Matrix2x3, Vector2, Vector3};

use super::refine::{Loss, PoseSolution};
use crate::model::{Contact, FitParameter, Observation};

/// Number of the dome's motions: three shifts and three turns.
const MOTIONS: usize = 6;
/// Number of times that each motion's variance is searched after a common search of all.
const ROUNDS: usize = 2;
/// Unit of the dome's three shifts, mm, one standard deviation.
const SHIFT_MM: f64 = 0.1;
/// Unit of the dome's three turns about the middle of its pins, rad, one standard deviation.
const TURN_RAD: f64 = 0.005;
/// Smallest number of degrees of freedom for an estimate of the error that presses of a pin share.
const MIN_DEGREES_OF_FREEDOM: f64 = 20.0;
/// Smallest number of captures for an estimate of the dome's motions.
const LEAST_CAPTURES: usize = 5;
/// Search range of the variances of the dome's motions, in the units above and relative to the pins' variance:
/// exponents of ten.
const VARIANCE_EXPONENTS: [f64; 2] = [-3.0, 4.0];
/// Number of steps of that search.
const STEPS: usize = 28;

/// Estimated errors of pins, domes and marks.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Standard deviation of the pins' own errors relative to that stated by their observations; at least 1 if domes do
    /// not move.
    pub pins: f64,
    /// Standard deviation of the dome's shift along the sensor's axes from capture to capture, mm.
    pub dome_mm: [f64; 3],
    /// Standard deviation of its turn about axes parallel to the sensor's through the middle of its pins, rad.
    pub dome_rad: [f64; 3],
    /// Standard deviation of the error of a mark's offset that all presses of its pin share, each coordinate, px.
    pub marks_px: f64,
    /// Covariance of the solved parameters caused by pins and domes alone, as leaving out captures shows it.
    pub pixel_covariance: DMatrix<f64>,
    /// Covariance of the solved parameters that also includes the shared errors of marks and the priors.
    pub covariance: DMatrix<f64>,
}

/// Residuals and derivatives of one capture.
struct CaptureResiduals {
    /// Derivative of the pixels by the solved parameters, and by the dome's six motions in their units.
    by_fit: DMatrix<f64>,
    by_dome: DMatrix<f64>,
    residuals: DVector<f64>,
    /// Contacts of the pins, bit by bit.
    places: Vec<[u64; 3]>,
    /// Variances of the residuals as the fit weighs them, px2.
    variances: DVector<f64>,
}

impl CaptureResiduals {
    fn covariance(&self, dome: &[f64; MOTIONS]) -> DMatrix<f64> {
        let motions = DMatrix::from_diagonal(&DVector::from_column_slice(dome));
        DMatrix::from_diagonal(&self.variances) + &self.by_dome * motions * self.by_dome.transpose()
    }
}

/// Estimates the errors of pins, domes and marks from a fit's residuals.
pub(super) fn estimate_errors(
    fit: &PoseSolution,
    observations: &[Observation],
    loss: Loss,
) -> ErrorEstimate {
    let groups = capture_residuals(fit, observations, loss);
    // A fit with the domes' seats as parameters leaves no motion of the domes in its residuals.
    let is_reseated = fit.parameters.iter().any(|p| matches!(p, FitParameter::Reseating(..)));
    let prior = prior(fit);
    let mut best = ([0.0; MOTIONS], Likelihood::new(&groups, &prior, &[0.0; MOTIONS]));
    if !is_reseated && groups.len() >= LEAST_CAPTURES {
        let logarithm = |l: &Option<Likelihood>| {
            l.as_ref().map_or(f64::NEG_INFINITY, |likelihood| likelihood.logarithm)
        };
        let consider = |dome: [f64; MOTIONS], best: &mut ([f64; MOTIONS], Option<Likelihood>)| {
            let tried = Likelihood::new(&groups, &prior, &dome);
            if logarithm(&tried) > logarithm(&best.1) {
                *best = (dome, tried);
            }
        };
        // A coarse search of one common variance, then each motion by itself: the likelihood has no simple derivative.
        variances().for_each(|all| consider([all; MOTIONS], &mut best));
        for _ in 0..ROUNDS {
            for motion in 0..MOTIONS {
                for one in std::iter::once(0.0).chain(variances()) {
                    let mut dome = best.0;
                    dome[motion] = one;
                    consider(dome, &mut best);
                }
            }
        }
    }
    let (dome, likelihood) = best;
    // If the dome's motions are part of the pins' stated scatter, the pins' own variance may be smaller than stated.
    let least = if dome == [0.0; MOTIONS] { 1.0 } else { 0.0 };
    let variance = likelihood.map_or(1.0, |likelihood| likelihood.variance).max(least);
    let count = fit.parameters.len();
    let mut noise = DMatrix::zeros(count, count);
    for group in &groups {
        let weighted = DMatrix::from_diagonal(&group.variances.map(f64::recip)) * &group.by_fit;
        noise += weighted.transpose() * group.covariance(&dome) * &weighted * variance;
    }
    // The sandwich formula: the fit's inverse information on both sides of the true noise.
    let of = |noise: &DMatrix<f64>| {
        let covariance = &fit.covariance * noise * &fit.covariance;
        (&covariance + covariance.transpose()) * 0.5
    };
    let of_pixels = of(&noise);
    let presses = presses(&groups);
    let reseatings =
        fit.parameters.iter().filter(|p| matches!(p, FitParameter::Reseating(..))).count();
    let marks_px2 = shared_variance_px2(&presses, [count - reseatings, reseatings]);
    for of_pin in presses.values() {
        // The fit has counted the shared part once per press as independent: that is replaced by the correlated sum.
        let mut all = DMatrix::zeros(count, 2);
        for press in of_pin {
            let own_px2 = marks_px2.min(press.variance_px2 * variance);
            noise -= &press.weighted * press.weighted.transpose() * own_px2;
            all += &press.weighted;
        }
        noise += &all * all.transpose() * marks_px2;
    }
    let covariance = of(&(noise + DMatrix::from_diagonal(&prior)));
    let moves = |motion: usize| (dome[motion] * variance).sqrt();
    ErrorEstimate {
        pins: variance.sqrt(),
        dome_mm: std::array::from_fn(|axis| SHIFT_MM * moves(axis)),
        dome_rad: std::array::from_fn(|axis| TURN_RAD * moves(3 + axis)),
        marks_px: marks_px2.sqrt(),
        pixel_covariance: of_pixels,
        covariance,
    }
}

/// Press of a pin: derivative of its mark by the solved parameters times the mark's weight, the mark's residual, px,
/// and the variance that defines the weight.
struct PinPress {
    weighted: DMatrix<f64>,
    residual: Vector2<f64>,
    variance_px2: f64,
}

/// Presses of each pin, by the bits of its contact.
type Presses = BTreeMap<[u64; 3], Vec<PinPress>>;

/// Collects the presses of each pin.
fn presses(groups: &[CaptureResiduals]) -> Presses {
    let mut presses = Presses::new();
    for group in groups {
        for (i, place) in group.places.iter().enumerate() {
            let precision = group.variances.rows(2 * i, 2).map(f64::recip);
            let by_fit = group.by_fit.rows(2 * i, 2);
            let weighted = by_fit.transpose() * DMatrix::from_diagonal(&precision);
            let residual = Vector2::new(group.residuals[2 * i], group.residuals[2 * i + 1]);
            let variance_px2 = group.variances[2 * i];
            let press = PinPress { weighted, residual, variance_px2 };
            presses.entry(*place).or_default().push(press);
        }
    }
    presses
}

/// Estimates the variance of the mark error that all presses of a pin share, each coordinate, px2; 0 if pins are not
/// pressed often enough. The degrees of freedom are corrected for the fit: parameters that were solved for once have
/// taken up differences between pins, and those that were solved for in each capture have taken up the same fraction of
/// the differences between pins and within them.
fn shared_variance_px2(presses: &Presses, [solved, reseatings]: [usize; 2]) -> f64 {
    let counts: Vec<f64> = presses.values().map(|of_pin| of_pin.len() as f64).collect();
    let (all, pins) = (counts.iter().sum::<f64>(), counts.len() as f64);
    let left = 1.0 - reseatings as f64 / (2.0 * all);
    let free_within = 2.0 * (all - pins) * left;
    let free_between = (2.0 * pins - solved as f64) * left;
    if free_within < MIN_DEGREES_OF_FREEDOM || free_between < MIN_DEGREES_OF_FREEDOM {
        return 0.0;
    }
    let (mut within, mut between) = (0.0, 0.0);
    for of_pin in presses.values() {
        let count = of_pin.len() as f64;
        let mean = of_pin.iter().map(|press| press.residual).sum::<Vector2<f64>>() / count;
        between += count * mean.norm_squared();
        within += of_pin.iter().map(|press| (press.residual - mean).norm_squared()).sum::<f64>();
    }
    // Effective number of presses per pin for unequal numbers (Searle 1971).
    let typical =
        (all - counts.iter().map(|count| count * count).sum::<f64>() / all) / (pins - 1.0);
    ((between / free_between - within / free_within) / typical).max(0.0)
}

/// Lists the variances of the dome's motions to try.
fn variances() -> impl Iterator<Item = f64> {
    let step = (VARIANCE_EXPONENTS[1] - VARIANCE_EXPONENTS[0]) / STEPS as f64;
    (0..=STEPS).map(move |k| 10f64.powf(VARIANCE_EXPONENTS[0] + step * k as f64))
}

/// Returns the prior information of each parameter: one over its variance, or 0.
fn prior(fit: &PoseSolution) -> DVector<f64> {
    let of = |parameter: &FitParameter| {
        fit.model.prior(*parameter).map_or(0.0, |(_, sigma)| sigma.powi(-2))
    };
    DVector::from_iterator(fit.parameters.len(), fit.parameters.iter().map(of))
}

/// Returns the bits of a contact's coordinates, which are the same for all presses of its pin.
fn bits(contact: &Contact) -> [u64; 3] {
    <[f64; 3]>::from(contact.contact_in_sensor_mm).map(f64::to_bits)
}

/// Computes residuals and derivatives of each capture.
fn capture_residuals(
    fit: &PoseSolution,
    observations: &[Observation],
    loss: Loss,
) -> Vec<CaptureResiduals> {
    let captures = observations.iter().map(|o| o.contact.capture + 1).max().unwrap_or(0);
    let middle =
        observations.iter().map(|o| o.contact.contact_in_sensor_mm.coords).sum::<Vector3<f64>>()
            / observations.len().max(1) as f64;
    let of_capture = |capture: usize| {
        let here: Vec<&Observation> =
            observations.iter().filter(|o| o.contact.capture == capture).collect();
        let rows = 2 * here.len();
        let mut group = CaptureResiduals {
            by_fit: DMatrix::zeros(rows, fit.parameters.len()),
            by_dome: DMatrix::zeros(rows, MOTIONS),
            residuals: DVector::zeros(rows),
            places: here.iter().map(|o| bits(&o.contact)).collect(),
            variances: DVector::from_element(rows, 1.0),
        };
        let mut columns = vec![Vector2::zeros(); fit.parameters.len()];
        for (i, observation) in here.iter().enumerate() {
            let contact = &observation.contact;
            // A fit exists only if all pins are visible.
            let Ok(pixel) = fit.model.differentiate(contact, &fit.parameters, &mut columns) else {
                continue;
            };
            let Ok(by_place) = fit.model.pixel_by_contact(contact) else { continue };
            let residual = observation.pixel - pixel;
            let precision = observation.sigma_px.powi(-2);
            let (_, weight) = loss.cost_and_weight(residual.norm_squared() * precision);
            let lever = (contact.contact_in_sensor_mm.coords - middle).cross_matrix();
            let by_turn: Matrix2x3<f64> = -by_place * lever;
            for axis in 0..2 {
                let row = 2 * i + axis;
                for (k, column) in columns.iter().enumerate() {
                    group.by_fit[(row, k)] = column[axis];
                }
                for k in 0..3 {
                    group.by_dome[(row, k)] = SHIFT_MM * by_place[(axis, k)];
                    group.by_dome[(row, 3 + k)] = TURN_RAD * by_turn[(axis, k)];
                }
                group.residuals[row] = residual[axis];
                group.variances[row] = 1.0 / (weight * precision);
            }
        }
        (rows > 0).then_some(group)
    };
    (0..captures).filter_map(of_capture).collect()
}

/// Restricted likelihood of the residuals for given variances of the dome's motions.
struct Likelihood {
    logarithm: f64,
    /// Variance of the pins' own errors relative to the stated one.
    variance: f64,
}

impl Likelihood {
    /// Computes the likelihood; `None` if a matrix is singular or no degree of freedom is left.
    fn new(
        groups: &[CaptureResiduals],
        prior: &DVector<f64>,
        dome: &[f64; MOTIONS],
    ) -> Option<Self> {
        let count = prior.len();
        let mut information = DMatrix::from_diagonal(prior);
        let mut gradient = DVector::zeros(count);
        let (mut square, mut determinant, mut coordinates) = (0.0, 0.0, 0);
        for group in groups {
            let factor = group.covariance(dome).cholesky()?;
            determinant += 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
            let solved = factor.solve(&group.by_fit);
            information += group.by_fit.transpose() * &solved;
            gradient += solved.transpose() * &group.residuals;
            square += group.residuals.dot(&factor.solve(&group.residuals));
            coordinates += group.residuals.len();
        }
        // In units that make the parameters comparable.
        let scale = information.diagonal().map(|v| v.max(f64::MIN_POSITIVE).sqrt().recip());
        let units = DMatrix::from_diagonal(&scale);
        let factor = (&units * &information * &units).cholesky()?;
        // Residuals after a weighted fit of the parameters, without forming them.
        let step = factor.solve(&(&units * &gradient));
        square -= (&units * gradient).dot(&step);
        let free = coordinates.checked_sub(count).filter(|free| *free > 0)? as f64;
        let of_fit = 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        // The variance of the pins is profiled out: its best value for these motions is known in closed form.
        let variance = (square / free).max(f64::MIN_POSITIVE);
        Some(Self {
            logarithm: -0.5
                * (free * variance.ln() + determinant + of_fit - 2.0 * scale.map(f64::ln).sum()),
            variance,
        })
    }
}
