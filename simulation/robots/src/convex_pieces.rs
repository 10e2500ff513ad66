//! Convex pieces of the stiff parts: boxes across the axes, each with the hull of its content.
//!
//! Plates, flanges and tubes follow each other along a sensor's axis, and posts and connectors stand beside it; each of
//! these is nearly convex. The bodies are cut recursively, each time where it saves most volume, at positions where
//! something ends.

use fabkit_files::Error;
use fabkit_mesh::{Hull, convex_hull};
use rayon::prelude::*;

use super::PlacedBody;

/// Largest number of pieces.
const MAX_PIECES: usize = 39;
/// Smallest saving of a cut, as a fraction of the volume of all pieces.
const MIN_SAVED_FRACTION: f64 = 0.002;
/// Number of positions that are tried along each axis of a box.
const POSITIONS_PER_AXIS: usize = 12;
/// Smallest thickness of a box, mm.
const MIN_BOX_MM: f64 = 0.3;
/// Smallest thickness of a box's content, mm.
const MIN_CONTENT_MM: f64 = 0.01;

/// Box across the axes with the hull of its content, and its best cut.
struct Block {
    /// Smallest and largest value of each coordinate, mm.
    from_mm: [f64; 3],
    to_mm: [f64; 3],
    hull: Hull,
    cut: Option<Cut>,
}

/// Cut across an axis.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    at_mm: f64,
    saved_mm3: f64,
}

/// Computes convex pieces that enclose some bodies in their places.
pub(super) fn compute_convex_pieces(bodies: &[&PlacedBody<'_>]) -> Result<Vec<Hull>, Error> {
    let triangles: Vec<Triangle> = bodies
        .iter()
        .flat_map(|body| {
            let corner = |i: u32| body.vertices_mm[i as usize];
            body.triangles.iter().map(move |corners| corners.map(corner))
        })
        .collect();
    if triangles.is_empty() {
        return Ok(Vec::new());
    }
    let end = |of: fn(f64, f64) -> f64, start: f64| {
        let along = |axis: usize| triangles.iter().flatten().map(move |corner| corner[axis]);
        [0, 1, 2].map(|axis| along(axis).fold(start, of))
    };
    let levels = [0, 1, 2].map(|axis| find_levels(&triangles, axis));
    let (least, most) = (end(f64::min, f64::INFINITY), end(f64::max, f64::NEG_INFINITY));
    let mut blocks = vec![block(&triangles, &levels, least, most)?];
    while blocks.len() < MAX_PIECES {
        let all_mm3: f64 = blocks.iter().map(|block| block.hull.volume_mm3()).sum();
        let saved = |block: &Block| block.cut.map_or(0.0, |cut| cut.saved_mm3);
        let best =
            (0..blocks.len()).max_by(|a, b| saved(&blocks[*a]).total_cmp(&saved(&blocks[*b])));
        let Some(best) = best.filter(|i| saved(&blocks[*i]) > MIN_SAVED_FRACTION * all_mm3) else {
            break;
        };
        let Some(Cut { axis, at_mm, .. }) = blocks[best].cut else { break };
        let (mut middle_from, mut middle_to) = (blocks[best].from_mm, blocks[best].to_mm);
        middle_from[axis] = at_mm;
        middle_to[axis] = at_mm;
        let upper = block(&triangles, &levels, middle_from, blocks[best].to_mm)?;
        blocks[best] = block(&triangles, &levels, blocks[best].from_mm, middle_to)?;
        // Neighbouring pieces stay next to each other, so that numbers follow the sensor's axis.
        blocks.insert(best + 1, upper);
    }
    Ok(blocks.into_iter().map(|block| block.hull).collect())
}

type Triangle = [[f64; 3]; 3];

/// Lists the positions along an axis at which something ends, sorted by the area of the flat faces there, the largest
/// first.
fn find_levels(triangles: &[Triangle], axis: usize) -> Vec<f64> {
    let mut flat: std::collections::BTreeMap<i64, f64> = std::collections::BTreeMap::new();
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    for [a, b, c] in triangles {
        let ends = [a[axis], b[axis], c[axis]];
        let [low, high] = [f64::min, f64::max].map(|of| ends.into_iter().reduce(of).unwrap_or(0.0));
        if high - low < 1e-6 {
            // Twice the triangle's area, by the cross product.
            let double = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
            // Positions are rounded to micrometres, so that faces of different bodies at one level add up.
            *flat.entry((a[axis] * 1e3).round() as i64).or_default() += double.abs() / 2.0;
        }
    }
    let mut levels: Vec<(i64, f64)> = flat.into_iter().collect();
    levels.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    levels.into_iter().map(|(um, _)| um as f64 / 1e3).collect()
}

/// Computes the hull of a box's content, and the cut that saves most.
fn block(
    triangles: &[Triangle],
    levels: &[Vec<f64>; 3],
    from_mm: [f64; 3],
    to_mm: [f64; 3],
) -> Result<Block, Error> {
    let mut own = triangles.to_vec();
    for axis in 0..3 {
        own = clip_triangles(&own, axis, [from_mm[axis], to_mm[axis]]);
    }
    let hull = convex_hull(&own.concat()).map_err(Error::bug)?;
    let all_mm3 = hull.volume_mm3();
    let volume_mm3 = |axis: usize, range: [f64; 2]| {
        let hull = convex_hull(&clip_triangles(&own, axis, range).concat());
        // Simulators refuse flat bodies.
        hull.ok().filter(is_thick).map_or(f64::INFINITY, |hull| hull.volume_mm3())
    };
    let tried = (0..3).flat_map(|axis| {
        let [from, to] = [from_mm[axis], to_mm[axis]];
        let is_within = move |at: &f64| *at > from + MIN_BOX_MM && *at < to - MIN_BOX_MM;
        let own = levels[axis].iter().copied().filter(is_within).take(POSITIONS_PER_AXIS);
        // Round bodies have no flat ends: some positions in between.
        let between = (1..4).map(move |k| from + f64::from(k) / 4.0 * (to - from));
        own.chain(between.filter(is_within)).map(move |at_mm| (axis, at_mm))
    });
    let tried: Vec<(usize, f64)> = tried.collect();
    let cut = |(axis, at_mm): &(usize, f64)| {
        let halves = [[from_mm[*axis], *at_mm], [*at_mm, to_mm[*axis]]];
        // If one part would be flat its volume counts as infinite, and the cut is never taken.
        let both: f64 = halves.iter().map(|range| volume_mm3(*axis, *range)).sum();
        Cut { axis: *axis, at_mm: *at_mm, saved_mm3: all_mm3 - both }
    };
    let cuts: Vec<Cut> = tried.par_iter().map(cut).collect();
    let cut = cuts.into_iter().max_by(|a, b| a.saved_mm3.total_cmp(&b.saved_mm3));
    Ok(Block { from_mm, to_mm, hull, cut })
}

fn is_thick(hull: &Hull) -> bool {
    (0..3).all(|axis| {
        let along = || hull.vertices.iter().map(move |vertex| vertex[axis]);
        along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min) > MIN_CONTENT_MM
    })
}

/// Clips triangles to the range between two positions along an axis, and triangulates the remaining polygons.
fn clip_triangles(
    triangles: &[Triangle],
    axis: usize,
    [from_mm, to_mm]: [f64; 2],
) -> Vec<Triangle> {
    let mut left = Vec::new();
    for triangle in triangles {
        let above = clip_polygon(triangle, |p| p[axis] - from_mm);
        let polygon = clip_polygon(&above, |p| to_mm - p[axis]);
        for k in 1..polygon.len().saturating_sub(1) {
            left.push([polygon[0], polygon[k], polygon[k + 1]]);
        }
    }
    left
}

/// Clips a polygon to the positive side (Sutherland and Hodgman 1974).
fn clip_polygon(polygon: &[[f64; 3]], side: impl Fn(&[f64; 3]) -> f64) -> Vec<[f64; 3]> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, here) in polygon.iter().enumerate() {
        let next = &polygon[(i + 1) % polygon.len()];
        let (at, after) = (side(here), side(next));
        if at >= 0.0 {
            kept.push(*here);
        }
        if (at >= 0.0) != (after >= 0.0) {
            let share = at / (at - after);
            kept.push([0, 1, 2].map(|k| here[k] + share * (next[k] - here[k])));
        }
    }
    kept
}
