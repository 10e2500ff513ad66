//! A camera and how sure we are of it.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::camera::Camera;
use crate::interface::Interface;

/// A calibrated camera with the covariance of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraEstimate {
    /// The most likely camera.
    camera: Camera,
    covariance: Option<DMatrix<f64>>,
}

/// Why a matrix is not the covariance of a camera's parameters.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum InvalidCovariance {
    /// Not N x N.
    #[error("the covariance is {rows} x {columns}, but there are {parameters} parameters")]
    WrongSize {
        /// Rows given.
        rows: usize,
        /// Columns given.
        columns: usize,
        /// How many parameters it is of.
        parameters: usize,
    },
    /// Infinite or not a number.
    #[error("the covariance of {row} and {column} is not finite")]
    NotFinite {
        /// A parameter.
        row: &'static str,
        /// A parameter.
        column: &'static str,
    },
    /// Two entries that must agree do not.
    #[error("the covariance of {row} and {column} is not that of {column} and {row}")]
    NotSymmetric {
        /// A parameter.
        row: &'static str,
        /// A parameter.
        column: &'static str,
    },
    /// Some combination of parameters would have a negative variance.
    #[error(
        "the covariance has a negative eigenvalue ({least_correlation_eigenvalue:e}, of its \
         correlations)"
    )]
    NotPositive {
        /// Of the correlation matrix.
        least_correlation_eigenvalue: f64,
    },
}

impl CameraEstimate {
    /// A camera with what is known about its uncertainty: nothing, or a symmetric positive
    /// semidefinite N x N matrix in the order of [`Camera::parameters`], in their units. A
    /// parameter that was held has a row and column of zeros.
    ///
    /// # Errors
    /// A matrix that is not a covariance of this camera's parameters.
    pub fn new(
        camera: Camera,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<Self, InvalidCovariance> {
        if let Some(matrix) = &covariance {
            let names: Vec<&str> = camera.parameters().into_iter().map(|(name, _)| name).collect();
            check(&names, matrix)?;
        }
        Ok(Self { camera, covariance })
    }

    /// The same, said to be of the lens by itself: see [`Interface::Drawn`](crate::Interface::Drawn). Only what
    /// has no interface is changed.
    #[must_use]
    pub fn behind_drawing(self) -> Self {
        let camera = match self.camera.interface() {
            Interface::None => self.camera.behind_drawing(),
            _ => self.camera,
        };
        Self { camera, ..self }
    }

    /// The same lens for who does not look at the drawing, or finds out what is before the lens.
    #[must_use]
    pub fn undrawn(self) -> Self {
        let camera = match self.camera.interface() {
            Interface::Drawn => self.camera.in_air(),
            _ => self.camera,
        };
        Self { camera, ..self }
    }

    /// The most likely camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// N x N in the order of [`CameraEstimate::names`]; `None` if nothing is known.
    pub fn covariance(&self) -> Option<&DMatrix<f64>> {
        self.covariance.as_ref()
    }

    /// Names of the parameters, with units, in the order of the covariance.
    pub fn names(&self) -> Vec<&'static str> {
        self.camera.parameters().into_iter().map(|(name, _)| name).collect()
    }

    /// Standard deviation of each parameter, in its unit.
    pub fn sigmas(&self) -> Option<Vec<f64>> {
        let variances = self.covariance()?.diagonal();
        Some(variances.iter().map(|v| v.max(0.0).sqrt()).collect())
    }
}

impl From<Camera> for CameraEstimate {
    /// Nothing is known about its uncertainty.
    fn from(camera: Camera) -> Self {
        Self { camera, covariance: None }
    }
}

/// Whether a matrix is a covariance of these parameters.
pub(crate) fn check(
    names: &[&'static str],
    covariance: &DMatrix<f64>,
) -> Result<(), InvalidCovariance> {
    let n = names.len();
    let (rows, columns) = covariance.shape();
    if (rows, columns) != (n, n) {
        return Err(InvalidCovariance::WrongSize { rows, columns, parameters: n });
    }
    // Parameters differ in scale by many orders: only correlations can be judged by one tolerance.
    let scale = |i: usize| covariance[(i, i)].abs().sqrt();
    let correlation = DMatrix::from_fn(n, n, |r, c| {
        let scale = scale(r) * scale(c);
        if scale > 0.0 { covariance[(r, c)] / scale } else { covariance[(r, c)] }
    });
    for (r, &row) in names.iter().enumerate() {
        for (c, &column) in names.iter().enumerate() {
            if !covariance[(r, c)].is_finite() {
                return Err(InvalidCovariance::NotFinite { row, column });
            }
            if (correlation[(r, c)] - correlation[(c, r)]).abs() > 1e-6 {
                return Err(InvalidCovariance::NotSymmetric { row, column });
            }
        }
    }
    let least = correlation.symmetric_eigenvalues().min();
    if least < -1e-6 {
        return Err(InvalidCovariance::NotPositive { least_correlation_eigenvalue: least });
    }
    Ok(())
}
