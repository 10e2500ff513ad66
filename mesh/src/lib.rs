//! Solids to triangles.
//!
//! [`mesh`] gives a [`TriMesh`] whose vertices on curved faces lie on the exact surface and whose
//! triangles are nowhere farther from it than the chord tolerance. [`PrintMesh`] is what files are
//! written from: rounded to `f32`, welded, and proven closed and oriented *after* that.
//!
//! This crate is the only one that knows the boolean kernel.

use fabkit_geometry::{Aabb, Pose, Solid};

/// Chord tolerance where nobody asks for another, mm.
pub const DEFAULT_TOLERANCE_MM: f64 = 0.01;

/// Which face of which primitive a triangle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FaceId {
    /// Index into [`Solid::leaves`].
    pub leaf: u32,
    /// Face number within the primitive, as the primitive documents.
    pub face: u32,
}

/// A closed, oriented triangle mesh, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct TriMesh {
    /// Vertex positions, mm.
    pub vertices: Vec<[f64; 3]>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One per triangle.
    pub faces: Vec<FaceId>,
}

/// A mesh as files hold it: `f32`, welded, checked. Only [`TriMesh::to_print`] makes one.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintMesh {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    faces: Vec<FaceId>,
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// The tree is not a solid.
    #[error(transparent)]
    Invalid(#[from] fabkit_geometry::InvalidSolid),
    /// To be completed.
    #[error("{0}")]
    Defect(String),
}

/// Meshes a solid.
///
/// # Errors
/// See [`MeshError`].
pub fn mesh(_solid: &Solid, _tolerance_mm: f64) -> Result<TriMesh, MeshError> {
    todo!()
}

impl TriMesh {
    /// The same mesh moved rigidly.
    #[must_use]
    pub fn placed(&self, _pose: &Pose) -> Self {
        todo!()
    }

    /// Rounds to `f32`, welds, removes what became degenerate, and proves the result closed,
    /// oriented and free of degenerate triangles.
    ///
    /// # Errors
    /// What could not be repaired.
    pub fn to_print(&self) -> Result<PrintMesh, MeshError> {
        todo!()
    }

    /// Enclosed volume, mm^3.
    pub fn volume_mm3(&self) -> f64 {
        todo!()
    }

    /// Surface area, mm^2.
    pub fn area_mm2(&self) -> f64 {
        todo!()
    }

    /// Through holes and handles, summed over connected shells: 1 - (V - E + F) / 2 per shell.
    pub fn genus(&self) -> i32 {
        todo!()
    }

    /// Smallest box, mm.
    pub fn bounds(&self) -> Aabb {
        todo!()
    }
}

impl PrintMesh {
    /// Vertex positions, mm.
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// Counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// One per triangle.
    pub fn faces(&self) -> &[FaceId] {
        &self.faces
    }
}
