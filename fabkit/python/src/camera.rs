//! Cameras: vectorised, without copies of inputs or outputs.

use std::path::PathBuf;

use fabkit_application::camera::files::{self, CameraFormat};
use fabkit_application::camera::{self, CameraEstimate, Point2, Point3};
use fabkit_application::geometry::NominalCamera;
use fabkit_application::scene;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arrays::array_rows;
use crate::errors::{Failure, OrRaise, exception};
use crate::running::run_short;

/// Splits `FILE#NAME` into the path of a camera file and the name of one of its cameras.
#[pyfunction]
pub fn split_camera_path(path: PathBuf) -> (PathBuf, Option<String>) {
    scene::split_camera_path(&path)
}

/// Camera with its covariance.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Camera {
    pub estimate: CameraEstimate,
}

type Array2<'py> = Bound<'py, PyArray2<f64>>;
type Array3<'py> = Bound<'py, PyArray3<f64>>;

impl Camera {
    pub fn nominal(py: Python<'_>, nominal: &NominalCamera) -> PyResult<Self> {
        let NominalCamera { width_px, height_px, field_of_view, lens, .. } = *nominal;
        let terms = lens.projection.terms();
        let made =
            || camera::Camera::from_data_sheet(width_px, height_px, field_of_view.rad(), terms);
        let camera = run_short(py, made)?.map_err(Failure::call).or_raise(py)?;
        // Without an interface of its own: the drawn bodies refract its rays.
        Ok(Self { estimate: CameraEstimate::from(camera).with_drawn_interface() })
    }
}

#[pymethods]
impl Camera {
    /// See [`camera::Camera::equidistant`].
    #[staticmethod]
    fn equidistant(
        py: Python<'_>,
        width_px: u32,
        height_px: u32,
        field_of_view_rad: f64,
    ) -> PyResult<Self> {
        let made = || camera::Camera::equidistant(width_px, height_px, field_of_view_rad);
        let camera = run_short(py, made)?;
        let camera = camera.map_err(Failure::call).or_raise(py)?;
        Ok(Self { estimate: camera.into() })
    }

    /// Reads a camera file in any known notation; `name` selects one of several cameras. Returns what is unusual about
    /// it, too.
    #[staticmethod]
    fn from_text(
        py: Python<'_>,
        text: &str,
        file: &str,
        name: Option<&str>,
    ) -> PyResult<(Self, Vec<String>)> {
        let wrong = |error: files::InvalidCameraFile| {
            let faults = error.faults.iter().map(|fault| match file {
                "" => fault.to_string(),
                _ => format!("{file}: {fault}"),
            });
            let faults: Vec<String> = faults.collect();
            Failure::call(faults.join("\nerror: "))
        };
        let read = run_short(py, || files::read_file(text, name))?.map_err(wrong).or_raise(py)?;
        let warnings = read.warnings();
        Ok((Self { estimate: read.estimate }, warnings))
    }

    /// Returns the content of a camera file in a format.
    fn to_text(&self, py: Python<'_>, format: &str) -> PyResult<String> {
        let known = || CameraFormat::ALL.iter().map(|format| format.name());
        let Some(format) = CameraFormat::ALL.iter().find(|known| known.name() == format) else {
            let unknown = fabkit_application::UnknownName::new("camera format", format, known());
            return Err(exception(py, unknown));
        };
        let text = run_short(py, || files::write(&self.estimate, *format))?;
        let hint = Some("`fabkit` keeps everything".into());
        text.map_err(|error| Failure::Call { message: error.to_string(), hint }).or_raise(py)
    }

    /// Returns the lens alone; the drawn bodies refract its rays.
    fn behind_drawing(&self) -> Self {
        Self { estimate: self.estimate.clone().with_drawn_interface() }
    }

    /// Resizes the camera, see [`camera::Camera::resized`]; the covariance is dropped.
    fn resized(&self, py: Python<'_>, width_px: u32, height_px: u32) -> PyResult<Self> {
        let made = || self.estimate.camera().resized([width_px, height_px]);
        let camera = run_short(py, made)?.map_err(Failure::call).or_raise(py)?;
        Ok(Self { estimate: camera.into() })
    }

    /// Returns the same kind of camera with other parameters and no covariance.
    fn with_parameters(&self, py: Python<'_>, parameters: Vec<f64>) -> PyResult<Self> {
        let camera = run_short(py, || self.estimate.camera().with_parameters(&parameters))?;
        let camera = camera.map_err(Failure::call).or_raise(py)?;
        Ok(Self { estimate: camera.into() })
    }

    fn size_px(&self) -> (u32, u32) {
        let camera = self.estimate.camera();
        (camera.width_px(), camera.height_px())
    }

    fn lens(&self) -> &'static str {
        self.estimate.camera().lens().model_name()
    }

    fn interface(&self) -> &'static str {
        self.estimate.camera().interface().kind_name()
    }

    fn angle_limit_rad(&self) -> f64 {
        self.estimate.camera().angle_limit_rad()
    }

    fn parameters(&self) -> Vec<(&'static str, f64)> {
        self.estimate.camera().parameters()
    }

    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Option<Array2<'py>>> {
        let Some(covariance) = self.estimate.covariance() else { return Ok(None) };
        // The matrix is symmetric, so column-major equals row-major.
        let flat = PyArray1::from_slice(py, covariance.as_slice());
        flat.reshape([covariance.nrows(), covariance.ncols()]).map(Some)
    }

    fn project<'py>(
        &self,
        py: Python<'py>,
        points_in_camera: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Array2<'py>> {
        let points: Vec<[f64; 3]> = array_rows(py, "points", &points_in_camera)?;
        let camera = self.estimate.camera();
        let pixels: Vec<[f64; 2]> = run_short(py, || {
            let pixel = |point: &[f64; 3]| match camera.project(&Point3::from(*point)) {
                Ok(pixel) => [pixel.x, pixel.y],
                Err(_) => [f64::NAN; 2],
            };
            points.iter().map(pixel).collect()
        })?;
        PyArray1::from_vec(py, pixels.into_flattened()).reshape([points.len(), 2])
    }

    /// Projects points: pixels, (n, 2); derivatives by the point, (n, 2, 3), and by the parameters, (n, 2, p).
    fn project_with_jacobians<'py>(
        &self,
        py: Python<'py>,
        points_in_camera: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<(Array2<'py>, Array3<'py>, Array3<'py>)> {
        let points: Vec<[f64; 3]> = array_rows(py, "points", &points_in_camera)?;
        let camera = self.estimate.camera();
        let (count, parameters) = (points.len(), camera.parameter_count());
        let (pixels, by_point, by_parameters) = run_short(py, || {
            let mut pixels = Vec::with_capacity(2 * count);
            let mut by_point = Vec::with_capacity(6 * count);
            let mut by_parameters = Vec::with_capacity(2 * parameters * count);
            for point in &points {
                let Ok(projection) = camera.project_with_jacobians(&Point3::from(*point)) else {
                    pixels.extend([f64::NAN; 2]);
                    by_point.extend([f64::NAN; 6]);
                    by_parameters.extend(std::iter::repeat_n(f64::NAN, 2 * parameters));
                    continue;
                };
                pixels.extend([projection.pixel.x, projection.pixel.y]);
                by_point.extend(
                    projection.by_point.row_iter().flat_map(|row| [row[0], row[1], row[2]]),
                );
                by_parameters.extend(projection.by_parameters.iter().map(|column| column.x));
                by_parameters.extend(projection.by_parameters.iter().map(|column| column.y));
            }
            (pixels, by_point, by_parameters)
        })?;
        Ok((
            PyArray1::from_vec(py, pixels).reshape([count, 2])?,
            PyArray1::from_vec(py, by_point).reshape([count, 2, 3])?,
            PyArray1::from_vec(py, by_parameters).reshape([count, 2, parameters])?,
        ))
    }

    /// Computes rays of pixels: origins and unit directions, (n, 3) each.
    fn unproject<'py>(
        &self,
        py: Python<'py>,
        pixels: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<(Array2<'py>, Array2<'py>)> {
        let pixels: Vec<[f64; 2]> = array_rows(py, "pixels", &pixels)?;
        let camera = self.estimate.camera();
        let (origins, directions): (Vec<[f64; 3]>, Vec<[f64; 3]>) = run_short(py, || {
            let ray = |pixel: &[f64; 2]| match camera.unproject(&Point2::from(*pixel)) {
                Ok(ray) => (ray.origin_in_camera.into(), ray.direction.into()),
                Err(_) => ([f64::NAN; 3], [f64::NAN; 3]),
            };
            pixels.iter().map(ray).unzip()
        })?;
        let shape = [pixels.len(), 3];
        Ok((
            PyArray1::from_vec(py, origins.into_flattened()).reshape(shape)?,
            PyArray1::from_vec(py, directions.into_flattened()).reshape(shape)?,
        ))
    }
}
