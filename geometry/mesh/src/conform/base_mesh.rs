//! Triangle mesh of the base during replacement.

use fabkit_geometry::{Aabb, Point3};

use crate::facets::Facets;
use crate::halfedges::{next, twins};

/// Marker for an edge without neighbour: it borders on a tool's wall.
pub(super) const NONE: u32 = u32::MAX;

/// Triangles with adjacency. Edge `3 t + i` runs from corner `i` of triangle `t` to the next corner.
pub(super) struct BaseMesh {
    pub points: Vec<[f64; 3]>,
    pub corners: Vec<u32>,
    pub twins: Vec<u32>,
    pub faces: Vec<u32>,
    // Removed triangles keep their number until the end, so that indices remain valid.
    pub alive: Vec<bool>,
    /// Mark of the last cavity that included the triangle.
    pub stamps: Vec<u32>,
}

impl BaseMesh {
    /// Copies the base; `None` if an edge does not have two triangles in opposite directions.
    pub fn new(base: &Facets) -> Option<Self> {
        let corners = base.triangles.as_flattened().to_vec();
        Some(Self {
            twins: twins(base.vertices.len(), &corners).ok()?,
            points: base.vertices.clone(),
            faces: base.faces.clone(),
            alive: vec![true; base.triangles.len()],
            stamps: vec![0; base.triangles.len()],
            corners,
        })
    }

    pub fn len(&self) -> u32 {
        self.faces.len() as u32
    }

    pub fn triangle(&self, t: u32) -> [u32; 3] {
        let first = 3 * t as usize;
        [self.corners[first], self.corners[first + 1], self.corners[first + 2]]
    }

    pub fn points_of(&self, t: u32) -> [[f64; 3]; 3] {
        self.triangle(t).map(|v| self.points[v as usize])
    }

    pub fn from(&self, edge: u32) -> u32 {
        self.corners[edge as usize]
    }

    pub fn to(&self, edge: u32) -> u32 {
        self.corners[next(edge as usize)]
    }

    pub fn bounds_of(&self, t: u32) -> Aabb {
        let [a, b, c] = self.points_of(t);
        let pick = |f: fn(f64, f64) -> f64| std::array::from_fn(|i| f(f(a[i], b[i]), c[i]));
        let (min, max): ([f64; 3], [f64; 3]) = (pick(f64::min), pick(f64::max));
        Aabb { min: Point3::from(min), max: Point3::from(max) }
    }

    /// Adds a triangle without neighbours and returns its number.
    pub fn push(&mut self, corners: [u32; 3], face: u32) -> u32 {
        self.corners.extend(corners);
        self.twins.extend([NONE; 3]);
        self.faces.push(face);
        self.alive.push(true);
        self.stamps.push(0);
        self.len() - 1
    }

    pub fn link(&mut self, a: u32, b: u32) {
        self.twins[a as usize] = b;
        self.twins[b as usize] = a;
    }

    /// Returns the remaining triangles, without unused vertices.
    pub fn into_facets(self) -> Facets {
        let mut facets = Facets::default();
        let mut new_index = vec![NONE; self.points.len()];
        for t in (0..self.len()).filter(|&t| self.alive[t as usize]) {
            let corners = self.triangle(t).map(|v| {
                let index = &mut new_index[v as usize];
                if *index == NONE {
                    *index = facets.vertex(self.points[v as usize]);
                }
                *index
            });
            facets.triangle(corners, self.faces[t as usize]);
        }
        facets
    }
}
