//! Volume, area, genus, shells and bounds of meshes.

use std::collections::BTreeMap;

use fabkit_geometry::{Aabb, Solid};

use crate::facets::bounds_of;
use crate::{FaceId, TriMesh};

impl TriMesh {
    /// Computes the enclosed volume, mm^3.
    pub fn volume_mm3(&self) -> f64 {
        volume_mm3(&self.vertices, &self.triangles)
    }

    /// Computes the surface area, mm^2.
    pub fn area_mm2(&self) -> f64 {
        area_mm2(&self.vertices, &self.triangles)
    }

    /// Computes the number of through holes and handles, summed over connected shells: 1 - (V - E + F) / 2 per shell.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// use fabkit_mesh::mesh;
    /// let holes = [-4.0, 0.0, 4.0].map(|x_mm| Solid::rod(1.0, [-0.1, 2.1]).at(x_mm, 0.0, 0.0));
    /// let plate = Solid::cuboid(20.0, 6.0, 2.0).minus_all(holes);
    /// assert_eq!(mesh(&plate, 0.1)?.genus(), 3);
    /// // A blind hole is none.
    /// let cup = Solid::cylinder(5.0, 8.0).minus(Solid::rod(4.0, [1.0, 8.1]));
    /// assert_eq!(mesh(&cup, 0.1)?.genus(), 0);
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    pub fn genus(&self) -> i32 {
        genus(self.vertices.len(), &self.triangles)
    }

    /// Returns the number of connected shells; a closed cavity counts as one.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// use fabkit_mesh::mesh;
    /// let hollow = Solid::sphere(5.0).minus(Solid::sphere(3.0));
    /// assert_eq!(mesh(&hollow, 0.1)?.shells(), 2); // one outside, one inside
    /// let pair = Solid::sphere(1.0).plus(Solid::sphere(1.0).at(3.0, 0.0, 0.0));
    /// assert_eq!(mesh(&pair, 0.1)?.shells(), 2); // two pieces
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    pub fn shells(&self) -> usize {
        shells_and_vertices(self.vertices.len(), &self.triangles).0
    }

    /// Returns the bounding box, mm.
    pub fn bounds(&self) -> Aabb {
        bounds_of(&self.vertices)
    }

    /// Computes the smallest altitude over the longest edge of any triangle, mm, which reveals slivers.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let brick = fabkit_mesh::mesh(&Solid::cuboid(3.0, 4.0, 12.0), 0.1)?;
    /// // The face of 3 mm by 4 mm has a diagonal of 5 mm, and its corners are 3 * 4 / 5 mm from it.
    /// assert!((brick.lowest_altitude_mm() - 2.4).abs() < 1e-12);
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    pub fn lowest_altitude_mm(&self) -> f64 {
        let altitude = |t: &[u32; 3]| {
            let corners = t.map(|v| self.vertices[v as usize]);
            let edge2 = |i: usize| {
                let edge = subtract(corners[i], corners[(i + 1) % 3]);
                dot(edge, edge)
            };
            let (normal, longest2) =
                (doubled_area_normal(corners), edge2(0).max(edge2(1)).max(edge2(2)));
            (dot(normal, normal) / longest2).sqrt()
        };
        self.triangles.iter().map(altitude).fold(f64::INFINITY, f64::min)
    }

    /// Returns the name of the feature that a triangle of `solid`'s mesh belongs to; empty if there is none.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let vent = Solid::rod(1.0, [-0.1, 2.1]).named("vent");
    /// let lid = Solid::cylinder(6.0, 2.0).minus(vent);
    /// let triangles = fabkit_mesh::mesh(&lid, 0.1)?;
    /// let of_vent = (0..triangles.triangles.len()).filter(|t| triangles.feature(*t, &lid) == "vent");
    /// let on_wall =
    ///     |v: &u32| triangles.vertices[*v as usize][0].hypot(triangles.vertices[*v as usize][1]);
    /// let mut corners = of_vent.flat_map(|t| triangles.triangles[t]);
    /// assert!(corners.all(|v| (on_wall(&v) - 1.0).abs() < 1e-9));
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    pub fn feature<'a>(&self, triangle: usize, solid: &'a Solid) -> &'a str {
        feature_of(self.faces.get(triangle), solid)
    }
}

/// Closed, connected surface.
///
/// ```
/// use fabkit_geometry::Solid;
/// let hollow = Solid::cuboid(4.0, 4.0, 4.0).minus(Solid::cuboid(2.0, 2.0, 2.0).at_z(1.0));
/// let shells = fabkit_mesh::mesh(&hollow, 0.1)?.to_print()?.shells();
/// let [outer, void] = shells[..] else { panic!("two shells") };
/// assert_eq!((outer.volume_mm3, outer.is_void()), (64.0, false));
/// assert_eq!((void.volume_mm3, void.is_void()), (-8.0, true));
/// assert_eq!(void.at_mm, [0.0, 0.0, 2.0]);
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    /// Enclosed volume, mm^3: negative for a cavity.
    pub volume_mm3: f64,
    /// Centre of its bounding box, mm.
    pub at_mm: [f64; 3],
}

impl Shell {
    /// Returns whether the material is outside.
    pub fn is_void(&self) -> bool {
        self.volume_mm3 < 0.0
    }
}

pub(crate) fn feature_of<'a>(face: Option<&FaceId>, solid: &'a Solid) -> &'a str {
    let leaves = solid.leaves();
    face.and_then(|id| leaves.get(id.leaf as usize)).map_or("", |leaf| leaf.feature)
}

pub(crate) fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the normal whose length is twice the triangle's area, mm^2.
pub(crate) fn doubled_area_normal(corners: [[f64; 3]; 3]) -> [f64; 3] {
    cross(subtract(corners[1], corners[0]), subtract(corners[2], corners[0]))
}

pub(crate) fn volume_mm3(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    // Tetrahedra to a point on the mesh: relative to a distant origin their sum would lose digits.
    let Some(&origin) = vertices.first() else { return 0.0 };
    let tetrahedron = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| subtract(vertices[v as usize], origin));
        dot(a, cross(b, c))
    };
    triangles.iter().map(tetrahedron).sum::<f64>() / 6.0
}

pub(crate) fn area_mm2(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> f64 {
    let double = |t: &[u32; 3]| {
        let normal = doubled_area_normal(t.map(|v| vertices[v as usize]));
        dot(normal, normal).sqrt()
    };
    triangles.iter().map(double).sum::<f64>() / 2.0
}

/// Computes the sum over shells of 1 - (V - E + F) / 2, where a closed mesh has E = 3 F / 2.
pub(crate) fn genus(vertex_count: usize, triangles: &[[u32; 3]]) -> i32 {
    let (shells, used) = shells_and_vertices(vertex_count, triangles);
    let characteristic = used as i64 - triangles.len() as i64 / 2;
    (shells as i64 - characteristic / 2) as i32
}

pub(crate) fn shells(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<Shell> {
    let root = components(vertices.len(), triangles);
    let mut of: BTreeMap<u32, (usize, Vec<[u32; 3]>)> = BTreeMap::new();
    for (t, triangle) in triangles.iter().enumerate() {
        let (_, all) = of.entry(root[triangle[0] as usize]).or_insert((t, Vec::new()));
        all.push(*triangle);
    }
    let mut of: Vec<(usize, Vec<[u32; 3]>)> = of.into_values().collect();
    // The order of shells follows their first triangles.
    of.sort_unstable_by_key(|(first, _)| *first);
    let shell = |triangles: Vec<[u32; 3]>| {
        // Each shell gets its own corners, so that its volume is summed relative to one of them.
        let corners: Vec<[f64; 3]> =
            triangles.iter().flatten().map(|&v| vertices[v as usize]).collect();
        let own: Vec<[u32; 3]> =
            (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let at_mm = bounds_of(&corners).centre().into();
        Shell { volume_mm3: volume_mm3(&corners, &own), at_mm }
    };
    of.into_iter().map(|(_, triangles)| shell(triangles)).collect()
}

/// Returns the number of connected components and of vertices in use.
fn shells_and_vertices(vertex_count: usize, triangles: &[[u32; 3]]) -> (usize, usize) {
    let root = components(vertex_count, triangles);
    let mut used = vec![false; vertex_count];
    for &v in triangles.as_flattened() {
        used[v as usize] = true;
    }
    let shells = (0..vertex_count).filter(|&v| used[v] && root[v] == v as u32).count();
    (shells, used.iter().filter(|u| **u).count())
}

/// Returns for each vertex the smallest vertex that it is connected with (union-find with path halving).
fn components(vertex_count: usize, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..vertex_count as u32).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    for &[a, b, c] in triangles {
        for v in [b, c] {
            let (x, y) = (root(&mut parent, a), root(&mut parent, v));
            parent[x.max(y) as usize] = x.min(y);
        }
    }
    (0..vertex_count as u32).map(|v| root(&mut parent, v)).collect()
}
