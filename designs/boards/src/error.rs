//! Why a board cannot be laid out.

use thiserror::Error;

/// Why a board cannot be laid out.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BoardError {
    /// The body is no plate that lies level.
    #[error("{board}: a circuit board must be a plate that lies level, and this body is none")]
    NoPlate {
        /// The body.
        board: String,
    },
    /// A part finds no place.
    #[error(
        "{board}: {part} ({package}) needs {:.2} x {:.2} mm beside everything else, and there is no such place",
        needs_mm[0],
        needs_mm[1]
    )]
    NoRoom {
        /// The board.
        board: String,
        /// The part.
        part: String,
        /// Its package.
        package: String,
        /// Its size, mm.
        needs_mm: [f64; 2],
    },
    /// A net finds no way.
    #[error(
        "{board}: no way for a track of {width_mm:.2} mm with {clearance_mm:.2} mm beside it from {from} to the \
         rest of net {net}"
    )]
    NoWay {
        /// The board.
        board: String,
        /// The net.
        net: String,
        /// The pin that is left alone.
        from: String,
        /// Tracks that were tried, mm.
        width_mm: f64,
        /// Between copper of two nets, mm.
        clearance_mm: f64,
    },
    /// What was laid out breaks rules.
    #[error("{board}: {first}{}", if *more > 0 { format!(", and {more} more") } else { String::new() })]
    Broken {
        /// The board.
        board: String,
        /// The first finding.
        first: String,
        /// How many others.
        more: usize,
    },
}
