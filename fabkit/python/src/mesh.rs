//! Triangle meshes.

use fabkit_application::export;
use fabkit_application::mesh::{FaceId, TriMesh};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{Failure, OrRaise};
use crate::running::run_short;

/// Closed mesh in the frame of its part, mm. Its arrays belong to numpy: moved there, not copied.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Mesh {
    name: String,
    vertices: Py<PyArray2<f64>>,
    triangles: Py<PyArray2<u32>>,
    faces: Vec<FaceId>,
    #[pyo3(get)]
    volume_mm3: f64,
    #[pyo3(get)]
    area_mm2: f64,
    #[pyo3(get)]
    genus: i32,
}

impl Mesh {
    pub fn new(py: Python<'_>, name: String, mesh: TriMesh) -> PyResult<Self> {
        let (volume_mm3, area_mm2, genus) = (mesh.volume_mm3(), mesh.area_mm2(), mesh.genus());
        let TriMesh { vertices, triangles, faces } = mesh;
        let shapes = [[vertices.len(), 3], [triangles.len(), 3]];
        let vertices = PyArray1::from_vec(py, vertices.into_flattened()).reshape(shapes[0])?;
        let triangles = PyArray1::from_vec(py, triangles.into_flattened()).reshape(shapes[1])?;
        let (vertices, triangles) = (vertices.unbind(), triangles.unbind());
        Ok(Self { name, vertices, triangles, faces, volume_mm3, area_mm2, genus })
    }
}

#[pymethods]
impl Mesh {
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.vertices.bind(py).clone()
    }

    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        self.triangles.bind(py).clone()
    }

    /// For each triangle, the index of the primitive of the part on which it lies.
    fn leaves<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_iter(py, self.faces.iter().map(|face| face.leaf))
    }

    /// Encodes the mesh as binary STL, in the frame of the part.
    fn stl<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        // The arrays belong to numpy and may have been changed there, so they are read back.
        let rows = |flat: Vec<f64>| flat.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
        let vertices = rows(self.vertices.bind(py).readonly().as_slice()?.to_vec());
        let triangles = self.triangles.bind(py).readonly();
        let triangles = triangles.as_slice()?.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        let mesh = TriMesh { vertices, triangles, faces: self.faces.clone() };
        let bytes = run_short(py, || {
            let print = mesh.to_print().map_err(Failure::bug)?;
            export::stl(&self.name, &print).map_err(Failure::bug)
        })?;
        Ok(PyBytes::new(py, &bytes.or_raise(py)?))
    }
}
