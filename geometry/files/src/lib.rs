//! Checked reading of foreign files, atomic writing of files, and error reporting.
//!
//! This is the lowest crate that touches the disk. [`reading`] refuses files that are too large or not regular,
//! [`staging`] writes sets of files atomically, [`resumable`] fills folders across interrupted runs, [`memory`] refuses
//! work that does not fit, [`progress`] reports progress. Errors of all topics implement [`Explained`] and are passed
//! on as [`Error`]. [`diagnostics`] prints problems of texts with their source lines.
//!
//! The crate knows no sensors, options or terminals.
//!
//! ```
//! use fabkit_files::reading::{ExpectedFile, read_text};
//! use fabkit_files::scratch_folder::ScratchFolder;
//! use fabkit_files::staging::{OutputFile, write_all};
//! use fabkit_files::{ErrorKind, Explained};
//!
//! const NOTE: ExpectedFile = ExpectedFile { what: "a note", max_bytes: 20, hint: "shorten it" };
//! let folder = ScratchFolder::new()?;
//! let file = |name: &str, text: &str| OutputFile { name: name.into(), bytes: text.into() };
//! let files = [file("a.txt", "short"), file("b.txt", "longer than twenty bytes")];
//! write_all(folder.path(), &files, &|| false)?;
//! assert_eq!(read_text(&folder.path_of_file("a.txt"), NOTE)?, "short");
//! let error = read_text(&folder.path_of_file("b.txt"), NOTE).unwrap_err();
//! assert_eq!((error.kind(), error.hint().as_deref()), (ErrorKind::Limit, Some("shorten it")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
