//! Lines where primitives meet, which lines aimed at faces hardly ever pass.

use std::collections::BTreeMap;

use fabkit_geometry::{Point3, Vector3};
use fabkit_mesh::TriMesh;

use super::{Caster, Line, MAX_AIMED};

/// Lines for each pair of primitives that meet.
const LINES_PER_PAIR: usize = 2;

/// For each two primitives that meet: lines through those points on and beside their common edges that
/// a mesh at the usual tolerance has farthest from the surface.
pub(super) fn aimed(caster: &mut Caster, mesh: &TriMesh, reach_mm: f64, lines: &mut Vec<Line>) {
    let mut triangle_of = BTreeMap::new();
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        triangle_of.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, t)));
    }
    // Triangles beside each pair's edges.
    let mut pairs: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (&[a, b], &t) in &triangle_of {
        let Some(&other) = triangle_of.get(&[b, a]) else { continue };
        let [here, beyond] = [t, other].map(|t| mesh.faces[t].leaf);
        if here != beyond {
            pairs.entry([here.min(beyond), here.max(beyond)]).or_default().push(t);
        }
    }
    let at = |v: u32| Vector3::from(mesh.vertices[v as usize]);
    for ([one, other], triangles) in pairs.into_iter().take(MAX_AIMED / LINES_PER_PAIR) {
        let of = format!("seam of leaves {one} and {other}");
        let mut found: Vec<(f64, Line)> = Vec::new();
        for t in triangles {
            let [a, b, c] = mesh.triangles[t].map(at);
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-12) else { continue };
            for point in [(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0] {
                let origin = Point3::from(point + reach_mm * normal);
                let Some(line) = caster.line(&of, origin, -normal) else { continue };
                let strays = line.t_mm.iter().map(|t| (t - reach_mm).abs());
                found.push((strays.fold(f64::INFINITY, f64::min), line));
            }
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            found.truncate(LINES_PER_PAIR);
        }
        lines.extend(found.into_iter().map(|(_, line)| line));
    }
}
