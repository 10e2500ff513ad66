//! What is stiff as convex pieces: slabs across z, each the hull of what lies in it.
//!
//! Sensors are built along their axis: plates, flanges and tubes follow each other, and each of these is nearly convex. Slabs
//! are cut where that saves most, one after the other.

use fabkit_mesh::{Hull, convex_hull};
use rayon::prelude::*;

use super::Standing;
use crate::Error;

/// No more pieces than this.
const MOST: usize = 39;
/// A cut that saves less of all that pieces enclose is not worth a piece.
const WORTH: f64 = 0.002;
/// Heights that are tried in each slab.
const TRIED: usize = 12;
/// Slabs are no thinner, mm.
const THINNEST_MM: f64 = 0.3;

/// A slab with its hull, and the best cut of it.
struct Slab {
    from_mm: f64,
    to_mm: f64,
    hull: Hull,
    /// Height, and what it saves, mm3.
    cut: Option<(f64, f64)>,
}

/// Convex pieces that hold all of some bodies in their places.
pub(super) fn pieces(bodies: &[&Standing<'_>]) -> Result<Vec<Hull>, Error> {
    let triangles: Vec<[[f64; 3]; 3]> = bodies
        .iter()
        .flat_map(|body| {
            let corner = |i: u32| body.vertices_mm[i as usize];
            body.triangles.iter().map(move |corners| corners.map(corner))
        })
        .collect();
    let mut heights: Vec<f64> = triangles.iter().flatten().map(|corner| corner[2]).collect();
    heights.sort_by(f64::total_cmp);
    let (Some(from_mm), Some(to_mm)) = (heights.first().copied(), heights.last().copied()) else {
        return Ok(Vec::new());
    };
    let levels = levels(&triangles);
    let mut slabs = vec![slab(&triangles, &levels, [from_mm, to_mm])?];
    while slabs.len() < MOST {
        let all_mm3: f64 = slabs.iter().map(|slab| slab.hull.volume_mm3()).sum();
        let saved = |slab: &Slab| slab.cut.map_or(0.0, |(_, saved_mm3)| saved_mm3);
        let best = (0..slabs.len()).max_by(|a, b| saved(&slabs[*a]).total_cmp(&saved(&slabs[*b])));
        let Some(best) = best.filter(|i| saved(&slabs[*i]) > WORTH * all_mm3) else { break };
        let Some((height_mm, _)) = slabs[best].cut else { break };
        let (from_mm, to_mm) = (slabs[best].from_mm, slabs[best].to_mm);
        let upper = slab(&triangles, &levels, [height_mm, to_mm])?;
        slabs[best] = slab(&triangles, &levels, [from_mm, height_mm])?;
        slabs.insert(best + 1, upper);
    }
    Ok(slabs.into_iter().map(|slab| slab.hull).collect())
}

/// Heights at which something ends, by how much lies flat there, the most first.
fn levels(triangles: &[[[f64; 3]; 3]]) -> Vec<f64> {
    let mut flat: std::collections::BTreeMap<i64, f64> = std::collections::BTreeMap::new();
    for [a, b, c] in triangles {
        let [low, high] =
            [f64::min, f64::max].map(|of| [a[2], b[2], c[2]].into_iter().reduce(of).unwrap_or(0.0));
        if high - low < 1e-6 {
            let double = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            *flat.entry((a[2] * 1e3).round() as i64).or_default() += double.abs() / 2.0;
        }
    }
    let mut levels: Vec<(i64, f64)> = flat.into_iter().collect();
    levels.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    levels.into_iter().map(|(um, _)| um as f64 / 1e3).collect()
}

fn slab(
    triangles: &[[[f64; 3]; 3]],
    levels: &[f64],
    [from_mm, to_mm]: [f64; 2],
) -> Result<Slab, Error> {
    let own = clipped(triangles, [from_mm, to_mm]);
    let hull = convex_hull(&own.concat()).map_err(Error::bug)?;
    let all_mm3 = hull.volume_mm3();
    let is_within = |height: &f64| *height > from_mm + THINNEST_MM && *height < to_mm - THINNEST_MM;
    let mut tried: Vec<f64> = levels.iter().copied().filter(is_within).take(TRIED).collect();
    // Round bodies end nowhere: some heights in between.
    tried
        .extend((1..4).map(|k| from_mm + f64::from(k) / 4.0 * (to_mm - from_mm)).filter(is_within));
    let volume_mm3 = |range: [f64; 2]| {
        let points = clipped(&own, range).concat();
        convex_hull(&points).map_or(f64::INFINITY, |hull| hull.volume_mm3())
    };
    let saves = |height: &f64| {
        let both = volume_mm3([from_mm, *height]) + volume_mm3([*height, to_mm]);
        (*height, all_mm3 - both)
    };
    let cuts: Vec<(f64, f64)> = tried.par_iter().map(saves).collect();
    let cut = cuts.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    Ok(Slab { from_mm, to_mm, hull, cut })
}

/// What of triangles lies between two heights: each as the triangles of what is left of it.
fn clipped(triangles: &[[[f64; 3]; 3]], [from_mm, to_mm]: [f64; 2]) -> Vec<[[f64; 3]; 3]> {
    let mut left = Vec::new();
    for triangle in triangles {
        let above = cut(triangle, |p| p[2] - from_mm);
        let polygon = cut(&above, |p| to_mm - p[2]);
        for k in 1..polygon.len().saturating_sub(1) {
            left.push([polygon[0], polygon[k], polygon[k + 1]]);
        }
    }
    left
}

/// A polygon without what lies on the negative side (Sutherland and Hodgman 1974).
fn cut(polygon: &[[f64; 3]], side: impl Fn(&[f64; 3]) -> f64) -> Vec<[f64; 3]> {
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
