//! Triangle mesh with adjacency that supports dividing and flipping edges.

use crate::TriMesh;
use crate::halfedges::{next, previous, twins};

/// Triangle mesh with adjacency. Edge `3 t + i` runs from corner `i` of triangle `t` to the next corner.
pub(super) struct HalfedgeMesh {
    pub points: Vec<[f64; 3]>,
    pub corners: Vec<u32>,
    pub twins: Vec<u32>,
    /// Face number of each triangle.
    pub faces: Vec<u32>,
    /// One outgoing edge of each vertex.
    leaving: Vec<u32>,
}

impl HalfedgeMesh {
    /// Builds the adjacency; `None` if an edge does not have two triangles in opposite directions.
    pub fn new(mesh: &TriMesh, faces: Vec<u32>) -> Option<Self> {
        let corners = mesh.triangles.as_flattened().to_vec();
        let twins = twins(mesh.vertices.len(), &corners).ok()?;
        let mut leaving = vec![0; mesh.vertices.len()];
        for (edge, &v) in (0..).zip(&corners) {
            leaving[v as usize] = edge;
        }
        Some(Self { points: mesh.vertices.clone(), corners, twins, faces, leaving })
    }

    pub fn ends(&self, edge: usize) -> [u32; 2] {
        [self.corners[edge], self.corners[next(edge)]]
    }

    pub fn triangle(&self, t: usize) -> [u32; 3] {
        [self.corners[3 * t], self.corners[3 * t + 1], self.corners[3 * t + 2]]
    }

    /// Returns the faces on both sides of an edge.
    pub fn faces_beside(&self, edge: usize) -> [u32; 2] {
        [self.faces[edge / 3], self.faces[self.twins[edge] as usize / 3]]
    }

    /// Returns the edges that start at a vertex: all of them, if its triangles form one fan.
    pub fn around(&self, vertex: u32) -> impl Iterator<Item = usize> + '_ {
        let first = self.leaving[vertex as usize] as usize;
        let mut current = Some(first);
        std::iter::from_fn(move || {
            let this = current?;
            let following = self.twins[previous(this)] as usize;
            current = (following != first).then_some(following);
            Some(this)
        })
    }

    fn link(&mut self, a: usize, b: usize) {
        self.twins[a] = b as u32;
        self.twins[b] = a as u32;
    }

    /// Divides an edge at a point. The first half keeps the edge's number. Returns the new vertex and the second half.
    pub fn divide(&mut self, edge: usize, at: [f64; 3]) -> (u32, usize) {
        let middle = self.points.len() as u32;
        let twin = self.twins[edge] as usize;
        self.points.push(at);
        // Triangles a b c and b a d become a m c, m b c and b m d, m a d.
        let [second, fourth] = [edge, twin].map(|side| self.half(side, middle));
        self.leaving.push(second as u32);
        self.link(edge, fourth);
        self.link(twin, second);
        (middle, second)
    }

    /// Divides the triangle on one side of the edge; returns the edge from the middle to the old end.
    fn half(&mut self, side: usize, middle: u32) -> usize {
        let (outgoing, incoming) = (next(side), previous(side));
        let [end, apex] = [self.corners[outgoing], self.corners[incoming]];
        let beyond = self.twins[outgoing] as usize;
        let first = self.corners.len();
        self.corners.extend([middle, end, apex]);
        self.twins.extend([u32::MAX; 3]);
        self.faces.push(self.faces[side / 3]);
        self.corners[outgoing] = middle;
        self.link(first + 1, beyond);
        self.link(first + 2, outgoing);
        // The outgoing edge stored for these vertices may belong to the other triangle now.
        self.leaving[end as usize] = first as u32 + 1;
        self.leaving[apex as usize] = incoming as u32;
        first
    }

    /// Returns the other diagonal of the two triangles beside an edge, if its ends are not neighbours yet.
    pub fn diagonal(&self, edge: usize) -> Option<[u32; 2]> {
        let twin = self.twins[edge] as usize;
        let [c, d] = [edge, twin].map(|side| self.corners[previous(side)]);
        let free = c != d && self.around(c).all(|e| self.ends(e)[1] != d);
        free.then_some([c, d])
    }

    /// Replaces an edge by the other diagonal: triangles a b c and b a d become d b c and c a d.
    pub fn flip(&mut self, edge: usize) {
        let twin = self.twins[edge] as usize;
        let [a, b] = self.ends(edge);
        let [c, d] = [edge, twin].map(|side| self.corners[previous(side)]);
        let [outer_ca, outer_db] = [edge, twin].map(|side| self.twins[previous(side)] as usize);
        self.corners[edge] = d;
        self.corners[twin] = c;
        // b c and a d stay in place; c a and d b move to the other triangle.
        self.link(edge, outer_db);
        self.link(twin, outer_ca);
        self.link(previous(edge), previous(twin));
        self.leaving[a as usize] = next(twin) as u32;
        self.leaving[b as usize] = next(edge) as u32;
        self.leaving[c as usize] = previous(edge) as u32;
        self.leaving[d as usize] = previous(twin) as u32;
    }

    /// Reverts the latest flip of an edge that had this twin.
    pub fn unflip(&mut self, edge: usize, twin: usize) {
        let [a, b] = [next(twin), next(edge)].map(|side| self.corners[side]);
        let [outer_db, outer_ca] = [edge, twin].map(|side| self.twins[side] as usize);
        self.corners[edge] = a;
        self.corners[twin] = b;
        self.link(previous(edge), outer_ca);
        self.link(previous(twin), outer_db);
        self.link(edge, twin);
        self.leaving[a as usize] = edge as u32;
        self.leaving[b as usize] = twin as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fabkit_geometry::Solid;

    fn net() -> HalfedgeMesh {
        let mesh = crate::mesh(&Solid::sphere(3.0), 0.1).unwrap();
        let faces = vec![0; mesh.triangles.len()];
        HalfedgeMesh::new(&mesh, faces).unwrap()
    }

    fn assert_sound(net: &HalfedgeMesh) {
        let found = twins(net.points.len(), &net.corners).unwrap();
        assert_eq!(found, net.twins);
        for v in 0..net.points.len() as u32 {
            let used = net.corners.iter().filter(|&&c| c == v).count();
            assert!(net.around(v).all(|edge| net.corners[edge] == v));
            assert_eq!(net.around(v).count(), used);
        }
    }

    #[test]
    fn flips_and_divisions_keep_adjacency() {
        let mut net = net();
        for edge in (0..net.corners.len()).step_by(7) {
            let before = (net.corners.clone(), net.twins.clone());
            if net.diagonal(edge).is_some() {
                let twin = net.twins[edge] as usize;
                net.flip(edge);
                assert_sound(&net);
                net.unflip(edge, twin);
                assert_eq!((net.corners.clone(), net.twins.clone()), before);
                assert_sound(&net);
                net.flip(edge);
            }
            let (middle, half) = net.divide(edge, [0.0; 3]);
            assert_eq!(net.corners[half], middle);
            assert_sound(&net);
        }
    }
}
