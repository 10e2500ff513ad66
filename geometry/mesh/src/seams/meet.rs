//! Where surfaces meet.

use fabkit_geometry::Vector3;

use crate::surface::LeafSurface;

/// A point no farther than this from a surface lies on it, mm.
pub(super) const ON_MM: f64 = 1e-9;

/// Normals that leave a smaller sine to what the others span count as one of them.
const LEAST_SINE: f64 = 1e-3;

/// Newton's method starts within a chord tolerance of the solution.
const STEPS: usize = 16;

/// The point of all surfaces that is nearest to a point close by; `None` if they have none in common
/// there.
pub(super) fn meeting(surfaces: &[&LeafSurface], from: [f64; 3]) -> Option<[f64; 3]> {
    let mut at = Vector3::from(from);
    for _ in 0..STEPS {
        // Each normal, made orthogonal to those before it, is a direction to go in; what has been
        // gone already along the normal counts.
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
        if farthest_mm < ON_MM {
            return Some(at.into());
        }
        at += step;
    }
    None
}

/// Share of the tolerance that the middle of an edge may stray: where a face bends more at one end than
/// at the other, another point of it strays a little more.
pub(super) const MOST_SHARE: f64 = 0.95;

/// Where two surfaces meet next to the middle of an edge between points of both, if that is too far
/// away.
pub(super) fn beyond(
    surfaces: [&LeafSurface; 2],
    [a, b]: [Vector3<f64>; 2],
    tolerance_mm: f64,
) -> Option<[f64; 3]> {
    let middle = (a + b) / 2.0;
    if surfaces.iter().all(|s| s.offset(middle.into()).distance_mm.abs() < ON_MM) {
        return None;
    }
    let to = meeting(&surfaces, middle.into())?;
    let stray_mm = (Vector3::from(to) - middle).norm();
    // What is farther away than the ends is another part of the curve.
    let is_near = stray_mm < (b - a).norm() / 2.0;
    (is_near && stray_mm > MOST_SHARE * tolerance_mm).then_some(to)
}
