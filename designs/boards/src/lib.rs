//! Circuit boards from circuits: copper, its rules, its netlist, and fabrication files.
//!
//! [`lay_out`] places the parts that the sensor does not place itself, and routes tracks over a grid that follows the
//! board: rings and rays on an annular board, rows and columns elsewhere. [`check`] then examines the finished copper
//! alone. It does not rely on the nets for which tracks were laid: it determines which copper is connected, and
//! compares that with the circuit. `files` writes Gerber X2, Excellon, the job file and tables.

#![forbid(unsafe_code)]

mod artwork;
mod check;
mod connectivity;
mod error;
mod files;
mod font;
mod gerber;
mod grid;
mod layout;
mod outline;
mod place_and_route;
mod placement;
mod route;
mod rules;
mod shapes;
mod silk;
mod tables;

pub use artwork::svg;
pub use check::{BoardFinding, BoardFlaw, check};
pub use error::BoardError;
pub use files::{BoardFile, fabrication_files};
pub use layout::{BoardLayout, Drill, MAX_DRILL_MM, Pad, PlacedPart, SIDES, SilkLine, Track, Via};
pub use outline::{BoardShape, RoundHole};
pub use place_and_route::lay_out;
pub use rules::{BoardRules, STANDARD_RULES, min_track_width_mm};
pub use shapes::{Point, Shape};
