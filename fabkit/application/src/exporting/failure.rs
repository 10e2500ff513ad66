//! Why there is nothing to write.

use fabkit_boards::BoardError;
use fabkit_checks::InvalidBody;
use fabkit_elastic::SoftError;
use fabkit_export::ExportError;
use fabkit_files::{ErrorKind, ErrorSubject, Explained, UnknownName};
use fabkit_geometry::{NotASheet, Shells};
use fabkit_mesh::{MeshError, Shell};
use fabkit_optics::InvalidStack;
use fabkit_scene::ground_truth::InvalidViewpoint;
use fabkit_tetra::TetraError;

use super::topology::places;
use crate::pictures::PictureError;

/// Why there is nothing to write.
#[derive(Debug, thiserror::Error)]
pub enum ExportFailure {
    /// No body of that name.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// Nothing soft that tetrahedra could be made of.
    #[error(transparent)]
    Soft(#[from] SoftError),
    /// Layers that tetrahedra cannot be made of.
    #[error(transparent)]
    Tetra(#[from] TetraError),
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
    #[error("{source}")]
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
    /// No guide can be made.
    #[error("the guide: {reason}")]
    Guide {
        /// Why.
        reason: String,
    },
    /// A solid that no rule can be applied to.
    #[error(transparent)]
    Examined(#[from] InvalidBody),
    /// Bodies that no light can be followed through.
    #[error(transparent)]
    Light(#[from] InvalidStack),
    /// A design whose camera cannot be.
    #[error(transparent)]
    Camera(#[from] InvalidViewpoint),
    /// Drawings of parts that have none.
    #[error("none of these parts is cut from a sheet: {}", .parts.join(", "))]
    NoOutlines {
        /// The parts asked for.
        parts: Vec<String>,
    },
    /// A circuit board that cannot be made as it is drawn.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// Boards of a design that has none.
    #[error(
        "{design} has no circuit board of its own{}",
        if .wired.is_empty() { String::new() } else { format!(": {} are bought and wired", .wired.join(", ")) }
    )]
    NoBoards {
        /// The design.
        design: String,
        /// What is wired instead.
        wired: Vec<String>,
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

impl Explained for ExportFailure {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::TooManyTriangles { .. }
            | Self::Tetra(TetraError::TooMany { .. })
            | Self::Mesh { source: MeshError::TooFine { .. }, .. } => ErrorKind::Limit,
            Self::Picture { source, .. } => source.kind(),
            Self::Unknown(_)
            | Self::Mesh { source: MeshError::Tolerance { .. }, .. }
            | Self::Plate(_)
            | Self::Stock(_)
            | Self::Outline { source: ExportError::KerfTooWide { .. }, .. }
            | Self::CannotBeMade { .. }
            | Self::HolesBreakOut { .. }
            | Self::ProfileWithoutFiles { .. }
            | Self::ProfileUnused { .. }
            | Self::Light(_)
            | Self::Camera(_)
            | Self::Board(_)
            | Self::NoBoards { .. }
            | Self::Soft(_)
            | Self::Tetra(TetraError::Edge { .. })
            | Self::NoOutlines { .. } => ErrorKind::BadInput,
            _ => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Unknown(unknown) => return Some(unknown.hint()),
            Self::Picture { source, .. } => return source.hint(),
            Self::Light(error) => return Some(error.hint().to_owned()).filter(|h| !h.is_empty()),
            Self::TooManyTriangles { .. }
            | Self::Mesh { source: MeshError::TooFine { .. }, .. } => {
                "allow a larger tolerance, or export fewer parts"
            }
            Self::Tetra(TetraError::TooMany { .. }) => "ask for longer edges",
            Self::Soft(_) => "tetrahedra are of the layers below a sensing surface of known shape",
            Self::Plate(_) => "name your printer's bed, or leave plates out: ask for stl alone",
            Self::Stock(_) => "name your stock, or leave drawings out: ask for stl,3mf",
            Self::Outline { source: ExportError::KerfTooWide { .. }, .. } => {
                "name your laser's width, or ask for nominal sizes"
            }
            Self::CannotBeMade { changed, .. } => {
                let list = match &changed[..] {
                    [] => String::new(),
                    all => format!(" of {}", all.join(", ")),
                };
                return Some(format!(
                    "take values{list} nearer to those of the built-in sensor: holes meet each other, \
                     break out of the part, or leave too little between them"
                ));
            }
            Self::HolesBreakOut { .. } => {
                "export this part without the profile, and let the slicer make up for the printer"
            }
            Self::ProfileWithoutFiles { .. } => {
                "ask for the formats stl or 3mf too, or leave the profile out"
            }
            Self::ProfileUnused { has_process: true, .. } => {
                "measure a coupon of that material (`fixtures.coupon.material`), or apply this \
                 profile to any material all the same"
            }
            Self::ProfileUnused { .. } => {
                "leave the profile out, or name that of the printer that makes these parts"
            }
            Self::Board(BoardError::NoPlate { .. }) => "let the board be a plate with holes",
            Self::Board(_) => {
                "make the board wider (its outside follows from the housing) or its bore smaller, take smaller or \
                 fewer LEDs, or lay this board out by hand from its outline (dxf)"
            }
            Self::NoBoards { .. } => "leave gerber out; a guide says how the lamps are wired",
            Self::NoOutlines { .. } => "printed parts have the formats stl,3mf",
            _ => return None,
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::Unknown(error) => return error.subject(),
            Self::Picture { source, .. } => return source.subject(),
            Self::TooManyTriangles { .. }
            | Self::Mesh { source: MeshError::TooFine { .. }, .. } => "too_many_triangles",
            Self::Mesh { source: MeshError::Tolerance { .. }, .. } => "out_of_range",
            Self::Plate(_) => "larger_than_bed",
            Self::Stock(_) => "larger_than_stock",
            Self::Outline { source: ExportError::KerfTooWide { .. }, .. } => "kerf_too_wide",
            Self::CannotBeMade { .. } => "cannot_be_made",
            Self::HolesBreakOut { .. } => "holes_break_out",
            Self::ProfileWithoutFiles { .. } | Self::ProfileUnused { .. } => "profile_unused",
            Self::NoOutlines { .. } => "no_outlines",
            Self::Soft(_) => "nothing_soft",
            Self::Tetra(TetraError::TooMany { .. }) => "too_many_tetrahedra",
            Self::Tetra(TetraError::Edge { .. }) => "out_of_range",
            other => return ErrorSubject::of_kind(other.kind()),
        })
    }
}

/// `1 piece`, `2 pieces`.
fn many(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}
