//! Errors of robot descriptions.

use fabkit_elastic::SoftError;
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_mesh::MeshError;
use fabkit_tetra::TetraError;

/// Reason why a sensor cannot be described for robots.
#[derive(Debug, thiserror::Error)]
pub enum RobotError {
    /// There are no soft layers to make tetrahedra of.
    #[error(transparent)]
    Soft(#[from] SoftError),
    /// The layers cannot be divided into tetrahedra.
    #[error(transparent)]
    Tetra(#[from] TetraError),
    /// A body cannot be meshed.
    #[error("{part}: {source}")]
    Mesh {
        /// Name of the body.
        part: String,
        /// Reason.
        source: MeshError,
    },
}

impl Explained for RobotError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Tetra(TetraError::TooMany { .. })
            | Self::Mesh { source: MeshError::TooFine { .. }, .. } => ErrorKind::Limit,
            Self::Soft(_) | Self::Tetra(TetraError::Edge { .. }) => ErrorKind::BadInput,
            Self::Tetra(_) | Self::Mesh { .. } => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Soft(_) => "tetrahedra are of the layers below a sensing surface of known shape",
            Self::Tetra(TetraError::TooMany { .. }) => "ask for longer edges",
            _ => return None,
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::Soft(_) => "nothing_soft",
            Self::Tetra(TetraError::TooMany { .. }) => "too_many_tetrahedra",
            Self::Tetra(TetraError::Edge { .. }) => "out_of_range",
            other => return ErrorSubject::from_kind(other.kind()),
        })
    }
}
