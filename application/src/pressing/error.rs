//! Why a press has no result.

use fabkit_elastic::ElasticError;
use fabkit_fixtures::PressError;
use fabkit_geometry::InvalidSolid;

use crate::error::{ErrorKind, Explained};

/// Why a press has no result.
#[derive(Debug, thiserror::Error)]
pub enum PressingError {
    /// Nothing of known elasticity below the surface.
    #[error("nothing of known elasticity lies below the surface of {sensor}")]
    Stiff {
        /// Its name.
        sensor: String,
    },
    /// Layers that nothing holds.
    #[error("nothing stiff holds the soft layers: neither from inside nor at their rim")]
    Loose,
    /// A body that is none.
    #[error(transparent)]
    Solid(InvalidSolid),
    /// No such press.
    #[error(transparent)]
    Press(#[from] PressError),
    /// What the solver says.
    #[error(transparent)]
    Elastic(ElasticError),
    /// A way along a surface of unknown friction.
    #[error("nobody says how much friction {material} has")]
    NoFriction {
        /// Its name.
        material: String,
    },
    /// A depth or a number of steps out of range.
    #[error("{what}: {value}; {limit}")]
    Range {
        /// What it is.
        what: &'static str,
        /// As asked for, with its unit.
        value: String,
        /// What is allowed.
        limit: String,
    },
}

impl Explained for PressingError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Elastic(
                ElasticError::NoConvergence { .. } | ElasticError::Factorisation { .. },
            ) => ErrorKind::Limit,
            _ => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Stiff { .. } => {
                "write `youngs_modulus: 70 kPa` for its material in a file of `materials:`"
            }
            Self::NoFriction { .. } => {
                "write `friction: 1.0` for it in a file of `materials:`, or say how much for this press"
            }
            Self::Loose => "let the layers stick to a plate or a shell",
            Self::Elastic(ElasticError::NoConvergence { .. }) => {
                "press less deep, or with nodes further apart"
            }
            _ => return None,
        };
        Some(hint.to_owned())
    }
}
