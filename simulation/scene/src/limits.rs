//! Limits of the options of casts.

/// Limits of the radius of the membrane's transition around contacts, mm. The upper limit is wider than any gel's skin
/// carries.
pub const MEMBRANE_LIMITS_MM: [f64; 2] = [0.0, 10.0];
/// Limits of the standard deviation of printed and cast surfaces, mm.
pub const SIGMA_LIMITS_MM: [f64; 2] = [0.0, 1.0];
/// Limits of the margin that is left out on either side of a seam, mm.
pub const MARGIN_LIMITS_MM: [f64; 2] = [0.0, 10.0];
/// Maximum number of rays along each side of a pixel.
pub const MAX_SAMPLES: u32 = 8;
/// Maximum number of rays of one cast: the same limit as for images.
pub const MAX_RAYS: u64 = fabkit_depth::MAX_PIXELS;
