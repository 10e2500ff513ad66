//! Why a press has no result.

use fabkit_elastic::{ElasticError, SoftError};
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_fixtures::PressError;

/// Why a press has no result.
#[derive(Debug, thiserror::Error)]
pub enum PressingError {
    /// Nothing to press.
    #[error(transparent)]
    Soft(SoftError),
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
    /// A press that is not asked at large strain.
    #[error("a press at large strain {what}")]
    Finite {
        /// What it is.
        what: &'static str,
    },
    /// Words that do not go together.
    #[error("{problem}")]
    Contact {
        /// What is wrong.
        problem: String,
    },
    /// A way along a surface that is not asked how it gives way.
    #[error("a way along the surface needs contact that gives way, not `{contact}`")]
    RigidShear {
        /// The level asked for.
        contact: &'static str,
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
            Self::Soft(SoftError::Stiff { .. }) => {
                "write `youngs_modulus: 70 kPa` for its material in a file of `materials:`"
            }
            Self::Finite { .. } => "ask for `linear` contact, or press at `@0deg,0deg`",
            Self::RigidShear { .. } => "ask for `linear` contact",
            Self::NoFriction { .. } => {
                "write `friction: 1.0` for it in a file of `materials:`, or say how much for this press"
            }
            Self::Soft(SoftError::Shut { .. }) => "press less deep, or beside the channel",
            Self::Elastic(ElasticError::TooFine { .. }) => "let nodes be further apart",
            Self::Soft(SoftError::Loose) => "let the layers stick to a plate or a shell",
            Self::Elastic(ElasticError::NoConvergence { .. }) => {
                "press less deep, or with nodes further apart"
            }
            _ => return None,
        };
        Some(hint.to_owned())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::Press(_) => "unknown_press",
            Self::Range { .. }
            | Self::NoFriction { .. }
            | Self::Contact { .. }
            | Self::Finite { .. }
            | Self::RigidShear { .. } => "out_of_range",
            Self::Elastic(_) => "no_contact_solution",
            Self::Soft(_) => "nothing_soft",
        })
    }
}

/// A ball of 4 mm goes so deep in before nodes 1 mm apart feel it, mm.
const FIRST_TOUCH_MM: f64 = 0.05;

impl PressingError {
    /// Whether nothing touches.
    pub fn is_no_contact(&self) -> bool {
        matches!(self, Self::Elastic(ElasticError::NoContact { .. }))
    }

    /// Whether what touches goes so little in that no node of the surface is below it: the first touch of a smooth body.
    pub fn is_first_touch(&self) -> bool {
        matches!(self, Self::Elastic(ElasticError::TooCoarse { depth_mm, .. }) if *depth_mm < FIRST_TOUCH_MM)
    }

    /// Whether what touches lies between the nodes of the surface.
    pub fn is_too_coarse(&self) -> bool {
        matches!(self, Self::Elastic(ElasticError::TooCoarse { .. }))
    }
}

impl From<ElasticError> for PressingError {
    fn from(error: ElasticError) -> Self {
        Self::Elastic(error)
    }
}

impl From<SoftError> for PressingError {
    fn from(error: SoftError) -> Self {
        match error {
            SoftError::Elastic(error) => Self::Elastic(error),
            other => Self::Soft(other),
        }
    }
}
