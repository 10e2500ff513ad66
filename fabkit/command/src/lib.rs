//! The `fabkit` command: from arguments to texts and exit codes. The work itself is done by `fabkit_application`.
//!
//! ```
//! let run = |line: &str| fabkit::run(line.split(' ').map(Into::into));
//! assert_eq!(run("fabkit list"), 0);
//! assert_eq!(run("fabkit show rtac0 --json"), 0);
//! // A name that does not exist is bad input: exit code 2, and a hint at `rtac0`.
//! assert_eq!(run("fabkit show rtac"), 2);
//! ```

use std::ffi::OsString;

mod cli;
mod commands;
mod defaults;
mod failure;
mod hints;
mod interrupt;
mod roles;
mod table;
mod terminal;

pub use cli::{CaptureOptions, CastOptions, ContactOptions, DatasetOptions, Named, PressOptions};

/// Runs a command line, whose first word is the command's name, prints results and errors, and returns the exit code.
///
/// The function assumes that it owns the process: it handles interrupts and panics, `--threads` sizes the global thread
/// pool, and `--help` or an empty command line ends the process.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    commands::main(arguments)
}
