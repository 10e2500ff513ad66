//! Meshes for rendering, with the normals of the exact surfaces: smooth within and across smooth faces, sharp at edges.

use std::collections::BTreeMap;

use fabkit_geometry::{Solid, Vector3};

use crate::surface::LeafSurface;
use crate::{FaceId, PrintMesh};

/// Cosine of about a degree: normals that differ by less belong to one smooth surface. Where a fillet joins a face
/// tangentially, both normals agree up to rounding.
const SAME_COSINE: f64 = 0.9998;

/// Cosine of about eight degrees: a normal that turns by more over the first hundredth of the way into a triangle is
/// not that of a smooth surface. The tip of a cone has none.
const TIP_COSINE: f64 = 0.99;
/// Fraction of the way from a corner to the triangle's centroid at which that is tested.
const INTO: f64 = 0.01;

/// Triangles with a normal at each corner. Where faces meet at an angle, one position has several vertices.
///
/// ```
/// use fabkit_geometry::Solid;
/// let shaded = |solid: &Solid| -> Result<_, fabkit_mesh::MeshError> {
///     let file = fabkit_mesh::mesh(solid, 0.1)?.to_print()?;
///     Ok((file.vertices().len(), file.with_exact_normals(solid).positions.len()))
/// };
/// assert_eq!(shaded(&Solid::cuboid(2.0, 2.0, 2.0))?, (8, 24)); // three faces meet at each corner
/// let (corners, shaded_corners) = shaded(&Solid::sphere(5.0))?;
/// assert_eq!(corners, shaded_corners); // smooth everywhere
/// # Ok::<(), fabkit_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ShadedMesh {
    /// Vertex positions, mm.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one per vertex, pointing outwards.
    pub normals: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl PrintMesh {
    /// Adds the normals of the exact surfaces of `solid`, in whose frame the mesh must be.
    ///
    /// ```
    /// use fabkit_geometry::Solid;
    /// let ball = Solid::sphere(5.0);
    /// let shaded = fabkit_mesh::mesh(&ball, 0.5)?.to_print()?.with_exact_normals(&ball);
    /// // Coarse as it is, each normal is that of the ball: the position over the radius.
    /// for (position, normal) in shaded.positions.iter().zip(&shaded.normals) {
    ///     assert!((0..3).all(|axis| (position[axis] / 5.0 - normal[axis]).abs() < 1e-6));
    /// }
    /// # Ok::<(), fabkit_mesh::MeshError>(())
    /// ```
    pub fn with_exact_normals(&self, solid: &Solid) -> ShadedMesh {
        let outward = self.outward_surfaces(solid);
        let count = self.triangles().len();
        let mut shaded = ShadedMesh {
            positions: Vec::with_capacity(count),
            normals: Vec::with_capacity(count),
            triangles: Vec::with_capacity(count),
        };
        // Vertices made so far at each position, with their normals.
        let mut made: Vec<Vec<(u32, Vector3<f64>)>> = vec![Vec::new(); self.vertices().len()];
        for (triangle, face) in self.triangles().iter().zip(self.faces()) {
            let corners = self.corners(triangle);
            let flat = doubled_area_normal(corners).try_normalize(0.0);
            let corner = |i: usize| {
                let normal = normal_at(outward.get(face), corners, i, flat);
                let known = &mut made[triangle[i] as usize];
                let same = known.iter().find(|(_, other)| other.dot(&normal) > SAME_COSINE);
                same.map(|(vertex, _)| *vertex).unwrap_or_else(|| {
                    let vertex = shaded.positions.len() as u32;
                    // Adding 0.0 removes negative zeros, so that equal numbers are equal bytes.
                    shaded.positions.push(self.vertices()[triangle[i] as usize].map(|x| x + 0.0));
                    shaded.normals.push([0, 1, 2].map(|axis| normal[axis] as f32 + 0.0));
                    known.push((vertex, normal));
                    vertex
                })
            };
            shaded.triangles.push([0, 1, 2].map(corner));
        }
        shaded
    }

    /// Returns each face's exact surface, and 1 if its normal points out of the solid, else -1. The sign is decided by
    /// the larger part of the face's area.
    fn outward_surfaces(&self, solid: &Solid) -> BTreeMap<FaceId, (LeafSurface, f64)> {
        let leaves = solid.leaves();
        let mut found: BTreeMap<FaceId, (LeafSurface, f64)> = BTreeMap::new();
        for (triangle, face) in self.triangles().iter().zip(self.faces()) {
            if !found.contains_key(face) {
                let leaf = &leaves[face.leaf as usize];
                let surface = LeafSurface::new(leaf.primitive, face.face, leaf.root_from_leaf);
                let Some(surface) = surface else { continue };
                found.insert(*face, (surface, 0.0));
            }
            let corners = self.corners(triangle);
            if let Some((surface, votes)) = found.get_mut(face) {
                // Weighted by area: `across` has twice the area as its length.
                *votes += surface
                    .offset(middle(corners).into())
                    .normal
                    .dot(&doubled_area_normal(corners));
            }
        }
        for (_, votes) in found.values_mut() {
            *votes = if *votes < 0.0 { -1.0 } else { 1.0 };
        }
        found
    }

    fn corners(&self, triangle: &[u32; 3]) -> [Vector3<f64>; 3] {
        triangle.map(|v| Vector3::from(self.vertices()[v as usize].map(f64::from)))
    }
}

/// Returns the normal by the right-hand rule, with twice the triangle's area as length.
fn doubled_area_normal([a, b, c]: [Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

fn middle([a, b, c]: [Vector3<f64>; 3]) -> Vector3<f64> {
    (a + b + c) / 3.0
}

/// Returns the normal at one corner of a triangle: that of the exact surface if it has one there.
fn normal_at(
    outward: Option<&(LeafSurface, f64)>,
    corners: [Vector3<f64>; 3],
    corner: usize,
    flat: Option<Vector3<f64>>,
) -> Vector3<f64> {
    // Readers drop a triangle without area, but it must still have a unit normal.
    let flat_or_up = flat.unwrap_or_else(Vector3::z);
    let Some((surface, sign)) = outward else { return flat_or_up };
    let exact = |at: Vector3<f64>| (*sign * surface.offset(at.into()).normal).try_normalize(0.0);
    let middle = middle(corners);
    let beside = exact(corners[corner].lerp(&middle, INTO));
    let is_smooth = |n: &Vector3<f64>| beside.is_some_and(|other| n.dot(&other) > TIP_COSINE);
    exact(corners[corner]).filter(is_smooth).or_else(|| exact(middle)).unwrap_or(flat_or_up)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh;

    fn shaded(solid: &Solid) -> ShadedMesh {
        mesh(solid, 0.05).unwrap().to_print().unwrap().with_exact_normals(solid)
    }

    fn length(normal: &[f32; 3]) -> f32 {
        normal.iter().map(|x| x * x).sum::<f32>().sqrt()
    }

    #[test]
    fn a_ball_is_smooth_and_its_normals_are_exact() {
        let ball = shaded(&Solid::sphere(5.0));
        assert_eq!(ball.positions.len() * 2 - 4, ball.triangles.len());
        for (position, normal) in ball.positions.iter().zip(&ball.normals) {
            assert!((0..3).all(|i| (position[i] / 5.0 - normal[i]).abs() < 1e-6));
        }
    }

    #[test]
    fn a_hole_has_normals_towards_its_axis_and_sharp_rims() {
        let hole = Solid::cylinder(2.0, 3.0).at(0.0, 0.0, -1.0);
        let washer = shaded(&Solid::cylinder(5.0, 1.0).minus(hole));
        let mut on_wall = 0;
        for (position, normal) in washer.positions.iter().zip(&washer.normals) {
            assert!((length(normal) - 1.0).abs() < 1e-6);
            let radius_mm = position[0].hypot(position[1]);
            if normal[2].abs() > 0.5 {
                assert_eq!(normal[2], if position[2] > 0.5 { 1.0 } else { -1.0 });
                continue;
            }
            let out = (position[0] * normal[0] + position[1] * normal[1]) / radius_mm;
            assert!((out - if radius_mm > 3.0 { 1.0 } else { -1.0 }).abs() < 1e-5, "{out}");
            on_wall += 1;
        }
        assert!(on_wall > 40, "{on_wall}");
    }

    /// A position has one vertex where a rounding joins a wall tangentially, and two at a rim.
    #[test]
    fn only_edges_divide_vertices() {
        let half_ball = Solid::sphere(2.0).at(0.0, 0.0, 4.0);
        let bullet = Solid::cylinder(2.0, 4.0).plus(half_ball);
        let solid = shaded(&bullet);
        let at = |z: f32| solid.positions.iter().filter(move |p| (p[2] - z).abs() < 1e-6).count();
        let around = |z: f32| {
            let on_rim = |p: &&[f32; 3]| (p[2] - z).abs() < 1e-6 && p[0].hypot(p[1]) > 1.999;
            solid.positions.iter().filter(on_rim).count()
        };
        assert!(around(0.0) == 2 * around(4.0), "{} and {}", at(0.0), at(4.0));
    }

    #[test]
    fn the_tip_of_a_cone_has_a_normal_for_each_of_its_triangles() {
        let cone = shaded(&Solid::cone(2.0, 0.0, 3.0));
        for triangle in &cone.triangles {
            let corners = triangle.map(|v| Vector3::from(cone.positions[v as usize]));
            let flat = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
            for v in triangle {
                assert!(Vector3::from(cone.normals[*v as usize]).dot(&flat) > 0.8);
            }
        }
    }
}
