//! Triangle meshes with the faces that the triangles belong to.

use fabkit_geometry::Pose;

use crate::facets;

/// Face of a primitive that a triangle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FaceId {
    /// Index into [`Solid::leaves`](fabkit_geometry::Solid::leaves).
    pub leaf: u32,
    /// Face number within the primitive, as the primitive documents.
    pub face: u32,
}

/// Closed, oriented triangle mesh, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct TriMesh {
    /// Vertex positions, mm.
    pub vertices: Vec<[f64; 3]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Faces, one per triangle.
    pub faces: Vec<FaceId>,
}

impl TriMesh {
    /// Returns the mesh after a rigid motion.
    #[must_use]
    pub fn placed(&self, pose: &Pose) -> Self {
        let vertices = self.vertices.iter().map(|&v| facets::transform_point(pose, v)).collect();
        Self { vertices, triangles: self.triangles.clone(), faces: self.faces.clone() }
    }

    /// Returns the mesh scaled about the origin by a factor above 0; its deviation from the surface scales with it.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let vertices = self.vertices.iter().map(|v| v.map(|x| x * factor)).collect();
        Self { vertices, triangles: self.triangles.clone(), faces: self.faces.clone() }
    }

    /// Returns the mesh stretched along x, y and z about the origin by factors above 0; its deviation from the surface
    /// grows by at most the largest factor.
    #[must_use]
    pub fn stretched(&self, factors: [f64; 3]) -> Self {
        let stretch = |v: &[f64; 3]| std::array::from_fn(|i| v[i] * factors[i]);
        let vertices = self.vertices.iter().map(stretch).collect();
        Self { vertices, triangles: self.triangles.clone(), faces: self.faces.clone() }
    }
}
