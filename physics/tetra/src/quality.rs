//! Quality of a mesh: volumes and angles.

use nalgebra::Vector3;

use crate::mesh::Tetrahedra;

/// Measured quality of a mesh.
///
/// ```
/// use fabkit_tetra::{MeshLayer, Tetrahedra};
///
/// // One corner of a cube of 1 mm: a sixth of its volume, and three right angles where its edges meet.
/// let gel = MeshLayer { name: "gel".into(), material: "".into(), young_mpa: 0.2, poissons_ratio: 0.49 };
/// let corner = Tetrahedra {
///     points_mm: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     cells: vec![[0, 1, 2, 3]],
///     cell_layers: vec![0],
///     layers: vec![gel],
/// #   touched_faces: vec![], bonded_faces: vec![], edge_mm: 1.0, simplifications: vec![],
/// };
/// let quality = corner.quality();
/// assert!((quality.volume_mm3[0] - 1.0 / 6.0).abs() < 1e-12);
/// assert!((quality.most_dihedral_deg - 90.0).abs() < 1e-9);
/// assert!((quality.least_dihedral_deg - 2_f64.sqrt().atan().to_degrees()).abs() < 1e-9);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Volume of each layer, mm3.
    pub volume_mm3: Vec<f64>,
    /// Smallest volume of a tetrahedron, mm3; positive if none is inverted.
    pub least_volume_mm3: f64,
    /// Smallest angle between two faces of a tetrahedron, degrees.
    pub least_dihedral_deg: f64,
    /// Largest angle between two faces of a tetrahedron, degrees.
    pub most_dihedral_deg: f64,
}

impl Tetrahedra {
    /// Measures volumes and angles of all tetrahedra.
    pub fn quality(&self) -> Quality {
        let mut quality = Quality {
            volume_mm3: vec![0.0; self.layers.len()],
            least_volume_mm3: f64::INFINITY,
            least_dihedral_deg: 180.0,
            most_dihedral_deg: 0.0,
        };
        for (cell, layer) in self.cells.iter().zip(&self.cell_layers) {
            let corners = cell.map(|node| Vector3::from(self.points_mm[node as usize]));
            let volume_mm3 = volume_mm3(&corners);
            quality.volume_mm3[*layer as usize] += volume_mm3;
            quality.least_volume_mm3 = quality.least_volume_mm3.min(volume_mm3);
            for deg in dihedrals_deg(&corners) {
                quality.least_dihedral_deg = quality.least_dihedral_deg.min(deg);
                quality.most_dihedral_deg = quality.most_dihedral_deg.max(deg);
            }
        }
        quality
    }
}

/// Computes the signed volume of a tetrahedron, mm3: positive if the first three corners run counter-clockwise seen
/// from the fourth.
pub(crate) fn volume_mm3([a, b, c, d]: &[Vector3<f64>; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// Computes the dihedral angles at the six edges, degrees.
fn dihedrals_deg(corners: &[Vector3<f64>; 4]) -> [f64; 6] {
    // Both corners of an edge, and the two others.
    const EDGES: [[usize; 4]; 6] =
        [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];
    EDGES.map(|[i, j, k, l]| {
        let along = (corners[j] - corners[i]).normalize();
        let across = |m: usize| {
            let to = corners[m] - corners[i];
            to - to.dot(&along) * along
        };
        let (a, b) = (across(k), across(l));
        a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
    })
}
