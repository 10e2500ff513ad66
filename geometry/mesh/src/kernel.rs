//! Interface to the boolean kernel, manifold-rust. Other modules use only its polygon triangulator
//! (`tessellate/extruded.rs`, `conform/fill.rs`).

use manifold_rust::boolean3;
use manifold_rust::impl_mesh::ManifoldImpl;
use manifold_rust::linalg::{Mat3x4, Vec3};
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{Error, MeshGLP, OpType};

use fabkit_geometry::{Aabb, Point3, Pose};

use crate::MeshError;
use crate::facets::Facets;

/// Distance below which vertices created by a boolean are merged, mm.
///
/// It is far below any chord tolerance and above the spacing of `f32` values at the size of parts, so that few slivers
/// reach the file.
const MERGE_MM: f64 = 1e-5;

/// Computes the convex hull of points.
pub(crate) fn hull(points: &[[f64; 3]]) -> Result<Facets, MeshError> {
    let points: Vec<Vec3> = points.iter().map(|p| Vec3::new(p[0], p[1], p[2])).collect();
    let hull = checked(Manifold::hull(&points).into_impl(), "the hull of points")?;
    Ok(hull.to_facets())
}

/// Boolean operation on two solids.
pub(crate) use manifold_rust::types::OpType as Operation;

/// Mesh prepared for booleans.
#[derive(Clone)]
pub(crate) struct Prepared(ManifoldImpl);

impl Prepared {
    pub fn from_facets(facets: &Facets) -> Result<Self, MeshError> {
        let mesh = MeshGLP::<f64, u32> {
            num_prop: 3,
            vert_properties: facets.vertices.as_flattened().to_vec(),
            tri_verts: facets.triangles.as_flattened().to_vec(),
            face_id: facets.faces.clone(),
            ..MeshGLP::default()
        };
        let mut prepared = checked(Manifold::from_mesh_glp(&mesh).into_impl(), "preparing")?;
        prepared.0.tolerance = prepared.0.tolerance.max(MERGE_MM);
        Ok(prepared)
    }

    pub fn to_facets(&self) -> Facets {
        let imp = &self.0;
        let vertices = imp.vert_pos.iter().map(|v| [v.x, v.y, v.z]).collect();
        let corners = imp.halfedge.chunks_exact(3);
        let triangles = corners.map(|t| [0, 1, 2].map(|i| t[i].start_vert as u32)).collect();
        let faces = imp.mesh_relation.tri_ref.iter().map(|r| r.face_id as u32).collect();
        Facets { vertices, triangles, faces }
    }

    /// Returns a moved copy whose face numbers start at `first_face`.
    pub fn placed(&self, pose: &Pose, first_face: u32) -> Self {
        let column = |c: [f64; 3]| Vec3::new(c[0], c[1], c[2]);
        let rotation = |i: usize| column(pose.rotation().column(i).into_owned().into());
        let shift = column((*pose.translation_mm()).into());
        let matrix = Mat3x4::from_cols(rotation(0), rotation(1), rotation(2), shift);
        let mut imp = self.0.transform(&matrix);
        for reference in &mut imp.mesh_relation.tri_ref {
            reference.face_id += first_face as i32;
        }
        Self(imp)
    }

    pub fn bounds(&self) -> Aabb {
        if self.0.is_empty() {
            return Aabb::nothing();
        }
        let corner = |v: Vec3| Point3::new(v.x, v.y, v.z);
        Aabb { min: corner(self.0.bbox.min), max: corner(self.0.bbox.max) }
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn combine(&self, other: &Self, operation: Operation) -> Result<Self, MeshError> {
        let name = match operation {
            OpType::Add => "uniting",
            OpType::Subtract => "cutting",
            OpType::Intersect => "intersecting",
        };
        checked(boolean3::boolean(&self.0, &other.0, operation), name)
    }
}

fn checked(imp: ManifoldImpl, operation: &'static str) -> Result<Prepared, MeshError> {
    match imp.status {
        Error::NoError => Ok(Prepared(imp)),
        error => Err(MeshError::Kernel { operation, reason: error.to_str() }),
    }
}
