//! Least-squares fits of a few positive parameters.

use nalgebra::{DMatrix, DVector};

/// Maximum number of accepted steps.
const MAX_STEPS: usize = 60;
/// Step of the numerical derivatives, in the logarithm of a parameter.
const DERIVATIVE_STEP: f64 = 1e-5;
/// Minimum damping. Less gains nothing, and is lost in rounding once a parameter is so close to zero that it has no
/// effect.
const MIN_DAMPING: f64 = 1e-9;
/// Minimum damping scale of a parameter without effect, relative to that of the parameter with the largest effect.
const MIN_RELATIVE_DIAGONAL: f64 = 1e-12;
/// Relative decrease of the sum of squares below which the fit ends.
const MIN_RELATIVE_DECREASE: f64 = 1e-10;

/// Finds positive parameters that minimize the sum of squared residuals, by least squares in their logarithms
/// (Levenberg 1944, Marquardt 1963).
///
/// `residuals` must return the same number of values each time. Returns `None` if the residuals are not finite at the
/// end.
///
/// ```
/// // A decay through four points.
/// let points = [(0.0, 8.0), (1.0, 4.0), (2.0, 2.0), (3.0, 1.0)];
/// let residuals = |p: &[f64]| points.map(|(x, y): (f64, f64)| p[0] * (-p[1] * x).exp() - y).to_vec();
/// let found = fabkit_light::fit_positive(residuals, &[1.0, 1.0]).unwrap();
/// assert!((found[0] - 8.0).abs() < 1e-6 && (found[1] - 2.0f64.ln()).abs() < 1e-6);
/// ```
pub fn fit_positive(residuals: impl Fn(&[f64]) -> Vec<f64>, start: &[f64]) -> Option<Vec<f64>> {
    let values = |logs: &DVector<f64>| logs.iter().map(|log| log.exp()).collect::<Vec<f64>>();
    let at = |logs: &DVector<f64>| DVector::from_vec(residuals(&values(logs)));
    let mut logs = DVector::from_iterator(start.len(), start.iter().map(|value| value.ln()));
    let mut left = at(&logs);
    let mut damping = 1e-3;
    for _ in 0..MAX_STEPS {
        let mut slopes = DMatrix::zeros(left.len(), logs.len());
        for k in 0..logs.len() {
            let mut moved = logs.clone();
            moved[k] += DERIVATIVE_STEP;
            slopes.set_column(k, &((at(&moved) - &left) / DERIVATIVE_STEP));
        }
        let (normal, slope) = (slopes.transpose() * &slopes, slopes.transpose() * &left);
        let held = MIN_RELATIVE_DIAGONAL * normal.diagonal().amax();
        let mut is_better = false;
        while !is_better && damping < 1e12 {
            let mut damped = normal.clone();
            // `MIN_POSITIVE` keeps the matrix positive definite even if no parameter has an effect.
            for k in 0..logs.len() {
                damped[(k, k)] += damping * normal[(k, k)].max(held) + f64::MIN_POSITIVE;
            }
            let Some(damped) = damped.cholesky() else {
                damping *= 8.0;
                continue;
            };
            let step = damped.solve(&slope);
            // No parameter changes by more than a factor of e at once. Clamping each one separately means that a
            // parameter without effect, which asks for a huge step, does not shorten the steps of the others.
            let step = step.map(|of| of.clamp(-1.0, 1.0));
            let next = &logs - step;
            let next_left = at(&next);
            let (before, after) = (left.norm_squared(), next_left.norm_squared());
            if after < before {
                let is_enough = before - after < MIN_RELATIVE_DECREASE * before;
                (logs, left, is_better) = (next, next_left, true);
                damping = MIN_DAMPING.max(0.2 * damping);
                if is_enough {
                    return Some(values(&logs));
                }
            } else {
                damping *= 8.0;
            }
        }
        if !is_better {
            break;
        }
    }
    left.norm().is_finite().then(|| values(&logs))
}

/// Solves a linear least-squares problem: finds the coefficients of the columns whose sum is closest to `wanted`, one
/// row per equation. Returns `None` if the columns are not independent.
///
/// ```
/// // A line through three points.
/// let found = fabkit_light::linear_fit(&[[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]], &[1.0, 3.0, 5.0]).unwrap();
/// assert!((found[0] - 1.0).abs() < 1e-12 && (found[1] - 2.0).abs() < 1e-12);
/// ```
pub fn linear_fit<const N: usize>(rows: &[[f64; N]], wanted: &[f64]) -> Option<[f64; N]> {
    let columns = DMatrix::from_fn(rows.len(), N, |row, column| rows[row][column]);
    let wanted = DVector::from_column_slice(wanted);
    let normal = columns.transpose() * &columns;
    let found = normal.cholesky()?.solve(&(columns.transpose() * wanted));
    Some(std::array::from_fn(|column| found[column]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_that_would_be_negative_goes_to_zero_while_others_converge() {
        // The best line would have a negative offset, and only the product of the two slopes is determined.
        let points = [(1.0, 0.1), (2.0, 1.2), (3.0, 1.9), (4.0, 3.1)];
        let residuals =
            |p: &[f64]| points.map(|(x, y): (f64, f64)| p[0] * p[1] * x + p[2] - y).to_vec();
        for ground in [1e-12, 1e-3, 1.0, 30.0] {
            let found = fit_positive(residuals, &[0.5, 3.0, ground]).unwrap();
            // The slope without an offset: the sum of x y over that of x x.
            let slope = points.iter().map(|(x, y)| x * y).sum::<f64>() / 30.0;
            assert!((found[0] * found[1] - slope).abs() < 1e-3 && found[2] < 1e-3, "{found:?}");
        }
    }
}
