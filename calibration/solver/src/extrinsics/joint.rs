//! Joint covariance of the pose and the camera after a fit.
//!
//! The camera comes from another calibration, with errors of its own. The fit uses the camera as given, so that the
//! pose and the other solved parameters take up a part of the camera's errors. With `A` the derivatives of the pixels
//! by the solved parameters, `B` those by the fixed ones, and the weights `W`, to first order
//!
//! ```text
//! error solved = (A' W A)^-1 A' W noise - (A' W A)^-1 A' W B (error fixed)
//! ```
//!
//! and the second part correlates the two ("consider" parameters: S. Schmidt, "Application of State-Space Methods to
//! Navigation Problems", 1966). The value and the variance that were given for a solved parameter do not matter: the
//! variance is replaced.

use fabkit_camera::{CameraEstimate, InvalidCovariance, JointEstimate, POSE_PARAMETER_COUNT};
use nalgebra::{DMatrix, Vector2};

use super::refine::{Loss, PoseSolution};
use crate::model::{FitParameter, Observation};

/// Covariances that [`joint_estimate`] computes.
#[derive(Clone, Debug, PartialEq)]
pub struct JointCovariance {
    /// Covariance of the solved parameters, in their order and units, including the errors of the given camera.
    pub fit_covariance: DMatrix<f64>,
    /// Joint estimate of pose and camera.
    pub estimate: JointEstimate,
}

/// Computes the covariance of a fit and of the camera that it used.
///
/// `given` is the camera before the fit; `noise` is the covariance of the solved parameters caused by the errors of the
/// observations alone.
///
/// # Errors
/// Fails if the covariance is not finite.
pub fn joint_estimate(
    given: &CameraEstimate,
    fit: &PoseSolution,
    observations: &[Observation],
    loss: Loss,
    noise: &DMatrix<f64>,
) -> Result<JointCovariance, InvalidCovariance> {
    let camera = &fit.model.camera;
    let held: Vec<FitParameter> =
        camera.parameters().into_iter().map(|(name, _)| FitParameter::Camera(name)).collect();
    let of_given = given_covariance(given, fit, &held);
    let scale = scale_by_given(given, fit);
    // Derivative of the solved parameters by the given ones.
    let taken_up = -(&fit.covariance * mixed_information(fit, &held, observations, loss)) * &scale;
    let of_fit = symmetric(noise + &taken_up * &of_given * taken_up.transpose());
    // Derivatives of pose and camera by the solved parameters, and by the given ones.
    let by_fit = by_fit(fit, &held);
    let mut by_given = &by_fit * &taken_up;
    // Fixed parameters are their given values, apart from the scale of the focal lengths.
    let mut camera_by_given = by_given.rows_mut(POSE_PARAMETER_COUNT, held.len());
    camera_by_given += &scale;
    let covariance =
        &by_fit * noise * by_fit.transpose() + &by_given * of_given * by_given.transpose();
    let estimate = JointEstimate::new(*camera, symmetric(covariance))?;
    Ok(JointCovariance { fit_covariance: of_fit, estimate })
}

/// Returns the covariance of the camera's parameters as given, by name; zeros for parameters that are unknown or that
/// the fit replaces.
fn given_covariance(
    given: &CameraEstimate,
    fit: &PoseSolution,
    held: &[FitParameter],
) -> DMatrix<f64> {
    let names = given.names();
    let place = |parameter: &FitParameter| match parameter {
        FitParameter::Camera(name) if !fit.parameters.contains(parameter) => {
            names.iter().position(|found| found == name)
        }
        _ => None,
    };
    let places: Vec<Option<usize>> = held.iter().map(place).collect();
    let known = given.covariance();
    DMatrix::from_fn(held.len(), held.len(), |r, c| {
        let entry = known.zip(places[r].zip(places[c]));
        entry.map_or(0.0, |(matrix, place)| matrix[place])
    })
}

/// Returns the derivatives of the camera's parameters by the given ones: 1, except for focal lengths that the fit has
/// scaled.
fn scale_by_given(given: &CameraEstimate, fit: &PoseSolution) -> DMatrix<f64> {
    let count = fit.model.camera.parameter_count();
    let mut scale = DMatrix::identity(count, count);
    let [before, after] =
        [given.camera(), &fit.model.camera].map(|camera| camera.lens().intrinsics());
    scale[(0, 0)] = after.fx_px / before.fx_px;
    scale[(1, 1)] = after.fy_px / before.fy_px;
    scale
}

/// Computes `A' W B`.
fn mixed_information(
    fit: &PoseSolution,
    held: &[FitParameter],
    observations: &[Observation],
    loss: Loss,
) -> DMatrix<f64> {
    let count = fit.parameters.len();
    let all = [&fit.parameters[..], held].concat();
    let mut columns = vec![Vector2::zeros(); all.len()];
    let mut mixed = DMatrix::zeros(count, held.len());
    for observation in observations {
        // A fit exists only if all pins are visible.
        let Ok(projected) = fit.model.differentiate(&observation.contact, &all, &mut columns)
        else {
            continue;
        };
        let residual = observation.pixel - projected;
        let precision = observation.sigma_px.powi(-2);
        let (_, weight) = loss.cost_and_weight(residual.norm_squared() * precision);
        let (solved, held) = columns.split_at(count);
        for (r, column) in solved.iter().enumerate() {
            let weighted = column * (weight * precision);
            for (c, other) in held.iter().enumerate() {
                mixed[(r, c)] += weighted.dot(other);
            }
        }
    }
    mixed
}

/// Returns the derivatives of pose and camera by the solved parameters. Seats, leans and offsets affect the pins only.
fn by_fit(fit: &PoseSolution, held: &[FitParameter]) -> DMatrix<f64> {
    let mut by_fit = DMatrix::zeros(POSE_PARAMETER_COUNT + held.len(), fit.parameters.len());
    let intrinsics = fit.model.camera.lens().intrinsics();
    for (c, parameter) in fit.parameters.iter().enumerate() {
        if let Some(r) = FitParameter::POSE.iter().position(|pose| pose == parameter) {
            by_fit[(r, c)] = 1.0;
        }
        if let Some(r) = held.iter().position(|held| held == parameter) {
            by_fit[(POSE_PARAMETER_COUNT + r, c)] = 1.0;
        }
        if let Some(by_interface) = by_interface(fit, parameter) {
            let of_interface = by_fit.nrows() - by_interface.len();
            for (r, by) in by_interface.into_iter().enumerate() {
                by_fit[(of_interface + r, c)] += by;
            }
        }
        if *parameter == FitParameter::FocalScale {
            by_fit[(POSE_PARAMETER_COUNT, c)] = intrinsics.fx_px;
            by_fit[(POSE_PARAMETER_COUNT + 1, c)] = intrinsics.fy_px;
        }
    }
    by_fit
}

/// Returns the derivatives of a drawn interface's parameters, which are the last of the camera's, by a parameter that
/// moves the interface relative to the lens.
fn by_interface(fit: &PoseSolution, parameter: &FitParameter) -> Option<Vec<f64>> {
    let model = &fit.model;
    let column = match parameter {
        FitParameter::InterfaceShift => POSE_PARAMETER_COUNT,
        pose => FitParameter::POSE.iter().position(|found| found == pose)?,
    };
    let by_pose = model
        .drawn_interface
        .as_ref()?
        .interface_by_pose(&model.camera_from_sensor, model.interface_shift_mm);
    let count =
        model.camera.parameters().iter().filter(|(n, _)| n.starts_with("interface_")).count();
    Some(by_pose.column(column).iter().copied().take(count).collect())
}

fn symmetric(matrix: DMatrix<f64>) -> DMatrix<f64> {
    (&matrix + matrix.transpose()) * 0.5
}
