//! Presses of soft layers: forces by indentation, and the displaced surface.

use std::sync::Arc;

use fabkit::PressOptions;
use fabkit_application::Error;
use fabkit_application::press_simulation::{self, PressRequest, PressingError};
use fabkit_application::source::convert_press_error;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::design::Project;
use crate::errors::Failure;
use crate::keywords::Keywords;
use crate::running::{InterruptPolicy, run_on_thread};

/// Computes a press: the JSON of `fabkit press --json`, and the arrays of `fabkit press -o FILE.npz` by name. Options
/// are those of [`PressOptions`], by name.
#[pyfunction]
pub fn press<'py>(
    py: Python<'py>,
    project: &Project,
    sensor: String,
    indenter: String,
    depth_mm: f64,
    options: Bound<'py, PyDict>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let options = PressOptions::from_named(&Keywords(&options))?;
    let project = Arc::clone(&project.project);
    let (document, field) = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
        let pressing = options.pressing(&indenter, depth_mm).map_err(Error::from)?;
        let explained = |error| match error {
            PressingError::Press(error) => convert_press_error(&sensor, error),
            other => Error::from(other),
        };
        if PressRequest::is_on_skin(&project.design.sensor) {
            let pressed = pressing.run_on_skin(&project).map_err(explained)?;
            let document = press_simulation::skin_document(&pressed).to_string();
            return Ok((document, press_simulation::skin_arrays(&pressed)));
        }
        let pressed = pressing.run(&project).map_err(explained)?;
        let document = press_simulation::press_document(&pressed).to_string();
        Ok::<_, Failure>((document, press_simulation::press_arrays(&pressed)))
    })?;
    Ok((document, arrays::dictionary(py, field)?))
}
