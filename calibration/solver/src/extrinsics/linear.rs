//! Pose from rays in one linear solve, without a starting value.
//!
//! A point `X` on the ray from `o` along `d` fulfils `(1 - d d^T)(M X + t - s o) = 0` with `M = s R`: linear in `M`,
//! `t` and `s`. The translation is eliminated (as in Terzakis & Lourakis, "A Consistently Fast and Globally Optimal
//! Solution to the Perspective-n-Point Problem", ECCV 2020). The rest is the eigenvector of the smallest eigenvalue of
//! a 9 x 9 matrix, or 10 x 10 if the rays do not meet in one point. Rays work at any angle, also behind the camera's
//! plane, where normalised image coordinates do not exist.

use fabkit_camera::ViewRay;
use fabkit_geometry::{Point3, Pose};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Smallest number of points that determine the twelve unknowns.
pub(super) const MIN_POINTS: usize = 6;
/// Largest distance of ray origins from the camera's centre, relative to the size of the scene, for which the rays
/// count as meeting there.
const CENTRAL: f64 = 1e-9;
/// Smallest ratio of the second smallest eigenvalue to the largest. Below, the points are coplanar, or nearly so for
/// their noise, and more than one pose solves the equations.
const MIN_SECOND: f64 = 1e-7;

/// Finds the pose under which every point lies on its ray, in the least squares sense of the algebraic error; `None`
/// for fewer than six points, or points in a plane.
pub(super) fn pose_from_rays(rays: &[ViewRay], points: &[Point3<f64>]) -> Option<Pose> {
    if points.len() < MIN_POINTS || points.len() != rays.len() {
        return None;
    }
    let size_mm = points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let away = |ray: &ViewRay| ray.origin_in_camera.coords.amax() > CENTRAL * size_mm;
    if rays.iter().any(away) {
        solve::<10>(rays, points, size_mm)
    } else {
        solve::<9>(rays, points, size_mm)
    }
}

/// Solves for `N` unknowns: the nine of `M` row by row, and `s` if there is a tenth.
fn solve<const N: usize>(rays: &[ViewRay], points: &[Point3<f64>], size_mm: f64) -> Option<Pose> {
    let count = points.len() as f64;
    let centroid = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count;
    // Lengths are in units of the scene, so that all unknowns have the same scale.
    let scaled = |p: &Point3<f64>| (p.coords - centroid) / size_mm;
    let across = |ray: &ViewRay| Matrix3::identity() - ray.direction * ray.direction.transpose();
    let mut sum_across = Matrix3::zeros();
    let mut sum_rows = SMatrix::<f64, 3, N>::zeros();
    let mut system = SMatrix::<f64, N, N>::zeros();
    for (ray, point) in rays.iter().zip(points) {
        let rows = rows::<N>(scaled(point), ray.origin_in_camera.coords / size_mm);
        let across = across(ray);
        sum_across += across;
        let weighted = across * rows;
        sum_rows += weighted;
        system += rows.transpose() * weighted;
    }
    let translation_of = -(sum_across.try_inverse()? * sum_rows);
    // The sum over (rows + translation_of)^T across (rows + translation_of), multiplied out.
    system += translation_of.transpose() * sum_rows;
    let (unknowns, well_posed) = find_smallest_eigenvector(&system)?;
    if !well_posed {
        return None;
    }
    let mut stacked = Matrix3::from_fn(|r, c| unknowns[3 * r + c]);
    let mut translation = translation_of * unknowns;
    // An eigenvector's sign is arbitrary; that of a rotation is not.
    if stacked.determinant() < 0.0 {
        stacked = -stacked;
        translation = -translation;
    }
    let svd = stacked.svd(true, true);
    let rotation = svd.u? * svd.v_t?;
    let scale = svd.singular_values.mean();
    let shift_mm = translation / scale * size_mm - rotation * centroid;
    let pose = Pose::new(rotation, shift_mm)?;
    // Points behind the origins of their rays would solve the equations as well.
    let ahead = |(ray, point): &(&ViewRay, &Point3<f64>)| {
        (pose.point(**point) - ray.origin_in_camera).dot(&ray.direction) > 0.0
    };
    (2 * rays.iter().zip(points).filter(ahead).count() > points.len()).then_some(pose)
}

/// Returns `M X - s o` as a matrix times the unknowns.
fn rows<const N: usize>(point: Vector3<f64>, origin: Vector3<f64>) -> SMatrix<f64, 3, N> {
    SMatrix::from_fn(|r, c| match c {
        9 => -origin[r],
        c if c / 3 == r => point[c % 3],
        _ => 0.0,
    })
}

/// Finds the eigenvector of the smallest eigenvalue by inverse iteration, and returns whether the next eigenvalue is
/// far from it.
///
/// Two vectors are iterated together: the second one shows the second smallest eigenvalue. A full eigendecomposition
/// would take longer than everything that follows.
fn find_smallest_eigenvector<const N: usize>(
    system: &SMatrix<f64, N, N>,
) -> Option<(SVector<f64, N>, bool)> {
    let size = system.trace();
    let mut lower = *system;
    for i in 0..N {
        // Exact data make the matrix singular; this keeps the pivots positive.
        lower[(i, i)] += 1e-13 * size;
    }
    // A Cholesky factorisation in place, by hand, because nalgebra's needs a bound that a generic `N` cannot have.
    for j in 0..N {
        for k in 0..j {
            for i in j..N {
                lower[(i, j)] -= lower[(i, k)] * lower[(j, k)];
            }
        }
        let pivot = lower[(j, j)];
        if pivot <= 0.0 || !pivot.is_finite() {
            return None;
        }
        for i in j..N {
            lower[(i, j)] /= pivot.sqrt();
        }
    }
    let inverse_times = |mut v: SVector<f64, N>| {
        for i in 0..N {
            for k in 0..i {
                v[i] -= lower[(i, k)] * v[k];
            }
            v[i] /= lower[(i, i)];
        }
        for i in (0..N).rev() {
            for k in i + 1..N {
                v[i] -= lower[(k, i)] * v[k];
            }
            v[i] /= lower[(i, i)];
        }
        v
    };
    // Arbitrary start vectors, only not parallel to each other.
    let mut first = SVector::<f64, N>::from_fn(|i, _| 1.0 + 0.37 * (i as f64 * 1.7).sin());
    let mut second = SVector::<f64, N>::from_fn(|i, _| 0.3 + (i as f64 * 2.3).cos());
    for _ in 0..12 {
        first = inverse_times(first).normalize();
        second = inverse_times(second);
        second -= first * first.dot(&second);
        second.normalize_mut();
    }
    let next = second.dot(&(system * second));
    Some((first, next > MIN_SECOND * size))
}
