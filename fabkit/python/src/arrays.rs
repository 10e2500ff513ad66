//! Conversion between numpy arrays and the libraries' types.

use fabkit_application::export::{NpyArray, NpyValues};
use fabkit_application::geometry::Pose;
use numpy::{Element, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{Failure, exception};

/// Converts a pose to a (4, 4) array whose last row is 0 0 0 1.
pub fn pose_array<'py>(py: Python<'py>, pose: &Pose) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (rotation, translation) = (pose.rotation(), pose.translation_mm());
    let entry = |r: usize, c: usize| match (r, c) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (_, 3) => translation[r],
        _ => rotation[(r, c)],
    };
    PyArray1::from_iter(py, (0..16).map(|i| entry(i / 4, i % 4))).reshape([4, 4])
}

/// Moves values into an array of the given shape.
pub fn into_array<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape)
}

/// Moves arrays into a dictionary by name; texts become lists.
pub fn dictionary<'py>(py: Python<'py>, arrays: Vec<NpyArray>) -> PyResult<Bound<'py, PyDict>> {
    let dictionary = PyDict::new(py);
    for NpyArray { name, shape, values } in arrays {
        match values {
            NpyValues::F64(values) => dictionary.set_item(name, into_array(py, values, &shape)?)?,
            NpyValues::F32(values) => dictionary.set_item(name, into_array(py, values, &shape)?)?,
            NpyValues::U8(values) => dictionary.set_item(name, into_array(py, values, &shape)?)?,
            NpyValues::U16(values) => dictionary.set_item(name, into_array(py, values, &shape)?)?,
            NpyValues::Bool(values) => {
                dictionary.set_item(name, into_array(py, values, &shape)?)?
            }
            NpyValues::Text(values) => dictionary.set_item(name, values)?,
        }
    }
    Ok(dictionary)
}

/// Returns the rows of an (n, N) array.
///
/// # Errors
/// Another number of columns, or an array that is not in C order; the Python side ensures the order.
pub fn array_rows<const N: usize>(
    py: Python<'_>,
    name: &str,
    array: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<[f64; N]>> {
    let (rows, remainder) = array.as_slice()?.as_chunks::<N>();
    if array.as_array().ncols() != N || !remainder.is_empty() {
        let message = format!("{name} has {} columns; it must have {N}", array.as_array().ncols());
        return Err(exception(py, Failure::call(message)));
    }
    Ok(rows.to_vec())
}
