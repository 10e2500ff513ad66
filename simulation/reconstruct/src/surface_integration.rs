//! Integration of normals to a surface, along the camera's rays.
//!
//! Let `P` be a node's point at rest, `r` the direction of its ray, `n` the mean normal of two neighbours, and `d` the
//! displacement towards the camera. Then `n . (P' - d' r' - P + d r) = 0`, which is linear in `d` and exact for any
//! lens and any surface. All pairs of neighbours, with a weak hold near rest, form a least-squares problem that
//! conjugate gradients solve.

use fabkit_geometry::{Point3, Vector3};

/// Standard deviation of normals, rad. Chosen for slopes from images with a noise of one intensity level.
const NORMAL_SIGMA_RAD: f64 = 0.02;
/// Standard deviation of the displacement where the image looks as at rest, mm. Chosen for the movement of gel around a
/// press.
const REST_SIGMA_MM: f64 = 0.03;
/// Standard deviation of the displacement elsewhere, mm. It exceeds the thickness of layers and only prevents parts
/// without any other constraint from drifting.
const FREE_SIGMA_MM: f64 = 5.0;
/// Smallest cosine between ray and normal at which a pair counts.
const LEAST_COSINE: f64 = 0.05;
/// Maximum number of steps and relative tolerance of conjugate gradients.
const MOST_STEPS: usize = 400;
const TOLERANCE: f64 = 1e-4;

/// Surface points of the image on a grid.
#[derive(Clone, Debug, Default)]
pub(super) struct Grid {
    pub columns: usize,
    /// Nodes row by row; `None` where no surface is seen.
    pub nodes: Vec<Option<Node>>,
}

/// A point of the undeformed surface, sensor frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub place: Point3<f64>,
    pub outward: Vector3<f64>,
    /// Direction of the ray that sees the point, away from the camera.
    pub direction: Vector3<f64>,
}

/// Normal equations of the displacements: for each node the diagonal entry, and the entries of its right and lower
/// neighbours. The matrix is symmetric.
struct NormalEquations {
    columns: usize,
    own: Vec<f64>,
    right: Vec<f64>,
    below: Vec<f64>,
    /// Right-hand side.
    right_hand_side: Vec<f64>,
}

impl Grid {
    /// Computes the displacement of each node towards the camera along its ray, mm, from the normals. `still` marks
    /// nodes that look as at rest, `known` those whose normal is known; the result is 0 where nothing is seen. The
    /// iteration starts at `nearer_mm`, an earlier result or zeros.
    pub fn solve_displacements_mm(
        &self,
        normals: &[Vector3<f64>],
        still: &[bool],
        known: &[bool],
        nearer_mm: Vec<f64>,
    ) -> Vec<f64> {
        let hold = |is_still: &bool| if *is_still { REST_SIGMA_MM } else { FREE_SIGMA_MM }.powi(-2);
        let count = self.nodes.len();
        let mut equations = NormalEquations {
            columns: self.columns,
            own: still.iter().map(hold).collect(),
            right: vec![0.0; count],
            below: vec![0.0; count],
            right_hand_side: vec![0.0; count],
        };
        self.add_pairs(normals, known, &mut equations);
        solve(&equations, nearer_mm)
    }

    /// Adds one equation for each pair of neighbours: `after` times the second displacement minus `before` times the
    /// first is `step`, mm.
    fn add_pairs(&self, normals: &[Vector3<f64>], known: &[bool], equations: &mut NormalEquations) {
        for (i, node) in self.nodes.iter().enumerate() {
            let Some(node) = node else { continue };
            // Each pair is visited once, from its left or upper node.
            let right = (i % self.columns + 1 < self.columns).then_some(i + 1);
            for j in right.into_iter().chain([i + self.columns]) {
                let Some(Some(other)) = self.nodes.get(j) else { continue };
                let mean = |a: &Vector3<f64>, b: &Vector3<f64>| (a + b).normalize();
                // If only one normal is known, it stands for both; if none is, the pair keeps its shape at rest.
                let rest = mean(&node.outward, &other.outward);
                let normal = match [known[i], known[j]] {
                    [true, true] => mean(&normals[i], &normals[j]),
                    [true, false] => normals[i],
                    [false, true] => normals[j],
                    [false, false] => rest,
                };
                let apart = other.place - node.place;
                let [before, after] = [node, other].map(|node| normal.dot(&node.direction));
                if before.min(after) < LEAST_COSINE {
                    continue;
                }
                let sure_mm = NORMAL_SIGMA_RAD * apart.norm();
                // Inverse variance, 1/mm2. Pairs without a known normal count a tenth.
                let weight = if known[i] || known[j] { 1.0 } else { 0.1 } / (sure_mm * sure_mm);
                // Subtracting the normal at rest cancels the grid's error on curved surfaces: at rest, `step` is
                // exactly 0.
                let step = (normal - rest).dot(&apart);
                equations.own[i] += weight * before * before;
                equations.own[j] += weight * after * after;
                equations.right_hand_side[i] -= weight * before * step;
                equations.right_hand_side[j] += weight * after * step;
                let side = if j == i + 1 { &mut equations.right } else { &mut equations.below };
                side[i] = -weight * before * after;
            }
        }
    }
}

impl NormalEquations {
    /// Multiplies the matrix with a vector.
    fn times(&self, x: &[f64], y: &mut [f64]) {
        for ((y, own), x) in y.iter_mut().zip(&self.own).zip(x) {
            *y = own * x;
        }
        for (factors, far) in [(&self.right, 1), (&self.below, self.columns)] {
            let ahead = x.get(far..).unwrap_or_default();
            for ((y, factor), x) in y.iter_mut().zip(factors).zip(ahead) {
                *y += factor * x;
            }
            let behind = y.get_mut(far..).unwrap_or_default();
            for ((y, factor), x) in behind.iter_mut().zip(factors).zip(x) {
                *y += factor * x;
            }
        }
    }
}

/// Returns the dot product. Eight independent partial sums allow vectorisation.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (eights, others) = a.as_chunks::<8>();
    let (of_b, others_of_b) = b.as_chunks::<8>();
    for (a, b) in eights.iter().zip(of_b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    let rest: f64 = others.iter().zip(others_of_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Solves the equations with conjugate gradients (Hestenes and Stiefel 1952), preconditioned by the diagonal. Starts at
/// `x`.
fn solve(equations: &NormalEquations, mut x: Vec<f64>) -> Vec<f64> {
    let NormalEquations { own: diagonal, right_hand_side: right, .. } = equations;
    let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(diagonal).map(|(r, d)| r / d).collect() };
    let enough = TOLERANCE * TOLERANCE * dot(right, &scaled(right));
    let mut along = vec![0.0; right.len()];
    equations.times(&x, &mut along);
    let mut residual: Vec<f64> = right.iter().zip(&along).map(|(r, a)| r - a).collect();
    let mut toward = scaled(&residual);
    let mut way = toward.clone();
    let mut length = dot(&residual, &toward);
    for _ in 0..MOST_STEPS {
        if length <= enough {
            break;
        }
        equations.times(&way, &mut along);
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
    fn dent_is_recovered_along_pinhole_rays() {
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
        let found = grid.solve_displacements_mm(&normals, &still, &known, vec![0.0; still.len()]);
        let worst = found.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // The grid's own error: a fourth of the second difference of slopes over a dent's radius, some 0.1 %, and what still holds.
        assert!(worst < 0.01, "{worst}");
    }
}
