//! Validity of the closed paths of a profile: they enclose area, do not cross, and holes lie inside.

use nalgebra::{Matrix2, Vector2};

use crate::Profile;
use crate::compiled::{Edge, Region, signed_area};

/// Largest number of segments of a path. The checks here compare neighbouring segments with each other, so more are
/// refused.
pub(crate) const MAX_SEGMENTS: usize = 10_000;

/// Angular step between points of the polyline that finds candidates for crossings.
const STEP_RAD: f64 = std::f64::consts::PI / 64.0;

/// Upper bound of the polyline's deviation from the arc, relative to the radius: 1 - cos(STEP_RAD / 2) is 3e-4.
const SAG: f64 = 5e-4;

/// Returns the violations of a profile whose paths are each closed and made of valid segments.
pub(crate) fn find_violations(profile: &Profile) -> Vec<String> {
    let mut problems = Vec::new();
    for (i, path) in profile.paths().enumerate() {
        let extent = extent(path.segments.iter().map(|s| Vector2::from(s.to())));
        let area = signed_area(path).abs();
        // Compared this way so that NaN is refused too.
        if area.partial_cmp(&(1e-12 * extent * extent)) != Some(std::cmp::Ordering::Greater) {
            problems.push(format!("{} encloses no area ({area} mm^2)", path_name(i)));
        }
    }
    problems.extend(crossing(profile));
    // The test of holes relies on paths that do not cross.
    if problems.is_empty() {
        problems.extend(misplaced_holes(profile));
    }
    problems
}

fn path_name(i: usize) -> String {
    if i == 0 { "the outer path".into() } else { format!("hole {}", i - 1) }
}

/// Computes half the diagonal of the smallest box around the points.
fn extent(points: impl Iterator<Item = Vector2<f64>>) -> f64 {
    let inf = Vector2::repeat(f64::INFINITY);
    let (low, high) = points.fold((inf, -inf), |(low, high), p| (low.inf(&p), high.sup(&p)));
    0.5 * (high - low).norm()
}

/// Returns messages for holes that lie outside the outer path or in another hole. Paths do not cross, so one point of
/// each suffices.
fn misplaced_holes(profile: &Profile) -> Vec<String> {
    let outer = Region::new(&Profile::new(profile.outer.clone()));
    let holes: Vec<Region> =
        profile.holes.iter().map(|hole| Region::new(&Profile::new(hole.clone()))).collect();
    let mut problems = Vec::new();
    for (i, hole) in profile.holes.iter().enumerate() {
        let start = Vector2::from(hole.start);
        if !outer.contains(start) {
            problems.push(format!("hole {i} lies outside the outer path"));
        }
        if let Some(j) = (0..holes.len()).find(|&j| j != i && holes[j].contains(start)) {
            problems.push(format!("hole {i} lies within hole {j}"));
        }
    }
    problems
}

/// Edge with the polyline through its points.
struct Sampled {
    edge: Edge,
    path: usize,
    name: String,
    points: Vec<Vector2<f64>>,
    low: Vector2<f64>,
    high: Vector2<f64>,
}

/// Returns the first crossing of two segments, as a message.
fn crossing(profile: &Profile) -> Option<String> {
    let region = Region::new(profile);
    let mut edges = region.edges.into_iter();
    let mut sampled = Vec::new();
    for (i, path) in profile.paths().enumerate() {
        for (k, edge) in edges.by_ref().take(path.segments.len()).enumerate() {
            sampled.push(sample(edge, i, format!("segment {k} of {}", path_name(i))));
        }
    }
    let size = extent(sampled.iter().flat_map(|s| s.points.iter().copied()));
    // Sorted from left to right, so that each edge is compared only with those that begin before it ends.
    sampled.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    for (i, a) in sampled.iter().enumerate() {
        for b in sampled[i + 1..].iter().take_while(|b| b.low.x <= a.high.x) {
            let apart = b.low.y > a.high.y || a.low.y > b.high.y;
            let met = if apart { None } else { meeting_point(a, b, size) };
            if let Some(p) = met {
                return Some(format!("{} and {} cross at [{}, {}] mm", a.name, b.name, p.x, p.y));
            }
        }
    }
    None
}

fn sample(edge: Edge, path: usize, name: String) -> Sampled {
    let count = (edge.sweep().abs() / STEP_RAD).ceil().max(1.0) as usize;
    let points: Vec<_> = (0..=count).map(|i| edge.at(i as f64 / count as f64).0).collect();
    let sag = edge.ellipse.map_or(0.0, |e| SAG * e.half_axes.amax());
    let inf = Vector2::repeat(f64::INFINITY);
    let (low, high) = points.iter().fold((inf, -inf), |(low, high), p| (low.inf(p), high.sup(p)));
    Sampled { edge, path, name, points, low: low.add_scalar(-sag), high: high.add_scalar(sag) }
}

/// Returns the point where two edges really cross, other than in a common end.
fn meeting_point(a: &Sampled, b: &Sampled, size: f64) -> Option<Vector2<f64>> {
    let (count_a, count_b) = (a.points.len() - 1, b.points.len() - 1);
    for i in 0..count_a {
        for j in 0..count_b {
            let ([p, q], [r, s]) = ([a.points[i], a.points[i + 1]], [b.points[j], b.points[j + 1]]);
            let side = |from: Vector2<f64>, to: Vector2<f64>, of| (to - from).perp(&(of - from));
            let straddles = |x: f64, y: f64| (x < 0.0) != (y < 0.0);
            if straddles(side(p, q, r), side(p, q, s)) && straddles(side(r, s, p), side(r, s, q)) {
                // Newton's method starts in the middle of the two chords that cross.
                let u = (i as f64 + 0.5) / count_a as f64;
                let v = (j as f64 + 0.5) / count_b as f64;
                let found = refined(&a.edge, &b.edge, u, v, size);
                // Only neighbours on one path may share a point, and only their common end.
                let at_common_end = |x: Vector2<f64>| {
                    let near = |end: Vector2<f64>| (x - end).norm() < 1e-7 * size;
                    let ends = [(a.edge.from, b.edge.to), (a.edge.to, b.edge.from)];
                    a.path == b.path && ends.iter().any(|(e, f)| e == f && near(*e))
                };
                if found.is_some_and(|x| !at_common_end(x)) {
                    return found;
                }
            }
        }
    }
    None
}

/// Refines a crossing by Newton's method on the edges themselves: polylines of thin walls cross where the walls do not.
fn refined(a: &Edge, b: &Edge, mut u: f64, mut v: f64, size: f64) -> Option<Vector2<f64>> {
    for _ in 0..20 {
        let ((p, dp), (q, dq)) = (a.at(u), b.at(v));
        if (p - q).norm() < 1e-10 * size {
            let on = |w: f64| (-1e-9..=1.0 + 1e-9).contains(&w);
            return (on(u) && on(v)).then_some(p);
        }
        let step = Matrix2::from_columns(&[dp, -dq]).try_inverse()? * (p - q);
        (u, v) = (u - step.x, v - step.y);
    }
    None
}
