//! Ground truth: a camera's view of a sensor's surface.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use fabkit::{CaptureOptions, CastOptions, ContactOptions};
use fabkit_application::Error;
use fabkit_application::camera::files::{PoseFile, read_pose};
use fabkit_application::capturing::plausibility::Judged;
use fabkit_application::capturing::{self, Unit, select_lighting};
use fabkit_application::export::{NpyArray, NpyValues, png};
use fabkit_application::fixtures::Press;
use fabkit_application::ground_truth::{Viewpoint, arrays, false_color_image};
use fabkit_application::press_simulation;
use fabkit_application::reconstructing::{self, CapturedImage, DepthNetwork};
use fabkit_application::scene::{self, SceneError, ViewpointFiles};
use fabkit_application::source::convert_press_error;
use numpy::{PyArray2, PyArrayDyn, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays;
use crate::camera::Camera;
use crate::design::Project;
use crate::errors::{Failure, OrRaise, exception};
use crate::keywords::Keywords;
use crate::running::{InterruptPolicy, run_on_thread, run_short};

/// Memory per ray of the arrays of ground truth, and of their copies in Python, bytes.
const ARRAYS_BYTES: u64 = 150;

/// Draws a map as a PNG image with a colour for each value and a scale.
#[pyfunction]
pub fn false_color<'py>(
    py: Python<'py>,
    map: PyReadonlyArray2<'py, f64>,
) -> PyResult<Bound<'py, PyBytes>> {
    let width_px = u32::try_from(map.shape()[1]).unwrap_or(u32::MAX);
    let values = map.as_slice()?;
    if values.is_empty() {
        let failure = Failure::call("a map without pixels has no image");
        return Err(exception(py, failure));
    }
    let bytes = run_short(py, || {
        let picture = false_color_image(width_px, values);
        png(picture.width_px, picture.height_px, &picture.rgb).map_err(Failure::bug)
    })?;
    Ok(PyBytes::new(py, &bytes.or_raise(py)?))
}

/// Camera at its pose, and the surface that it sees.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Scene {
    pub sensor: String,
    pub scene: Arc<scene::SensorView>,
}

#[pymethods]
impl Scene {
    /// Makes a scene. Camera and pose are the nominal ones, or read from files, or given: a camera, and the content of
    /// a pose file or a matrix with its covariance.
    #[new]
    #[pyo3(signature = (project, sensor, camera_file, pose_file, camera, pose_text, camera_from_sensor, covariance, unit))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments in Python")]
    fn new(
        py: Python<'_>,
        project: &Project,
        sensor: String,
        camera_file: Option<PathBuf>,
        pose_file: Option<PathBuf>,
        camera: Option<PyRef<'_, Camera>>,
        pose_text: Option<String>,
        camera_from_sensor: Option<[[f64; 4]; 4]>,
        covariance: Option<[[f64; 6]; 6]>,
        unit: Option<u64>,
    ) -> PyResult<Self> {
        let drawn = Arc::clone(&project.project);
        let (source, overrides) = (Arc::clone(&project.source), &project.overrides);
        let given_camera = camera.map(|camera| camera.estimate.clone());
        let scene = run_short(py, || {
            let project = match unit.map(Unit) {
                None => drawn,
                Some(unit) => Arc::new(source.load_unit(unit, overrides)?),
            };
            let bad = |error| SceneError::viewpoint(None, error);
            let mut files =
                ViewpointFiles::read(&project, camera_file.as_deref(), pose_file.as_deref())?;
            // What is given replaces the files' one by one; camera and pose may have different origins.
            if let Some(camera) = given_camera {
                files.camera = Some(camera.into());
            }
            let given = pose_text.map(|text| read_pose(&text)).transpose();
            if let Some(pose) = given.map_err(|error| bad(error.into()))? {
                files.pose = Some(pose);
            }
            if let Some(camera_from_sensor) = camera_from_sensor {
                files.pose = Some(PoseFile {
                    camera_from_sensor,
                    covariance: None,
                    joint: None,
                    camera: None,
                });
            }
            if let Some((pose, given)) = files.pose.as_mut().zip(covariance) {
                pose.covariance = Some(given);
                // A joint covariance would contradict the given one.
                pose.joint = None;
            }
            let nominal = &project.design.sensor.camera;
            let viewpoint =
                Viewpoint::from_files(nominal, files.camera.as_ref(), files.pose.as_ref())
                    .map_err(bad)?;
            scene::SensorView::new(project, viewpoint)
        })?;
        Ok(Self { sensor, scene: Arc::new(scene.or_raise(py)?) })
    }

    /// Returns the same view at another resolution.
    fn resized(&self, py: Python<'_>, width_px: u32, height_px: u32) -> PyResult<Self> {
        let view = Arc::clone(&self.scene);
        let scene = run_short(py, || {
            let viewpoint = view.viewpoint.resized([width_px, height_px]);
            let viewpoint = viewpoint.map_err(|error| SceneError::viewpoint(None, error))?;
            scene::SensorView::new(Arc::clone(&view.project), viewpoint)
        })?;
        let scene = Arc::new(scene.or_raise(py)?);
        Ok(Self { sensor: self.sensor.clone(), scene })
    }

    /// Unusual values of the camera file, each a sentence.
    fn warnings(&self) -> Vec<String> {
        self.scene.viewpoint.warnings().to_vec()
    }

    /// Description of the contributions to `sigma_mm`.
    fn sigma_of(&self) -> String {
        self.scene.viewpoint.sigma_contributions()
    }

    /// Names of the parameters whose variances `sigma_mm` includes.
    fn sigma_parameters(&self) -> Vec<&'static str> {
        self.scene.viewpoint.sigma_parameters()
    }

    fn camera(&self) -> Camera {
        let viewpoint = &self.scene.viewpoint;
        let estimate = viewpoint.estimate.camera_estimate();
        // Passed to another scene, the camera must give the same view: the drawn bodies refract its rays.
        let is_drawn = viewpoint.is_bare_lens();
        Camera { estimate: if is_drawn { estimate.with_drawn_interface() } else { estimate } }
    }

    fn sensor_from_camera<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::pose_array(py, &self.scene.viewpoint.sensor_from_camera)
    }

    /// Share of the surface that the camera sees, and the area of the whole surface, mm2.
    fn coverage(&self) -> (f64, f64) {
        (self.scene.coverage.area, self.scene.coverage.area_mm2)
    }

    /// Casts a press: the arrays of `fabkit depth -o FILE.npz` by name, and the solution of the soft layers, as JSON.
    /// Options are those of [`CastOptions`] and [`ContactOptions`], by name.
    fn cast<'py>(
        &self,
        py: Python<'py>,
        presses: Vec<String>,
        options: Bound<'py, PyDict>,
    ) -> PyResult<(Bound<'py, PyDict>, Option<String>)> {
        let contact = ContactOptions::from_named(&Keywords(&options))?;
        let options = CastOptions::from_named(&Keywords(&options))?;
        let (scene, sensor) = (Arc::clone(&self.scene), self.sensor.clone());
        let (seen, elastic) = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let presses = find_presses(&scene, &sensor, &presses)?;
            scene.cast(&options.cast(&presses, &contact)?, ARRAYS_BYTES, |seen| {
                let gap = seen.gap.as_ref();
                let elastic = seen.answer.map(|answer| {
                    press_simulation::visible_solution_document(answer, gap).to_string()
                });
                Ok((arrays(seen.map, seen.sigmas), elastic))
            })
        })?;
        Ok((arrays::dictionary(py, seen)?, elastic))
    }

    /// Simulates the capture of a press: intensities as `grey`, ground truth as the arrays of [`Scene::cast`], and the
    /// JSON of `fabkit capture --json`. Options are those of [`CaptureOptions`], by name.
    fn capture<'py>(
        &self,
        py: Python<'py>,
        presses: Vec<String>,
        options: Bound<'py, PyDict>,
    ) -> PyResult<(Bound<'py, PyDict>, String)> {
        let options = CaptureOptions::from_named(&Keywords(&options))?;
        let (scene, sensor) = (Arc::clone(&self.scene), self.sensor.clone());
        let (shown, document) = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let presses = find_presses(&scene, &sensor, &presses)?;
            let (lighting, constants) = select_lighting(
                &scene.project,
                options.light.as_deref(),
                options.constants.as_deref(),
            )?;
            let capturing = options.capturing(&presses, lighting, &constants)?;
            let mut shown = Vec::new();
            let captured = capturing.render(&scene, ARRAYS_BYTES, |seen| {
                shown = arrays(seen.map, seen.sigmas);
                Ok(())
            })?;
            let document = capturing::capture_document(
                &scene.project,
                &scene.viewpoint,
                &capturing,
                &captured,
            );
            let document = document.to_string();
            let [width, height] = captured.size_px.map(|px| px as usize);
            let mut shape = vec![height, width];
            if captured.channels > 1 {
                shape.push(captured.channels);
            }
            let name = "grey".to_owned();
            shown.push(NpyArray { name, shape, values: NpyValues::F64(captured.grey) });
            Ok::<_, Failure>((shown, document))
        })?;
        Ok((arrays::dictionary(py, shown)?, document))
    }
}

/// Finds presses by name.
fn find_presses(
    scene: &scene::SensorView,
    sensor: &str,
    presses: &[String],
) -> Result<Vec<Press>, Error> {
    let finder = scene.project.press_finder();
    let press = |id: &String| finder.press(id).map_err(|error| convert_press_error(sensor, error));
    presses.iter().map(press).collect()
}

/// Reconstructor of depth, see [`reconstructing::Reconstructor`].
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Reconstructor {
    known: Arc<reconstructing::Reconstructor>,
    force: bool,
}

#[pymethods]
impl Reconstructor {
    /// Makes a reconstructor from the image at rest, values from 0 to 1, rows x columns x channels; with the network of
    /// a file, if one is given. Unless forced, images and depth that are implausible are errors.
    #[new]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        light: Option<String>,
        constants: Option<PathBuf>,
        reference: PyReadonlyArray3<'_, f32>,
        network: Option<PathBuf>,
        force: bool,
    ) -> PyResult<Self> {
        let view = Arc::clone(&scene.scene);
        let reference = array_image(&reference);
        let known = run_on_thread(py, InterruptPolicy::Abandon, None, move |_| {
            let given = (Path::new("reference"), &reference);
            let (lighting, constants) =
                select_lighting(&view.project, light.as_deref(), constants.as_deref())?;
            let known = match network {
                Some(file) => {
                    let network = DepthNetwork::read(&file)?;
                    reconstructing::Reconstructor::with_network(&view, &network, lighting, given)?
                }
                None => reconstructing::Reconstructor::new(&view, lighting, &constants, given)?,
            };
            Ok::<_, Failure>(decide(known, force)?)
        })?;
        Ok(Self { known: Arc::new(known), force })
    }

    /// Reconstructs an image: depth, mm, contact, and its overall brightness relative to the image at rest.
    fn depth<'py>(
        &self,
        py: Python<'py>,
        picture: PyReadonlyArray3<'py, f32>,
    ) -> PyResult<(Map<'py, f32>, Map<'py, bool>, f32)> {
        let picture = array_image(&picture);
        let known = Arc::clone(&self.known);
        let force = self.force;
        let shown = run_short(py, move || {
            known.reconstruct(Path::new("picture"), picture).and_then(|shown| decide(shown, force))
        })?;
        let shown = shown.or_raise(py)?;
        let [width, height] = self.known.size_px();
        let shape = [height, width];
        let depth_mm = arrays::into_array(py, shown.depth_mm, &shape)?;
        Ok((depth_mm, arrays::into_array(py, shown.contact, &shape)?, shown.relative_brightness))
    }
}

/// Takes a value out with its findings, which are errors unless forced.
pub fn decide<T>(judged: Judged<T>, force: bool) -> Result<T, Error> {
    if force { Ok(judged.accept_anyway().0) } else { judged.accept() }
}

type Map<'py, T> = Bound<'py, PyArrayDyn<T>>;

/// Converts an array to an image.
pub fn array_image(picture: &PyReadonlyArray3<'_, f32>) -> CapturedImage {
    let &[height, width, channels] = picture.shape() else { unreachable!("three axes") };
    let values = picture.as_array().iter().copied().collect();
    CapturedImage { size_px: [width, height], channels, values }
}
