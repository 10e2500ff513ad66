//! Levenberg-Marquardt on pixels with a robust loss.
//!
//! A few lines of our own instead of the `levenberg-marquardt` crate: steps live on the rotation
//! group and pass through [`Model::stepped`], observations are reweighted while it runs, and a step
//! that leaves the lens's domain is a step to be shortened, not an error.

use fabkit_camera::OutsideDomain;
use nalgebra::{DMatrix, DVector, Vector2};

use crate::information::ScaledCholesky;
use crate::model::{FitParameter, Model, Observation};
use crate::observability::{Unobservable, unobservable};

const MAX_ITERATIONS: usize = 200;
/// After a step that is shorter than this part of a standard deviation nothing is left to do: the
/// next would be shorter by orders of magnitude.
const LAST_STEP: f64 = 0.01;
/// A step shorter than this need not be taken.
const NO_STEP: f64 = 1e-6;
const START_DAMPING: f64 = 1e-5;
const MAX_DAMPING: f64 = 1e12;
/// Steps taken as they come. Most fits need fewer; what takes longer creeps or swings along one
/// direction, and then the best share of each step is looked for.
const PATIENCE: usize = 10;
/// Shares of a step that are tried besides all of it.
const SHARES: [f64; 2] = [0.05, 50.0];
/// A share this near to all of a step is not worth another look.
const MUCH_THE_SAME: [f64; 2] = [0.7, 1.4];

/// How residuals count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// All by their square.
    Squares,
    /// Beyond this many standard deviations by their length (Huber 1964); a pixel's two
    /// coordinates together.
    Huber(f64),
}

impl Loss {
    /// Cost and weight for a squared length in standard deviations.
    pub(super) fn of(self, squared: f64) -> (f64, f64) {
        match self {
            Self::Huber(limit) if squared > limit * limit => {
                let length = squared.sqrt();
                (2.0 * limit * length - limit * limit, limit / length)
            }
            _ => (squared, 1.0),
        }
    }
}

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// More unknowns than coordinates.
    #[error("{unknowns} unknowns, but only {coordinates} pixel coordinates")]
    TooFew {
        /// What is solved for.
        unknowns: usize,
        /// Two for each pin.
        coordinates: usize,
    },
    /// At the starting pose, a pin cannot be seen.
    #[error("hole {hole} in capture {capture} cannot be seen from the starting pose: {source}")]
    Unseen {
        /// Number of the hole.
        hole: u32,
        /// Counts from 0.
        capture: usize,
        /// Why.
        source: OutsideDomain,
    },
    /// The pixels do not determine the parameters.
    #[error("the pins do not determine {}", names(.combinations))]
    NotObservable {
        /// What can change without a trace.
        combinations: Vec<Unobservable>,
    },
    /// Wherever a fit puts the surface of the gel, pins reach through it.
    #[error("the surface of the gel would lie behind the pins that are nearest to the camera")]
    PinsInTheWay,
    /// The camera cannot stand before the drawn interface from where the fit starts.
    #[error("the interface that the design draws is not before the camera")]
    NoDrawnInterface,
    /// No step from the starting values makes the residuals smaller, yet they are not at rest.
    #[error("no convergence after {iterations} steps")]
    NoConvergence {
        /// Steps tried.
        iterations: usize,
    },
}

/// The parameters of each combination, for messages.
pub(crate) fn names(combinations: &[Unobservable]) -> String {
    let join = |u: &Unobservable| {
        let names: Vec<String> = u.terms.iter().map(|(p, _)| p.to_string()).collect();
        names.join(" with ")
    };
    combinations.iter().map(join).collect::<Vec<_>>().join("; ")
}

/// A model that fits.
#[derive(Clone, Debug)]
pub struct PoseSolution {
    /// What fits best.
    pub model: Model,
    /// What was solved for.
    pub parameters: Vec<FitParameter>,
    /// Covariance of the parameters, in their order and units, if the observations' standard
    /// deviations are right.
    pub covariance: DMatrix<f64>,
    /// Robust sum of squared residuals in standard deviations, priors included.
    pub cost: f64,
    /// Steps taken.
    pub iterations: usize,
}

impl PoseSolution {
    /// Observed minus projected, px, in the order of `observations`; `None` where a contact cannot
    /// be seen.
    pub fn residuals_px(&self, observations: &[Observation]) -> Vec<Option<Vector2<f64>>> {
        let residual = |o: &Observation| Some(o.pixel - self.model.project(&o.contact).ok()?);
        observations.iter().map(residual).collect()
    }
}

/// Solves for `parameters`, starting from `start`.
///
/// # Errors
/// [`SolveError`]: too few pins, a pin that cannot be seen at the start, parameters that the
/// pixels do not determine, no convergence.
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
        return Err(SolveError::TooFew { unknowns: count - held, coordinates });
    }
    let mut normal = Normal::new(count);
    let mut tried_normal = Normal::new(count);
    let mut spare_normal = Normal::new(count);
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
            if damping > MAX_DAMPING {
                return Err(SolveError::NotObservable {
                    combinations: unobservable(&normal.information, parameters),
                });
            }
            continue;
        };
        let tried = model.stepped(parameters, step.as_slice());
        let length = normal.length(&step);
        if length < LAST_STEP {
            // Nothing can be worse after it, unless it leads out of sight.
            if let Some(tried) = tried.filter(|tried| sees_all(tried, observations)) {
                model = tried;
                break;
            }
            if length < NO_STEP {
                break;
            }
            damping *= 10.0;
            continue;
        }
        let whole = tried.and_then(|tried| {
            let next = tried_normal.build(&tried, parameters, observations, loss).ok()?;
            Some((tried, next))
        });
        let share = whole.as_ref().and_then(|(_, next)| normal.best_share(&step, cost, *next));
        let mut lower = whole.filter(|(_, next)| *next <= cost);
        if let Some(share) = share.filter(|_| iterations > PATIENCE)
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
                damping = (damping * 0.1).max(1e-12);
            }
            None if damping > MAX_DAMPING => {
                return Err(SolveError::NoConvergence { iterations });
            }
            None => damping *= 10.0,
        }
    }
    let Some(factor) = ScaledCholesky::new(&normal.information) else {
        let combinations = unobservable(&normal.information, parameters);
        return Err(SolveError::NotObservable { combinations });
    };
    let (parameters, covariance) = (parameters.to_vec(), factor.inverse());
    Ok(PoseSolution { model, parameters, covariance, cost, iterations })
}

fn sees_all(model: &Model, observations: &[Observation]) -> bool {
    observations.iter().all(|o| model.project(&o.contact).is_ok())
}

/// The normal equations and room for them.
struct Normal {
    information: DMatrix<f64>,
    gradient: DVector<f64>,
    columns: Vec<Vector2<f64>>,
}

impl Normal {
    fn new(count: usize) -> Self {
        Self {
            information: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            columns: vec![Vector2::zeros(); count],
        }
    }

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
                    SolveError::Unseen { hole: contact.hole, capture: contact.capture, source }
                })?;
            let residual = observation.pixel - projected;
            let precision = observation.sigma_px.powi(-2);
            let (part, weight) = loss.of(residual.norm_squared() * precision);
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

    /// The share of a step that lowers the cost most, if that is not about all of it: from the
    /// parabola through the cost before, its slope, and the cost after the whole step.
    ///
    /// Reweighting takes steps that are too short where many pins count by their length, and the
    /// normal equations take too long ones where residuals are large and the projection is bent:
    /// they leave out its second derivatives. Both end in steps that shrink by a few percent each.
    fn best_share(&self, step: &DVector<f64>, before: f64, after: f64) -> Option<f64> {
        let slope = -2.0 * step.dot(&self.gradient);
        let bend = after - before - slope;
        let [least, most] = SHARES;
        let share = if bend > 0.0 { (-0.5 * slope / bend).clamp(least, most) } else { most };
        let [from, to] = MUCH_THE_SAME;
        (!(from..=to).contains(&share)).then_some(share)
    }

    /// Length of a step in standard deviations.
    fn length(&self, step: &DVector<f64>) -> f64 {
        step.dot(&(&self.information * step)).max(0.0).sqrt()
    }
}
