//! What glows in a light that is used up on its way.

/// How much light comes from a layer that glows, of what arrives on its inner face, and what is left of the light behind it.
///
/// The light that makes it glow gets less by `per_mm` on its way in (Beer and Lambert), what glows comes back unhindered.
/// Both ways are longer than the layer is thick, by `slants`: that of the light, of which a slanted layer meets less and uses
/// up more, and that along which one looks, on which more of what glows lies.
///
/// ```
/// // A thin layer glows by its thickness, an endless one with all the light.
/// let (thin, left) = fabkit_light::glow(0.5, 0.001, [1.0, 1.0]);
/// assert!((thin - 0.0005).abs() < 1e-6 && left > 0.999);
/// assert!((fabkit_light::glow(0.5, 1e3, [1.0, 1.0]).0 - 1.0).abs() < 1e-12);
/// // From aside, light passes more of a thin layer; who looks from aside sees more of it.
/// assert!((fabkit_light::glow(0.5, 0.001, [2.0, 3.0]).0 / thin - 6.0).abs() < 0.01);
/// ```
pub fn glow(per_mm: f64, thickness_mm: f64, slants: [f64; 2]) -> (f64, f64) {
    let [light, view] = slants;
    let left = (-per_mm * light * thickness_mm.max(0.0)).exp();
    (view * (1.0 - left), left)
}
