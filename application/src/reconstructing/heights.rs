//! A surface from the ways its places look: neighbours lie across them.
//!
//! Of a node's place `P` at rest, its ray's direction `r` and the mean normal `n` of two neighbours, how much nearer they
//! are, `d`, follows from `n . (P' - d' r' - P + d r) = 0`: linear in `d`, exact for any lens and any surface. All pairs
//! together, with what is still held near rest, are least squares, solved by conjugate gradients.

use fabkit_geometry::{Point3, Vector3};

/// How sure ways are, rad: chosen, of slopes from pictures with a noise of a grey value.
const SLOPE_RAD: f64 = 0.02;
/// How far what looks as at rest may be from it, mm: chosen, what gel does around a press.
const STILL_MM: f64 = 0.03;
/// Everything is held by this much, mm: more than layers are thick, so that what nothing holds does not drift.
const LOOSE_MM: f64 = 5.0;
/// Pairs that are seen flatter than this say nothing, cosine.
const LEAST_COSINE: f64 = 0.05;
/// Of conjugate gradients.
const MOST_STEPS: usize = 400;
const TOLERANCE: f64 = 1e-4;

/// Places that are seen, on a grid.
#[derive(Clone, Debug, Default)]
pub(super) struct Grid {
    pub columns: usize,
    /// Row by row; nothing where no surface is seen.
    pub nodes: Vec<Option<Node>>,
}

/// A place of the surface at rest, sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub place: Point3<f64>,
    pub outward: Vector3<f64>,
    /// Of the ray that sees it, away from the camera.
    pub direction: Vector3<f64>,
}

/// Two neighbours: `after` of the second minus `before` of the first is `step`, each in mm.
struct Pair {
    first: usize,
    second: usize,
    before: f64,
    after: f64,
    step: f64,
    /// One over the variance, 1/mm2.
    weight: f64,
}

impl Grid {
    /// How much nearer each node is than at rest, mm, from the way each looks, and whether it looks as at rest; 0 where
    /// nothing is seen. It begins with `nearer_mm`: what was found before, or zeros.
    pub fn nearer_mm(
        &self,
        normals: &[Vector3<f64>],
        still: &[bool],
        known: &[bool],
        nearer_mm: Vec<f64>,
    ) -> Vec<f64> {
        let pairs = self.pairs(normals, known);
        let hold: Vec<f64> = still
            .iter()
            .map(|is_still| if *is_still { STILL_MM } else { LOOSE_MM }.powi(-2))
            .collect();
        let mut right = vec![0.0; self.nodes.len()];
        let mut diagonal = hold.clone();
        for pair in &pairs {
            right[pair.first] -= pair.weight * pair.before * pair.step;
            right[pair.second] += pair.weight * pair.after * pair.step;
            diagonal[pair.first] += pair.weight * pair.before * pair.before;
            diagonal[pair.second] += pair.weight * pair.after * pair.after;
        }
        let times = |x: &[f64], y: &mut [f64]| {
            for ((y, x), hold) in y.iter_mut().zip(x).zip(&hold) {
                *y = hold * x;
            }
            for pair in &pairs {
                let off = pair.weight * (pair.after * x[pair.second] - pair.before * x[pair.first]);
                y[pair.second] += pair.after * off;
                y[pair.first] -= pair.before * off;
            }
        };
        solve(&right, &diagonal, nearer_mm, times)
    }

    fn pairs(&self, normals: &[Vector3<f64>], known: &[bool]) -> Vec<Pair> {
        let mut pairs = Vec::with_capacity(2 * self.nodes.len());
        for (i, node) in self.nodes.iter().enumerate() {
            let Some(node) = node else { continue };
            let right = (i % self.columns + 1 < self.columns).then_some(i + 1);
            for j in right.into_iter().chain([i + self.columns]) {
                let Some(Some(other)) = self.nodes.get(j) else { continue };
                let mean = |a: &Vector3<f64>, b: &Vector3<f64>| (a + b).normalize();
                // A place of which nothing is known looks as at rest beside those that do.
                let normal = match [known[i], known[j]] {
                    [true, true] => mean(&normals[i], &normals[j]),
                    [true, false] => normals[i],
                    [false, true] => normals[j],
                    [false, false] => mean(&node.outward, &other.outward),
                };
                let rest = mean(&node.outward, &other.outward);
                let apart = other.place - node.place;
                let [before, after] = [node, other].map(|node| normal.dot(&node.direction));
                if before.min(after) < LEAST_COSINE {
                    continue;
                }
                let sure_mm = SLOPE_RAD * apart.norm();
                let weight = if known[i] || known[j] { 1.0 } else { 0.1 } / (sure_mm * sure_mm);
                // At rest nothing is nearer, whatever the grid makes of a curved surface.
                let step = (normal - rest).dot(&apart);
                pairs.push(Pair { first: i, second: j, before, after, step, weight });
            }
        }
        pairs
    }
}

/// Conjugate gradients (Hestenes and Stiefel 1952), each unknown scaled by its diagonal.
fn solve(
    right: &[f64],
    diagonal: &[f64],
    mut x: Vec<f64>,
    times: impl Fn(&[f64], &mut [f64]),
) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(diagonal).map(|(r, d)| r / d).collect() };
    let enough = TOLERANCE * TOLERANCE * dot(right, &scaled(right));
    let mut along = vec![0.0; right.len()];
    times(&x, &mut along);
    let mut residual: Vec<f64> = right.iter().zip(&along).map(|(r, a)| r - a).collect();
    let mut toward = scaled(&residual);
    let mut way = toward.clone();
    let mut length = dot(&residual, &toward);
    for _ in 0..MOST_STEPS {
        if length <= enough {
            break;
        }
        times(&way, &mut along);
        let step = length / dot(&way, &along);
        for i in 0..x.len() {
            x[i] += step * way[i];
            residual[i] -= step * along[i];
        }
        toward = scaled(&residual);
        let now = dot(&residual, &toward);
        for (way, toward) in way.iter_mut().zip(&toward) {
            *way = toward + now / length * *way;
        }
        length = now;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dent in a flat surface that is seen askew through a pinhole: from its exact normals to its depth along rays.
    #[test]
    fn a_dent_is_found_along_the_rays_of_a_pinhole() {
        let (columns, rows) = (80, 60);
        let pupil = Point3::new(3.0, -2.0, -20.0);
        // The surface is z = 0, outward +z; the dent presses towards -z, to the camera below.
        let dent = |x: f64, y: f64| 0.8 * (-(x * x + y * y) / 8.0).exp();
        let slope = |x: f64, y: f64| [-x / 4.0 * dent(x, y), -y / 4.0 * dent(x, y)];
        let mut grid = Grid { columns, nodes: Vec::new() };
        let (mut normals, mut truth) = (Vec::new(), Vec::new());
        for i in 0..columns * rows {
            let x = (i % columns) as f64 * 0.2 - 8.0;
            let y = (i / columns) as f64 * 0.2 - 6.0;
            let place = Point3::new(x, y, 0.0);
            let direction = (place - pupil).normalize();
            grid.nodes.push(Some(Node { place, outward: Vector3::z(), direction }));
            // Where the ray meets z = -dent(x, y).
            let mut nearer = 0.0;
            for _ in 0..50 {
                let at = place - nearer * direction;
                nearer = dent(at.x, at.y) / direction.z;
            }
            let at = place - nearer * direction;
            let [sx, sy] = slope(at.x, at.y);
            normals.push(Vector3::new(sx, sy, 1.0).normalize());
            truth.push(nearer);
        }
        let still: Vec<bool> = truth.iter().map(|mm| *mm < 1e-3).collect();
        let known = vec![true; still.len()];
        let found = grid.nearer_mm(&normals, &still, &known, vec![0.0; still.len()]);
        let worst = found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The grid's own error: a fourth of the second difference of slopes over a dent's radius, some 0.1 %, and what still holds.
        assert!(worst < 0.01, "{worst}");
    }
}
