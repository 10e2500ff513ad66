//! Options by name, from Python's keyword arguments.

use fabkit::Named;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Values by the names of options; a missing one is `None`.
pub struct Keywords<'a, 'py>(pub &'a Bound<'py, PyDict>);

impl<'py, T: FromPyObjectOwned<'py>> Named<T, PyErr> for Keywords<'_, 'py> {
    fn named(&self, name: &'static str) -> PyResult<T> {
        let py = self.0.py();
        let value = self.0.get_item(name)?.unwrap_or_else(|| py.None().into_bound(py));
        value.extract().map_err(|error: T::Error| {
            let error: PyErr = error.into();
            // Same message as PyO3's for ordinary arguments.
            if error.is_instance_of::<PyTypeError>(py) {
                return PyTypeError::new_err(format!("argument '{name}': {}", error.value(py)));
            }
            error
        })
    }
}
