//! The `fabkit` command that comes with the wheel.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command as its own process would; the first argument is its name. The exit code.
#[pyfunction]
pub fn command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    // The command handles interrupts itself: Python's handler would wait for Python code to run.
    py.detach(|| fabkit::run(arguments))
}
