//! Reading what others wrote, writing files whole or not at all, and saying what went wrong.
//!
//! The lowest crate that touches the disk: [`reading`] refuses what is too large or no file, [`staging`] lets files
//! appear whole or not at all, [`resumable`] fills folders that survive being killed, [`memory`] refuses work that does
//! not fit, [`progress`] carries how far work is. Failures of all topics implement [`Explained`] and travel as
//! [`Error`]; [`diagnostics`] shows problems of texts with their lines.
//!
//! Knows no sensors, no options and no terminals.

pub mod diagnostics;
mod error;
pub mod listing;
pub mod memory;
mod names;
pub mod progress;
pub mod reading;
pub mod resumable;
pub mod scratch;
pub mod staging;
mod subject;

pub use error::{Error, ErrorKind, Explained, joined, listed};
pub use names::UnknownName;
pub use subject::{ErrorSubject, amount, limit, problem_json};
