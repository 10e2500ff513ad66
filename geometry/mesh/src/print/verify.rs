//! Verification that a file's mesh is valid. It shares no code with the repair.

use super::{PrintDefect, PrintMesh};
use crate::TriMesh;
use crate::measure::{doubled_area_normal, genus, subtract, volume_mm3};

/// Checks all properties that [`PrintMesh`] guarantees.
pub(super) fn check_validity(print: &PrintMesh, original: &TriMesh) -> Result<(), PrintDefect> {
    let vertices: Vec<[f64; 3]> = print.vertices.iter().map(|v| v.map(f64::from)).collect();
    let at = |v: u32| vertices[v as usize];
    let defect = |problem, at_mm| Err(PrintDefect { problem, at_mm });

    // All bits of a position in one number, with the vertex number in the lowest 32 bits.
    let place = |(v, vertex): (usize, &[f32; 3])| {
        vertex.iter().fold(0, |bits, c| bits << 32 | u128::from((c + 0.0).to_bits())) << 32
            | v as u128
    };
    let mut places: Vec<u128> = print.vertices.iter().enumerate().map(place).collect();
    places.sort_unstable();
    if let Some(pair) = places.windows(2).find(|w| w[0] >> 32 == w[1] >> 32) {
        return defect("two vertices fall together", at(pair[0] as u32));
    }
    if let Some(&[a, ..]) =
        print.triangles.iter().find(|t| doubled_area_normal(t.map(at)) == [0.0; 3])
    {
        return defect("a triangle has no area", at(a));
    }
    if let Some(vertex) = open_fan(vertices.len(), &print.triangles) {
        return defect("the triangles around a vertex do not close to one fan", at(vertex));
    }
    let somewhere = vertices.first().copied().unwrap_or_default();
    if volume_mm3(&vertices, &print.triangles) <= 0.0 {
        return defect("the volume is not positive", somewhere);
    }
    if genus(vertices.len(), &print.triangles) != original.genus() {
        return defect("the genus has changed", somewhere);
    }
    Ok(())
}

/// Returns a vertex whose triangles are not one closed, oriented fan.
///
/// Around a vertex, every triangle leads from one neighbour to another. The surface is a closed, oriented manifold
/// there exactly if those steps form a single cycle.
fn open_fan(vertex_count: usize, triangles: &[[u32; 3]]) -> Option<u32> {
    let mut first = vec![0usize; vertex_count + 1];
    for v in triangles.iter().flatten() {
        first[*v as usize + 1] += 1;
    }
    for v in 0..vertex_count {
        first[v + 1] += first[v];
    }
    let mut filled = first.clone();
    let mut steps = vec![[0u32; 2]; 3 * triangles.len()];
    for &[a, b, c] in triangles {
        for [at, from, to] in [[a, b, c], [b, c, a], [c, a, b]] {
            steps[filled[at as usize]] = [from, to];
            filled[at as usize] += 1;
        }
    }
    (0..vertex_count as u32).find(|&v| {
        let fan = &mut steps[first[v as usize]..first[v as usize + 1]];
        // A linear search of a small fan takes less time than sorting it.
        let is_small = fan.len() <= SMALL_FAN;
        if !is_small {
            fan.sort_unstable();
        }
        !is_single_cycle(fan, is_small)
    })
}

/// Largest number of triangles of a small fan.
const SMALL_FAN: usize = 16;

/// Returns whether the steps lead once through all their starts and back. They are sorted unless `are_few`.
fn is_single_cycle(steps: &[[u32; 2]], are_few: bool) -> bool {
    if steps.len() < 3 {
        return false;
    }
    let next = |at: u32| {
        if are_few {
            steps.iter().find(|step| step[0] == at)
        } else {
            steps.binary_search_by_key(&at, |step| step[0]).ok().map(|i| &steps[i])
        }
    };
    // If two steps share a start, one of them is never taken, and the cycle closes too early.
    let mut current = steps[0][0];
    for taken in 1..=steps.len() {
        let Some(step) = next(current) else { return false };
        current = step[1];
        if current == steps[0][0] {
            return taken == steps.len();
        }
    }
    false
}

/// Checks the distance of each original vertex from the one it was merged into.
pub(super) fn check_displacement(
    original: &[[f64; 3]],
    positions: &[[f64; 3]],
    moved_to: &[u32],
    most_mm: f64,
) -> Result<(), PrintDefect> {
    for (v, &from) in original.iter().enumerate() {
        let mut end = v;
        while moved_to[end] as usize != end {
            end = moved_to[end] as usize;
        }
        let way = subtract(positions[end], from);
        if way.iter().any(|c| c.abs() > most_mm) {
            let problem = "a vertex would have to move too far to mend the mesh";
            return Err(PrintDefect { problem, at_mm: from });
        }
    }
    Ok(())
}
