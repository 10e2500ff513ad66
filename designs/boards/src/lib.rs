//! Circuit boards from circuits: copper, its rules, its netlist, and the files that a fab reads.
//!
//! [`lay_out`] places what the sensor does not draw and lays tracks over a grid that follows the board: around
//! the axis on a ring, along the edges elsewhere. [`check`] then looks at the finished copper alone: it does not
//! believe what the tracks were laid for, but finds out what touches what, and compares that with the circuit.
//! [`files`] writes Gerber X2, Excellon, the job file and tables.

#![forbid(unsafe_code)]

mod artwork;
mod check;
mod connected;
mod error;
mod files;
mod font;
mod gerber;
mod grid;
mod layout;
mod outline;
mod place;
mod place_and_route;
mod route;
mod rules;
mod shapes;
mod silk;
mod tables;

pub use artwork::svg;
pub use check::{Finding, Flaw, check};
pub use error::BoardError;
pub use files::{BoardFile, files};
pub use layout::{Drill, LARGEST_DRILL_MM, Layout, Pad, PlacedPart, SIDES, SilkLine, Track, Via};
pub use outline::{BoardShape, RoundHole};
pub use place_and_route::lay_out;
pub use rules::{Rules, USUAL, width_for_mm};
pub use shapes::{Point, Shape};
