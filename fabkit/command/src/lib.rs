//! The `fabkit` command: arguments in, texts and exit codes out. What it does is `fabkit_application`'s.

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

/// Does what a command line says, whose first word is the command's name, and says how it went on
/// standard output and standard error; the exit code.
///
/// It takes the process for its own: it handles interrupts and panics, `--threads` sizes the global
/// thread pool, and `--help` and a command line that says nothing end the process.
#[must_use]
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    commands::main(arguments)
}
