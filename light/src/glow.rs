//! What glows in a light that is used up on its way.

/// How much light comes from a stretch that glows, of what arrives at its beginning: the light that makes it glow gets
/// less by `per_mm` on its way in (Beer and Lambert), what glows comes back unhindered. And what is left of the light
/// behind it.
///
/// ```
/// // A thin stretch glows by its length, an endless one with all the light.
/// let (thin, left) = fabkit_light::glow(0.5, 0.001);
/// assert!((thin - 0.0005).abs() < 1e-6 && left > 0.999);
/// assert!((fabkit_light::glow(0.5, 1e3).0 - 1.0).abs() < 1e-12);
/// ```
pub fn glow(per_mm: f64, length_mm: f64) -> (f64, f64) {
    let left = (-per_mm * length_mm.max(0.0)).exp();
    (1.0 - left, left)
}
