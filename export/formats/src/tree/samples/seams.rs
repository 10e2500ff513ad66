//! Lines at the seams of primitives, which lines aimed at faces rarely pass.

use std::collections::BTreeMap;

use fabkit_geometry::{Point3, Vector3};
use fabkit_mesh::TriMesh;

use super::{Caster, Line, MAX_AIMED};

/// Number of lines for each pair of primitives that meet.
const LINES_PER_PAIR: usize = 2;

/// Positions between an edge's midpoint (0) and the centre of the triangle beside it (1) where lines pass. On the edge
/// itself another kernel's result would be arbitrary.
const INWARDS: [f64; 2] = [0.3, 1.0];

/// Casts, for each pair of primitives that meet, lines through those points beside their common edges where a mesh at
/// the default tolerance deviates most from the surface.
pub(super) fn cast_at_seams(
    caster: &mut Caster,
    mesh: &TriMesh,
    reach_mm: f64,
    lines: &mut Vec<Line>,
) {
    let mut triangle_of = BTreeMap::new();
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        triangle_of.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, t)));
    }
    // Triangles beside the edges of each pair, rotated so that the edge comes first.
    let mut pairs: BTreeMap<[u32; 2], Vec<[u32; 3]>> = BTreeMap::new();
    for (&[a, b], &t) in &triangle_of {
        let Some(&other) = triangle_of.get(&[b, a]) else { continue };
        let [here, beyond] = [t, other].map(|t| mesh.faces[t].leaf);
        if here != beyond {
            pairs
                .entry([here.min(beyond), here.max(beyond)])
                .or_default()
                .push(rotate_corners(mesh.triangles[t], a));
        }
    }
    let at = |v: u32| Vector3::from(mesh.vertices[v as usize]);
    for ([one, other], triangles) in pairs.into_iter().take(MAX_AIMED / LINES_PER_PAIR) {
        let of = format!("seam of leaves {one} and {other}");
        let mut found: Vec<(f64, Line)> = Vec::new();
        for t in triangles {
            let [a, b, c] = t.map(at);
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-12) else { continue };
            let (edge, middle) = (0.5 * (a + b), (a + b + c) / 3.0);
            for point in INWARDS.map(|share| edge + share * (middle - edge)) {
                let origin = Point3::from(point + reach_mm * normal);
                let Some(line) = caster.line(&of, origin, -normal) else { continue };
                let strays = line.t_mm.iter().map(|t| (t - reach_mm).abs());
                found.push((strays.fold(f64::INFINITY, f64::min), line));
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let clear = found.into_iter().map(|(_, line)| line).filter(|line| {
            let direction = Vector3::from(line.direction);
            caster.has_steady_crossings(Point3::from(line.origin_mm), direction)
        });
        lines.extend(clear.take(LINES_PER_PAIR));
    }
}

/// Rotates a triangle's corners so that `first` comes first.
fn rotate_corners([a, b, c]: [u32; 3], first: u32) -> [u32; 3] {
    match first {
        _ if first == b => [b, c, a],
        _ if first == c => [c, a, b],
        _ => [a, b, c],
    }
}
