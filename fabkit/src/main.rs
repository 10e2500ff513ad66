//! The fabkit command: one description of a tactile sensor to parts, molds and ground truth.

mod cli;
mod commands;
mod diagnostics;
mod failure;
mod interrupt;
mod reading;
mod source;
mod table;

use std::process::ExitCode;

fn main() -> ExitCode {
    failure::guard(commands::main)
}
