//! Reading data sets, sample by sample.

use std::path::PathBuf;

use fabkit::dataset::{ReadError, SampleArray};
use fabkit::export::Element;
use fabkit::failure::{Exit, Failure};
use pyo3::prelude::*;

use crate::arrays::shaped;
use crate::errors::OrRaise;

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
