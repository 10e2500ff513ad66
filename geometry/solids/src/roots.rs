//! Real roots of polynomials of low degree, isolated by the roots of their derivatives.
//!
//! Between two neighbouring stationary points a polynomial is monotone, so a sign change brackets exactly one root and
//! a safeguarded Newton iteration cannot miss it or leave it. The stationary points come from the same procedure one
//! degree lower. Closed formulas for cubics and quartics are shorter but lose half the digits to cancellation, which
//! shows as holes in thin tori.

/// Highest supported degree.
const MAX_DEGREE: usize = 4;

/// Short ascending list of roots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Roots {
    values: [f64; MAX_DEGREE],
    count: usize,
}

impl Roots {
    fn push(&mut self, root: f64) {
        // A root that is also the end of a bracket is found from both sides.
        if self.count < MAX_DEGREE && self.as_slice().last() != Some(&root) {
            self.values[self.count] = root;
            self.count += 1;
        }
    }

    /// Returns the roots multiplied by a positive factor.
    pub(crate) fn scaled(mut self, factor: f64) -> Self {
        self.values.iter_mut().for_each(|v| *v *= factor);
        self
    }

    pub(crate) fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

/// Computes the roots of `a x^2 + 2 half_b x + c`, ascending, by the numerically stable form of the quadratic formula.
///
/// Tangents (a vanishing discriminant) count as no root: they bound no volume. With `a = 0` the one root of the linear
/// equation is returned.
pub(crate) fn quadratic(a: f64, half_b: f64, c: f64) -> Roots {
    let mut roots = Roots::default();
    if a == 0.0 {
        if half_b != 0.0 {
            roots.push(-0.5 * c / half_b);
        }
        return roots;
    }
    let discriminant = half_b * half_b - a * c;
    // Compared this way so that NaN is refused too.
    if discriminant > 0.0 {
        // Both terms have the same sign, so nothing cancels; the other root follows from the product c / a.
        let q = -(half_b + discriminant.sqrt().copysign(half_b));
        let (x0, x1) = (q / a, c / q);
        roots.push(x0.min(x1));
        roots.push(x0.max(x1));
    }
    roots
}

/// Computes the roots in `[low, high]` of `c[0] + c[1] x + ... + c[n] x^n` with n up to 4, ascending.
///
/// A root of even multiplicity is found once, where the polynomial comes within its own rounding error of zero. Simple
/// roots are exact to a few units in the last place of the evaluation.
pub(crate) fn polynomial(c: &[f64], low: f64, high: f64) -> Roots {
    let degree = c.iter().rposition(|&v| v != 0.0).unwrap_or(0);
    debug_assert!(degree <= MAX_DEGREE);
    let mut roots = Roots::default();
    if degree == 0 {
        return roots;
    }
    let c = &c[..=degree];
    match sign_changes(c, low, high) {
        // Most calls end here, without a search.
        Some((0, _)) => return roots,
        Some((1, rising)) => {
            roots.push(find_bracketed_root(c, low, high, rising));
            return roots;
        }
        _ => {}
    }
    let mut stationary = Roots::default();
    if degree > 1 {
        let mut slope = [0.0; MAX_DEGREE];
        for (i, s) in slope.iter_mut().enumerate().take(degree) {
            *s = (i + 1) as f64 * c[i + 1];
        }
        stationary = polynomial(&slope[..degree], low, high);
    }
    // Between neighbouring stationary points the polynomial is monotone.
    let mut left = low;
    let mut at_left = value(c, left);
    for &right in stationary.as_slice().iter().chain(std::iter::once(&high)) {
        let at_right = value(c, right);
        if at_left.is_zero() {
            roots.push(left);
        } else if !at_right.is_zero() && (at_left.value < 0.0) != (at_right.value < 0.0) {
            roots.push(find_bracketed_root(c, left, right, at_left.value < 0.0));
        }
        (left, at_left) = (right, at_right);
    }
    if at_left.is_zero() {
        roots.push(high);
    }
    roots
}

/// Weights that convert Taylor to Bernstein coefficients, for each degree: C(i, j) / C(n, j).
const BERNSTEIN: [[[f64; MAX_DEGREE + 1]; MAX_DEGREE + 1]; MAX_DEGREE + 1] = bernstein();

const fn bernstein() -> [[[f64; MAX_DEGREE + 1]; MAX_DEGREE + 1]; MAX_DEGREE + 1] {
    // Pascal's triangle; `while` because `for` is not allowed in const functions.
    let mut choose = [[0.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
    let mut n = 0;
    while n <= MAX_DEGREE {
        choose[n][0] = 1.0;
        let mut k = 1;
        while k <= n {
            choose[n][k] = choose[n - 1][k - 1] + choose[n - 1][k];
            k += 1;
        }
        n += 1;
    }
    let mut weights = [[[0.0; MAX_DEGREE + 1]; MAX_DEGREE + 1]; MAX_DEGREE + 1];
    let mut n = 0;
    while n <= MAX_DEGREE {
        let mut i = 0;
        while i <= n {
            let mut j = 0;
            while j <= i {
                weights[n][i][j] = choose[i][j] / choose[n][j];
                j += 1;
            }
            i += 1;
        }
        n += 1;
    }
    weights
}

/// Counts the sign changes of the Bernstein coefficients on `[low, high]` and tells whether the first is negative;
/// `None` if rounding leaves a sign open.
///
/// The number of roots in between is the number of sign changes, or smaller by an even number (Farouki, "The Bernstein
/// polynomial basis", Computer Aided Geometric Design 29, 2012). So 0 or 1 need no search, and most lines miss the
/// surface they are tested against.
fn sign_changes(c: &[f64], low: f64, high: f64) -> Option<(u32, bool)> {
    let (degree, width) = (c.len() - 1, high - low);
    // Taylor coefficients about `low`, in units of the width.
    let mut taylor = [0.0; MAX_DEGREE + 1];
    taylor[..=degree].copy_from_slice(c);
    for first in 0..degree {
        for i in (first..degree).rev() {
            taylor[i] += low * taylor[i + 1];
        }
    }
    let (mut scale, mut size) = (1.0, 0.0);
    for t in &mut taylor[..=degree] {
        *t *= scale;
        scale *= width;
    }
    let reach = low.abs() + width;
    for &k in c.iter().rev() {
        size = size * reach + f64::abs(k);
    }
    // Bound for about forty operations on numbers that add up to `size` at most.
    let error = 64.0 * f64::EPSILON * size;
    let (mut changes, mut last) = (0, 0.0);
    // The first coefficient is the value at `low`.
    let rising = taylor[0] < 0.0;
    for row in &BERNSTEIN[degree][..=degree] {
        let coefficient: f64 = row.iter().zip(&taylor).map(|(weight, t)| weight * t).sum();
        // The sign is not certain; the caller falls back to the search.
        if coefficient.is_nan() || coefficient.abs() <= error {
            return None;
        }
        changes += u32::from(last * coefficient < 0.0);
        last = coefficient.signum();
    }
    Some((changes, rising))
}

/// Value with a bound of its rounding error.
struct Value {
    value: f64,
    error: f64,
}

impl Value {
    fn is_zero(&self) -> bool {
        self.value.abs() <= self.error
    }
}

/// Evaluates a polynomial by Horner's rule with a running error bound (Higham, "Accuracy and Stability of Numerical
/// Algorithms", section 5.1).
fn value(c: &[f64], x: f64) -> Value {
    let (mut value, mut error) = (0.0, 0.0);
    for &k in c.iter().rev() {
        value = value * x + k;
        error = error * x.abs() + f64::abs(value);
    }
    Value { value, error: 2.0 * f64::EPSILON * error }
}

fn value_and_slope(c: &[f64], x: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for &k in c.iter().rev() {
        slope = slope * x + value;
        value = value * x + k;
    }
    (value, slope)
}

/// Finds the root between two ends of different sign by Newton's method, with bisection where it would leave the
/// bracket.
fn find_bracketed_root(c: &[f64], mut left: f64, mut right: f64, rising: bool) -> f64 {
    let mut x = 0.5 * (left + right);
    let mut last_step = right - left;
    // Bisection alone needs about 60 steps; the limit only guards against a broken invariant.
    for _ in 0..200 {
        let (value, slope) = value_and_slope(c, x);
        if value == 0.0 {
            return x;
        }
        if (value < 0.0) == rising {
            left = x;
        } else {
            right = x;
        }
        let newton = x - value / slope;
        // A Newton step must also at least halve the last step, which excludes cycles.
        let stays = newton > left && newton < right && 2.0 * (newton - x).abs() < last_step.abs();
        let next = if stays { newton } else { 0.5 * (left + right) };
        last_step = next - x;
        if last_step == 0.0 || last_step.abs() <= 0.5 * f64::EPSILON * x.abs() {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Coefficients of the monic polynomial with the given roots.
    fn with_roots(roots: &[f64]) -> Vec<f64> {
        let mut c = vec![1.0];
        for &root in roots {
            c.insert(0, 0.0);
            for i in 0..c.len() - 1 {
                c[i] -= root * c[i + 1];
            }
        }
        c
    }

    fn is_root(c: &[f64], x: f64) -> bool {
        value(c, x).value.abs() <= 8.0 * value(c, x).error
    }

    proptest! {
        #![proptest_config(fabkit_geometry_testing::cases(512))]

        #[test]
        fn finds_well_separated_roots(
            gaps in prop::collection::vec(0.05f64..3.0, 1..=4),
            start in -5.0f64..1.0,
            scale in prop::sample::select(vec![1e-6, 1.0, 1e6]),
        ) {
            let mut known = vec![start];
            for gap in &gaps[1..] {
                known.push(known[known.len() - 1] + gap);
            }
            let c: Vec<f64> = with_roots(&known).iter().map(|v| v * scale).collect();
            let found = polynomial(&c, -20.0, 20.0);
            prop_assert_eq!(found.as_slice().len(), known.len());
            for (x, y) in found.as_slice().iter().zip(&known) {
                // Coefficient rounding ~ 20^4 eps over a slope of at least 0.05^3.
                prop_assert!((x - y).abs() < 1e-7, "{} {}", x, y);
                prop_assert!(is_root(&c, *x));
            }
        }

        #[test]
        fn finds_double_and_triple_roots_with_exact_coefficients(
            a in -4i32..4, b in -4i32..4, multiplicity in 1usize..=3,
        ) {
            prop_assume!(a != b);
            // Integer coefficients are exact, so a multiple root is one in floating point too.
            let mut known = vec![f64::from(a); multiplicity];
            known.push(f64::from(b));
            let c = with_roots(&known);
            let found = polynomial(&c, -10.0, 10.0);
            for root in [a, b] {
                // A triple root is determined to the cube root of the rounding error only.
                let close = |x: &f64| (x - f64::from(root)).abs() < 1e-4;
                prop_assert!(found.as_slice().iter().any(close), "{:?} in {:?}", root, found);
            }
            for x in found.as_slice() {
                prop_assert!(is_root(&c, *x));
            }
        }

        #[test]
        fn counts_what_sign_changes_prove(
            c in prop::collection::vec(-10.0f64..10.0, 5),
        ) {
            // Independent: a dense scan proves at least as many roots as it sees sign changes.
            let at = |i: usize| -3.0 + 6.0 * i as f64 / 3000.0;
            let changes = (0..3000)
                .filter(|&i| (value(&c, at(i)).value < 0.0) != (value(&c, at(i + 1)).value < 0.0))
                .count();
            let found = polynomial(&c, -3.0, 3.0);
            prop_assert!(found.as_slice().len() >= changes);
            prop_assert!(found.as_slice().windows(2).all(|w| w[0] < w[1]));
            for x in found.as_slice() {
                prop_assert!(is_root(&c, *x));
            }
        }

        #[test]
        fn a_part_of_the_line_has_the_roots_that_lie_there(
            c in prop::collection::vec(-10.0f64..10.0, 2..=5), ends in [-3.0f64..3.0, -3.0f64..3.0],
        ) {
            let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let (all, part) = (polynomial(&c, -3.0, 3.0), polynomial(&c, low, high));
            // A root on the end, or one of two that rounding cannot part, may count either way.
            let is_clear = |x: f64| {
                let (_, slope) = value_and_slope(&c, x);
                (x - low).abs().min((x - high).abs()) > 1e-9 && slope.abs() > 1e-3
            };
            let between = |x: &&f64| low < **x && **x < high && is_clear(**x);
            for x in all.as_slice().iter().filter(between) {
                prop_assert!(part.as_slice().iter().any(|y| (x - y).abs() < 1e-9), "{} of {:?}", x, part);
            }
            for x in part.as_slice() {
                prop_assert!(low <= *x && *x <= high && is_root(&c, *x));
            }
        }

        #[test]
        fn quadratic_agrees_with_its_factors(a in -5.0f64..5.0, x in -1e3f64..1e3, gap in 1e-3f64..1e3) {
            prop_assume!(a.abs() > 1e-3);
            let y = x + gap;
            let found = quadratic(a, -0.5 * a * (x + y), a * x * y);
            prop_assert_eq!(found.as_slice().len(), 2);
            let tolerance = 1e-9 * (1.0 + x * x / gap);
            prop_assert!((found.as_slice()[0] - x).abs() < tolerance);
            prop_assert!((found.as_slice()[1] - y).abs() < tolerance);
        }
    }

    #[test]
    fn quadratic_keeps_the_small_root() {
        // 1e-8 x^2 - x + 1e-8: the naive formula returns 0 for the small root.
        let found = quadratic(1e-8, -0.5, 1e-8);
        assert!((found.as_slice()[0] - 1e-8).abs() < 1e-22);
        assert_eq!(quadratic(0.0, 0.5, -3.0).as_slice(), [3.0]);
        assert_eq!(quadratic(1.0, 0.0, 1.0).as_slice(), []);
    }
}
