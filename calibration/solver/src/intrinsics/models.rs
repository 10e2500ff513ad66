//! Start values of the lens models among which the images choose.

use fabkit_camera::{Camera, Interface, LensModel, Point3};
use nalgebra::{DMatrix, DVector};

use crate::information::ScaledCholesky;

/// Finds the camera of a model that is most like `other` for directions up to `angle_rad` off the axis. `None` if the
/// model does not reach that far.
///
/// The fit begins with the innermost directions and proceeds outwards: a lens without distortion is right near its
/// axis, but farther out too wrong for the model to converge in one step.
pub(super) fn fit_model_to_camera(
    model: LensModel,
    other: &Camera,
    angle_rad: f64,
) -> Option<Camera> {
    let (width_px, height_px) = (other.width_px(), other.height_px());
    let lens = model.start_lens(other.lens().intrinsics())?;
    let mut camera = Camera::new(width_px, height_px, lens, Interface::None).ok()?;
    for part in 1..=PARTS {
        let limit_rad = angle_rad * f64::from(part) / f64::from(PARTS);
        camera = closest(camera, other, limit_rad)?;
    }
    Some(camera)
}

/// Number of stages in which the fit proceeds outwards.
const PARTS: u32 = 12;
/// Number of rings in the fan of directions.
const RINGS: u32 = 24;
/// Number of directions on a ring.
const SPOKES: u32 = 8;
/// Number of iterations of each fit.
const ITERATIONS: usize = 15;

/// Fits a camera to the pixels of a fan of directions by least squares.
fn closest(start: Camera, other: &Camera, limit_rad: f64) -> Option<Camera> {
    let mut fan = Vec::new();
    for ring in 0..RINGS {
        let (s, c) = (limit_rad * f64::from(ring + 1) / f64::from(RINGS)).sin_cos();
        for spoke in 0..SPOKES {
            let turn = std::f64::consts::TAU * f64::from(spoke) / f64::from(SPOKES);
            let direction = Point3::new(s * turn.cos(), s * turn.sin(), c);
            fan.push((direction, other.project(&direction).ok()?));
        }
    }
    let build = |camera: &Camera| {
        let n = camera.parameter_count();
        let (mut cost, mut normal, mut gradient) = (0.0, DMatrix::zeros(n, n), DVector::zeros(n));
        for (direction, pixel) in &fan {
            let projected = camera.project_with_jacobians(direction).ok()?;
            let residual = pixel - projected.pixel;
            cost += residual.norm_squared();
            for (i, by_i) in projected.by_parameters.iter().enumerate() {
                gradient[i] += by_i.dot(&residual);
                for (j, by_j) in projected.by_parameters.iter().enumerate() {
                    normal[(i, j)] += by_i.dot(by_j);
                }
            }
        }
        Some((cost, normal, gradient))
    };
    let mut camera = start;
    let (mut cost, mut normal, mut gradient) = build(&camera)?;
    // Levenberg-Marquardt without robust loss: the pixels are exact.
    let mut damping = 1e-6;
    for _ in 0..ITERATIONS {
        let step = ScaledCholesky::damped(&normal, damping)?.solve(&gradient);
        let values = camera.parameters();
        let values: Vec<f64> = values.iter().zip(step.iter()).map(|((_, v), s)| v + s).collect();
        let tried = camera.with_parameters(&values).ok();
        match tried.and_then(|tried| Some((tried, build(&tried)?))) {
            Some((tried, next)) if next.0 <= cost => {
                camera = tried;
                (cost, normal, gradient) = next;
                damping = (damping * 0.1).max(1e-9);
            }
            _ => damping *= 10.0,
        }
    }
    Some(camera)
}
