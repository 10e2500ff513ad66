//! Mesh adjacency, updated while edges collapse and flip.

use super::PrintDefect;
use crate::TriMesh;
use crate::halfedges::{next, previous, twins};

/// Marker in the corners of a removed triangle.
const GONE: u32 = u32::MAX;

/// Triangles and, for each of their edges, the twin edge of the neighbour.
///
/// Edge `3 t + i` of triangle `t` runs from its corner `i` to corner `i + 1`.
pub(super) struct Halfedges {
    /// Vertex positions, rounded to `f32` values, mm.
    pub positions: Vec<[f64; 3]>,
    corners: Vec<u32>,
    twins: Vec<u32>,
}

impl Halfedges {
    /// Rounds the positions and finds neighbours.
    pub fn new(mesh: &TriMesh) -> Result<Self, PrintDefect> {
        let round = |v: &[f64; 3]| v.map(|c| f64::from(c as f32));
        let positions: Vec<_> = mesh.vertices.iter().map(round).collect();
        let corners = mesh.triangles.as_flattened().to_vec();
        let twins = twins(positions.len(), &corners).map_err(|edge| PrintDefect {
            problem: "an edge does not have two triangles in opposite directions",
            at_mm: mesh.vertices[corners[edge] as usize],
        })?;
        Ok(Self { positions, corners, twins })
    }

    /// Returns the triangles that have not been removed.
    pub fn alive(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.corners.len() / 3).filter(|&t| self.is_alive(t))
    }

    pub fn is_alive(&self, triangle: usize) -> bool {
        self.corners[3 * triangle] != GONE
    }

    pub fn triangle(&self, t: usize) -> [u32; 3] {
        [self.corners[3 * t], self.corners[3 * t + 1], self.corners[3 * t + 2]]
    }

    pub fn points(&self, t: usize) -> [[f64; 3]; 3] {
        self.triangle(t).map(|v| self.positions[v as usize])
    }

    pub fn from(&self, edge: usize) -> u32 {
        self.corners[edge]
    }

    pub fn to(&self, edge: usize) -> u32 {
        self.corners[next(edge)]
    }

    pub fn twin(&self, edge: usize) -> usize {
        self.twins[edge] as usize
    }

    /// Returns all edges that start where `edge` starts, in order around that vertex.
    pub fn around(&self, edge: usize) -> impl Iterator<Item = usize> + '_ {
        let mut current = Some(edge);
        std::iter::from_fn(move || {
            let this = current?;
            let following = self.twin(previous(this));
            current = (following != edge).then_some(following);
            Some(this)
        })
    }

    /// Returns the ends of all edges from the start of `edge`, sorted.
    pub fn neighbours(&self, edge: usize) -> Vec<u32> {
        let mut ends: Vec<u32> = self.around(edge).map(|e| self.to(e)).collect();
        ends.sort_unstable();
        ends
    }

    /// Collapses an edge by moving its start onto its end. The two triangles beside it are removed.
    ///
    /// Only for edges whose ends have exactly two common neighbours.
    pub fn collapse(&mut self, edge: usize) {
        let (moved, kept) = (self.from(edge), self.to(edge));
        let fan: Vec<usize> = self.around(edge).collect();
        for e in fan {
            debug_assert_eq!(self.corners[e], moved);
            self.corners[e] = kept;
        }
        for side in [edge, self.twin(edge)] {
            let (a, b) = (self.twin(next(side)), self.twin(previous(side)));
            self.twins[a] = b as u32;
            self.twins[b] = a as u32;
            let t = side / 3;
            self.corners[3 * t..3 * t + 3].fill(GONE);
        }
    }

    /// Replaces an edge by the other diagonal of the two triangles beside it.
    ///
    /// Only if the ends of the new edge are not neighbours already.
    pub fn flip(&mut self, edge: usize) {
        let other = self.twin(edge);
        let (c, d) = (self.from(previous(edge)), self.from(previous(other)));
        // Triangles a b c and b a d become d b c and c a d.
        let (outer_bc, outer_ad) = (self.twin(next(edge)), self.twin(next(other)));
        let (bc, ad) = (next(edge), next(other));
        self.corners[edge] = d;
        self.corners[other] = c;
        // The edges b c and a d stay in place; c a and d b move to the other triangle.
        let outer_ca = self.twin(previous(edge));
        let outer_db = self.twin(previous(other));
        self.link(bc, outer_bc);
        self.link(ad, outer_ad);
        self.link(edge, outer_db);
        self.link(other, outer_ca);
        self.link(previous(edge), previous(other));
    }

    fn link(&mut self, a: usize, b: usize) {
        self.twins[a] = b as u32;
        self.twins[b] = a as u32;
    }
}
