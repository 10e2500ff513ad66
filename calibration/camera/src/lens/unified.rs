//! Shared formulas of the double sphere and the extended unified model. Both end in the unified model `r = sin t /
//! (alpha + (1 - alpha) cos t)`, where the angle `t` grows with the incidence angle.

/// Computes the `t` at which `r` ceases to grow (`alpha > 1/2`) or becomes infinite (`alpha <= 1/2`).
pub(super) fn limit_angle(alpha: f64) -> f64 {
    // For alpha > 1/2 the slope of r vanishes, else its denominator does.
    let cosine = if alpha > 0.5 { (1.0 - alpha) / alpha } else { alpha / (1.0 - alpha) };
    (-cosine).acos()
}

/// Computes the height, above the normalised plane and in units of its scale, of the point that projects to the squared
/// radius `squared`; `None` beyond the image.
///
/// Usenko, Demmel and Cremers, "The Double Sphere Camera Model", 3DV 2018, equations 50 and 51;
/// the same expression as in Khomutenko, Garcia and Martinet, RA-L 2016.
pub(super) fn unprojected_height(alpha: f64, squared: f64) -> Option<f64> {
    let under_root = 1.0 - (2.0 * alpha - 1.0) * squared;
    if under_root < 0.0 {
        return None;
    }
    let denominator = alpha * under_root.sqrt() + (1.0 - alpha);
    // Both vanish only for alpha = 1 at the rim, where the direction is level with the plane.
    let numerator = 1.0 - alpha * alpha * squared;
    Some(if denominator > 0.0 { numerator / denominator } else { 0.0 })
}
