//! Errors of boards that cannot be laid out.

use thiserror::Error;

/// Reason why a board cannot be laid out.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BoardError {
    /// The body is not a horizontal plate.
    #[error("{board}: a circuit board must be a plate that lies level, and this body is none")]
    NotAPlate {
        /// Name of the body.
        board: String,
    },
    /// There is no place for a part.
    #[error(
        "{board}: {part} ({package}) needs {:.2} x {:.2} mm beside everything else, and there is no such place",
        needs_mm[0],
        needs_mm[1]
    )]
    NoRoom {
        /// Name of the board.
        board: String,
        /// Designator of the part.
        part: String,
        /// Its package.
        package: String,
        /// Size of the part, mm.
        needs_mm: [f64; 2],
    },
    /// There is no path for a track.
    #[error(
        "{board}: no way for a track of {width_mm:.2} mm with {clearance_mm:.2} mm beside it from {from} to the \
         rest of net {net}"
    )]
    NoRoute {
        /// Name of the board.
        board: String,
        /// Name of the net.
        net: String,
        /// Pin that stays unconnected.
        from: String,
        /// Width of the track, mm.
        width_mm: f64,
        /// Clearance between copper of two nets, mm.
        clearance_mm: f64,
    },
    /// The laid-out board breaks rules.
    #[error("{board}: {first}{}", if *more > 0 { format!(", and {more} more") } else { String::new() })]
    RuleViolations {
        /// Name of the board.
        board: String,
        /// First finding.
        first: String,
        /// Number of further findings.
        more: usize,
    },
}
