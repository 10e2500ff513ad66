//! What is known of a mesh: volumes and angles.

use nalgebra::Vector3;

use crate::mesh::Tetrahedra;

/// What a mesh is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Of each layer, mm3.
    pub volume_mm3: Vec<f64>,
    /// Of any tetrahedron; positive if none is inverted, mm3.
    pub least_volume_mm3: f64,
    /// The smallest angle between two faces of a tetrahedron, degrees.
    pub least_dihedral_deg: f64,
    /// The largest one, degrees.
    pub most_dihedral_deg: f64,
}

impl Tetrahedra {
    /// Measures all tetrahedra.
    pub fn quality(&self) -> Quality {
        let mut quality = Quality {
            volume_mm3: vec![0.0; self.layers.len()],
            least_volume_mm3: f64::INFINITY,
            least_dihedral_deg: 180.0,
            most_dihedral_deg: 0.0,
        };
        for (cell, layer) in self.cells.iter().zip(&self.layer_of) {
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

/// Positive if the fourth corner lies where the first three run counter-clockwise.
pub(crate) fn volume_mm3([a, b, c, d]: &[Vector3<f64>; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// At each of the six edges.
fn dihedrals_deg(corners: &[Vector3<f64>; 4]) -> [f64; 6] {
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
