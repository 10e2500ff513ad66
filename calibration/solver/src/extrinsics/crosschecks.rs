//! Cross-checks of a fit with other captures: halves of them, all but one, and outlying pins.

use nalgebra::{DMatrix, DVector, Rotation3};

use super::refine::{PoseSolution, refine};
use super::{CalibrationOptions, SurfaceNormal};
use crate::model::{FitParameter, Model, Observation};
use crate::uncertainty::surface_derivatives;

/// Length of a residual, in standard deviations, from which a pin is an outlier: one in 450 by chance.
pub const OUTLIER_SIGMAS: f64 = 3.5;
/// Smallest number of captures that are compared by halves.
const LEAST_CAPTURES: usize = 4;

/// Differences between fits to different captures: of points of the surface as pixels show them, root mean square over
/// the places where pins touch, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossChecks {
    /// Standard deviation of the whole fit by the errors of observations alone; 0 if the surface's normals are unknown.
    pub sigma_mm: f64,
    /// Difference between fits to the even and the odd captures; `None` if there are too few, or a half does not
    /// determine all parameters.
    pub halves_mm: Option<f64>,
    /// Displacement of the surface if each capture in turn is left out; `None` if the fit without it fails.
    pub without_mm: Vec<Option<f64>>,
    /// Outlying observations, the farthest first: index, and length of the residual in standard deviations.
    pub outliers: Vec<(usize, f64)>,
}

impl CrossChecks {
    /// Returns the expected difference of the halves if [`CrossChecks::sigma_mm`] is right: each half has twice the
    /// variance, and their difference four times.
    pub fn halves_expected_mm(&self) -> f64 {
        2.0 * self.sigma_mm
    }

    /// Computes a capture's displacement of the surface relative to the average of as many equal captures.
    ///
    /// ```
    /// use fabkit_calibration::extrinsics::CrossChecks;
    /// let checks = CrossChecks {
    ///     sigma_mm: 0.1,
    ///     halves_mm: None,
    ///     without_mm: vec![Some(0.05), Some(0.05), Some(0.2), None],
    ///     outliers: Vec::new(),
    /// };
    /// // An average one of four captures moves the surface by 0.1 mm over the square root of 4.
    /// assert_eq!(checks.influence(0), Some(1.0));
    /// assert_eq!(checks.influence(2), Some(4.0));
    /// assert_eq!(checks.influence(3), None);
    /// ```
    pub fn influence(&self, capture: usize) -> Option<f64> {
        let count = self.without_mm.len() as f64;
        let moved_mm = self.without_mm.get(capture).copied().flatten()?;
        (self.sigma_mm > 0.0).then(|| moved_mm / (self.sigma_mm / count.sqrt()))
    }
}

/// Compares a fit with fits to other captures. `of_pixels` is its covariance caused by the errors of observations
/// alone.
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
    // Even and odd captures, so that a drift over time affects both halves equally.
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
        residuals.filter_map(sigmas).filter(|(_, sigmas)| *sigmas > OUTLIER_SIGMAS).collect();
    far.sort_by(|a, b| b.1.total_cmp(&a.1));
    CrossChecks {
        sigma_mm: (&surface * of_pixels).trace().max(0.0).sqrt(),
        halves_mm,
        without_mm,
        outliers: far,
    }
}

/// Computes the mean of `D'D` over the places where pins touch, where `D` are the derivatives of the surface point that
/// a pixel shows there.
fn surface(
    fit: &PoseSolution,
    observations: &[Observation],
    outward: Option<SurfaceNormal<'_>>,
) -> DMatrix<f64> {
    let count = fit.parameters.len();
    let (mut sum, mut places) = (DMatrix::zeros(count, count), 0.0);
    for contact in observations.iter().map(|o| &o.contact) {
        let place = contact.contact_in_sensor_mm;
        // A pin that is pushed straight in shows the normal.
        let of_axis = || contact.axis_in_sensor.map(|axis| -axis);
        let Some(outward) = outward.map(|SurfaceNormal(at)| at(&place)).or_else(of_axis) else {
            continue;
        };
        if let Some(by) = surface_derivatives(&fit.model, &fit.parameters, place, outward) {
            sum += by.point_mm_by_parameters.transpose() * by.point_mm_by_parameters;
            places += 1.0;
        }
    }
    sum / f64::max(places, 1.0)
}

/// Computes the difference of two models by parameters.
fn step(to: &Model, from: &Model, parameters: &[FitParameter]) -> DVector<f64> {
    let [after, before] = [to, from].map(|model| model.camera_from_sensor);
    let turned = Rotation3::from_matrix_unchecked(after.rotation() * before.rotation().transpose());
    let turned = turned.scaled_axis();
    let by = |parameter: &FitParameter| match parameter {
        FitParameter::Rotation(axis) => turned[*axis as usize],
        // A factor relative to the model's own focal length has no value; see [`Model::value`].
        FitParameter::FocalScale => {
            let [after, before] = [to, from].map(|model| model.camera.lens().intrinsics().fx_px);
            after / before - 1.0
        }
        other => to.value(*other).unwrap_or(0.0) - from.value(*other).unwrap_or(0.0),
    };
    DVector::from_iterator(parameters.len(), parameters.iter().map(by))
}
