//! Sparse linear systems, factorised once and solved for many right-hand sides: a non-generic interface to `faer`.
//!
//! It is a crate of its own because `faer` is generic: every crate that names its types compiles all of it, and a
//! library is compiled once more for its tests.
//!
//! ```
//! use fabkit_sparse::{RightHandSides, SymmetricPattern};
//!
//! // Two springs in a row, 2 N/mm and 1 N/mm, and 3 N on their end.
//! let pattern = SymmetricPattern::new(2, [[0, 0], [0, 0], [1, 0], [1, 1]])?;
//! let factors = pattern.factorise(&[2.0, 1.0, -1.0, 1.0])?;
//! let mut sides = RightHandSides::new(2, 1);
//! sides.column_mut(0)[1] = 3.0;
//! factors.solve(&mut sides);
//! assert!((sides.column(0)[0] - 1.5).abs() < 1e-12);
//! assert!((sides.column(0)[1] - 4.5).abs() < 1e-12);
//! # Ok::<(), fabkit_sparse::SparseError>(())
//! ```

#![forbid(unsafe_code)]

use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{Argsort, Pair, SparseColMat, SymbolicSparseColMat, Triplet};
use faer::{MatMut, Side};

/// Failure of a factorisation, in the words of `faer`: a pivot that is not positive, or no memory.
///
/// ```
/// use fabkit_sparse::SymmetricPattern;
///
/// // A spring of 1 N/mm beside one of -1 N/mm: together they hold nothing.
/// let pattern = SymmetricPattern::new(1, [[0, 0], [0, 0]])?;
/// let error = pattern.factorise(&[1.0, -1.0]).unwrap_err();
/// assert!(!error.to_string().is_empty());
/// # Ok::<(), fabkit_sparse::SparseError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SparseError(String);

impl SparseError {
    fn from_error(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}

/// Sparsity pattern of a symmetric positive definite matrix, with its elimination order.
#[derive(Debug)]
pub struct SymmetricPattern {
    entries: SymbolicSparseColMat<usize>,
    /// Order of the given values among the entries of the matrix.
    order: Argsort<usize>,
    elimination: SymbolicLlt<usize>,
}

impl SymmetricPattern {
    /// Analyses a matrix with `size` unknowns and entries at these rows and columns, on and below the diagonal. The
    /// values of repeated entries add up.
    ///
    /// # Errors
    /// If an entry lies outside the matrix, or memory is lacking.
    ///
    /// ```
    /// use fabkit_sparse::SymmetricPattern;
    ///
    /// // Only places on and below the diagonal are named: what lies at [1, 0] counts at [0, 1] too.
    /// assert!(SymmetricPattern::new(2, [[0, 0], [1, 0], [1, 1]]).is_ok());
    /// // Rows and columns are counted from 0, so a matrix of two unknowns has no row 2.
    /// assert!(SymmetricPattern::new(2, [[2, 0]]).is_err());
    /// ```
    pub fn new(
        size: usize,
        places: impl IntoIterator<Item = [usize; 2]>,
    ) -> Result<Self, SparseError> {
        Self::from_pairs(
            size,
            &places.into_iter().map(|[row, col]| Pair { row, col }).collect::<Vec<_>>(),
        )
    }

    fn from_pairs(size: usize, places: &[Pair<usize, usize>]) -> Result<Self, SparseError> {
        // `order` says into which entry each value goes; repeated entries share one.
        let (entries, order) = SymbolicSparseColMat::try_new_from_indices(size, size, places)
            .map_err(SparseError::from_error)?;
        let elimination =
            SymbolicLlt::try_new(entries.as_ref(), Side::Lower).map_err(SparseError::from_error)?;
        Ok(Self { entries, order, elimination })
    }

    /// Factorises the matrix with one value for each entry, in the order given to [`SymmetricPattern::new`].
    ///
    /// # Errors
    /// If the matrix is not positive definite, or memory is lacking.
    ///
    /// # Panics
    /// If the number of values differs from the number of entries.
    ///
    /// ```
    /// use fabkit_sparse::{RightHandSides, SymmetricPattern};
    ///
    /// // The pattern is analysed once; springs of 2 N/mm, then of 4 N/mm, use it again.
    /// let pattern = SymmetricPattern::new(1, [[0, 0]])?;
    /// for (stiffness_n_mm, stretch_mm) in [(2.0, 1.5), (4.0, 0.75)] {
    ///     let factors = pattern.factorise(&[stiffness_n_mm])?;
    ///     let mut forces_n = RightHandSides::new(1, 1);
    ///     forces_n.column_mut(0)[0] = 3.0;
    ///     factors.solve(&mut forces_n);
    ///     assert!((forces_n.column(0)[0] - stretch_mm).abs() < 1e-12);
    /// }
    /// # Ok::<(), fabkit_sparse::SparseError>(())
    /// ```
    pub fn factorise(&self, values: &[f64]) -> Result<Factors, SparseError> {
        let matrix = SparseColMat::new_from_argsort(self.entries.clone(), &self.order, values)
            .map_err(SparseError::from_error)?;
        let factors =
            Llt::try_new_with_symbolic(self.elimination.clone(), matrix.as_ref(), Side::Lower);
        Ok(Factors(factors.map_err(SparseError::from_error)?))
    }
}

/// Factors of a symmetric matrix.
#[derive(Debug)]
pub struct Factors(Llt<usize, f64>);

impl Factors {
    /// Replaces right-hand sides by solutions. Rounding depends on how many are solved together.
    pub fn solve(&self, sides: &mut RightHandSides) {
        self.0.solve_in_place(sides.matrix());
    }
}

/// Solves a square system that need not be symmetric, in place. The matrix is given as rows, columns and values.
///
/// # Errors
/// If the matrix is singular, an entry lies outside it, or memory is lacking.
///
/// ```
/// // Unknowns change places: 2 y = 1, and 5 x = 2, whose 5 is given as 4 + 1.
/// let mut side = [1.0, 2.0];
/// fabkit_sparse::solve_general(&[(0, 1, 2.0), (1, 0, 4.0), (1, 0, 1.0)], &mut side)?;
/// assert!((side[0] - 0.4).abs() < 1e-15 && (side[1] - 0.5).abs() < 1e-15);
/// # Ok::<(), fabkit_sparse::SparseError>(())
/// ```
pub fn solve_general(entries: &[(usize, usize, f64)], side: &mut [f64]) -> Result<(), SparseError> {
    let size = side.len();
    let entries: Vec<_> =
        entries.iter().map(|&(row, col, by)| Triplet::new(row, col, by)).collect();
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &entries)
        .map_err(SparseError::from_error)?;
    let factors = matrix.sp_lu().map_err(SparseError::from_error)?;
    factors.solve_in_place(MatMut::from_column_major_slice_mut(side, size, 1));
    Ok(())
}

/// Right-hand sides, one per column.
///
/// ```
/// use fabkit_sparse::RightHandSides;
///
/// // Two load cases of three unknowns each.
/// let mut loads = RightHandSides::new(3, 2);
/// loads.column_mut(1)[2] = 5.0;
/// assert_eq!((loads.column(0), loads.column(1)), (&[0.0; 3][..], &[0.0, 0.0, 5.0][..]));
/// loads.clear();
/// assert_eq!(loads.column(1), [0.0; 3]);
/// ```
#[derive(Clone, Debug)]
pub struct RightHandSides {
    size: usize,
    columns: Vec<f64>,
}

impl RightHandSides {
    /// Creates `columns` columns of zeros for `size` unknowns.
    pub fn new(size: usize, columns: usize) -> Self {
        Self { size, columns: vec![0.0; size * columns] }
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.columns.fill(0.0);
    }

    /// Returns one column.
    pub fn column(&self, column: usize) -> &[f64] {
        &self.columns[column * self.size..][..self.size]
    }

    /// Returns one column for writing.
    pub fn column_mut(&mut self, column: usize) -> &mut [f64] {
        &mut self.columns[column * self.size..][..self.size]
    }

    /// Returns a matrix view for `faer`.
    fn matrix(&mut self) -> MatMut<'_, f64> {
        // A matrix without rows has no columns.
        let columns = self.columns.len().checked_div(self.size).unwrap_or(0);
        MatMut::from_column_major_slice_mut(&mut self.columns, self.size, columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indefinite_matrices_are_refused() {
        let pattern = SymmetricPattern::new(2, [[0, 0], [1, 0], [1, 1]]).unwrap();
        assert!(pattern.factorise(&[1.0, 2.0, 1.0]).is_err());
        assert!(pattern.factorise(&[2.0, 1.0, 1.0]).is_ok());
        assert!(SymmetricPattern::new(2, [[2, 0]]).is_err());
    }

    #[test]
    fn unsymmetric_systems_are_solved() {
        let mut side = [1.0, 2.0];
        solve_general(&[(0, 1, 2.0), (1, 0, 4.0), (1, 0, 1.0)], &mut side).unwrap();
        assert!((side[0] - 0.4).abs() < 1e-15 && (side[1] - 0.5).abs() < 1e-15, "{side:?}");
        assert!(solve_general(&[(0, 0, 1.0), (1, 0, 1.0)], &mut side).is_err());
    }
}
