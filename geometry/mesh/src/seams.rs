//! Edges where faces meet, brought to where the exact faces meet.
//!
//! A boolean of triangles intersects triangles. Those keep to the tolerance, but where two faces meet
//! at a small angle, what strays by d from one of them strays by d / sin(angle) along the other, and
//! with it the edge between them. So when all booleans are done, vertices between faces are moved to
//! where the exact surfaces meet, and edges between faces are divided until no chord is farther from
//! the exact curve than the tolerance.
//!
//! A vertex stays where it is if the surfaces have no point in common near it (a contact without an
//! angle), or if moving it would fold the mesh.

mod meet;
mod net;
mod survey;

use std::collections::VecDeque;

use fabkit_geometry::{Solid, Vector3};

use self::meet::{MOST_SHARE, ON_MM, beyond, meeting};
use self::net::Net;
use crate::halfedges::next;
use crate::measure::double_area;
use crate::surface::LeafSurface;
use crate::{FaceId, TriMesh, tessellate};

/// Vertices may be in each other's way: so often the rest are tried again.
const ROUNDS: usize = 3;

/// A vertex that is moved makes at most so many edges flip.
const MOST_FLIPS: usize = 4;

/// A triangle that is lower than this counts as folded, mm: as near as the boolean kernel lets vertices
/// come to each other.
const LOWEST_MM: f64 = 1e-5;

/// The mesh with its seams where they belong.
pub(crate) fn fitted(mesh: TriMesh, solid: &Solid, tolerance_mm: f64) -> TriMesh {
    let leaves = solid.leaves();
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
    if !survey::is_off(&mesh.vertices, &mesh.triangles, &faces, &surfaces, tolerance_mm) {
        return mesh;
    }
    let Some(net) = Net::new(&mesh, faces) else { return mesh };
    let mut seams = Seams { net, outward: vec![1.0; surfaces.len()], surfaces, tolerance_mm };
    seams.orient();
    seams.settle();
    seams.divide();
    let Net { points, corners, faces, .. } = seams.net;
    TriMesh {
        vertices: points,
        triangles: corners.as_chunks().0.to_vec(),
        faces: faces.iter().map(|&f| ids[f as usize]).collect(),
    }
}

struct Seams {
    net: Net,
    surfaces: Vec<Option<LeafSurface>>,
    /// Of each face's surface: 1 if its normal leaves the solid, else -1.
    outward: Vec<f64>,
    tolerance_mm: f64,
}

impl Seams {
    /// Vertices between faces that do not lie on all of them, and where those meet.
    fn off(&self) -> Vec<(u32, [f64; 3])> {
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
                off.extend(meeting(&surfaces, at).map(|to| (v, to)));
            }
        }
        off
    }

    /// Edges between two faces.
    fn seams(&self) -> impl Iterator<Item = usize> + '_ {
        let once = (0..self.net.corners.len()).filter(|&e| e < self.net.twins[e] as usize);
        once.filter(|&edge| {
            let [face, beyond] = self.net.beside(edge);
            face != beyond
        })
    }

    /// Where the faces beside an edge meet next to its middle, if that is too far away.
    fn beyond(&self, edge: usize) -> Option<[f64; 3]> {
        let [face, other] = self.net.beside(edge).map(|f| self.surfaces[f as usize].as_ref());
        beyond([face?, other?], self.net.ends(edge).map(|v| self.at(v)), self.tolerance_mm)
    }

    fn at(&self, vertex: u32) -> Vector3<f64> {
        Vector3::from(self.net.points[vertex as usize])
    }

    /// Finds out on which side of its faces the solid lies.
    fn orient(&mut self) {
        let mut facing = vec![0.0; self.surfaces.len()];
        for (t, &face) in self.net.faces.iter().enumerate() {
            facing[face as usize] += self.spread(t);
        }
        self.outward = facing.into_iter().map(f64::signum).collect();
    }

    /// Twice the area of a triangle as the exact face sees it, mm^2; below 0 if it is folded.
    fn spread(&self, t: usize) -> f64 {
        let face = self.net.faces[t] as usize;
        let Some(surface) = &self.surfaces[face] else { return 1.0 };
        let [a, b, c] = self.net.triangle(t).map(|v| self.at(v));
        let normal = surface.offset(((a + b + c) / 3.0).into()).normal;
        let area = double_area([a.into(), b.into(), c.into()]);
        self.outward[face] * normal.dot(&Vector3::from(area))
    }

    /// Its lowest altitude as the exact face sees it, mm; below 0 if it is folded.
    fn altitude_mm(&self, t: usize) -> f64 {
        let [a, b, c] = self.net.triangle(t).map(|v| self.at(v));
        let longest_mm = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        self.spread(t) / longest_mm.max(f64::MIN_POSITIVE)
    }

    /// Moves vertices to where their faces meet.
    fn settle(&mut self) {
        let mut left = self.off();
        for _ in 0..ROUNDS {
            left.retain(|&(vertex, to)| !self.moved(vertex, to));
        }
    }

    /// Whether a vertex could be moved without a fold. Where it passes the far edge of one of its
    /// triangles, that edge is flipped.
    fn moved(&mut self, vertex: u32, to: [f64; 3]) -> bool {
        let around = self.net.around(vertex).map(|edge| edge / 3);
        let mut before: Vec<(usize, f64)> = around.map(|t| (t, self.altitude_mm(t))).collect();
        let from = std::mem::replace(&mut self.net.points[vertex as usize], to);
        let mut flipped = Vec::new();
        loop {
            let is_folded = |t: usize| {
                let altitude_mm = self.altitude_mm(t);
                let was_mm =
                    before.iter().find(|(other, _)| *other == t).map_or(LOWEST_MM, |b| b.1);
                altitude_mm < LOWEST_MM.min(was_mm)
            };
            let Some(edge) = self.net.around(vertex).find(|edge| is_folded(edge / 3)) else {
                return true;
            };
            let far = next(edge);
            if flipped.len() == MOST_FLIPS || !self.may_flip(far) {
                break;
            }
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

    /// Whether the other diagonal keeps to the face.
    fn may_flip(&self, edge: usize) -> bool {
        let [face, beyond] = self.net.beside(edge);
        let (Some(ends), Some(surface)) = (self.net.diagonal(edge), &self.surfaces[face as usize])
        else {
            return false;
        };
        let [a, b] = ends.map(|v| self.at(v));
        let stray_mm = surface.offset(((a + b) / 2.0).into()).distance_mm.abs();
        face == beyond && stray_mm <= MOST_SHARE * self.tolerance_mm
    }

    /// Halves edges until none strays.
    fn divide(&mut self) {
        let mut long: VecDeque<usize> = self.seams().collect();
        while let Some(edge) = long.pop_front() {
            let Some(to) = self.beyond(edge) else { continue };
            let [a, b] = self.net.ends(edge).map(|v| self.at(v));
            let (middle, half) = self.net.divide(edge, ((a + b) / 2.0).into());
            if self.moved(middle, to) {
                // Each half strays by a quarter: this comes to an end.
                long.extend([edge, half]);
            }
        }
    }
}
