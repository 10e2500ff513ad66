//! What cannot be made.

use fabkit_geometry::InvalidSolid;
use fabkit_geometry::measure::MeasureError;

/// A part that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoSuchPart {
    /// A tree that is no solid.
    #[error("{body}: {source}")]
    Solid {
        /// Which part.
        body: String,
        /// Why.
        source: InvalidSolid,
    },
    /// A solid that no rule can be applied to.
    #[error("{0}")]
    Examined(String),
    /// A solid that has no volume.
    #[error("{body}: {source}")]
    Volume {
        /// Which part.
        body: String,
        /// Why.
        source: MeasureError,
    },
}
