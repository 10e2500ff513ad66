//! Intermediate triangles: unchecked, with unresolved face numbers.

use fabkit_geometry::{Aabb, Point3, Pose};

/// Triangles with one face number each, counted through all leaves of a tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Facets {
    pub vertices: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub faces: Vec<u32>,
}

impl Facets {
    pub fn vertex(&mut self, point: [f64; 3]) -> u32 {
        self.vertices.push(point);
        self.vertices.len() as u32 - 1
    }

    pub fn triangle(&mut self, corners: [u32; 3], face: u32) {
        self.triangles.push(corners);
        self.faces.push(face);
    }

    /// Appends a moved copy whose face numbers start at `first_face`.
    pub fn append(&mut self, other: &Self, pose: &Pose, first_face: u32) {
        let first_vertex = self.vertices.len() as u32;
        if *pose == Pose::identity() {
            self.vertices.extend_from_slice(&other.vertices);
        } else {
            self.vertices.extend(other.vertices.iter().map(|&v| transform_point(pose, v)));
        }
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first_vertex)));
        self.faces.extend(other.faces.iter().map(|f| f + first_face));
    }

    pub fn bounds(&self) -> Aabb {
        bounds_of(&self.vertices)
    }
}

pub(crate) fn transform_point(pose: &Pose, point: [f64; 3]) -> [f64; 3] {
    pose.point(Point3::from(point)).into()
}

pub(crate) fn bounds_of(vertices: &[[f64; 3]]) -> Aabb {
    vertices.iter().fold(Aabb::nothing(), |bounds, &v| {
        let point = Point3::from(v);
        bounds.hull(&Aabb { min: point, max: point })
    })
}
