//! Errors of meshing.

use crate::print::PrintDefect;

/// Valid range of chord tolerances, mm: below it, rounding to `f32` would affect the shape; above it, the shape of a
/// sensor's part would be lost.
pub const TOLERANCE_RANGE_MM: std::ops::RangeInclusive<f64> = 1e-4..=5.0;

/// Reason why a solid cannot be meshed.
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::{MeshError, mesh};
/// let ball = Solid::sphere(2.0);
/// assert_eq!(mesh(&Solid::below(0.0), 0.1), Err(MeshError::Unbounded));
/// assert_eq!(mesh(&ball.clone().minus(Solid::sphere(3.0)), 0.1), Err(MeshError::Empty));
/// assert_eq!(mesh(&ball, 0.0), Err(MeshError::Tolerance { tolerance_mm: 0.0 }));
/// assert!(matches!(mesh(&Solid::sphere(-2.0), 0.1), Err(MeshError::Invalid(_))));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Invalid solid.
    #[error(transparent)]
    Invalid(#[from] fabkit_geometry::InvalidSolid),
    /// Chord tolerance outside of [`TOLERANCE_RANGE_MM`].
    #[error(
        "a chord tolerance of {tolerance_mm} mm; it must lie between {} and {} mm",
        TOLERANCE_RANGE_MM.start(), TOLERANCE_RANGE_MM.end()
    )]
    Tolerance {
        /// Requested tolerance, mm.
        tolerance_mm: f64,
    },
    /// Half space that no finite solid bounds.
    #[error("the solid is unbounded: a half space only cuts, or is cut by, something finite")]
    Unbounded,
    /// Empty result.
    #[error("the solid is empty: the booleans leave nothing")]
    Empty,
    /// Too many triangles.
    #[error("a face cannot be followed to {tolerance_mm} mm with a sensible number of triangles")]
    TooFine {
        /// Requested tolerance, mm.
        tolerance_mm: f64,
    },
    /// Failure of the boolean kernel.
    #[error("the boolean kernel failed while {operation}: {reason}")]
    Kernel {
        /// Operation that failed.
        operation: &'static str,
        /// Message of the kernel.
        reason: &'static str,
    },
    /// Defect of the mesh after rounding to `f32`.
    #[error(transparent)]
    Print(#[from] PrintDefect),
}
