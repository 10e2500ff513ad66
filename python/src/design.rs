//! Sensors and their fixtures.

use std::sync::Arc;

use fabkit::bodies::{self, BodyRef};
use fabkit::exporting::ExportFailure;
use fabkit::failure::Failure;
use fabkit::source::Source;
use fabkit::{designs, fixtures};
use pyo3::prelude::*;

use crate::errors::OrRaise;
use crate::mesh::Mesh;
use crate::running::{Interrupted, run};

/// Names of the built-in sensors.
#[pyfunction]
pub fn sensors() -> Vec<&'static str> {
    designs::builtin_names()
}

/// Reads a sensor: a built-in one or one of its presets by name, or a file.
#[pyfunction]
pub fn load(
    py: Python<'_>,
    sensor: &str,
    preset: Option<&str>,
    overrides: Vec<String>,
) -> PyResult<Project> {
    let loaded = py.detach(|| {
        let source = match preset {
            None => Source::find(sensor)?,
            Some(preset) => Source::preset(sensor, preset)?,
        };
        let project = source.load(&overrides)?;
        Ok::<_, Failure>((source, project))
    });
    let (source, project) = loaded.or_raise(py)?;
    Ok(Project { source: Arc::new(source), project: Arc::new(project) })
}

/// A sensor with the parameters of its fixtures.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Project {
    source: Arc<Source>,
    project: Arc<fixtures::Project>,
}

#[pymethods]
impl Project {
    fn design(&self) -> Design {
        Design { design: Arc::new(self.project.design.clone()) }
    }

    fn fixture_names(&self) -> Vec<&'static str> {
        self.project.fixture_names()
    }

    fn fixture(&self, py: Python<'_>, name: String) -> PyResult<Design> {
        let (source, project) = (Arc::clone(&self.source), Arc::clone(&self.project));
        let design = run(py, Interrupted::Leave, None, move |_| {
            project.fixture(&name).map_err(|error| source.failure(error))
        })?;
        Ok(Design { design: Arc::new(design) })
    }
}

/// A sensor, or a fixture made for one.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Design {
    pub design: Arc<designs::Design>,
}

impl Design {
    fn bodies(&self) -> Vec<BodyRef<'_>> {
        bodies::bodies(&self.design.sensor)
    }
}

#[pymethods]
impl Design {
    fn name(&self) -> &str {
        &self.design.sensor.name
    }

    /// Kind and name of each body, in order.
    fn body_names(&self) -> Vec<(&'static str, String)> {
        self.bodies().iter().map(|body| (body.kind.word(), body.name.to_owned())).collect()
    }

    fn mesh(&self, py: Python<'_>, body: String, tolerance_mm: f64) -> PyResult<Mesh> {
        let (design, name) = (Arc::clone(&self.design), body.clone());
        let mesh = run(py, Interrupted::Leave, None, move |_| {
            let body = bodies::find(&design.sensor, &name)?;
            fabkit::mesh::mesh(body.solid, tolerance_mm)
                .map_err(|source| ExportFailure::Mesh { part: name.clone(), source }.into())
        })?;
        Ok(Mesh { name: body, mesh: Arc::new(mesh) })
    }
}
