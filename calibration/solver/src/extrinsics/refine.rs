//! Levenberg-Marquardt method on pixels with a robust loss.
//!
//! Implemented here rather than with the `levenberg-marquardt` crate, because steps are taken on the rotation group by
//! [`Model::stepped`], observations are reweighted during the iteration, and a step that leaves the lens's domain must
//! be shortened and is no error.

use fabkit_camera::OutsideDomain;
use nalgebra::{DMatrix, DVector, Vector2};

use crate::information::ScaledCholesky;
use crate::model::{FitParameter, Model, Observation};
use crate::observability::{UnobservableCombination, find_unobservable};

/// Largest number of iterations.
const MAX_ITERATIONS: usize = 200;
/// Length of a step, in standard deviations, after which the iteration ends: the next step would be shorter by orders
/// of magnitude.
const LAST_STEP: f64 = 0.01;
/// Length of a step, in standard deviations, that need not be taken.
const NEGLIGIBLE_STEP: f64 = 1e-6;
/// Damping of the first step, as a fraction of the information's diagonal.
const START_DAMPING: f64 = 1e-5;
/// Damping at which the fit is given up.
const MAX_DAMPING: f64 = 1e12;
/// Number of iterations with unscaled steps. Most fits need fewer; slower ones creep or oscillate along one direction,
/// and from then on the best multiple of each step is tried too.
const PLAIN_ITERATIONS: usize = 10;
/// Smallest and largest multiple of a step that is tried.
const STEP_MULTIPLES: [f64; 2] = [0.05, 50.0];
/// Range of multiples that are too close to 1 to be tried.
const UNCHANGED_STEP_MULTIPLES: [f64; 2] = [0.7, 1.4];

/// Loss function of the residuals.
///
/// ```
/// use fabkit_calibration::extrinsics::{Loss, refine};
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::{FitParameter, Model};
/// use fabkit_calibration::synthetic::SyntheticSensor;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9], "6": [12, 0, 9], "7": [-12, 0, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let truth = Model::new(Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// let captures = vec![landmarks.pins.iter().collect(); 3];
/// let mut seen = SyntheticSensor::new(truth.clone(), 1).observe(&captures, 0.1)?;
/// // One of 21 pins is 20 px off.
/// seen[4].pixel.x += 20.0;
/// let off_mm = |loss| {
///     let found = refine(&truth, &FitParameter::POSE, &seen, loss).unwrap().model;
///     let [found, truth] = [&found, &truth].map(|m| *m.camera_from_sensor.translation_mm());
///     (found - truth).norm()
/// };
/// assert!(off_mm(Loss::Huber(3.0)) < 0.1 * off_mm(Loss::Squares));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// Sum of squares.
    Squares,
    /// Huber loss (Huber 1964): residuals longer than this many standard deviations count by their length. The two
    /// coordinates of a pixel are taken together.
    Huber(f64),
}

impl Loss {
    /// Returns cost and weight of a squared length in standard deviations.
    pub(super) fn cost_and_weight(self, squared: f64) -> (f64, f64) {
        match self {
            Self::Huber(limit) if squared > limit * limit => {
                let length = squared.sqrt();
                (2.0 * limit * length - limit * limit, limit / length)
            }
            _ => (squared, 1.0),
        }
    }
}

/// Reason why a fit failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// There are more unknowns than coordinates.
    #[error("{unknowns} unknowns, but only {coordinates} pixel coordinates")]
    TooFewObservations {
        /// Number of unknowns, without those that have a prior.
        unknowns: usize,
        /// Number of coordinates, two for each pin.
        coordinates: usize,
    },
    /// A pin is not visible from the starting pose.
    #[error("hole {hole} in capture {capture} cannot be seen from the starting pose: {source}")]
    PinNotVisible {
        /// Number of the hole.
        hole: u32,
        /// Index of the capture, from 0.
        capture: usize,
        /// Reason.
        source: OutsideDomain,
    },
    /// The pixels do not determine the parameters.
    #[error("the pins do not determine {}", combination_names(.combinations))]
    NotObservable {
        /// Combinations of parameters that can change almost without effect.
        combinations: Vec<UnobservableCombination>,
    },
    /// In every fit, pins reach through the surface of the gel.
    #[error("the surface of the gel would lie behind the pins that are nearest to the camera")]
    PinsThroughGel,
    /// At the start of the fit the drawn interface is not in front of the camera.
    #[error("the interface that the design draws is not before the camera")]
    NoDrawnInterface,
    /// No step from the current values makes the residuals smaller, although they are not at a minimum.
    #[error("no convergence after {iterations} steps")]
    NoConvergence {
        /// Number of steps tried.
        iterations: usize,
    },
}

/// Joins the names of each combination's parameters, for messages.
pub(crate) fn combination_names(combinations: &[UnobservableCombination]) -> String {
    let join = |u: &UnobservableCombination| {
        let names: Vec<String> = u.terms.iter().map(|(p, _)| p.to_string()).collect();
        names.join(" with ")
    };
    combinations.iter().map(join).collect::<Vec<_>>().join("; ")
}

/// Fitted model.
#[derive(Clone, Debug)]
pub struct PoseSolution {
    /// Model with the fitted values.
    pub model: Model,
    /// Parameters that were solved for.
    pub parameters: Vec<FitParameter>,
    /// Covariance of the parameters, in their order and units, if the observations' standard deviations are right.
    pub covariance: DMatrix<f64>,
    /// Robust sum of squared residuals in standard deviations, including priors.
    pub cost: f64,
    /// Number of steps taken.
    pub iterations: usize,
}

impl PoseSolution {
    /// Computes observed minus projected, px, in the order of `observations`; `None` for contacts that are not visible.
    pub fn residuals_px(&self, observations: &[Observation]) -> Vec<Option<Vector2<f64>>> {
        let residual = |o: &Observation| Some(o.pixel - self.model.project(&o.contact).ok()?);
        observations.iter().map(residual).collect()
    }
}

/// Fits `parameters` to observations, starting from `start`.
///
/// # Errors
/// Fails for too few pins, a pin that is not visible at the start, parameters that the pixels do not determine, or no
/// convergence.
///
/// ```
/// use fabkit_calibration::extrinsics::{Loss, refine};
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::{FitParameter, Model};
/// use fabkit_calibration::synthetic::SyntheticSensor;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let camera = Camera::equidistant(640, 480, 2.8)?;
/// let truth = Model::new(camera, Pose::translation(0.4, -0.3, 7.6));
/// let seen = SyntheticSensor::new(truth, 1).observe(&[landmarks.pins.iter().collect()], 0.1)?;
/// let start = Model::new(camera, Pose::translation(0.0, 0.0, 7.0));
/// let fit = refine(&start, &FitParameter::POSE, &seen, Loss::Squares)?;
/// // The last of the six parameters is the distance; its standard deviation is the root of its variance.
/// let z_mm = fit.model.camera_from_sensor.translation_mm().z;
/// assert!((z_mm - 7.6).abs() < 4.0 * fit.covariance[(5, 5)].sqrt());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn refine(
    start: &Model,
    parameters: &[FitParameter],
    observations: &[Observation],
    loss: Loss,
) -> Result<PoseSolution, SolveError> {
    let count = parameters.len();
    let held = parameters.iter().filter(|p| start.prior(**p).is_some()).count();
    if 2 * observations.len() < count - held {
        let coordinates = 2 * observations.len();
        return Err(SolveError::TooFewObservations { unknowns: count - held, coordinates });
    }
    let mut normal = NormalEquations::new(count);
    let mut tried_normal = NormalEquations::new(count);
    let mut spare_normal = NormalEquations::new(count);
    let mut model = start.clone();
    let mut cost = normal.build(&model, parameters, observations, loss)?;
    let mut damping = START_DAMPING;
    let mut iterations = 0;
    loop {
        if iterations == MAX_ITERATIONS {
            return Err(SolveError::NoConvergence { iterations });
        }
        iterations += 1;
        let Some(step) = normal.step(damping) else {
            damping *= 10.0;
            // Even strongly damped equations are singular: some parameter has no effect on any pixel.
            if damping > MAX_DAMPING {
                return Err(SolveError::NotObservable {
                    combinations: find_unobservable(&normal.information, parameters),
                });
            }
            continue;
        };
        let tried = model.stepped(parameters, step.as_slice());
        let length = normal.length(&step);
        if length < LAST_STEP {
            // So short a step needs no comparison of costs, unless it makes a pin invisible.
            if let Some(tried) = tried.filter(|tried| sees_all(tried, observations)) {
                model = tried;
                break;
            }
            if length < NEGLIGIBLE_STEP {
                break;
            }
            damping *= 10.0;
            continue;
        }
        let whole = tried.and_then(|tried| {
            // A failure means that a pin has left the lens's domain: then the step is shortened by more damping.
            let next = tried_normal.build(&tried, parameters, observations, loss).ok()?;
            Some((tried, next))
        });
        let share =
            whole.as_ref().and_then(|(_, next)| normal.best_step_multiple(&step, cost, *next));
        // The lowest cost wins: the whole step, its best multiple, or neither.
        let mut lower = whole.filter(|(_, next)| *next <= cost);
        if let Some(share) = share.filter(|_| iterations > PLAIN_ITERATIONS)
            && let Some(tried) = model.stepped(parameters, (&step * share).as_slice())
            && let Ok(next) = spare_normal.build(&tried, parameters, observations, loss)
            && next < lower.as_ref().map_or(cost, |(_, whole)| *whole)
        {
            lower = Some((tried, next));
            std::mem::swap(&mut tried_normal, &mut spare_normal);
        }
        match lower {
            Some((tried, next)) => {
                (model, cost) = (tried, next);
                std::mem::swap(&mut normal, &mut tried_normal);
                // The equations of the accepted step are already built.
                damping = (damping * 0.1).max(1e-12);
            }
            None if damping > MAX_DAMPING => {
                return Err(SolveError::NoConvergence { iterations });
            }
            None => damping *= 10.0,
        }
    }
    let Some(factor) = ScaledCholesky::new(&normal.information) else {
        let combinations = find_unobservable(&normal.information, parameters);
        return Err(SolveError::NotObservable { combinations });
    };
    let (parameters, covariance) = (parameters.to_vec(), factor.inverse());
    Ok(PoseSolution { model, parameters, covariance, cost, iterations })
}

fn sees_all(model: &Model, observations: &[Observation]) -> bool {
    observations.iter().all(|o| model.project(&o.contact).is_ok())
}

/// Normal equations, with working memory.
struct NormalEquations {
    information: DMatrix<f64>,
    gradient: DVector<f64>,
    columns: Vec<Vector2<f64>>,
}

impl NormalEquations {
    fn new(count: usize) -> Self {
        Self {
            information: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            columns: vec![Vector2::zeros(); count],
        }
    }

    /// Builds the normal equations of a model, and returns its cost.
    fn build(
        &mut self,
        model: &Model,
        parameters: &[FitParameter],
        observations: &[Observation],
        loss: Loss,
    ) -> Result<f64, SolveError> {
        self.information.fill(0.0);
        self.gradient.fill(0.0);
        let mut cost = 0.0;
        for observation in observations {
            let contact = &observation.contact;
            let projected =
                model.differentiate(contact, parameters, &mut self.columns).map_err(|source| {
                    SolveError::PinNotVisible {
                        hole: contact.hole,
                        capture: contact.capture,
                        source,
                    }
                })?;
            let residual = observation.pixel - projected;
            let precision = observation.sigma_px.powi(-2);
            let (part, weight) = loss.cost_and_weight(residual.norm_squared() * precision);
            cost += part;
            let weight = weight * precision;
            for (i, column) in self.columns.iter().enumerate() {
                let weighted = column * weight;
                self.gradient[i] += weighted.dot(&residual);
                for (j, other) in self.columns[..=i].iter().enumerate() {
                    self.information[(i, j)] += weighted.dot(other);
                }
            }
        }
        for (i, parameter) in parameters.iter().enumerate() {
            for j in 0..i {
                self.information[(j, i)] = self.information[(i, j)];
            }
            if let Some((value, sigma)) = model.prior(*parameter) {
                self.information[(i, i)] += sigma.powi(-2);
                self.gradient[i] -= value * sigma.powi(-2);
                cost += (value / sigma).powi(2);
            }
        }
        Ok(cost)
    }

    fn step(&self, damping: f64) -> Option<DVector<f64>> {
        Some(ScaledCholesky::damped(&self.information, damping)?.solve(&self.gradient))
    }

    /// Computes the multiple of a step that lowers the cost most, from the parabola through the cost before, its slope,
    /// and the cost after the whole step. `None` if the multiple is close to 1.
    ///
    /// Reweighting makes steps too short if many pins count by their length. The normal equations, which leave out the
    /// second derivatives of the projection, make steps too long if residuals are large. Both end in steps that shrink
    /// by a few percent each.
    fn best_step_multiple(&self, step: &DVector<f64>, before: f64, after: f64) -> Option<f64> {
        // The gradient is half of the cost's negative derivative.
        let slope = -2.0 * step.dot(&self.gradient);
        let bend = after - before - slope;
        let [least, most] = STEP_MULTIPLES;
        let share = if bend > 0.0 { (-0.5 * slope / bend).clamp(least, most) } else { most };
        let [from, to] = UNCHANGED_STEP_MULTIPLES;
        (!(from..=to).contains(&share)).then_some(share)
    }

    /// Computes the length of a step in standard deviations.
    fn length(&self, step: &DVector<f64>) -> f64 {
        step.dot(&(&self.information * step)).max(0.0).sqrt()
    }
}
