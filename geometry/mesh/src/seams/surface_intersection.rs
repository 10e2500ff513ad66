//! Intersection points of surfaces.

use fabkit_geometry::Vector3;

use crate::surface::LeafSurface;

/// Distance from a surface up to which a point lies on it, mm.
pub(super) const ON_MM: f64 = 1e-9;

/// Smallest sine between a normal and the span of the others for which it counts as independent.
const LEAST_SINE: f64 = 1e-3;

/// Largest number of Newton steps; they start within a chord tolerance of the solution.
const STEPS: usize = 16;

/// Finds the nearest common point of all surfaces by Newton's method; `None` if they have none near `from`.
pub(super) fn find_common_point(surfaces: &[&LeafSurface], from: [f64; 3]) -> Option<[f64; 3]> {
    let mut at = Vector3::from(from);
    for _ in 0..STEPS {
        // Each normal is made orthogonal to those before it and gives a direction of the step. The part of the step
        // that has already been made along the normal is subtracted.
        let (mut directions, mut step) = ([Vector3::zeros(); 3], Vector3::zeros());
        let (mut count, mut farthest_mm) = (0, 0.0f64);
        for surface in surfaces {
            let offset = surface.offset(at.into());
            farthest_mm = farthest_mm.max(offset.distance_mm.abs());
            let mut left = offset.normal;
            for direction in &directions[..count] {
                left -= left.dot(direction) * direction;
            }
            let sine = left.norm();
            if sine > LEAST_SINE {
                directions[count] = left / sine;
                step -= (offset.distance_mm + offset.normal.dot(&step)) / sine * directions[count];
                count += 1;
            }
        }
        // Tested before the step, so that a point that is already right does not move.
        if farthest_mm < ON_MM {
            return Some(at.into());
        }
        at += step;
    }
    None
}

/// Fraction of the tolerance by which the midpoint of an edge may deviate: if the curvature varies along the edge,
/// another point of it deviates a little more.
pub(super) const MOST_SHARE: f64 = 0.95;

/// Finds the point where two surfaces meet next to the midpoint of an edge with both ends on both surfaces, if that
/// point is too far away.
pub(super) fn find_stray_midpoint(
    surfaces: [&LeafSurface; 2],
    [a, b]: [Vector3<f64>; 2],
    tolerance_mm: f64,
) -> Option<[f64; 3]> {
    let middle = (a + b) / 2.0;
    if surfaces.iter().all(|s| s.offset(middle.into()).distance_mm.abs() < ON_MM) {
        return None;
    }
    let to = find_common_point(&surfaces, middle.into())?;
    let stray_mm = (Vector3::from(to) - middle).norm();
    // A point farther away than the ends belongs to another part of the curve.
    let is_near = stray_mm < (b - a).norm() / 2.0;
    (is_near && stray_mm > MOST_SHARE * tolerance_mm).then_some(to)
}
