//! Model selection: every explanation is fitted, and judged on held-out captures.

use fabkit_camera::Interface;
use fabkit_geometry::Pose;
use nalgebra::Vector2;

use super::CalibrationOptions;
use super::candidates::{Medium, Optics, ParameterSet};
use super::refine::{Loss, PoseSolution, SolveError, refine};
use super::tolerances::{ExpectedValues, TOLERANCE_SIGMAS, UnitDifference, log_likelihood};
use crate::model::{FitParameter, Model, Observation};
use crate::observability::{UnobservableCombination, find_unobservable_from_observations};

/// Natural logarithm of the factor by which each parameter beyond the pose must make the held-out pins more likely.
const PARAMETER_PENALTY: f64 = 0.5;
/// Largest ratio of held-out errors to those of the best prediction for which the drawn explanation is preferred.
const NEARLY_BEST_RATIO: f64 = 1.3;
/// Decrease of Akaike's criterion that a reseated dome must achieve: odds of 150 to 1.
const RESEATING_AICC_GAIN: f64 = 10.0;
/// Largest plausible distance of the camera from its designed place, mm: three standard deviations of
/// [`FitParameter::prior_sigma`].
pub(super) const PLAUSIBLE_MM: f64 = 15.0;
/// Largest number of radial terms tried.
const MAX_TERMS: usize = 3;

/// Explanation that was fitted and judged.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Set of parameters of the explanation.
    pub candidate: ParameterSet,
    /// Best fit.
    pub fit: PoseSolution,
    /// Root mean square residual of the pins that were fitted, px, both coordinates together.
    pub rms_px: f64,
    /// Root mean square residual of each capture predicted from the others, px; infinite if a prediction fails.
    pub held_out_rms_px: f64,
    /// Residual of each observation when its capture was held out, px; `None` if the prediction fails.
    pub held_out_px: Vec<Option<Vector2<f64>>>,
    /// Index of the capture of each observation.
    captures: Vec<usize>,
    /// Akaike's information criterion, corrected for few observations (Hurvich & Tsai 1989), for the standard
    /// deviations that the observations state. The smallest is best.
    pub aicc: f64,
    /// Combinations of parameters that the pixels leave undetermined.
    pub unobservable: Vec<UnobservableCombination>,
    /// Distance of the sensor's origin from its designed place, camera frame, mm.
    pub from_design_mm: Option<f64>,
    /// Implied differences of the unit from the drawing and from the lens's own calibration.
    pub differences: Vec<UnitDifference>,
    /// Poses of the fits without each capture in turn, as far as these succeed.
    pub left_out: Vec<Pose>,
}

impl Trial {
    /// Returns whether the unit is within the tolerances of the drawing by this explanation.
    pub fn within_tolerances(&self) -> bool {
        self.differences.iter().all(|difference| difference.sigmas() <= TOLERANCE_SIGMAS)
    }

    /// Lists the differences that exceed the tolerances.
    pub fn differences_beyond_tolerance(&self) -> impl Iterator<Item = &UnitDifference> {
        self.differences.iter().filter(|difference| difference.sigmas() > TOLERANCE_SIGMAS)
    }

    /// Computes the logarithm of the probability density of all held-out pins, px^-2 each, for a normal distribution
    /// about their predictions with the width of their scatter.
    pub fn log_predictive_density(&self) -> f64 {
        let variance = 0.5 * self.held_out_rms_px.powi(2);
        -(self.held_out_px.len() as f64) * ((std::f64::consts::TAU * variance).ln() + 1.0)
    }

    /// Returns whether the camera is at a plausible place.
    pub fn is_position_plausible(&self) -> bool {
        self.from_design_mm.is_none_or(|distance| distance < PLAUSIBLE_MM)
    }
}

/// Trials of all explanations, and the choice.
#[derive(Clone, Debug)]
pub struct Selection {
    /// Trials, in their order: the pose alone first, if it could be fitted. At least one.
    pub trials: Vec<Trial>,
    /// Index into `trials`.
    pub chosen: usize,
    /// True if the pixels determine a seating offset. It was tried only then.
    pub is_seating_observable: bool,
    /// Explanations that could not be fitted, with their errors.
    pub failed: Vec<(ParameterSet, SolveError)>,
}

/// Fits all explanations that the landmarks allow and chooses one.
///
/// First the optics are varied, each with and without leaning pins and, if the pixels determine it, a seating offset.
/// Then a reseated dome is added to the best of them. If an explanation cannot be fitted, even the plainest, the choice
/// is among the others.
///
/// # Errors
/// If none can be fitted, returns all of them with their errors.
pub(super) fn select(
    start: &Model,
    observations: &[Observation],
    captures: usize,
    options: &CalibrationOptions<'_>,
    expected: &ExpectedValues<'_>,
) -> Result<Selection, Vec<(ParameterSet, SolveError)>> {
    let judge = |candidate| judge(candidate, start, observations, captures, options, expected);
    let mut trials = Vec::new();
    let mut failed = Vec::new();
    let mut attempt = |candidate, trials: &mut Vec<Trial>| match judge(candidate) {
        Ok(trial) => trials.push(trial),
        Err(error) => failed.push((candidate, error)),
    };
    attempt(ParameterSet::PLAIN, &mut trials);
    // Without a fit of the pose alone, the start serves as well.
    let plain = trials.first().map_or(start, |plain: &Trial| &plain.fit.model);
    let seating_shows = is_seating_observable(plain, observations);
    let seats: &[bool] = if seating_shows { &[false, true] } else { &[false] };
    // An interface in the camera file is not questioned.
    let media = match (start.camera.interface(), &options.drawing) {
        (Interface::None, Some(_)) => {
            vec![Medium::Given, Medium::Drawn, Medium::Gel(options.gel_index)]
        }
        (Interface::None, None) => vec![Medium::Given, Medium::Gel(options.gel_index)],
        _ => vec![Medium::Given],
    };
    for &medium in &media {
        for radial_terms in 0..=MAX_TERMS {
            for lean in [false, true] {
                for &seating in seats {
                    let optics = Optics { medium, radial_terms };
                    let candidate = ParameterSet { optics, lean, seating, reseating: false };
                    if candidate != ParameterSet::PLAIN {
                        attempt(candidate, &mut trials);
                    }
                }
            }
        }
    }
    if trials.is_empty() {
        return Err(failed);
    }
    // A seating offset that the fit cannot separate from the optics is not eligible.
    let eligible = (0..trials.len()).filter(|i| {
        !trials[*i].candidate.seating
            || !trials[*i].leaves_unobservable(FitParameter::SeatingOffset)
    });
    // With a drawing the physical explanation is the drawn one, without one it is the camera as given.
    let physical = if media.contains(&Medium::Drawn) { Medium::Drawn } else { Medium::Given };
    let mut chosen = choose_best(&trials, eligible, captures, physical);
    if captures > 2 {
        attempt(ParameterSet { reseating: true, ..trials[chosen].candidate }, &mut trials);
        // The seat of a held-out capture is unknown: held-out errors show whether the rest suffers, and the information
        // criterion whether the seats are real.
        let reseated = &trials[trials.len() - 1];
        let real = reseated.aicc < trials[chosen].aicc - RESEATING_AICC_GAIN;
        let harmless = reseated.held_out_rms_px < 1.05 * trials[chosen].held_out_rms_px;
        if reseated.candidate.reseating && real && harmless {
            chosen = trials.len() - 1;
        }
    }
    Ok(Selection { trials, chosen, is_seating_observable: seating_shows, failed })
}

/// Returns whether the pixels determine a seating offset, if everything else is as in the camera file.
fn is_seating_observable(plain: &Model, observations: &[Observation]) -> bool {
    if observations.iter().any(|o| o.contact.axis_in_sensor.is_none()) {
        return false;
    }
    let parameters = [&FitParameter::POSE[..], &[FitParameter::SeatingOffset]].concat();
    let unknown = find_unobservable_from_observations(plain, &parameters, observations);
    let named = |u: &UnobservableCombination| {
        u.terms.iter().any(|(p, _)| *p == FitParameter::SeatingOffset)
    };
    !unknown.iter().any(named)
}

impl Trial {
    /// Returns whether a parameter is part of a combination that the pixels leave undetermined.
    pub fn leaves_unobservable(&self, parameter: FitParameter) -> bool {
        self.unobservable.iter().any(|u| u.terms.iter().any(|(found, _)| *found == parameter))
    }

    /// Returns the number of parameters besides the pose and those with a prior from the drawing.
    fn free_parameters(&self) -> usize {
        let known = |p: &&FitParameter| self.fit.model.has_drawing_prior(**p);
        let from_drawing = self.fit.parameters.iter().filter(known).count();
        self.fit.parameters.len().saturating_sub(6 + from_drawing)
    }

    /// Computes the score of the explanation: predictive density and likelihood of the implied differences, less a
    /// penalty for each parameter. `together` divides the density, because pins of a capture with common errors count
    /// for less.
    fn score(&self, together: f64) -> f64 {
        let extra = PARAMETER_PENALTY * self.free_parameters().min(12) as f64;
        self.log_predictive_density() / together + log_likelihood(&self.differences) - extra
    }

    /// Computes the design effect 1 + (m - 1) r for m pins per capture and a correlation r of their errors within
    /// captures (Kish 1965).
    fn design_effect(&self, captures: usize) -> f64 {
        let mut sums = vec![(Vector2::zeros(), 0.0); captures];
        for (residual, capture) in self.held_out_px.iter().zip(&self.captures) {
            let Some(residual) = residual else { return 1.0 };
            sums[*capture].0 += residual;
            sums[*capture].1 += 1.0;
        }
        let (mut between, mut all, mut groups) = (0.0, 0.0, 0.0);
        for (sum, count) in sums.iter().filter(|(_, count)| *count > 0.0) {
            between += sum.norm_squared() / count;
            all += count;
            groups += 1.0;
        }
        let squares = self.held_out_rms_px.powi(2) * all;
        let within = (squares - between) / (all - groups);
        let each = all / groups;
        // Mean squares between and within captures, each by its degrees of freedom.
        // An analysis of variance gives the correlation within captures.
        let ratio = between / groups / within;
        let correlation = (ratio - 1.0) / (ratio - 1.0 + each);
        if correlation.is_finite() { 1.0 + (each - 1.0) * correlation.clamp(0.0, 1.0) } else { 1.0 }
    }
}

/// Chooses a trial. The drawn media with the calibrated lens win if they predict nearly as well as the best: the
/// offsets of marks from tips are not known to a tenth of a pixel, and other explanations turn such errors into
/// millimetres. Otherwise the trial with the highest score wins.
fn choose_best(
    trials: &[Trial],
    among: impl IntoIterator<Item = usize>,
    captures: usize,
    physical: Medium,
) -> usize {
    let among: Vec<usize> = among.into_iter().collect();
    let held_out_px = |i: &usize| trials[*i].held_out_rms_px;
    let nearest = among.iter().copied().min_by(|a, b| held_out_px(a).total_cmp(&held_out_px(b)));
    let Some(nearest) = nearest else { return 0 };
    let together = trials[nearest].design_effect(captures);
    let score = |i: &usize| trials[*i].score(together);
    let likeliest = |among: &[usize]| {
        among.iter().copied().max_by(|a, b| score(a).total_cmp(&score(b)).then(b.cmp(a)))
    };
    let is_physical = |i: &usize| {
        let optics = trials[*i].candidate.optics;
        optics.medium == physical
            && optics.radial_terms == 0
            && held_out_px(i) <= NEARLY_BEST_RATIO * held_out_px(&nearest)
    };
    let drawn: Vec<usize> = among.iter().copied().filter(is_physical).collect();
    likeliest(&drawn).or_else(|| likeliest(&among)).unwrap_or(nearest)
}

/// Fits a candidate and computes everything by which it is judged.
fn judge(
    candidate: ParameterSet,
    start: &Model,
    observations: &[Observation],
    captures: usize,
    options: &CalibrationOptions<'_>,
    known: &ExpectedValues<'_>,
) -> Result<Trial, SolveError> {
    let loss = options.loss;
    let fit = candidate.fit(start, observations, captures, options)?;
    let (held_out_px, left_out) = held_out(&fit, observations, captures, loss);
    let parameters = &fit.parameters;
    // A parameter with a prior counts by the fraction that the pixels determine: little, for a dome's seat.
    let (n, k) = (2.0 * observations.len() as f64, effective_parameters(&fit));
    // With fewer coordinates than this the criterion is undefined: such an explanation must not win.
    let correction = if n > k + 1.0 { 2.0 * k * (k + 1.0) / (n - k - 1.0) } else { f64::INFINITY };
    let unobservable = find_unobservable_from_observations(&fit.model, parameters, observations);
    let expected = fit.model.expected_translation_mm;
    let shift = |expected: fabkit_geometry::Vector3<f64>| {
        (fit.model.camera_from_sensor.translation_mm() - expected).norm()
    };
    Ok(Trial {
        candidate,
        rms_px: rms(&fit.residuals_px(observations)),
        held_out_rms_px: rms(&held_out_px),
        held_out_px,
        aicc: fit.cost + 2.0 * k + correction,
        unobservable,
        from_design_mm: expected.map(shift),
        differences: known.differences(&candidate, &fit),
        left_out,
        captures: observations.iter().map(|o| o.contact.capture).collect(),
        fit,
    })
}

/// Computes the effective number of parameters, `sum 1 - posterior / prior variance`.
fn effective_parameters(fit: &PoseSolution) -> f64 {
    let parts = fit.parameters.iter().enumerate().map(|(i, parameter)| {
        let prior = fit.model.prior(*parameter).map(|(_, sigma)| sigma * sigma);
        prior.map_or(1.0, |variance| (1.0 - fit.covariance[(i, i)] / variance).max(0.0))
    });
    parts.sum()
}

/// Computes the residuals of each capture under a fit of the others, and these fits' poses. The held-out capture's dome
/// is assumed at its nominal place, because its seat is unknown.
fn held_out(
    fit: &PoseSolution,
    observations: &[Observation],
    captures: usize,
    loss: Loss,
) -> (Vec<Option<Vector2<f64>>>, Vec<Pose>) {
    let mut residuals = vec![None; observations.len()];
    let mut poses = Vec::new();
    for capture in 0..captures {
        let others: Vec<Observation> =
            observations.iter().filter(|o| o.contact.capture != capture).cloned().collect();
        // A capture without assigned pins.
        if others.len() == observations.len() {
            continue;
        }
        let mut start = fit.model.clone();
        // The seat that the whole fit found for this capture must not leak into its prediction.
        if let Some(seat) = start.reseatings.get_mut(capture) {
            *seat = [0.0; 3];
        }
        let Ok(refitted) = refine(&start, &fit.parameters, &others, loss) else { continue };
        poses.push(refitted.model.camera_from_sensor);
        for (residual, observation) in residuals.iter_mut().zip(observations) {
            if observation.contact.capture == capture {
                let projected = refitted.model.project(&observation.contact).ok();
                *residual = projected.map(|pixel| observation.pixel - pixel);
            }
        }
    }
    (residuals, poses)
}

/// Computes the root mean square length, px; infinite if a residual is missing.
pub(super) fn rms(residuals: &[Option<Vector2<f64>>]) -> f64 {
    let squared = |r: &Option<Vector2<f64>>| r.map_or(f64::INFINITY, |r| r.norm_squared());
    (residuals.iter().map(squared).sum::<f64>() / residuals.len().max(1) as f64).sqrt()
}
