//! Why a sensor has nothing to press.

use fabkit_geometry::InvalidSolid;

use crate::ElasticError;

/// Why a sensor has nothing to press.
#[derive(Debug, thiserror::Error)]
pub enum SoftError {
    /// Nothing of known elasticity below the surface.
    #[error("nothing of known elasticity lies below the surface of {sensor}")]
    Stiff {
        /// Its name.
        sensor: String,
    },
    /// Layers that nothing holds.
    #[error("nothing stiff holds the soft layers: neither from inside nor at their rim")]
    Loose,
    /// A channel that is pressed shut.
    #[error(
        "channel {channel} is pressed shut: its cover would come down by {closes_mm:.3} mm, but the channel is \
         {height_mm} mm high"
    )]
    Shut {
        /// Which.
        channel: String,
        /// By how much its cover would come down onto its floor, mm.
        closes_mm: f64,
        /// How high it is, mm.
        height_mm: f64,
    },
    /// A body that is none.
    #[error(transparent)]
    Solid(#[from] InvalidSolid),
    /// What the solver says.
    #[error(transparent)]
    Elastic(#[from] ElasticError),
}
