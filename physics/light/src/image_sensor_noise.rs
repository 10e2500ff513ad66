//! Noise of an image sensor.

use std::f64::consts::TAU;

/// Noise model of an image sensor, in intensities of 0 to 255.
///
/// ```
/// use fabkit_light::ImageSensorNoise;
///
/// // 0.6 in the dark, and 0.8 more at 100: 0.08 times its root.
/// let chip = ImageSensorNoise { read_noise: 0.6, shot_noise: 0.08 };
/// let squares = (0..10_000).map(|pixel| (chip.add_noise(100.0, 7, pixel) - 100.0).powi(2));
/// let deviation = (squares.sum::<f64>() / 10_000.0).sqrt();
/// assert!((deviation - 0.6_f64.hypot(0.8)).abs() < 0.05);
/// // The same image again has the same noise, another one has not.
/// assert_eq!(chip.add_noise(100.0, 7, 3), chip.add_noise(100.0, 7, 3));
/// assert_ne!(chip.add_noise(100.0, 7, 3), chip.add_noise(100.0, 8, 3));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageSensorNoise {
    /// Standard deviation of the noise in the dark.
    pub read_noise: f64,
    /// Standard deviation of the shot noise at intensity 1; it grows with the square root of the intensity.
    pub shot_noise: f64,
}

impl ImageSensorNoise {
    /// Image sensor without noise.
    pub const IDEAL: Self = Self { read_noise: 0.0, shot_noise: 0.0 };

    /// Adds the noise of one pixel to its intensity, and clamps to 0 to 255 without rounding. The noise depends on seed
    /// and pixel only.
    ///
    /// ```
    /// use fabkit_light::ImageSensorNoise;
    ///
    /// // What is brighter than white is white; nothing is rounded.
    /// assert_eq!(ImageSensorNoise::IDEAL.add_noise(300.0, 1, 0), 255.0);
    /// assert_eq!(ImageSensorNoise::IDEAL.add_noise(12.25, 1, 0), 12.25);
    /// ```
    pub fn add_noise(&self, grey: f64, seed: u64, pixel: u64) -> f64 {
        let variance = self.read_noise.powi(2) + self.shot_noise.powi(2) * grey.max(0.0);
        let noise = if variance > 0.0 { variance.sqrt() * draw_normal(seed, pixel) } else { 0.0 };
        (grey + noise).clamp(0.0, 255.0)
    }
}

/// Draws the brightness offset of a whole image, in intensities, from a normal distribution with standard deviation
/// `sigma` over images.
///
/// ```
/// use fabkit_light::draw_drift;
///
/// // Images of one sequence have seeds of their own; their brightness varies by the stated amount.
/// let squares = (0..10_000).map(|seed| draw_drift(0.5, seed).powi(2));
/// assert!(((squares.sum::<f64>() / 10_000.0).sqrt() - 0.5).abs() < 0.02);
/// assert_eq!(draw_drift(0.0, 1), 0.0);
/// ```
pub fn draw_drift(sigma: f64, seed: u64) -> f64 {
    // No pixel has this number, so the draw is independent of all pixel noise.
    if sigma > 0.0 { sigma * draw_normal(seed, u64::MAX) } else { 0.0 }
}

/// Draws a standard normal number that depends on nothing but seed and number (Box and Muller 1958).
///
/// ```
/// use fabkit_light::draw_normal;
///
/// // Two thirds of all draws lie within one standard deviation.
/// let within = (0..10_000).filter(|number| draw_normal(1, *number).abs() < 1.0).count();
/// assert!((6_700..6_950).contains(&within));
/// assert_eq!(draw_normal(1, 5), draw_normal(1, 5));
/// ```
pub fn draw_normal(seed: u64, number: u64) -> f64 {
    let first = mix_bits(mix_bits(seed) ^ number);
    let [a, b] =
        // 53 random bits; the half keeps the logarithm away from zero.
        [first, mix_bits(first)].map(|bits| ((bits >> 11) as f64 + 0.5) / (1u64 << 53) as f64);
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}

/// Scrambles bits: the finaliser of SplitMix64 (Steele, Lea, Flood 2014).
fn mix_bits(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_stated_spread_and_no_correlation_between_neighbours() {
        let chip = ImageSensorNoise { read_noise: 0.6, shot_noise: 0.08 };
        let noise: Vec<f64> = (0..40_000).map(|i| chip.add_noise(100.0, 3, i) - 100.0).collect();
        let count = noise.len() as f64;
        let mean = noise.iter().sum::<f64>() / count;
        let variance = noise.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
        // The variance is 0.36 + 0.64 = 1; tolerances are five standard errors.
        assert!(mean.abs() < 5.0 / count.sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / count).sqrt(), "{variance}");
        let beside = noise.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / count;
        assert!(beside.abs() < 5.0 / count.sqrt(), "{beside}");
        assert_ne!(chip.add_noise(100.0, 3, 0), chip.add_noise(100.0, 4, 0));
    }

    #[test]
    fn recorded_intensities_stay_between_black_and_white() {
        let chip = ImageSensorNoise { read_noise: 50.0, shot_noise: 0.0 };
        let all: Vec<f64> =
            (0..2_000).flat_map(|i| [0.0, 255.0].map(|g| chip.add_noise(g, 1, i))).collect();
        assert!(all.iter().all(|grey| (0.0..=255.0).contains(grey)));
        assert_eq!(ImageSensorNoise::IDEAL.add_noise(12.25, 9, 9), 12.25);
        assert_eq!(draw_drift(0.0, 5), 0.0);
    }
}
