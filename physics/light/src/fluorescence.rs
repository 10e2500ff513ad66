//! Fluorescence in light that is absorbed on its way.

/// Computes the emission of a fluorescent layer, relative to the light that arrives on its inner face, and the part of
/// that light behind the layer.
///
/// The exciting light decreases by `per_mm` on its way in (Beer and Lambert); the emitted light returns unhindered.
/// `slants` lengthen both paths relative to the thickness: that of the exciting light, of which a slanted layer
/// receives less and absorbs more, and that of the line of sight, which then crosses more fluorescent material.
///
/// ```
/// // A thin layer glows by its thickness, an endless one with all the light.
/// let (thin, left) = fabkit_light::fluorescence(0.5, 0.001, [1.0, 1.0]);
/// assert!((thin - 0.0005).abs() < 1e-6 && left > 0.999);
/// assert!((fabkit_light::fluorescence(0.5, 1e3, [1.0, 1.0]).0 - 1.0).abs() < 1e-12);
/// // From aside, light passes more of a thin layer; who looks from aside sees more of it.
/// assert!((fabkit_light::fluorescence(0.5, 0.001, [2.0, 3.0]).0 / thin - 6.0).abs() < 0.01);
/// ```
pub fn fluorescence(per_mm: f64, thickness_mm: f64, slants: [f64; 2]) -> (f64, f64) {
    let [light, view] = slants;
    let left = (-per_mm * light * thickness_mm.max(0.0)).exp();
    (view * (1.0 - left), left)
}
