//! Law of refraction.

use fabkit_geometry::Vector3;

/// Computes the unit direction behind an interface; `None` if light is totally reflected.
///
/// `ratio` is the refractive index before the interface divided by the one behind it; `normal` is a unit normal on
/// either side (Snell's law in vector form: Born and Wolf, "Principles of Optics", 3.2.2).
///
/// ```
/// use fabkit_geometry::Vector3;
/// use fabkit_optics::refract;
/// // From air into water at 45 degrees: the sine shrinks by the index.
/// let direction = Vector3::new(1.0, 0.0, 1.0).normalize();
/// let bent = refract(&direction, &Vector3::z(), 1.0 / 1.333).unwrap();
/// assert!((bent.x - direction.x / 1.333).abs() < 1e-15);
/// // Back out of the water, flatter than the critical angle.
/// assert_eq!(refract(&Vector3::new(0.8, 0.0, 0.6), &Vector3::z(), 1.333), None);
/// ```
#[inline]
pub fn refract(
    direction: &Vector3<f64>,
    normal: &Vector3<f64>,
    ratio: f64,
) -> Option<Vector3<f64>> {
    let cosine = direction.dot(normal);
    let along = ratio * (direction - cosine * normal);
    let squared = 1.0 - along.norm_squared();
    if squared <= 0.0 {
        return None;
    }
    // The length is 1 but for rounding, which later pieces would accumulate.
    Some((along + squared.sqrt().copysign(cosine) * normal).normalize())
}
