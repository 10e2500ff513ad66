//! Choosing by evidence: every explanation is fitted, and judged on captures it has not seen.

use fabkit_camera::Interface;
use fabkit_geometry::Pose;
use nalgebra::Vector2;

use super::CalibrationOptions;
use super::candidates::{Medium, Optics, ParameterSet};
use super::refine::{Loss, PoseSolution, SolveError, refine};
use super::tolerances::{Difference, Expected, TOLERANCE_SIGMAS, log_likelihood};
use crate::model::{FitParameter, Model, Observation};
use crate::observability::{Unobservable, unobservable_from};

/// Each parameter beyond the pose must make what was left out more likely by this factor's logarithm.
const WORTH_A_PARAMETER: f64 = 0.5;
/// What is drawn is believed where held-out errors are no more than this many times those of what predicts best.
const NEARLY: f64 = 1.3;
/// Reseated domes must lower Akaike's criterion by this: odds of 150 to 1.
const WORTH_A_SEAT: f64 = 10.0;
/// Farther than this from where the design puts it the camera cannot be: three standard deviations
/// of [`FitParameter::prior_sigma`], mm.
pub(super) const PLAUSIBLE_MM: f64 = 15.0;
/// Most radial terms tried.
const MAX_TERMS: usize = 3;

/// One explanation, fitted and judged.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Which.
    pub candidate: ParameterSet,
    /// What fits best.
    pub fit: PoseSolution,
    /// Root mean square residual of the pins it was fitted to, px, both coordinates together.
    pub rms_px: f64,
    /// The same for each capture predicted from the others; infinite where that fails.
    pub held_out_rms_px: f64,
    /// Residual of each observation when its capture was left out; `None` where that fails.
    pub held_out_px: Vec<Option<Vector2<f64>>>,
    /// The capture of each observation.
    captures: Vec<usize>,
    /// Akaike's information criterion, corrected for few observations (Hurvich & Tsai 1989), for
    /// the standard deviations the observations state. The smallest is best.
    pub aicc: f64,
    /// What the pixels leave unknown.
    pub unobservable: Vec<Unobservable>,
    /// How far the sensor's origin is from where the design puts it, camera frame, mm.
    pub from_design_mm: Option<f64>,
    /// What it says of the unit, against the drawing and the lens's own calibration.
    pub differences: Vec<Difference>,
    /// Poses without each capture in turn, of those without which it can be fitted.
    pub left_out: Vec<Pose>,
}

impl Trial {
    /// Whether the unit is the drawn one, by this explanation.
    pub fn within_tolerances(&self) -> bool {
        self.differences.iter().all(|difference| difference.sigmas() <= TOLERANCE_SIGMAS)
    }

    /// What differs by more than is made.
    pub fn differs(&self) -> impl Iterator<Item = &Difference> {
        self.differences.iter().filter(|difference| difference.sigmas() > TOLERANCE_SIGMAS)
    }

    /// The logarithm of the density of all pins that were left out, px^-2 each: of a normal distribution about their
    /// prediction that is as wide as they scatter.
    pub fn log_predictive_density(&self) -> f64 {
        let variance = 0.5 * self.held_out_rms_px.powi(2);
        -(self.held_out_px.len() as f64) * ((std::f64::consts::TAU * variance).ln() + 1.0)
    }

    /// Whether the camera is where it can be.
    pub fn is_plausible(&self) -> bool {
        self.from_design_mm.is_none_or(|distance| distance < PLAUSIBLE_MM)
    }
}

/// What was tried and which of it was chosen.
#[derive(Clone, Debug)]
pub struct Selection {
    /// In the order in which they were tried: the pose alone first, if it could be fitted. At least
    /// one.
    pub trials: Vec<Trial>,
    /// Index into `trials`.
    pub chosen: usize,
    /// Whether the pixels tell a seating offset at all. If not, it was not tried.
    pub seating_shows: bool,
    /// Explanations that could not be fitted, and why.
    pub failed: Vec<(ParameterSet, SolveError)>,
}

/// Fits all explanations that the landmarks allow and chooses one.
///
/// First the optics, each with and without leaning pins and, if the pixels show it at all, a
/// seating offset. The best of them is then offered a reseated dome. One that cannot be fitted, be
/// it the plainest, leaves the choice to the others.
///
/// # Errors
/// None can be fitted: all of them, with why.
pub(super) fn select(
    start: &Model,
    observations: &[Observation],
    captures: usize,
    options: &CalibrationOptions<'_>,
    expected: &Expected<'_>,
) -> Result<Selection, Vec<(ParameterSet, SolveError)>> {
    let judge = |candidate| judge(candidate, start, observations, captures, options, expected);
    let mut trials = Vec::new();
    let mut failed = Vec::new();
    let mut attempt = |candidate, trials: &mut Vec<Trial>| match judge(candidate) {
        Ok(trial) => trials.push(trial),
        Err(error) => failed.push((candidate, error)),
    };
    attempt(ParameterSet::PLAIN, &mut trials);
    // Where the pose alone cannot be fitted, the start is as good a place to ask.
    let plain = trials.first().map_or(start, |plain: &Trial| &plain.fit.model);
    let seating_shows = shows_seating(plain, observations);
    let seats: &[bool] = if seating_shows { &[false, true] } else { &[false] };
    // A camera file that has an interface already is believed.
    let media = match (start.camera.interface(), &options.drawn) {
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
    let eligible = (0..trials.len()).filter(|i| {
        !trials[*i].candidate.seating || !trials[*i].names(FitParameter::SeatingOffset)
    });
    let physical = if media.contains(&Medium::Drawn) { Medium::Drawn } else { Medium::Given };
    let mut chosen = best(&trials, eligible, captures, physical);
    if captures > 2 {
        attempt(ParameterSet { reseating: true, ..trials[chosen].candidate }, &mut trials);
        // Nobody can know the seat of a capture that was left out: held-out errors say whether the
        // rest suffers, the information criterion whether it is real.
        let reseated = &trials[trials.len() - 1];
        let real = reseated.aicc < trials[chosen].aicc - WORTH_A_SEAT;
        let harmless = reseated.held_out_rms_px < 1.05 * trials[chosen].held_out_rms_px;
        if reseated.candidate.reseating && real && harmless {
            chosen = trials.len() - 1;
        }
    }
    Ok(Selection { trials, chosen, seating_shows, failed })
}

/// Whether the pixels tell a seating offset, if all else is as the camera file says.
fn shows_seating(plain: &Model, observations: &[Observation]) -> bool {
    if observations.iter().any(|o| o.contact.axis_in_sensor.is_none()) {
        return false;
    }
    let parameters = [&FitParameter::POSE[..], &[FitParameter::SeatingOffset]].concat();
    let unknown = unobservable_from(plain, &parameters, observations);
    let named = |u: &Unobservable| u.terms.iter().any(|(p, _)| *p == FitParameter::SeatingOffset);
    !unknown.iter().any(named)
}

impl Trial {
    /// Whether a parameter has a part in something that the pixels leave unknown.
    pub fn names(&self, parameter: FitParameter) -> bool {
        self.unobservable.iter().any(|u| u.terms.iter().any(|(found, _)| *found == parameter))
    }

    /// Parameters besides the pose; what the drawing says beforehand is none that the pixels have to tell.
    fn free_parameters(&self) -> usize {
        let known = |p: &&FitParameter| self.fit.model.is_drawn(**p);
        let from_drawing = self.fit.parameters.iter().filter(known).count();
        self.fit.parameters.len().saturating_sub(6 + from_drawing)
    }

    /// How well it predicts, with what it says of the unit and what its complications must earn. Pins of a capture that err
    /// together count for less than pins that do not.
    fn score(&self, together: f64) -> f64 {
        let extra = WORTH_A_PARAMETER * self.free_parameters().min(12) as f64;
        self.log_predictive_density() / together + log_likelihood(&self.differences) - extra
    }

    /// For how many pins one counts, where those of a capture err together: 1 + (m - 1) r for m pins each and a correlation
    /// r within captures (Kish 1965).
    fn together(&self, captures: usize) -> f64 {
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
        // Mean squares between captures and within them, by one degree of freedom.
        let ratio = between / groups / within;
        let correlation = (ratio - 1.0) / (ratio - 1.0 + each);
        if correlation.is_finite() { 1.0 + (each - 1.0) * correlation.clamp(0.0, 1.0) } else { 1.0 }
    }
}

/// What is drawn, with the lens as it is calibrated, where that predicts nearly as well as anything: how far a mark is
/// found from its tip is not known to the last tenth of a pixel, and other explanations turn that into millimetres. Else the
/// likeliest.
fn best(
    trials: &[Trial],
    among: impl IntoIterator<Item = usize>,
    captures: usize,
    physical: Medium,
) -> usize {
    let among: Vec<usize> = among.into_iter().collect();
    let held_out_px = |i: &usize| trials[*i].held_out_rms_px;
    let nearest = among.iter().copied().min_by(|a, b| held_out_px(a).total_cmp(&held_out_px(b)));
    let Some(nearest) = nearest else { return 0 };
    let together = trials[nearest].together(captures);
    let score = |i: &usize| trials[*i].score(together);
    let likeliest = |among: &[usize]| {
        among.iter().copied().max_by(|a, b| score(a).total_cmp(&score(b)).then(b.cmp(a)))
    };
    let is_physical = |i: &usize| {
        let optics = trials[*i].candidate.optics;
        optics.medium == physical
            && optics.radial_terms == 0
            && held_out_px(i) <= NEARLY * held_out_px(&nearest)
    };
    let drawn: Vec<usize> = among.iter().copied().filter(is_physical).collect();
    likeliest(&drawn).or_else(|| likeliest(&among)).unwrap_or(nearest)
}

fn judge(
    candidate: ParameterSet,
    start: &Model,
    observations: &[Observation],
    captures: usize,
    options: &CalibrationOptions<'_>,
    known: &Expected<'_>,
) -> Result<Trial, SolveError> {
    let loss = options.loss;
    let fit = candidate.fit(start, observations, captures, options)?;
    let (held_out_px, left_out) = held_out(&fit, observations, captures, loss);
    let parameters = &fit.parameters;
    // What a prior holds counts as far as the pixels moved it: little, for a dome's seat.
    let (n, k) = (2.0 * observations.len() as f64, effective_parameters(&fit));
    let correction = if n > k + 1.0 { 2.0 * k * (k + 1.0) / (n - k - 1.0) } else { f64::INFINITY };
    let unobservable = unobservable_from(&fit.model, parameters, observations);
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

/// Parameters, less what their priors already fixed: `sum 1 - posterior / prior variance`.
fn effective_parameters(fit: &PoseSolution) -> f64 {
    let parts = fit.parameters.iter().enumerate().map(|(i, parameter)| {
        let prior = fit.model.prior(*parameter).map(|(_, sigma)| sigma * sigma);
        prior.map_or(1.0, |variance| (1.0 - fit.covariance[(i, i)] / variance).max(0.0))
    });
    parts.sum()
}

/// Residuals of each capture under a fit of the others. Its dome sits where it should, as far as
/// anybody could know.
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
        if others.len() == observations.len() {
            continue;
        }
        let mut start = fit.model.clone();
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

/// Root mean square length, px; infinite if a residual is missing.
pub(super) fn rms(residuals: &[Option<Vector2<f64>>]) -> f64 {
    let squared = |r: &Option<Vector2<f64>>| r.map_or(f64::INFINITY, |r| r.norm_squared());
    (residuals.iter().map(squared).sum::<f64>() / residuals.len().max(1) as f64).sqrt()
}
