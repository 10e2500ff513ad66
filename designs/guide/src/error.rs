//! Errors of the guide.

use fabkit_geometry::InvalidSolid;
use fabkit_geometry::measure::MeasureError;

/// Part that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GuideError {
    /// Tree that is not a valid solid.
    #[error("{body}: {source}")]
    Solid {
        /// Name of the part.
        body: String,
        /// Reason why it is not valid.
        source: InvalidSolid,
    },
    /// Part whose print settings cannot be derived, with the reason.
    #[error("{0}")]
    PrintSettings(String),
    /// Solid whose volume cannot be measured.
    #[error("{body}: {source}")]
    Volume {
        /// Name of the part.
        body: String,
        /// Reason why the measurement failed.
        source: MeasureError,
    },
}
