//! Sensors and their fixtures.

use std::sync::Arc;

use fabkit_application::calibration::board::Board;
use fabkit_application::calibration::landmarks::PinLandmarks;
use fabkit_application::designs::fixing::ValueChange;
use fabkit_application::exports::ExportRunError;
use fabkit_application::images::{self, DrawingError, ImageView};
use fabkit_application::progress::ignore_progress;
use fabkit_application::source::Source;
use fabkit_application::{Error, bodies, checks, designs, documents, fixtures, model_view};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays;
use crate::camera::Camera;
use crate::errors::{Failure, OrRaise};
use crate::export::{ExportRequest, Exported, exported};
use crate::mesh::Mesh;
use crate::running::{InterruptPolicy, run_on_thread, run_short};

/// Names of the built-in sensors.
#[pyfunction]
pub fn sensors() -> Vec<&'static str> {
    designs::builtin_names()
}

/// Loads a sensor: a built-in one or one of its presets by name, or a file.
#[pyfunction]
pub fn load(
    py: Python<'_>,
    sensor: &str,
    preset: Option<&str>,
    mut overrides: Vec<String>,
    fix: bool,
) -> PyResult<Project> {
    let loaded = run_short(py, || {
        let source = match preset {
            None => Source::find(sensor)?,
            Some(preset) => Source::preset(sensor, preset)?,
        };
        let changes = if fix { source.fix(&overrides)? } else { Vec::new() };
        // The changes become overrides, so that sensors derived from this one keep them.
        overrides.extend(changes.iter().map(ValueChange::as_override));
        let project = source.load(&overrides)?;
        Ok::<_, Error>((source, project, changes))
    })?;
    let (source, project, changes) = loaded.or_raise(py)?;
    Ok(Project { source: Arc::new(source), project: Arc::new(project), overrides, changes })
}

/// Sensor with the parameters of its fixtures.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Project {
    pub source: Arc<Source>,
    pub project: Arc<fixtures::Project>,
    /// Overrides with which it was read, `path=value`.
    pub overrides: Vec<String>,
    /// Automatic changes that made it buildable.
    pub changes: Vec<ValueChange>,
}

#[pymethods]
impl Project {
    fn design(&self) -> Design {
        Design { design: Arc::new(self.project.design.clone()) }
    }

    /// The family of its file.
    fn family(&self) -> &'static str {
        self.project.design.family
    }

    fn overrides(&self) -> Vec<String> {
        self.overrides.clone()
    }

    /// Reads the same source with other overrides.
    fn replaced(&self, py: Python<'_>, overrides: Vec<String>) -> PyResult<Self> {
        let project = run_short(py, || self.source.load(&overrides))?.or_raise(py)?;
        let (source, project) = (Arc::clone(&self.source), Arc::new(project));
        Ok(Self { source, project, overrides, changes: Vec::new() })
    }

    /// Automatic changes that made the sensor buildable: path, from, to, because.
    fn changes(&self) -> Vec<(String, String, String, String)> {
        let told = |change: ValueChange| (change.path, change.from, change.to, change.because);
        self.changes.iter().cloned().map(told).collect()
    }

    /// Sentences about values that change nothing, or change the size of the whole.
    fn value_effects(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        run_short(py, || self.source.value_effects(&self.overrides).sentences())
    }

    fn fixture_names(&self) -> Vec<&'static str> {
        self.project.fixture_names()
    }

    fn fixture_summary(&self, name: &str) -> Option<&'static str> {
        self.project.summary(name)
    }

    fn fixture(&self, py: Python<'_>, name: String) -> PyResult<Design> {
        let (source, project) = (Arc::clone(&self.source), Arc::clone(&self.project));
        let design = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            Ok(project.fixture(&name).map_err(|error| source.convert_fixture_error(error))?)
        })?;
        Ok(Design { design: Arc::new(design) })
    }

    /// IDs of the presses with known places, in order.
    fn presses(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let (source, project) = (Arc::clone(&self.source), Arc::clone(&self.project));
        run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let mut ids = Vec::new();
            for presses in project.presses() {
                let presses = presses.map_err(|error| source.convert_fixture_error(error))?;
                ids.extend(presses.into_iter().map(|press| press.id));
            }
            Ok(ids)
        })
    }

    /// Checks the sensor or a fixture: a `fabkit-check` document.
    fn check(&self, py: Python<'_>, fixture: Option<String>) -> PyResult<String> {
        let (source, project) = (Arc::clone(&self.source), Arc::clone(&self.project));
        run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let (design, report) = match &fixture {
                None => (project.design.clone(), checks::check(&project.design.sensor)),
                Some(name) => {
                    let failed = |error| source.convert_fixture_error(error);
                    let report = project.check_fixture(name, &|_, _| {}).map_err(failed)?;
                    (project.fixture(name).map_err(failed)?, report)
                }
            };
            let report = report.map_err(Failure::bug)?;
            Ok(documents::check(&design, &report).to_string())
        })
    }

    /// The nominal camera.
    fn camera(&self, py: Python<'_>) -> PyResult<Camera> {
        Camera::nominal(py, &self.project.design.sensor.camera)
    }

    /// The pose from camera frame to sensor frame, (4, 4).
    fn sensor_from_camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::pose_array(py, &self.project.design.sensor.camera.sensor_from_camera)
    }
}

/// Names, (n, 3) points and (n, 3) unit axes.
type Landmarks<'py> = (Vec<String>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Sensor, or fixture made for one.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Design {
    pub design: Arc<designs::Design>,
}

impl Design {
    fn body(&self, py: Python<'_>, name: &str) -> PyResult<&fabkit_application::geometry::Body> {
        bodies::find(&self.design.sensor, name).or_raise(py)
    }
}

#[pymethods]
impl Design {
    /// A `fabkit-show` document.
    fn about(&self, py: Python<'_>) -> PyResult<String> {
        run_short(py, || documents::show(&self.design).to_string())
    }

    /// A `fabkit-chain` document.
    fn chain(&self, py: Python<'_>) -> PyResult<String> {
        run_short(py, || documents::chain(&self.design).to_string())
    }

    /// Files that come with the design: names and contents.
    fn companions<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyBytes>)>> {
        let files = self.design.companions.iter();
        // Some are computed only now.
        files
            .map(|file| {
                let bytes = run_short(py, || file.bytes())?;
                Ok((file.name.clone(), PyBytes::new(py, bytes)))
            })
            .collect()
    }

    /// Contact points of pins, as JSON; `None` for a design without pins.
    fn pin_landmarks(&self) -> Option<String> {
        self.design.documents().next().map(PinLandmarks::to_json)
    }

    /// Calibration boards, as JSON.
    fn boards(&self) -> Vec<String> {
        self.design.documents().map(Board::to_json).collect()
    }

    /// Named points of a body, in its frame.
    fn landmarks<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Landmarks<'py>> {
        let landmarks = &self.body(py, body)?.landmarks;
        let names = landmarks.iter().map(|landmark| landmark.name.clone()).collect();
        let points = landmarks.iter().flat_map(|landmark| landmark.point.coords.data.0[0]);
        let axes = landmarks.iter().flat_map(|landmark| landmark.axis.data.0[0]);
        let shape = [landmarks.len(), 3];
        let points = PyArray1::from_vec(py, points.collect()).reshape(shape)?;
        let axes = PyArray1::from_vec(py, axes.collect()).reshape(shape)?;
        Ok((names, points, axes))
    }

    fn mesh(&self, py: Python<'_>, body: String, tolerance_mm: f64) -> PyResult<Mesh> {
        let (design, name) = (Arc::clone(&self.design), body.clone());
        let mesh = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let body = bodies::find(&design.sensor, &name)?;
            fabkit_application::mesh::mesh(&body.solid, tolerance_mm)
                .map_err(|source| ExportRunError::Mesh { part: name.clone(), source }.into())
        })?;
        Mesh::new(py, body, mesh)
    }

    /// Draws a body or an assembly as PNG.
    #[pyo3(signature = (body, assembly, exploded, section, view, size_px))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments in Python")]
    fn picture<'py>(
        &self,
        py: Python<'py>,
        body: Option<String>,
        assembly: Option<String>,
        exploded: bool,
        section: bool,
        view: Option<String>,
        size_px: [u32; 2],
    ) -> PyResult<Bound<'py, PyBytes>> {
        let design = Arc::clone(&self.design);
        let bytes = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let from = view.map(|view| view.parse().map_err(DrawingError::Viewer)).transpose()?;
            let (sensor, shot) = (&design.sensor, ImageView { size_px, is_section: section, from });
            Ok(match body {
                Some(name) => {
                    images::draw_body(bodies::find(sensor, &name)?, shot, &ignore_progress)?
                }
                None => {
                    let assembly = assembly.unwrap_or_else(|| images::default_assembly(sensor));
                    images::draw_assembly(sensor, &assembly, exploded, shot, &ignore_progress)?
                }
            })
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// One HTML page with the interactive model.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let design = Arc::clone(&self.design);
        run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            Ok(model_view::build_model(&design)?.to_html())
        })
    }

    /// Exports files in memory.
    #[pyo3(signature = (wish, progress))]
    fn exported(
        &self,
        py: Python<'_>,
        wish: ExportRequest,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Exported> {
        exported(py, &self.design, wish, progress)
    }
}
