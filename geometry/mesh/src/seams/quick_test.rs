//! Quick test whether any edge needs correction: most meshes need none.

use fabkit_geometry::Vector3;

use super::surface_intersection::{ON_MM, find_stray_midpoint};
use crate::surface::LeafSurface;

/// Marker of a vertex in which several faces meet.
const SEVERAL: u32 = u32::MAX - 1;
/// Marker of a vertex without a triangle so far.
const NONE: u32 = u32::MAX;

/// Returns whether a vertex between faces does not lie on one of them, or an edge between faces deviates too far from
/// their intersection.
pub(super) fn needs_correction(
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
    // Edges with both ends between faces, lower end first, so that an edge and its twin sort next to each other.
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
                find_stray_midpoint([face, other], [a, b], tolerance_mm).is_some()
            })
    })
}
