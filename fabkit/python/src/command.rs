//! Entry point of the `fabkit` command in the wheel.

use std::ffi::OsString;

use pyo3::prelude::*;

use crate::process_pool::run_in_pool;

/// Runs the command as if in its own process. The first argument is its name. Returns the exit code.
#[pyfunction]
pub fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    // The command handles interrupts itself: Python's handler would wait until Python code runs.
    py.detach(|| run_in_pool(|| fabkit::run(arguments)))
}
