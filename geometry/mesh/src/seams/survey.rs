//! Whether there is anything to do, found out at little cost: most meshes are as they should be.

use fabkit_geometry::Vector3;

use super::meet::{ON_MM, beyond};
use crate::surface::LeafSurface;

/// Several faces meet in the vertex.
const SEVERAL: u32 = u32::MAX - 1;
/// No triangle yet.
const NONE: u32 = u32::MAX;

/// Whether a vertex between faces lies beside one of them, or an edge between faces strays from where
/// they meet.
pub(super) fn is_off(
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    faces: &[u32],
    surfaces: &[Option<LeafSurface>],
    tolerance_mm: f64,
) -> bool {
    let mut face_at = vec![NONE; points.len()];
    for (triangle, &face) in triangles.iter().zip(faces) {
        for &v in triangle {
            let there = &mut face_at[v as usize];
            *there = if *there == NONE || *there == face { face } else { SEVERAL };
        }
    }
    let between = |v: u32| face_at[v as usize] == SEVERAL;
    let surface = |face: u32| surfaces[face as usize].as_ref();
    // Edges with both ends between faces, lower end first.
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for (&[a, b, c], &face) in triangles.iter().zip(faces) {
        let far = |v: u32| {
            let at = points[v as usize];
            surface(face).is_some_and(|s| s.offset(at).distance_mm.abs() > ON_MM)
        };
        for [from, to] in [[a, b], [b, c], [c, a]] {
            if between(from) {
                if far(from) {
                    return true;
                }
                if between(to) {
                    edges.push(([from.min(to), from.max(to)], face));
                }
            }
        }
    }
    edges.sort_unstable();
    edges.windows(2).any(|pair| {
        let ([(edge, face), (twin, other)], ends) = ([pair[0], pair[1]], pair[0].0);
        edge == twin
            && face != other
            && surface(face).zip(surface(other)).is_some_and(|(face, other)| {
                let [a, b] = ends.map(|v| Vector3::from(points[v as usize]));
                beyond([face, other], [a, b], tolerance_mm).is_some()
            })
    })
}
