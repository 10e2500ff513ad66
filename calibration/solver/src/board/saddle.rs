//! Saddle points of the intensity, where two dark and two light squares meet.
//!
//! A corner of a checkerboard is symmetric under half a turn. Smoothing with a round kernel therefore leaves the saddle
//! point of its intensity at the corner, whatever the blur and the angle between the edges. The saddle point is the
//! zero of the gradient. Newton's method on derivatives of a Gaussian, evaluated at real coordinates, finds it without
//! interpolating the image.

use fabkit_camera::{Point2, Vector2};
use nalgebra::Matrix2;

use crate::image::GreyImage;

/// Radius at which the Gaussian is cut off, in standard deviations: its tail is 4e-6 of its peak.
const KERNEL_REACH: f64 = 5.0;
/// Smallest distance of a saddle from the border, in standard deviations: nearer, the smoothing would need pixels that
/// do not exist.
const BORDER: f64 = 3.0;
/// Largest ratio of the two curvatures: edges that cross at less than about 35 degrees are more often a scratch than a
/// corner.
const MAX_CURVATURE_RATIO: f64 = 10.0;
/// Largest distance of Newton's method from its start, in standard deviations.
const MAX_WALK: f64 = 1.5;
/// Largest number of steps of Newton's method.
const NEWTON_STEPS: usize = 12;
/// Length of a step, px, below which Newton's method has converged.
const STEP_PX: f64 = 1e-4;
/// Smallest response of a candidate, as a fraction of the strongest: weaker ones are texture.
const MIN_RELATIVE_RESPONSE: f32 = 1e-3;
/// Smallest square root of a candidate's response, as a multiple of its noise.
const MIN_SIGNAL_TO_NOISE: f32 = 6.0;
/// Largest number of candidates examined, the strongest first.
const MAX_CANDIDATES: usize = 6000;

/// Saddle point of the intensity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Saddle {
    /// Column and row, px.
    pub at: Point2<f64>,
    /// Approximate unit vectors along the two edges. The sector between them, turning from the first to the second the
    /// short way (from +x towards +y), and the opposite sector are light; the others are dark.
    pub edges: [Vector2<f64>; 2],
    /// Intensity difference between light and dark, as far as the blur leaves it.
    pub contrast: f64,
    /// Largest standard deviation of `at` in any direction, from the image's noise, px.
    pub noise_px: f64,
}

/// Derivatives of the smoothed image at a point.
struct LocalDerivatives {
    gradient: Vector2<f64>,
    hessian: Matrix2<f64>,
}

/// Finds all saddles of an image smoothed with `sigma_px`, the strongest first.
pub(super) fn find(image: &GreyImage, sigma_px: f64, noise: f64) -> Vec<Saddle> {
    let smooth = image.blurred(sigma_px as f32);
    let response = responses(&smooth);
    // Standard deviation of a second derivative of smoothed white noise: sqrt(3 / (16 pi)) / s^3.
    let noise_of_response = (noise * 0.244 / sigma_px.powi(3)) as f32;
    let strongest = response.iter().copied().fold(0.0, f32::max);
    // The response is a product of two second derivatives, hence the square of the noise.
    // The response is relative to the strongest corner, but must also stand out of the noise.
    let weakest =
        (MIN_RELATIVE_RESPONSE * strongest).max((MIN_SIGNAL_TO_NOISE * noise_of_response).powi(2));
    let mut peaks = peaks(&response, image.width_px(), sigma_px.ceil() as usize, weakest);
    // Ties are broken by position, so that the order is the same in every run.
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    peaks.truncate(MAX_CANDIDATES);
    let mut saddles: Vec<Saddle> = Vec::new();
    for (_, [x, y]) in peaks {
        let start = Point2::new(x as f64, y as f64);
        let Some(saddle) = refine(image, start, sigma_px, noise) else { continue };
        // Newton's method may lead from two peaks to one saddle.
        if saddles.iter().all(|other| (other.at - saddle.at).norm() > 1.0) {
            saddles.push(saddle);
        }
    }
    saddles
}

/// Finds the saddle next to `start`, if there is one.
pub(super) fn refine(
    image: &GreyImage,
    start: Point2<f64>,
    sigma_px: f64,
    noise: f64,
) -> Option<Saddle> {
    let mut at = start;
    for _ in 0..NEWTON_STEPS {
        let local = derivatives_at(image, at, sigma_px)?;
        let step = -(local.hessian.try_inverse()? * local.gradient);
        at += step;
        let walked = (at - start).norm();
        if walked.is_nan() || walked > MAX_WALK * sigma_px {
            return None;
        }
        if step.norm() < STEP_PX {
            return saddle_from_hessian(&local.hessian, at, sigma_px, noise);
        }
    }
    None
}

/// Derives a saddle's edges, contrast and uncertainty from the Hessian; `None` if it is no corner.
fn saddle_from_hessian(
    hessian: &Matrix2<f64>,
    at: Point2<f64>,
    sigma_px: f64,
    noise: f64,
) -> Option<Saddle> {
    let eigen = hessian.symmetric_eigen();
    let (light, dark) = if eigen.eigenvalues[0] > eigen.eigenvalues[1] { (0, 1) } else { (1, 0) };
    let (rise, fall) = (eigen.eigenvalues[light], -eigen.eigenvalues[dark]);
    // Opposite curvatures: brighter along one axis, darker along the other.
    let is_saddle = rise > 0.0 && fall > 0.0;
    if !is_saddle || rise.max(fall) > MAX_CURVATURE_RATIO * rise.min(fall) {
        return None;
    }
    // The intensity does not curve along the edges: tan^2 of their angle to the middle of the light sector is the ratio
    // of the curvatures.
    let middle: Vector2<f64> = eigen.eigenvectors.column(light).into_owned();
    let across = Vector2::new(-middle.y, middle.x);
    let (s, c) = (rise / fall).sqrt().atan().sin_cos();
    let curvature = (rise * fall).sqrt();
    // The smoothed corner of contrast A has the mixed derivative A / (pi s^2). The gradient of smoothed white noise has
    // the variance n^2 / (8 pi s^4).
    let noise_of_gradient = noise / ((8.0 * std::f64::consts::PI).sqrt() * sigma_px.powi(2));
    Some(Saddle {
        at,
        edges: [middle * c - across * s, middle * c + across * s],
        contrast: std::f64::consts::PI * sigma_px.powi(2) * curvature,
        noise_px: noise_of_gradient / rise.min(fall),
    })
}

/// Computes the derivatives of the image smoothed with a Gaussian, at real coordinates.
fn derivatives_at(image: &GreyImage, at: Point2<f64>, sigma_px: f64) -> Option<LocalDerivatives> {
    let (width, height) = (image.width_px(), image.height_px());
    let border = BORDER * sigma_px;
    let inside = |v: f64, n: usize| v >= border && v <= n as f64 - 1.0 - border;
    if !inside(at.x, width) || !inside(at.y, height) {
        return None;
    }
    let reach = (KERNEL_REACH * sigma_px).ceil() as isize;
    let taps = |v: f64, n: usize| {
        let centre = v.round() as isize;
        (centre - reach..=centre + reach).map(move |i| {
            let d = (i as f64 - v) / sigma_px;
            (i.clamp(0, n as isize - 1) as usize, d, (-0.5 * d * d).exp())
        })
    };
    let columns: Vec<_> = taps(at.x, width).collect();
    // A constant has no derivative; without it the kernel's cut tail matters less.
    let offset = image.at(at.x.round() as usize, at.y.round() as usize);
    let mut sums = [0.0; 5];
    for (y, dy, weight_y) in taps(at.y, height) {
        let mut row = [0.0; 3];
        for &(x, dx, weight_x) in &columns {
            let value = weight_x * f64::from(image.at(x, y) - offset);
            row[0] += value;
            row[1] += value * dx;
            row[2] += value * (dx * dx - 1.0);
        }
        sums[0] += weight_y * row[1];
        sums[1] += weight_y * dy * row[0];
        sums[2] += weight_y * row[2];
        sums[3] += weight_y * dy * row[1];
        sums[4] += weight_y * (dy * dy - 1.0) * row[0];
    }
    let scale = 1.0 / (std::f64::consts::TAU * sigma_px.powi(2));
    let (first, second) = (scale / sigma_px, scale / sigma_px.powi(2));
    Some(LocalDerivatives {
        gradient: Vector2::new(sums[0], sums[1]) * first,
        hessian: Matrix2::new(sums[2], sums[3], sums[3], sums[4]) * second,
    })
}

/// Computes minus the determinant of the Hessian at every pixel; 0 on the border.
fn responses(smooth: &GreyImage) -> Vec<f32> {
    let (width, height, v) = (smooth.width_px(), smooth.height_px(), smooth.values());
    let mut out = vec![0.0; v.len()];
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let i = y * width + x;
            let xx = v[i - 1] + v[i + 1] - 2.0 * v[i];
            let yy = v[i - width] + v[i + width] - 2.0 * v[i];
            let xy =
                0.25 * (v[i - width - 1] + v[i + width + 1] - v[i - width + 1] - v[i + width - 1]);
            out[i] = xy * xy - xx * yy;
        }
    }
    out
}

/// Finds pixels that are the largest within `radius` pixels and above `weakest`, with their positions.
fn peaks(response: &[f32], width: usize, radius: usize, weakest: f32) -> Vec<(f32, [usize; 2])> {
    let height = response.len() / width;
    let mut peaks = Vec::new();
    for y in radius..height - radius {
        for x in radius..width - radius {
            let here = response[y * width + x];
            if here <= weakest {
                continue;
            }
            let rows = y - radius..=y + radius;
            // Of equal neighbours the first is the peak.
            let is_peak = rows.clone().all(|v| {
                (x - radius..=x + radius).all(|u| {
                    let other = response[v * width + u];
                    other < here || (other == here && (v, u) >= (y, x))
                })
            });
            if is_peak {
                peaks.push((here, [x, y]));
            }
        }
    }
    peaks
}

/// Estimates the standard deviation of the image's noise, at least that of rounding to 8 bits.
///
/// The mask cancels everything that is linear in x or in y (J. Immerkaer, "Fast Noise Variance Estimation", CVIU 1996).
/// The median, in place of the mean, is not affected by edges.
pub(super) fn noise(image: &GreyImage) -> f64 {
    let (width, height, v) = (image.width_px(), image.height_px(), image.values());
    let mut magnitudes = Vec::with_capacity(v.len());
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let i = y * width + x;
            let row = |i: usize| v[i - 1] - 2.0 * v[i] + v[i + 1];
            magnitudes.push((row(i - width) - 2.0 * row(i) + row(i + width)).abs());
        }
    }
    let middle = magnitudes.len() / 2;
    let (_, median, _) = magnitudes.select_nth_unstable_by(middle, f32::total_cmp);
    // The root of the sum of squares of the mask's weights is 6; 0.6745 is the median of |N(0, 1)|.
    let rounding = 1.0 / (255.0 * 12f64.sqrt());
    (f64::from(*median) / (6.0 * 0.6745)).max(rounding)
}
