//! Failures as exceptions of `fabkit.errors`.

use fabkit::bodies::UnknownName;
use fabkit::failure::Failure;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What to say to somebody who asked for a name that is not among those known.
#[pyfunction]
pub fn hint(name: &str, known: Vec<String>) -> String {
    UnknownName::new("name", name, known.iter().map(String::as_str)).hint()
}

/// What the command would print and `--json` would say, as the exception made from it.
pub fn exception(py: Python<'_>, failure: impl Into<Failure>) -> PyErr {
    let failure = failure.into();
    made(py, &failure).unwrap_or_else(|error| error)
}

fn made(py: Python<'_>, failure: &Failure) -> PyResult<PyErr> {
    let arguments = PyDict::new(py);
    arguments.set_item("document", failure.to_json().to_string())?;
    arguments.set_item("text", failure.to_text())?;
    let exception = py.import("fabkit.errors")?.getattr("_of")?.call((), Some(&arguments))?;
    Ok(PyErr::from_value(exception))
}

/// [`exception`] for results.
pub trait OrRaise<T> {
    /// The value, or the failure as an exception.
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T, E: Into<Failure>> OrRaise<T> for Result<T, E> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| exception(py, error))
    }
}
