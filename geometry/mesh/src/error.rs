//! Why there is no mesh.

use crate::print::PrintDefect;

/// Chord tolerances outside this range are refused, mm: below, rounding to `f32` would take part in
/// the shape; above, nothing of a sensor's part is left.
pub const TOLERANCE_RANGE_MM: std::ops::RangeInclusive<f64> = 1e-4..=5.0;

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The tree is not a solid.
    #[error(transparent)]
    Invalid(#[from] fabkit_geometry::InvalidSolid),
    /// The chord tolerance makes no sense.
    #[error(
        "a chord tolerance of {tolerance_mm} mm; it must lie between {} and {} mm",
        TOLERANCE_RANGE_MM.start(), TOLERANCE_RANGE_MM.end()
    )]
    Tolerance {
        /// As asked for, mm.
        tolerance_mm: f64,
    },
    /// A half space is not cut down to anything finite.
    #[error("the solid is unbounded: a half space only cuts, or is cut by, something finite")]
    Unbounded,
    /// Nothing is left.
    #[error("the solid is empty: the booleans leave nothing")]
    Empty,
    /// Too many triangles.
    #[error("a face cannot be followed to {tolerance_mm} mm with a sensible number of triangles")]
    TooFine {
        /// As asked for, mm.
        tolerance_mm: f64,
    },
    /// The boolean kernel refused.
    #[error("the boolean kernel failed while {operation}: {reason}")]
    Kernel {
        /// What it was doing.
        operation: &'static str,
        /// In its own words.
        reason: &'static str,
    },
    /// What is left after rounding to `f32` is no solid.
    #[error(transparent)]
    Print(#[from] PrintDefect),
}
