//! Errors of an export.

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

use super::topology::format_shells;
use crate::images::DrawingError;

/// Error that prevents an export.
#[derive(Debug, thiserror::Error)]
pub enum ExportRunError {
    /// A requested body does not exist.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
    /// The sensor has no soft layers to divide into tetrahedra.
    #[error(transparent)]
    Soft(#[from] SoftError),
    /// Layers that cannot be divided into tetrahedra.
    #[error(transparent)]
    Tetra(#[from] TetraError),
    /// The solid could not be meshed.
    #[error("{part}: {source}")]
    Mesh {
        /// Name of the part.
        part: String,
        /// Reason.
        source: MeshError,
    },
    /// The mesh has a different genus (number of through holes and handles) than the design.
    #[error("{part}: the mesh has {found} holes and handles, the design counts {counted}")]
    Genus {
        /// Name of the part.
        part: String,
        /// Genus of the mesh.
        found: i32,
        /// Genus counted in the design.
        counted: i32,
    },
    /// The mesh has different numbers of pieces or closed cavities than the design.
    #[error(
        "{part}: the mesh has {} and {}, the design counts {} and {}{}",
        count_noun(.found.pieces, "piece", "pieces"),
        count_noun(.found.voids, "closed cavity", "closed cavities"),
        .counted.pieces,
        .counted.voids,
        format_shells(.unexpected)
    )]
    Shells {
        /// Name of the part.
        part: String,
        /// Shells of the mesh.
        found: Shells,
        /// Shells counted in the design.
        counted: Shells,
        /// Smallest of the surplus shells, in the frame of the part's files.
        unexpected: Vec<Shell>,
    },
    /// Parts whose holes, pieces or cavities differ from the design's counts, in a design whose values differ from the
    /// built-in one's. The values are then the likely cause.
    #[error("{reason}: with these values it cannot be made")]
    CannotBeMade {
        /// Name of the part and its fault.
        reason: String,
        /// Parameters that differ from the built-in design's, with their values.
        changed: Vec<String>,
    },
    /// Holes that break out of the part or into each other once the printer's profile has widened them.
    #[error("{part}: holes fitted for {profile} break out of the part or into each other")]
    HolesBreakOut {
        /// Name of the part.
        part: String,
        /// Name of the printer profile.
        profile: String,
    },
    /// A printer profile was given, but no requested file can apply it.
    #[error("the profile {profile} is for STL and 3MF files, and none are asked for")]
    ProfileWithoutFiles {
        /// Name of the printer profile.
        profile: String,
    },
    /// A printer profile that applies to none of the parts.
    #[error(
        "the profile {profile} is for {process} of {material}, and no part of this export is made \
         so: {}",
        .made.join("; ")
    )]
    ProfileUnused {
        /// Name of the printer profile.
        profile: String,
        /// Process of the coupon from which the profile was measured.
        process: String,
        /// Material of that coupon.
        material: String,
        /// Process and material of the parts, for example `sla of tough resin`, each once.
        made: Vec<String>,
        /// True if some parts are made by the profile's process.
        has_process: bool,
    },
    /// More triangles than slicers can be expected to load.
    #[error(
        "the export has more than {most} triangles, which is as many as slicers and memory take"
    )]
    TooManyTriangles {
        /// Largest allowed number.
        most: usize,
    },
    /// Two bodies would have the same file name.
    #[error("two files are called {0}")]
    DuplicateFile(String),
    /// The part could not be drawn.
    #[error("{source}")]
    Image {
        /// Name of the part.
        part: String,
        /// Reason.
        source: DrawingError,
    },
    /// A file could not be encoded in its format.
    #[error("{file}: {source}")]
    Write {
        /// Name of the file.
        file: String,
        /// Reason.
        source: ExportError,
    },
    /// A part larger than the printer's bed.
    #[error(transparent)]
    Plate(#[from] ExportError),
    /// A part larger than the stock sheet.
    #[error(transparent)]
    Stock(ExportError),
    /// A part with a sheet process that is not flat.
    #[error("{part} cannot be made by {process}: {source}")]
    NotASheet {
        /// Name of the part.
        part: String,
        /// Process given for it.
        process: String,
        /// Reason why it is not a sheet.
        source: NotASheet,
    },
    /// Outlines that cannot be cut.
    #[error("{part}: {source}")]
    Outline {
        /// Name of the part.
        part: String,
        /// Reason.
        source: ExportError,
    },
    /// The build guide cannot be made.
    #[error("the guide: {reason}")]
    Guide {
        /// Reason.
        reason: String,
    },
    /// A solid that cannot be examined by rules.
    #[error(transparent)]
    Examined(#[from] InvalidBody),
    /// Bodies through which no light can be traced.
    #[error(transparent)]
    Light(#[from] InvalidStack),
    /// A design with an invalid camera.
    #[error(transparent)]
    Camera(#[from] InvalidViewpoint),
    /// Outlines were requested of parts that are not cut from sheets.
    #[error("none of these parts is cut from a sheet: {}", .parts.join(", "))]
    NoOutlines {
        /// Names of the requested parts.
        parts: Vec<String>,
    },
    /// A circuit board that cannot be made as designed.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// Boards were requested of a design without any.
    #[error(
        "{design} has no circuit board of its own{}",
        if .wired.is_empty() { String::new() } else { format!(": {} are bought and wired", .wired.join(", ")) }
    )]
    NoBoards {
        /// Name of the design.
        design: String,
        /// Circuits that are bought and wired instead.
        wired: Vec<String>,
    },
}

impl ExportRunError {
    /// Returns whether a smaller chord tolerance may remove the failure.
    pub(super) fn is_topology_failure(&self) -> bool {
        matches!(
            self,
            Self::Genus { .. }
                | Self::Shells { .. }
                | Self::HolesBreakOut { .. }
                | Self::Mesh { source: MeshError::Empty | MeshError::Print(_), .. }
        )
    }
}

impl Explained for ExportRunError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::TooManyTriangles { .. }
            | Self::Tetra(TetraError::TooMany { .. })
            | Self::Mesh { source: MeshError::TooFine { .. }, .. } => ErrorKind::Limit,
            Self::Image { source, .. } => source.kind(),
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
            // All other failures contradict what the design itself guarantees.
            _ => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::Unknown(unknown) => return Some(unknown.hint()),
            Self::Image { source, .. } => return source.hint(),
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
            Self::Board(BoardError::NotAPlate { .. }) => "let the board be a plate with holes",
            Self::Board(_) => {
                "make the board wider (its outside follows from the housing) or its bore smaller, take smaller or \
                 fewer LEDs, or lay this board out by hand from its outline (dxf)"
            }
            Self::NoBoards { .. } => "leave gerber out; the guide shows how the LEDs are wired",
            Self::NoOutlines { .. } => "printed parts have the formats stl,3mf",
            _ => return None,
        };
        Some(hint.into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new(match self {
            Self::Unknown(error) => return error.subject(),
            Self::Image { source, .. } => return source.subject(),
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
            other => return ErrorSubject::from_kind(other.kind()),
        })
    }
}

/// Returns the count with its noun: `1 piece`, `2 pieces`.
fn count_noun(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}
