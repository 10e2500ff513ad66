//! Root finding in brackets, so that no root is missed: Newton's method inside a bracket that always shrinks.

/// Finds the root of an increasing function between `low` and `high`, to the last digits.
///
/// `f` returns value and slope, with `f(low) <= 0 <= f(high)`. A Newton step is taken if it stays in the bracket and is
/// at most half of the previous step; otherwise the bracket is halved, so that the search ends even if the slope is
/// wrong.
pub(crate) fn find_increasing_root(
    f: impl Fn(f64) -> (f64, f64),
    mut low: f64,
    mut high: f64,
    start: f64,
) -> f64 {
    let mut x = start.clamp(low, high);
    let mut last_step = high - low;
    // 64 halvings exhaust the digits of any bracket; Newton's method needs about five steps.
    for _ in 0..200 {
        let (value, slope) = f(x);
        if value == 0.0 {
            return x;
        }
        // The bracket shrinks to the side on which the root lies.
        *(if value < 0.0 { &mut low } else { &mut high }) = x;
        // A slope of 0 makes this infinite or NaN, which fails the comparisons below: then the bracket is halved.
        let newton = x - value / slope;
        let halves = (newton - x).abs() <= 0.5 * last_step.abs();
        let next =
            if newton >= low && newton <= high && halves { newton } else { 0.5 * (low + high) };
        last_step = next - x;
        x = next;
        if last_step.abs() <= f64::EPSILON * x.abs() {
            break;
        }
    }
    x
}

/// Finds the smallest `x` in `(0, upper]` where a polynomial that is positive at 0 ceases to be positive.
///
/// `coefficients[i]` belongs to `x^i`. The polynomial is monotone between the roots of its derivative, which are found
/// by recursion one degree lower, so that no root is missed.
pub(crate) fn first_zero(coefficients: &[f64], upper: f64) -> Option<f64> {
    zeros(coefficients, upper).first().copied()
}

/// Finds all sign changes of a polynomial in `(0, upper]`, ascending.
fn zeros(coefficients: &[f64], upper: f64) -> Vec<f64> {
    let Some(degree) = coefficients.iter().rposition(|c| *c != 0.0).filter(|d| *d > 0) else {
        return Vec::new();
    };
    let coefficients = &coefficients[..=degree];
    let derivative: Vec<f64> =
        coefficients.iter().enumerate().skip(1).map(|(i, c)| i as f64 * c).collect();
    let value = |x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let slope = |x: f64| derivative.iter().rev().fold(0.0, |sum, c| sum * x + c);

    let mut bounds = zeros(&derivative, upper);
    bounds.push(upper);
    let mut roots = Vec::new();
    let mut low = 0.0;
    for high in bounds {
        let (at_low, at_high) = (value(low), value(high));
        // A zero exactly at the upper end counts here, and not again at the lower end of the next interval.
        if (at_low > 0.0 && at_high <= 0.0) || (at_low < 0.0 && at_high >= 0.0) {
            let sign = -at_low.signum();
            let rising = |x| (sign * value(x), sign * slope(x));
            roots.push(find_increasing_root(rising, low, high, 0.5 * (low + high)));
        }
        low = high;
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_root_of_a_product_is_found() {
        // (x - 1)(x - 2)(x - 3)(x + 4) = -24 + 38 x - 13 x^2 - 2 x^3 + x^4
        let roots = zeros(&[-24.0, 38.0, -13.0, -2.0, 1.0], 10.0);
        assert_eq!(roots.len(), 3);
        for (root, expected) in roots.iter().zip([1.0, 2.0, 3.0]) {
            assert!((root - expected).abs() < 1e-14);
        }
        assert_eq!(zeros(&[-24.0, 38.0, -13.0, -2.0, 1.0], 1.5).len(), 1);
    }

    #[test]
    fn touching_zero_counts() {
        // (x - 1)^2, then a constant
        // A double root is known to the root of the rounding only.
        assert!((first_zero(&[1.0, -2.0, 1.0], 10.0).unwrap() - 1.0).abs() < 1e-7);
        assert_eq!(first_zero(&[1.0, 0.0, 0.0], 10.0), None);
    }

    #[test]
    fn a_slope_that_misleads_does_not_matter() {
        // The slope is a hundred times too small, so that every Newton step overshoots.
        let root = find_increasing_root(|x| (x.powi(3) - 8.0, 0.03 * x * x), 0.0, 1e6, 5e5);
        assert!((root - 2.0).abs() < 1e-14);
    }
}
