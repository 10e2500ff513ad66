//! Information matrices of parameters whose units differ by many orders of magnitude.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Threshold of squared sines: below, a parameter is a combination of others up to rounding, and not determined.
const SINGULAR: f64 = 1e-12;

/// Replacement for zero information, so that nothing is divided by 0.
const LEAST_DIAGONAL: f64 = 1e-300;

/// Cholesky factor of an information matrix that is scaled to make parameters comparable.
#[derive(Clone, Debug)]
pub(crate) struct ScaledCholesky {
    /// Inverse of each parameter's unit.
    scale: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl ScaledCholesky {
    /// Factors the matrix in units that make it a correlation matrix; `None` if a combination of parameters is not
    /// determined.
    pub fn new(information: &DMatrix<f64>) -> Option<Self> {
        let scaled = Self::damped(information, 0.0)?;
        // A pivot is the sine of the angle between a parameter and those before it.
        let pivots = scaled.factor.l_dirty().diagonal();
        pivots.iter().all(|pivot| pivot * pivot > SINGULAR).then_some(scaled)
    }

    /// Factors the matrix after adding `share` of each diagonal entry to it, as in the Levenberg-Marquardt method.
    pub fn damped(information: &DMatrix<f64>, share: f64) -> Option<Self> {
        Self::scaled(information, information.diagonal().map(f64::sqrt), share)
    }

    /// Factors the matrix in units of the parameters' prior standard deviations `sigmas`, with the prior's information
    /// added.
    pub fn with_prior(information: &DMatrix<f64>, sigmas: &DVector<f64>) -> Option<Self> {
        Self::scaled(information, sigmas.map(f64::recip), 1.0)
    }

    fn scaled(information: &DMatrix<f64>, scale: DVector<f64>, added: f64) -> Option<Self> {
        let (n, scale) = (scale.len(), scale.map(|v| v.max(LEAST_DIAGONAL.sqrt())));
        let entry = |i, j| information[(i, j)] / (scale[i] * scale[j]);
        let scaled = DMatrix::from_fn(n, n, |i, j| entry(i, j) + if i == j { added } else { 0.0 });
        // Fails if the scaled matrix is not positive definite.
        Some(Self { factor: Cholesky::new(scaled)?, scale })
    }

    /// Solves for the step that belongs to a gradient.
    pub fn solve(&self, gradient: &DVector<f64>) -> DVector<f64> {
        self.factor.solve(&gradient.component_div(&self.scale)).component_div(&self.scale)
    }

    /// Computes the variance of a quantity with the given derivatives. Nearly dependent parameters do not spoil it, as
    /// they would if the variance were computed from their covariance.
    pub fn variance(&self, derivatives: &DVector<f64>) -> f64 {
        let mut half = derivatives.component_div(&self.scale);
        self.factor.l_dirty().solve_lower_triangular_mut(&mut half);
        half.norm_squared()
    }

    /// Computes the covariance, exactly symmetric.
    pub fn inverse(&self) -> DMatrix<f64> {
        let inverse = self.factor.inverse();
        let n = self.scale.len();
        let entry = |i, j| inverse[(i, j)] / (self.scale[i] * self.scale[j]);
        DMatrix::from_fn(n, n, |i, j| if i >= j { entry(i, j) } else { entry(j, i) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::sequences::SplitMix64;

    /// `J^T J` of more rows than columns, whose columns differ by `spread` orders in all.
    fn information(n: usize, spread: f64, random: &mut SplitMix64) -> DMatrix<f64> {
        let unit = |j: usize| 10f64.powf(spread * (j as f64 / (n - 1) as f64 - 0.5));
        let rows = DMatrix::from_fn(3 * n, n, |_, j| unit(j) * random.between(-1.0, 1.0));
        rows.transpose() * rows
    }

    /// Largest difference, in units of what is expected at the same place.
    fn worst(found: &DMatrix<f64>, expected: &DMatrix<f64>) -> f64 {
        let unit = |i: usize| expected[(i, i.min(expected.ncols() - 1))].abs();
        let relative = found.zip_map(expected, |a, b| (a - b).abs());
        let of = |(k, miss): (usize, &f64)| {
            let (i, j) = (k % found.nrows(), k / found.nrows());
            let scale = if found.ncols() > 1 { (unit(i) * unit(j)).sqrt() } else { unit(i) };
            miss / scale
        };
        relative.iter().enumerate().map(of).fold(0.0, f64::max)
    }

    #[test]
    fn steps_and_covariances_are_those_of_a_decomposition_with_pivots() {
        let mut random = SplitMix64::new(1);
        for n in [2, 6, 12] {
            // LU with complete pivoting knows nothing of symmetry or of scales. Its rounding is some
            // 1e-16 times the condition, which six orders in the parameters square.
            for (spread, tolerance) in [(0.0, 1e-12), (6.0, 1e-3)] {
                let information = information(n, spread, &mut random);
                let gradient = DVector::from_fn(n, |_, _| random.between(-1.0, 1.0));
                let lu = information.clone().full_piv_lu();
                let expected = lu.try_inverse().unwrap();
                let factor = ScaledCholesky::new(&information).unwrap();
                assert!(worst(&factor.inverse(), &expected) < tolerance, "{n} {spread}");
                let step = factor.solve(&gradient);
                let miss = (&information * &step - &gradient).amax();
                assert!(miss < 1e-9, "{n} {spread}: {miss}");
                let variance = factor.variance(&gradient);
                assert!((variance / gradient.dot(&step) - 1.0).abs() < 1e-9, "{variance}");
            }
        }
    }

    #[test]
    fn units_do_not_matter() {
        let information = information(5, 0.0, &mut SplitMix64::new(2));
        // Powers of two, so that nothing is rounded.
        let unit = |i: usize| 2f64.powi(20 * i as i32 - 40);
        let other = DMatrix::from_fn(5, 5, |i, j| information[(i, j)] * unit(i) * unit(j));
        let inverse = ScaledCholesky::new(&information).unwrap().inverse();
        let other = ScaledCholesky::new(&other).unwrap().inverse();
        let back = DMatrix::from_fn(5, 5, |i, j| other[(i, j)] * unit(i) * unit(j));
        assert!(worst(&back, &inverse) < 1e-15);
    }

    #[test]
    fn what_is_not_determined_has_no_factor_but_one_with_damping_or_a_prior() {
        // The second parameter does what the first does; the third does nothing.
        for rows in [[1.0, 2.0, 0.0], [1.0, 2.0, 1.0]] {
            let row = DMatrix::from_row_slice(1, 3, &rows);
            let information = row.transpose() * &row;
            assert!(ScaledCholesky::new(&information).is_none());
            let sigmas = DVector::from_vec(vec![0.5, 2.0, 3.0]);
            let with_prior = ScaledCholesky::with_prior(&information, &sigmas).unwrap().inverse();
            let prior = DMatrix::from_diagonal(&sigmas.map(|sigma| sigma.powi(-2)));
            let expected = (information.clone() + prior).full_piv_lu().try_inverse().unwrap();
            assert!(worst(&with_prior, &expected) < 1e-12);
        }
        let row = DMatrix::from_row_slice(1, 2, &[1.0, 2.0]);
        let damped = ScaledCholesky::damped(&(row.transpose() * &row), 0.1).unwrap();
        // (1.1, 1; 1, 1.1) in units of its diagonal.
        let expected = DMatrix::from_row_slice(2, 2, &[1.1, -0.5, -0.5, 0.275]) / 0.21;
        assert!(worst(&damped.inverse(), &expected) < 1e-12);
    }
}
