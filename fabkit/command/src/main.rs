//! The `fabkit` command: from the description of a tactile sensor to parts, molds and ground truth.

use std::process::ExitCode;

fn main() -> ExitCode {
    fabkit::run(std::env::args_os()).into()
}
