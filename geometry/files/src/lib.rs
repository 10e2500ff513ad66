//! Checked reading of foreign files, atomic writing of files, and error reporting.
//!
//! This is the lowest crate that touches the disk. [`reading`] refuses files that are too large or not regular,
//! [`staging`] writes sets of files atomically, [`resumable`] fills folders across interrupted runs, [`memory`] refuses
//! work that does not fit, [`progress`] reports progress. Errors of all topics implement [`Explained`] and are passed
//! on as [`Error`]. [`diagnostics`] prints problems of texts with their source lines.
//!
//! The crate knows no sensors, options or terminals.

pub mod diagnostics;
pub mod directory_listing;
mod error;
mod error_subject;
pub mod memory;
pub mod progress;
pub mod reading;
pub mod resumable;
pub mod scratch_folder;
pub mod staging;
mod unknown_name;

pub use error::{Error, ErrorKind, Explained, join_first_messages, join_messages};
pub use error_subject::{ErrorSubject, limit_json, problem_json, split_amount};
pub use unknown_name::UnknownName;
