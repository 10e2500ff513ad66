//! The `fabkit` command: from arguments to texts and exit codes. The work itself is done by `fabkit_application`.

use std::ffi::OsString;

mod cli;
mod commands;
mod defaults;
mod failure;
mod hints;
mod interrupt;
mod roles;
mod table;

pub use cli::{CaptureOptions, CastOptions, ContactOptions, DatasetOptions, Named, PressOptions};

/// Runs a command line, whose first word is the command's name, prints results and errors, and returns the exit code.
///
/// The function assumes that it owns the process: it handles interrupts and panics, `--threads` sizes the global thread
/// pool, and `--help` or an empty command line ends the process.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    commands::main(arguments)
}
