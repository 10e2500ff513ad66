//! Correction of edges between faces, so that they lie where the exact faces meet.
//!
//! A boolean of triangles intersects triangles. They keep to the tolerance, but where two faces meet at a small angle,
//! a deviation of d from one of them becomes a deviation of d / sin(angle) along the other, and the edge between them
//! moves by as much. So when all booleans are done, vertices between faces are moved to where the exact surfaces meet,
//! and edges between faces are divided until no chord is farther from the exact curve than the tolerance.
//!
//! A vertex stays where it is if the surfaces have no common point near it (a tangential contact), or if moving it
//! would fold the mesh.

mod halfedge_mesh;
mod quick_test;
mod surface_intersection;

use std::collections::VecDeque;

use fabkit_geometry::{Solid, Vector3};

use self::halfedge_mesh::HalfedgeMesh;
use self::surface_intersection::{MOST_SHARE, ON_MM, find_common_point, find_stray_midpoint};
use crate::halfedges::next;
use crate::measure::doubled_area_normal;
use crate::surface::LeafSurface;
use crate::{FaceId, TriMesh, tessellate};

/// Number of attempts to move the vertices: they may block each other.
const ROUNDS: usize = 3;

/// Largest number of edge flips for moving one vertex.
const MOST_FLIPS: usize = 4;

/// Altitude below which a triangle counts as folded, mm: the distance at which the boolean kernel merges vertices.
const MIN_ALTITUDE_MM: f64 = 1e-5;

/// Returns the mesh with corrected edges between faces.
pub(crate) fn correct_face_edges(mesh: TriMesh, solid: &Solid, tolerance_mm: f64) -> TriMesh {
    let leaves = solid.leaves();
    // A single primitive has no edges made by booleans.
    if leaves.len() < 2 {
        return mesh; // As tessellated.
    }
    let (mut ids, mut surfaces, mut first_face) = (Vec::new(), Vec::new(), Vec::new());
    for (number, leaf) in (0..).zip(&leaves) {
        first_face.push(surfaces.len() as u32);
        for face in 0..tessellate::face_count(leaf.primitive) {
            ids.push(FaceId { leaf: number, face });
            surfaces.push(LeafSurface::new(leaf.primitive, face, leaf.root_from_leaf));
        }
    }
    let number = |id: &FaceId| first_face[id.leaf as usize] + id.face;
    let faces: Vec<u32> = mesh.faces.iter().map(number).collect();
    if !quick_test::needs_correction(
        &mesh.vertices,
        &mesh.triangles,
        &faces,
        &surfaces,
        tolerance_mm,
    ) {
        return mesh;
    }
    let Some(net) = HalfedgeMesh::new(&mesh, faces) else { return mesh };
    let mut seams = Seams { net, outward: vec![1.0; surfaces.len()], surfaces, tolerance_mm };
    seams.orient();
    seams.move_vertices();
    seams.divide();
    let HalfedgeMesh { points, corners, faces, .. } = seams.net;
    TriMesh {
        vertices: points,
        triangles: corners.as_chunks().0.to_vec(),
        faces: faces.iter().map(|&f| ids[f as usize]).collect(),
    }
}

struct Seams {
    net: HalfedgeMesh,
    surfaces: Vec<Option<LeafSurface>>,
    /// Orientation of each face's surface: 1 if its normal points out of the solid, else -1.
    outward: Vec<f64>,
    tolerance_mm: f64,
}

impl Seams {
    /// Returns the vertices between faces that do not lie on all of them, and the points where those faces meet.
    fn find_displaced_vertices(&self) -> Vec<(u32, [f64; 3])> {
        let mut is_between = vec![false; self.net.points.len()];
        for edge in self.seams() {
            for v in self.net.ends(edge) {
                is_between[v as usize] = true;
            }
        }
        let mut around: Vec<u32> = Vec::new();
        let mut surfaces: Vec<&LeafSurface> = Vec::new();
        let mut off = Vec::new();
        for v in (0..).zip(&is_between).filter(|v| *v.1).map(|v| v.0) {
            around.clear();
            around.extend(self.net.around(v).map(|edge| self.net.faces[edge / 3]));
            around.sort_unstable();
            around.dedup();
            surfaces.clear();
            surfaces.extend(around.iter().filter_map(|&f| self.surfaces[f as usize].as_ref()));
            let at = self.net.points[v as usize];
            let is_off = |s: &&LeafSurface| s.offset(at).distance_mm.abs() > ON_MM;
            if surfaces.iter().any(is_off) {
                off.extend(find_common_point(&surfaces, at).map(|to| (v, to)));
            }
        }
        off
    }

    /// Returns the edges between two faces.
    fn seams(&self) -> impl Iterator<Item = usize> + '_ {
        let once = (0..self.net.corners.len()).filter(|&e| e < self.net.twins[e] as usize);
        once.filter(|&edge| {
            let [face, beyond] = self.net.faces_beside(edge);
            face != beyond
        })
    }

    /// Returns the point next to an edge's midpoint where the faces beside it meet, if that is too far away.
    fn find_stray_midpoint(&self, edge: usize) -> Option<[f64; 3]> {
        let [face, other] = self.net.faces_beside(edge).map(|f| self.surfaces[f as usize].as_ref());
        find_stray_midpoint(
            [face?, other?],
            self.net.ends(edge).map(|v| self.at(v)),
            self.tolerance_mm,
        )
    }

    fn at(&self, vertex: u32) -> Vector3<f64> {
        Vector3::from(self.net.points[vertex as usize])
    }

    /// Determines on which side of its faces the solid lies.
    fn orient(&mut self) {
        let mut facing = vec![0.0; self.surfaces.len()];
        for (t, &face) in self.net.faces.iter().enumerate() {
            facing[face as usize] += self.spread(t);
        }
        self.outward = facing.into_iter().map(f64::signum).collect();
    }

    /// Computes twice the area of a triangle projected on the exact face, mm^2; negative if it is folded.
    fn spread(&self, t: usize) -> f64 {
        let face = self.net.faces[t] as usize;
        let Some(surface) = &self.surfaces[face] else { return 1.0 };
        let [a, b, c] = self.net.triangle(t).map(|v| self.at(v));
        let normal = surface.offset(((a + b + c) / 3.0).into()).normal;
        let area = doubled_area_normal([a.into(), b.into(), c.into()]);
        self.outward[face] * normal.dot(&Vector3::from(area))
    }

    /// Computes the smallest altitude of a triangle projected on the exact face, mm; negative if it is folded.
    fn altitude_mm(&self, t: usize) -> f64 {
        let [a, b, c] = self.net.triangle(t).map(|v| self.at(v));
        let longest_mm = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        self.spread(t) / longest_mm.max(f64::MIN_POSITIVE)
    }

    /// Moves vertices to where their faces meet.
    fn move_vertices(&mut self) {
        let mut left = self.find_displaced_vertices();
        for _ in 0..ROUNDS {
            left.retain(|&(vertex, to)| !self.try_move(vertex, to));
        }
    }

    /// Moves a vertex if that is possible without a fold, and returns whether it was. If it passes the far edge of one
    /// of its triangles, that edge is flipped.
    fn try_move(&mut self, vertex: u32, to: [f64; 3]) -> bool {
        let around = self.net.around(vertex).map(|edge| edge / 3);
        let mut before: Vec<(usize, f64)> = around.map(|t| (t, self.altitude_mm(t))).collect();
        let from = std::mem::replace(&mut self.net.points[vertex as usize], to);
        let mut flipped = Vec::new();
        loop {
            let is_folded = |t: usize| {
                let altitude_mm = self.altitude_mm(t);
                let was_mm =
                    before.iter().find(|(other, _)| *other == t).map_or(MIN_ALTITUDE_MM, |b| b.1);
                altitude_mm < MIN_ALTITUDE_MM.min(was_mm)
            };
            let Some(edge) = self.net.around(vertex).find(|edge| is_folded(edge / 3)) else {
                return true;
            };
            let far = next(edge);
            if flipped.len() == MOST_FLIPS || !self.may_flip(far) {
                break;
            }
            // The flipped triangle is a new one, so its former altitude does not apply.
            before.retain(|(t, _)| *t != edge / 3);
            flipped.push((far, self.net.twins[far] as usize));
            self.net.flip(far);
        }
        for &(edge, twin) in flipped.iter().rev() {
            self.net.unflip(edge, twin);
        }
        self.net.points[vertex as usize] = from;
        false
    }

    /// Returns whether the other diagonal stays within tolerance of the face.
    fn may_flip(&self, edge: usize) -> bool {
        let [face, beyond] = self.net.faces_beside(edge);
        let (Some(ends), Some(surface)) = (self.net.diagonal(edge), &self.surfaces[face as usize])
        else {
            return false;
        };
        let [a, b] = ends.map(|v| self.at(v));
        let stray_mm = surface.offset(((a + b) / 2.0).into()).distance_mm.abs();
        face == beyond && stray_mm <= MOST_SHARE * self.tolerance_mm
    }

    /// Halves edges until all are within tolerance.
    fn divide(&mut self) {
        let mut long: VecDeque<usize> = self.seams().collect();
        while let Some(edge) = long.pop_front() {
            // The edge is divided at its midpoint first, and the new vertex is then moved.
            let Some(to) = self.find_stray_midpoint(edge) else { continue };
            let [a, b] = self.net.ends(edge).map(|v| self.at(v));
            let (middle, half) = self.net.divide(edge, ((a + b) / 2.0).into());
            if self.try_move(middle, to) {
                // Each half deviates by a quarter, so this terminates.
                long.extend([edge, half]);
            }
        }
    }
}
