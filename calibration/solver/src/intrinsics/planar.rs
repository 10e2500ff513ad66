//! Pose of a board from rays in one linear solve, without a starting value.
//!
//! A corner `(x, y)` of the board on the ray `d` fulfils `d x (x r1 + y r2 + t) = 0`: linear in the nine numbers of
//! `[r1 r2 t]`, as for the homography of a flat board (Z. Zhang, "A Flexible New Technique for Camera Calibration",
//! PAMI 2000), but with rays, which exist for a fisheye beyond 90 degrees too.

use fabkit_camera::{Point2, Vector3};
use fabkit_geometry::Pose;
use nalgebra::{Matrix3, SMatrix};

/// Smallest number of corners: fewer leave the eight unknowns undetermined, or have no redundancy.
pub(super) const MIN_CORNERS: usize = 6;

/// Finds `camera_from_board` from at least [`MIN_CORNERS`] corners in the board frame, mm, and the unit rays through
/// their pixels. `None` if they do not determine it, as on one line.
pub(super) fn pose_from_rays(corners_mm: &[Point2<f64>], rays: &[Vector3<f64>]) -> Option<Pose> {
    if corners_mm.len() < MIN_CORNERS || corners_mm.len() != rays.len() {
        return None;
    }
    let count = corners_mm.len() as f64;
    let centre = corners_mm.iter().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>() / count;
    let size_mm = corners_mm.iter().map(|p| (p.coords - centre).norm()).fold(0.0, f64::max);
    // Lengths are in units of the board, so that all unknowns have the same scale.
    let scaled = |p: &Point2<f64>| {
        let q = (p.coords - centre) / size_mm;
        Vector3::new(q.x, q.y, 1.0)
    };
    let mut system = SMatrix::<f64, 9, 9>::zeros();
    for (corner, ray) in corners_mm.iter().zip(rays) {
        let (p, across) = (scaled(corner), ray.cross_matrix());
        let rows = SMatrix::<f64, 3, 9>::from_fn(|r, c| across[(r, c % 3)] * p[c / 3]);
        system += rows.transpose() * rows;
    }
    let eigen = system.symmetric_eigen();
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    // If a second eigenvalue vanishes, another pose solves the equations as well.
    if eigen.eigenvalues[order[1]] < 1e-9 * eigen.eigenvalues[order[8]] {
        return None;
    }
    let mut stacked = Matrix3::from_column_slice(eigen.eigenvectors.column(order[0]).as_slice());
    // The eigenvector's sign is arbitrary: most corners must lie ahead on their rays.
    let ahead = corners_mm.iter().zip(rays).filter(|(p, ray)| (stacked * scaled(p)).dot(ray) > 0.0);
    if 2 * ahead.count() < corners_mm.len() {
        stacked = -stacked;
    }
    let (r1, r2, t) = (stacked.column(0), stacked.column(1), stacked.column(2));
    // The homography is known up to scale; the columns of a rotation have length 1.
    let scale = 0.5 * (r1.norm() + r2.norm()) / size_mm;
    let frame = Matrix3::from_columns(&[r1.into_owned(), r2.into_owned(), r1.cross(&r2) / scale]);
    // The nearest rotation to the frame.
    let svd = frame.svd(true, true);
    let rotation = svd.u? * svd.v_t?;
    let shift_mm = t / scale - rotation * Vector3::new(centre.x, centre.y, 0.0);
    Pose::new(rotation, shift_mm)
}
