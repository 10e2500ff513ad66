//! Extent of a body along a direction, by casting rays.

use fabkit_geometry::sequences::radical_inverse;
use fabkit_geometry::{CompiledSolid, Point3, Ray, Scratch, Vector3};

/// Number of rays through a body. They find the top of a ball of 30 mm to 0.01 mm, and flat faces exactly.
const LINES: u64 = 1024;

/// Tolerance for replacing the measured end by that of the bounding box, mm. The box of round or cut bodies may be too
/// large, so it is used only where the rays come this close: then they have merely missed the end.
const NEAR_MM: f64 = 0.02;

/// Returns the smallest and largest coordinate of a body along a unit vector, mm; `None` if no ray hits it.
pub(crate) fn extent(body: &CompiledSolid, along: &Vector3<f64>) -> Option<[f64; 2]> {
    let bounds = body.bounds();
    if bounds.is_empty() || !bounds.is_finite() {
        return None;
    }
    let (centre, half) = (bounds.centre(), 0.5 * (bounds.max - bounds.min));
    let reach = |w: &Vector3<f64>| w.abs().dot(&half);
    let aside = if along.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let u = along.cross(&aside).normalize();
    let v = along.cross(&u);
    let start = centre - along * (reach(along) + 1.0);
    let (mut scratch, mut stretches) = (Scratch::default(), Vec::new());
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for index in 0..LINES {
        // A low-discrepancy sequence covers the silhouette more evenly than random points.
        let at = |base| 2.0 * radical_inverse(index + 1, base) - 1.0;
        let origin = start + u * (at(2) * reach(&u)) + v * (at(3) * reach(&v));
        body.stretches_into(&Ray { origin, direction: *along }, &mut scratch, &mut stretches);
        let from = (origin - Point3::origin()).dot(along);
        for [enter, leave] in &stretches {
            (low, high) = (low.min(from + enter), high.max(from + leave));
        }
    }
    let middle = (centre - Point3::origin()).dot(along);
    let (box_low, box_high) = (middle - reach(along), middle + reach(along));
    let snapped = |met: f64, edge: f64| if (met - edge).abs() < NEAR_MM { edge } else { met };
    (low < high).then(|| [snapped(low, box_low), snapped(high, box_high)])
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::{Pose, Solid};

    use super::*;

    #[test]
    fn extent_ignores_cut_off_material() {
        let cut = Solid::sphere(10.0).minus(Solid::cylinder(20.0, 20.0).at_z(4.0));
        let body = CompiledSolid::new(&cut).unwrap();
        let [low, high] = extent(&body, &Vector3::z()).unwrap();
        assert!((low + 10.0).abs() < 1e-9 && (high - 4.0).abs() < 1e-9, "{low} {high}");
        let turned = Pose::z_to(Vector3::new(1.0, 2.0, 2.0) / 3.0, Point3::origin());
        let body = CompiledSolid::new(&cut.placed(turned)).unwrap();
        let [_, high] = extent(&body, &turned.vector(Vector3::z())).unwrap();
        assert!((high - 4.0).abs() < 1e-9, "{high}");
    }
}
