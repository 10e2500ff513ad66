//! Volume, area, genus, shells and bounds of meshes in file form.

use fabkit_geometry::{Aabb, Solid};

use super::PrintMesh;
use crate::Shell;
use crate::facets::bounds_of;
use crate::measure::{area_mm2, feature_of, genus, shells, volume_mm3};

impl PrintMesh {
    /// Computes the enclosed volume, mm^3, of the rounded vertices.
    pub fn volume_mm3(&self) -> f64 {
        volume_mm3(&self.vertices_f64(), self.triangles())
    }

    /// Computes the surface area, mm^2.
    pub fn area_mm2(&self) -> f64 {
        area_mm2(&self.vertices_f64(), self.triangles())
    }

    /// Computes the genus, see [`TriMesh::genus`](crate::TriMesh::genus).
    pub fn genus(&self) -> i32 {
        genus(self.vertices().len(), self.triangles())
    }

    /// Returns the closed surfaces that it consists of, in the order of their first triangles.
    pub fn shells(&self) -> Vec<Shell> {
        shells(&self.vertices_f64(), self.triangles())
    }

    /// Returns the bounding box, mm.
    pub fn bounds(&self) -> Aabb {
        bounds_of(&self.vertices_f64())
    }

    /// Returns the feature name of a triangle, see [`TriMesh::feature`](crate::TriMesh::feature).
    pub fn feature<'a>(&self, triangle: usize, solid: &'a Solid) -> &'a str {
        feature_of(self.faces().get(triangle), solid)
    }

    fn vertices_f64(&self) -> Vec<[f64; 3]> {
        self.vertices().iter().map(|v| v.map(f64::from)).collect()
    }
}
