//! A camera with the covariance of its parameters.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::camera::Camera;
use crate::interface::Interface;

/// Calibrated camera with the covariance of its parameters.
///
/// ```
/// use fabkit_camera::{Camera, CameraEstimate, DMatrix};
/// let camera = Camera::equidistant(640, 480, 2.5)?;
/// let mut covariance = DMatrix::zeros(8, 8);
/// covariance[(0, 0)] = 4.0; // px2: the first focal length is known to 2 px, the rest was fixed
/// let estimate = CameraEstimate::new(camera, Some(covariance))?;
/// assert_eq!(estimate.names()[..2], ["fx_px", "fy_px"]);
/// assert_eq!(estimate.sigmas().unwrap()[..2], [2.0, 0.0]);
/// // Unknown is not the same as zero.
/// assert_eq!(CameraEstimate::from(camera).sigmas(), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CameraEstimate {
    /// Most likely camera.
    camera: Camera,
    covariance: Option<DMatrix<f64>>,
}

/// Reason why a matrix is not the covariance of a camera's parameters.
///
/// ```
/// use fabkit_camera::{Camera, CameraEstimate, DMatrix, InvalidCovariance};
/// let camera = Camera::equidistant(640, 480, 2.5)?;
/// let mut covariance = DMatrix::identity(8, 8);
/// // A correlation of 2: the variance of fx - fy would be 1 + 1 - 2 x 2.
/// (covariance[(0, 1)], covariance[(1, 0)]) = (2.0, 2.0);
/// let refused = CameraEstimate::new(camera, Some(covariance)).unwrap_err();
/// assert!(matches!(refused, InvalidCovariance::NotPositive { .. }));
/// let too_small = CameraEstimate::new(camera, Some(DMatrix::identity(4, 4))).unwrap_err();
/// assert_eq!(too_small.to_string(), "the covariance is 4 x 4, but there are 8 parameters");
/// # Ok::<(), fabkit_camera::InvalidCamera>(())
/// ```
#[derive(Clone, Debug, PartialEq, Error)]
pub enum InvalidCovariance {
    /// The matrix is not N x N.
    #[error("the covariance is {rows} x {columns}, but there are {parameters} parameters")]
    WrongSize {
        /// Number of rows given.
        rows: usize,
        /// Number of columns given.
        columns: usize,
        /// Number of parameters that the covariance must have.
        parameters: usize,
    },
    /// An entry is infinite or not a number.
    #[error("the covariance of {row} and {column} is not finite")]
    NotFinite {
        /// Parameter of the entry's row.
        row: &'static str,
        /// Parameter of the entry's column.
        column: &'static str,
    },
    /// The matrix is not symmetric at an entry.
    #[error("the covariance of {row} and {column} is not that of {column} and {row}")]
    NotSymmetric {
        /// Parameter of the entry's row.
        row: &'static str,
        /// Parameter of the entry's column.
        column: &'static str,
    },
    /// The matrix is not positive semidefinite: some combination of parameters has a negative variance.
    #[error(
        "the covariance has a negative eigenvalue ({least_correlation_eigenvalue:e}, of its \
         correlations)"
    )]
    NotPositive {
        /// Smallest eigenvalue of the correlation matrix.
        least_correlation_eigenvalue: f64,
    },
}

impl CameraEstimate {
    /// Creates an estimate with the covariance of the camera's parameters: `None` if it is unknown, or a symmetric
    /// positive semidefinite N x N matrix in the order of [`Camera::parameters`], in their units. A parameter that was
    /// fixed has a row and a column of zeros.
    ///
    /// # Errors
    /// Fails for a matrix that is not a covariance of this camera's parameters.
    pub fn new(
        camera: Camera,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<Self, InvalidCovariance> {
        if let Some(matrix) = &covariance {
            let names: Vec<&str> = camera.parameters().into_iter().map(|(name, _)| name).collect();
            check_covariance(&names, matrix)?;
        }
        Ok(Self { camera, covariance })
    }

    /// Marks a camera without interface as calibrated without what stands in front of it; see
    /// [`Interface::FromDrawing`](crate::Interface::FromDrawing). A camera with an interface is returned unchanged.
    ///
    /// ```
    /// use fabkit_camera::{Camera, CameraEstimate, Interface};
    /// let in_air = CameraEstimate::from(Camera::equidistant(640, 480, 2.5)?);
    /// let lens_alone = in_air.clone().with_drawn_interface();
    /// assert_eq!(*lens_alone.camera().interface(), Interface::FromDrawing);
    /// assert_eq!(lens_alone.without_drawn_interface(), in_air);
    /// # Ok::<(), fabkit_camera::InvalidCamera>(())
    /// ```
    #[must_use]
    pub fn with_drawn_interface(self) -> Self {
        let camera = match self.camera.interface() {
            Interface::None => self.camera.with_drawn_interface(),
            _ => self.camera,
        };
        Self { camera, ..self }
    }

    /// Turns [`Interface::FromDrawing`] into [`Interface::None`], for callers who ignore the drawing or solve for the
    /// interface.
    #[must_use]
    pub fn without_drawn_interface(self) -> Self {
        let camera = match self.camera.interface() {
            Interface::FromDrawing => self.camera.without_interface(),
            _ => self.camera,
        };
        Self { camera, ..self }
    }

    /// Most likely camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Covariance, N x N in the order of [`CameraEstimate::names`]; `None` if it is unknown.
    pub fn covariance(&self) -> Option<&DMatrix<f64>> {
        self.covariance.as_ref()
    }

    /// Returns the names of the parameters, with units, in the order of the covariance.
    pub fn names(&self) -> Vec<&'static str> {
        self.camera.parameters().into_iter().map(|(name, _)| name).collect()
    }

    /// Returns the standard deviation of each parameter, in its unit.
    pub fn sigmas(&self) -> Option<Vec<f64>> {
        let variances = self.covariance()?.diagonal();
        Some(variances.iter().map(|v| v.max(0.0).sqrt()).collect())
    }
}

impl From<Camera> for CameraEstimate {
    /// Creates an estimate with unknown covariance.
    fn from(camera: Camera) -> Self {
        Self { camera, covariance: None }
    }
}

/// Checks that a matrix is a covariance of the parameters in `names`.
pub(crate) fn check_covariance(
    names: &[&'static str],
    covariance: &DMatrix<f64>,
) -> Result<(), InvalidCovariance> {
    let n = names.len();
    let (rows, columns) = covariance.shape();
    if (rows, columns) != (n, n) {
        return Err(InvalidCovariance::WrongSize { rows, columns, parameters: n });
    }
    // Parameters differ in scale by many orders of magnitude, so only correlations can be compared with one tolerance.
    let scale = |i: usize| covariance[(i, i)].abs().sqrt();
    let correlation = DMatrix::from_fn(n, n, |r, c| {
        let scale = scale(r) * scale(c);
        // A parameter without variance must have zeros, which the checks below see unscaled.
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
    // Rounding makes the smallest eigenvalue of a singular matrix slightly negative.
    if least < -1e-6 {
        return Err(InvalidCovariance::NotPositive { least_correlation_eigenvalue: least });
    }
    Ok(())
}
