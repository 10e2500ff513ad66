//! Meshes in the form that files contain.
//!
//! Files for printers contain 32-bit coordinates, and readers weld vertices with equal ones. A mesh that is valid in 64
//! bits may not be valid after that: vertices coincide, slivers become lines. So the rounding happens here, where
//! defects can be repaired, and the result is proven valid.

mod halfedges;
mod measure;
mod repair;
mod verify;

use crate::{FaceId, TriMesh};
use halfedges::Halfedges;

/// Mesh in the form that files contain: `f32`, welded, checked. Only [`TriMesh::to_print`] creates it.
///
/// No two vertices are equal; every edge has exactly two triangles, in opposite directions; the triangles around a
/// vertex form one fan; none has area 0; the volume is positive; the genus is that of the original mesh; and no vertex
/// is farther from its original position than [`PrintMesh::MAX_DISPLACEMENT_ULPS`] spacings of `f32` values at the
/// mesh's largest coordinate.
///
/// ```
/// use fabkit_geometry::Solid;
/// let thin = Solid::cuboid(0.2, 0.2, 0.1);
/// let file = fabkit_mesh::mesh(&thin, 0.01)?.to_print()?;
/// // 0.1 is no number of 32 bits; the nearest one is written.
/// assert_eq!(file.vertices().iter().map(|v| v[2]).fold(0.0, f32::max), 0.1f32);
/// assert_eq!((file.vertices().len(), file.triangles().len(), file.faces().len()), (8, 12, 12));
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PrintMesh {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    faces: Vec<FaceId>,
}

/// Defect that prevents a mesh from being written.
///
/// ```
/// use fabkit_geometry::Solid;
/// use fabkit_mesh::{MeshError, mesh};
/// let mut open = mesh(&Solid::cuboid(2.0, 2.0, 2.0), 0.1)?;
/// open.triangles.pop();
/// open.faces.pop();
/// let MeshError::Print(defect) = open.to_print().unwrap_err() else { panic!("it has a hole") };
/// assert!(defect.at_mm.iter().all(|x_mm| x_mm.abs() <= 2.0)); // where the hole is
/// # Ok::<(), MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("after rounding to 32 bits, {problem} at ({:.4}, {:.4}, {:.4}) mm", at_mm[0], at_mm[1], at_mm[2])]
pub struct PrintDefect {
    /// Description of the defect.
    pub problem: &'static str,
    /// Position, mm.
    pub at_mm: [f64; 3],
}

impl PrintMesh {
    /// Largest displacement of a vertex by rounding and repair, in spacings of `f32` values at the largest coordinate:
    /// 0.1 micrometres for a part that reaches 30 mm.
    pub const MAX_DISPLACEMENT_ULPS: f64 = 64.0;

    /// Returns the vertex positions, mm.
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// Returns the triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Returns the faces, one per triangle.
    pub fn faces(&self) -> &[FaceId] {
        &self.faces
    }
}

/// Computes the spacing of `f32` values at the largest coordinate, mm.
fn ulp_mm(vertices: &[[f64; 3]]) -> f64 {
    let largest = vertices.as_flattened().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let above = (largest as f32).max(f32::MIN_POSITIVE);
    // The spacing above the value, which is never smaller than the one below.
    f64::from(above.next_up()) - f64::from(above)
}

pub(crate) fn to_print(mesh: &TriMesh) -> Result<PrintMesh, PrintDefect> {
    let ulp_mm = ulp_mm(&mesh.vertices);
    let mut edges = Halfedges::new(mesh)?;
    let moved_to = repair::repair(&mut edges, ulp_mm);
    let print = compact(&edges, &mesh.faces);
    verify::check_displacement(
        &mesh.vertices,
        &edges.positions,
        &moved_to,
        PrintMesh::MAX_DISPLACEMENT_ULPS * ulp_mm,
    )?;
    verify::check_validity(&print, mesh)?;
    Ok(print)
}

/// Removes unused vertices and removed triangles.
fn compact(edges: &Halfedges, faces: &[FaceId]) -> PrintMesh {
    const UNUSED: u32 = u32::MAX;
    let mut new_index = vec![UNUSED; edges.positions.len()];
    for v in edges.alive().flat_map(|t| edges.triangle(t)) {
        new_index[v as usize] = 0;
    }
    let mut vertices = Vec::with_capacity(edges.positions.len());
    for (position, index) in edges.positions.iter().zip(&mut new_index) {
        if *index != UNUSED {
            *index = vertices.len() as u32;
            vertices.push(position.map(|c| c as f32));
        }
    }
    let renumbered = |t: usize| edges.triangle(t).map(|v| new_index[v as usize]);
    PrintMesh {
        vertices,
        triangles: edges.alive().map(renumbered).collect(),
        faces: edges.alive().map(|t| faces[t]).collect(),
    }
}
