//! Columns of prisms below triangles, each prism divided into three tetrahedra.

use crate::mesh::Face;

/// Numbering of the nodes: level by level, each with as many nodes as the surface.
pub(crate) struct Levels {
    /// Number of nodes of the surface.
    pub per_level: u32,
}

impl Levels {
    /// Returns the node at a level below a node of the surface.
    pub fn node(&self, of_surface: u32, level: usize) -> u32 {
        of_surface + level as u32 * self.per_level
    }

    /// Divides the prism below a triangle between two levels. The diagonal of each side runs from the upper corner with
    /// the lower number to the lower corner with the higher number, so that both neighbours use the same one.
    pub fn prism(&self, face: Face, level: usize) -> [[u32; 4]; 3] {
        let mut corners = face;
        corners.sort_unstable();
        let [i, j, k] = corners;
        let above = |node: u32| self.node(node, level);
        let below = |node: u32| self.node(node, level + 1);
        [
            [above(i), below(i), below(j), below(k)],
            [above(i), above(j), below(j), below(k)],
            [above(i), above(j), above(k), below(k)],
        ]
    }

    /// Divides the side below an edge between two levels, with the same diagonal.
    pub fn side(&self, from: u32, to: u32, level: usize) -> [Face; 2] {
        let (i, j) = (from.min(to), from.max(to));
        let (above_i, above_j) = (self.node(i, level), self.node(j, level));
        let (below_i, below_j) = (self.node(i, level + 1), self.node(j, level + 1));
        [[above_i, below_i, below_j], [above_i, above_j, below_j]]
    }
}
