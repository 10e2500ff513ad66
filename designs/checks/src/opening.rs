//! Openings: where a layer may border on air.

use fabkit_geometry::{Opening, Point3, Vector3};

use crate::memo::Key;

/// Rounding allowed between an opening and the surface that it lies on, mm.
const ON_SURFACE_MM: f64 = 1e-6;

/// Smallest cosine between the surface's normal and the opening's axis; a steeper surface is a wall.
const STEEPEST: f64 = 0.5;

/// Returns whether a point of a layer's surface lies on an opening's disc.
///
/// The surface under a vent on a dome is not flat: it may leave the disc's plane by at most its slope times the
/// distance from the centre. `spread_mm` widens the disc for callers that know the surface only at points so far apart.
pub(crate) fn contains_surface_point(
    opening: &Opening,
    point: &Point3<f64>,
    normal: &Vector3<f64>,
    spread_mm: f64,
) -> bool {
    let (along_mm, radial_mm) = from_axis(opening, point);
    let cosine = normal.dot(&opening.axis);
    if !is_beside(opening, point, spread_mm) || cosine < STEEPEST {
        return false;
    }
    let slope = (1.0 - cosine * cosine).max(0.0).sqrt() / cosine;
    along_mm.abs() <= radial_mm * slope + ON_SURFACE_MM
}

/// Returns whether a point is within the radius of an opening, widened by `spread_mm`, from its axis.
pub(crate) fn is_beside(opening: &Opening, point: &Point3<f64>, spread_mm: f64) -> bool {
    from_axis(opening, point).1 <= opening.radius_mm + ON_SURFACE_MM + spread_mm
}

/// Returns the distance along an opening's axis and the distance from it, mm.
fn from_axis(opening: &Opening, point: &Point3<f64>) -> (f64, f64) {
    let offset = point - opening.point;
    let along_mm = offset.dot(&opening.axis);
    (along_mm, (offset - along_mm * opening.axis).norm())
}

/// Appends openings to a cache key.
pub(crate) fn add_to_key(key: Key, openings: &[Opening]) -> Key {
    openings.iter().fold(key, |key, opening| {
        key.vector(&opening.point.coords).vector(&opening.axis).number(opening.radius_mm)
    })
}
