//! Triangle meshes.

use std::sync::Arc;

use fabkit::export;
use fabkit::failure::Failure;
use fabkit::mesh::TriMesh;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::OrRaise;

/// A closed mesh in the frame of its part, mm.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Mesh {
    pub name: String,
    pub mesh: Arc<TriMesh>,
}

#[pymethods]
impl Mesh {
    /// (n, 3) float64, mm.
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let flat = PyArray1::from_slice(py, self.mesh.vertices.as_flattened());
        flat.reshape([self.mesh.vertices.len(), 3])
    }

    /// (m, 3) uint32.
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let flat = PyArray1::from_slice(py, self.mesh.triangles.as_flattened());
        flat.reshape([self.mesh.triangles.len(), 3])
    }

    fn volume_mm3(&self) -> f64 {
        self.mesh.volume_mm3()
    }

    fn area_mm2(&self) -> f64 {
        self.mesh.area_mm2()
    }

    fn genus(&self) -> i32 {
        self.mesh.genus()
    }

    /// A binary STL file, in the frame of the part.
    fn stl<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| {
            let print = self.mesh.to_print().map_err(Failure::bug)?;
            export::stl(&self.name, &print).map_err(Failure::bug)
        });
        Ok(PyBytes::new(py, &bytes.or_raise(py)?))
    }
}
