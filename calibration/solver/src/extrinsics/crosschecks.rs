//! Whether a fit would be another with other captures: halves of them, all but one, and pins that are far off.

use nalgebra::{DMatrix, DVector, Rotation3};

use super::refine::{PoseSolution, refine};
use super::{CalibrationOptions, Outward};
use crate::model::{FitParameter, Model, Observation};
use crate::uncertainty::surface_derivatives;

/// Pins whose residual is longer than this many standard deviations are far off: one in 450 by chance.
pub const FAR_SIGMAS: f64 = 3.5;
/// Fewer captures have no halves.
const LEAST_CAPTURES: usize = 4;

/// What a fit is with other captures. Differences are those of points of the surface as pixels show them, root mean square
/// over the places where pins touch, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossChecks {
    /// Standard deviation of the whole by the errors of observations alone; 0 where nobody says how the surface lies.
    pub sigma_mm: f64,
    /// Every other capture against the rest; `None` where there are too few, or a half does not tell all.
    pub halves_mm: Option<f64>,
    /// By how much the surface moves without each capture in turn; `None` where it cannot be fitted without it.
    pub without_mm: Vec<Option<f64>>,
    /// Observations that are far off, the farthest first: which, and how many standard deviations.
    pub far: Vec<(usize, f64)>,
}

impl CrossChecks {
    /// What halves differ by where [`CrossChecks::sigma_mm`] is right: each has twice the variance, and so has their
    /// difference.
    pub fn halves_expected_mm(&self) -> f64 {
        2.0 * self.sigma_mm
    }

    /// How much more a capture moves the surface than one of so many does on average.
    pub fn influence(&self, capture: usize) -> Option<f64> {
        let count = self.without_mm.len() as f64;
        let moved_mm = self.without_mm.get(capture).copied().flatten()?;
        (self.sigma_mm > 0.0).then(|| moved_mm / (self.sigma_mm / count.sqrt()))
    }
}

/// Of a fit with the covariance that errors of observations alone give it.
pub(super) fn cross_checks(
    fit: &PoseSolution,
    observations: &[Observation],
    options: &CalibrationOptions<'_>,
    of_pixels: &DMatrix<f64>,
) -> CrossChecks {
    let loss = options.loss;
    let captures = observations.iter().map(|o| o.contact.capture + 1).max().unwrap_or(0);
    let surface = surface(fit, observations, options.outward);
    let rms_mm = |by: &DVector<f64>| by.dot(&(&surface * by)).max(0.0).sqrt();
    let of = |kept: &dyn Fn(usize) -> bool| {
        let some: Vec<Observation> =
            observations.iter().filter(|o| kept(o.contact.capture)).cloned().collect();
        Some(refine(&fit.model, &fit.parameters, &some, loss).ok()?.model)
    };
    let moved = |model: &Model, from: &Model| rms_mm(&step(model, from, &fit.parameters));
    let halves = [0, 1].map(|half| of(&|capture| capture % 2 == half));
    let halves_mm = match halves {
        [Some(even), Some(odd)] if captures >= LEAST_CAPTURES => Some(moved(&even, &odd)),
        _ => None,
    };
    let without_mm = (0..captures)
        .map(|left_out| Some(moved(&of(&|capture| capture != left_out)?, &fit.model)))
        .collect();
    let sigmas = |(i, residual): (usize, Option<nalgebra::Vector2<f64>>)| {
        Some((i, residual?.norm() / observations[i].sigma_px))
    };
    let residuals = fit.residuals_px(observations).into_iter().enumerate();
    let mut far: Vec<(usize, f64)> =
        residuals.filter_map(sigmas).filter(|(_, sigmas)| *sigmas > FAR_SIGMAS).collect();
    far.sort_by(|a, b| b.1.total_cmp(&a.1));
    CrossChecks {
        sigma_mm: (&surface * of_pixels).trace().max(0.0).sqrt(),
        halves_mm,
        without_mm,
        far,
    }
}

/// Mean of `D'D` over the places where pins touch, `D` the derivatives of what a pixel shows there.
fn surface(
    fit: &PoseSolution,
    observations: &[Observation],
    outward: Option<Outward<'_>>,
) -> DMatrix<f64> {
    let count = fit.parameters.len();
    let (mut sum, mut places) = (DMatrix::zeros(count, count), 0.0);
    for contact in observations.iter().map(|o| &o.contact) {
        let place = contact.contact_in_sensor_mm;
        let of_axis = || contact.axis_in_sensor.map(|axis| -axis);
        let Some(outward) = outward.map(|Outward(at)| at(&place)).or_else(of_axis) else {
            continue;
        };
        if let Some(by) = surface_derivatives(&fit.model, &fit.parameters, place, outward) {
            sum += by.point.transpose() * by.point;
            places += 1.0;
        }
    }
    sum / f64::max(places, 1.0)
}

/// From one model to another, by parameters.
fn step(to: &Model, from: &Model, parameters: &[FitParameter]) -> DVector<f64> {
    let [after, before] = [to, from].map(|model| model.camera_from_sensor);
    let turned = Rotation3::from_matrix_unchecked(after.rotation() * before.rotation().transpose());
    let turned = turned.scaled_axis();
    let by = |parameter: &FitParameter| match parameter {
        FitParameter::Rotation(axis) => turned[*axis as usize],
        // A factor, which has no value of its own.
        FitParameter::FocalScale => {
            let [after, before] = [to, from].map(|model| model.camera.lens().intrinsics().fx_px);
            after / before - 1.0
        }
        other => to.value(*other).unwrap_or(0.0) - from.value(*other).unwrap_or(0.0),
    };
    DVector::from_iterator(parameters.len(), parameters.iter().map(by))
}
