//! Where the camera is, from pins at known places.

mod linear;
mod refine;

use fabkit_camera::Camera;
use fabkit_geometry::Pose;

pub use refine::{Fit, Loss, SolveError, refine};

use crate::model::{Model, Observation, Parameter};

/// The pose that rays through the observed pixels give without a starting value; `None` for fewer
/// than six pins, or pins whose contacts lie in a plane.
pub fn pose_without_start(camera: &Camera, observations: &[Observation]) -> Option<Pose> {
    let mut rays = Vec::with_capacity(observations.len());
    let mut points = Vec::with_capacity(observations.len());
    for observation in observations {
        // A pixel outside the lens's image has no ray; refinement will deal with its pin.
        if let Ok(ray) = camera.unproject(&observation.pixel) {
            rays.push(ray);
            points.push(observation.contact.contact_in_sensor_mm);
        }
    }
    linear::pose_from_rays(&rays, &points)
}

/// Solves for the pose alone, from a linear solution if there is one and else from `nominal`.
///
/// # Errors
/// As [`refine`], also where there is neither a linear solution nor a nominal pose.
pub fn solve_pose(
    camera: &Camera,
    observations: &[Observation],
    nominal: Option<&Pose>,
    loss: Loss,
) -> Result<Fit, SolveError> {
    let linear = pose_without_start(camera, observations);
    let starts = [linear, nominal.copied()];
    let mut best: Option<Result<Fit, SolveError>> = None;
    for start in starts.into_iter().flatten() {
        let fit = refine(&Model::new(*camera, start), &Parameter::POSE, observations, loss);
        if fit.is_ok() {
            return fit;
        }
        best.get_or_insert(fit);
    }
    best.unwrap_or_else(|| {
        Err(SolveError::TooFew { unknowns: 6, coordinates: 2 * observations.len() })
    })
}
