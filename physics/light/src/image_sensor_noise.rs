//! Noise of an image sensor.

use std::f64::consts::TAU;

/// Noise model of an image sensor, in intensities of 0 to 255.
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
    pub fn add_noise(&self, grey: f64, seed: u64, pixel: u64) -> f64 {
        let variance = self.read_noise.powi(2) + self.shot_noise.powi(2) * grey.max(0.0);
        let noise = if variance > 0.0 { variance.sqrt() * draw_normal(seed, pixel) } else { 0.0 };
        (grey + noise).clamp(0.0, 255.0)
    }
}

/// Draws the brightness offset of a whole image, in intensities, from a normal distribution with standard deviation
/// `sigma` over images.
pub fn draw_drift(sigma: f64, seed: u64) -> f64 {
    // No pixel has this number, so the draw is independent of all pixel noise.
    if sigma > 0.0 { sigma * draw_normal(seed, u64::MAX) } else { 0.0 }
}

/// Draws a standard normal number that depends on nothing but seed and number (Box and Muller 1958).
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
