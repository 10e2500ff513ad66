//! Why there is nothing to write.

use fabkit_export::ExportError;
use fabkit_geometry::{NotASheet, Shells};
use fabkit_mesh::{MeshError, Shell};

use super::topology::places;
use crate::bodies::UnknownName;
use crate::pictures::PictureError;

/// Why there is nothing to write.
#[derive(Debug, thiserror::Error)]
pub enum ExportFailure {
    /// No body of that name.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// The solid could not be turned into triangles.
    #[error("{part}: {source}")]
    Mesh {
        /// Which part.
        part: String,
        /// Why.
        source: MeshError,
    },
    /// The mesh has other holes than the design counts.
    #[error("{part}: the mesh has {found} holes and handles, the design counts {counted}")]
    Genus {
        /// Which part.
        part: String,
        /// In the mesh.
        found: i32,
        /// In the design.
        counted: i32,
    },
    /// The mesh is in other pieces, or has other cavities, than the design counts.
    #[error(
        "{part}: the mesh has {} and {}, the design counts {} and {}{}",
        many(.found.pieces, "piece", "pieces"),
        many(.found.voids, "closed cavity", "closed cavities"),
        .counted.pieces,
        .counted.voids,
        places(.unexpected)
    )]
    Shells {
        /// Which part.
        part: String,
        /// In the mesh.
        found: Shells,
        /// In the design.
        counted: Shells,
        /// The smallest of those that are too many, in the frame of the part's files.
        unexpected: Vec<Shell>,
    },
    /// Parts whose holes, pieces or cavities are not those of the design, with values that are not the
    /// built-in design's.
    #[error("{reason}: with these values it cannot be made")]
    CannotBeMade {
        /// Which part, and what is wrong with it.
        reason: String,
        /// Parameters that differ from the built-in design's, with their values.
        changed: Vec<String>,
    },
    /// Holes as wide as the printer needs them leave the part elsewhere.
    #[error("{part}: holes fitted for {profile} break out of the part or into each other")]
    HolesBreakOut {
        /// Which part.
        part: String,
        /// Name of the printer's profile.
        profile: String,
    },
    /// A printer's profile, but no file that could make up for what it says.
    #[error("the profile {profile} is for STL and 3MF files, and none are asked for")]
    ProfileWithoutFiles {
        /// Name of the printer's profile.
        profile: String,
    },
    /// A printer's profile that says nothing of any part.
    #[error(
        "the profile {profile} is for {process} of {material}, and no part of this export is made \
         so: {}",
        .made.join("; ")
    )]
    ProfileUnused {
        /// Name of the printer's profile.
        profile: String,
        /// How its coupon was made.
        process: String,
        /// From what.
        material: String,
        /// How the parts are made, for example `sla of tough resin`, each once.
        made: Vec<String>,
        /// Whether parts of its process are among them.
        has_process: bool,
    },
    /// More triangles than a slicer can be expected to load.
    #[error(
        "the export has more than {most} triangles, which is as many as slicers and memory take"
    )]
    TooManyTriangles {
        /// How many there may be.
        most: usize,
    },
    /// Two bodies would have the same file name.
    #[error("two files are called {0}")]
    DuplicateFile(String),
    /// The part could not be drawn.
    #[error("{part}: {source}")]
    Picture {
        /// Which part.
        part: String,
        /// Why.
        source: PictureError,
    },
    /// A format could not hold it.
    #[error("{file}: {source}")]
    Write {
        /// Which file.
        file: String,
        /// Why.
        source: ExportError,
    },
    /// A part that the printer cannot hold.
    #[error(transparent)]
    Plate(#[from] ExportError),
    /// A part that the stock cannot hold.
    #[error(transparent)]
    Stock(ExportError),
    /// A part that is said to be cut from a sheet, but is not flat.
    #[error("{part} cannot be made by {process}: {source}")]
    NotASheet {
        /// Which part.
        part: String,
        /// How it is said to be made.
        process: String,
        /// Why not.
        source: NotASheet,
    },
    /// Outlines that cannot be cut.
    #[error("{part}: {source}")]
    Outline {
        /// Which part.
        part: String,
        /// Why.
        source: ExportError,
    },
    /// Drawings of parts that have none.
    #[error("none of these parts is cut from a sheet: {}", .parts.join(", "))]
    NoOutlines {
        /// The parts asked for.
        parts: Vec<String>,
    },
}

impl ExportFailure {
    /// Whether triangles that stray less may do better.
    pub(super) fn is_of_topology(&self) -> bool {
        matches!(
            self,
            Self::Genus { .. }
                | Self::Shells { .. }
                | Self::HolesBreakOut { .. }
                | Self::Mesh { source: MeshError::Empty | MeshError::Print(_), .. }
        )
    }
}

/// `1 piece`, `2 pieces`.
fn many(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}
