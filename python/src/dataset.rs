//! Writing data sets, and reading them sample by sample.

use std::path::PathBuf;
use std::sync::Arc;

use fabkit::commands::dataset::{self as order, Order};
use fabkit::dataset::{ReadError, SampleArray, Written, write};
use fabkit::export::Element;
use fabkit::failure::{Exit, Failure};
use fabkit::scene::{MARGIN_LIMITS_MM, MEMBRANE_LIMITS_MM, within};
use pyo3::prelude::*;

use crate::arrays::shaped;
use crate::errors::OrRaise;
use crate::running::{Interrupted, run};
use crate::scene::Scene;

/// Writes a data set; the halves of it that press nothing that the camera sees.
#[pyfunction]
#[pyo3(signature = (scene, folder, presses, captures, membrane_mm, seam_margin_mm, seed, materialise, resume, progress))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments in Python")]
pub fn write_dataset(
    py: Python<'_>,
    scene: &Scene,
    folder: PathBuf,
    presses: Option<PathBuf>,
    captures: Option<PathBuf>,
    membrane_mm: f64,
    seam_margin_mm: f64,
    seed: u64,
    materialise: bool,
    resume: bool,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Vec<String>> {
    let (scene, sensor) = (Arc::clone(&scene.scene), scene.sensor.clone());
    let written: Written = run(py, Interrupted::Wait, progress, move |link| {
        within("membrane_mm", membrane_mm, MEMBRANE_LIMITS_MM)?;
        within("seam_margin_mm", seam_margin_mm, MARGIN_LIMITS_MM)?;
        let (presses, captures) = (presses.as_deref(), captures.as_deref());
        let order =
            Order { presses, captures, membrane_mm, seam_margin_mm, seed, materialise, resume };
        order::prepare(&scene, &sensor, &order, |job| {
            let show = |done, _, all| link.show(done, all);
            write(&folder, job, &show, &|| link.is_cancelled()).map_err(order::failure)
        })
    })?;
    Ok(written.untouched)
}

/// An array whose first axis counts samples.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Samples {
    array: SampleArray,
}

#[pymethods]
impl Samples {
    #[new]
    fn new(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let array = py.detach(|| SampleArray::open(&folder)).map_err(failure).or_raise(py)?;
        Ok(Self { array })
    }

    fn shape(&self) -> Vec<usize> {
        self.array.shape().to_vec()
    }

    fn dtype(&self) -> &'static str {
        match self.array.element() {
            Element::F32 => "float32",
            Element::U16 => "uint16",
            Element::U8 => "uint8",
        }
    }

    fn sample<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyAny>> {
        let bytes = py.detach(|| self.array.sample(index)).map_err(failure).or_raise(py)?;
        let shape = &self.array.shape()[1..];
        Ok(match self.array.element() {
            Element::U8 => shaped(py, bytes, shape)?.into_any(),
            Element::U16 => {
                let values = bytes.as_chunks().0.iter().map(|value| u16::from_le_bytes(*value));
                shaped(py, values.collect(), shape)?.into_any()
            }
            Element::F32 => {
                let values = bytes.as_chunks().0.iter().map(|value| f32::from_le_bytes(*value));
                shaped(py, values.collect(), shape)?.into_any()
            }
        })
    }
}

fn failure(error: ReadError) -> Failure {
    match error {
        ReadError::Io { .. } => Failure::plain(Exit::Io, error),
        ReadError::Damaged { .. } => {
            Failure::new(Exit::Io, error, "delete that file and run `fabkit dataset --resume`")
        }
        ReadError::Foreign { .. } => {
            Failure::new(Exit::BadInput, error, "read it with the Python package `zarr`")
        }
        ReadError::OutOfRange { .. } => Failure::plain(Exit::BadInput, error),
    }
}
