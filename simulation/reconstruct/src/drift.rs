//! Estimation of the overall brightness of an image relative to the one at rest.

/// Intensity of a value of 1 in an image.
const WHITE: f32 = 255.0;
/// Minimum intensity at rest for a pixel to be used.
pub(super) const LEAST_GREY: f64 = 8.0;
/// Largest relative drift of brightness, and number of histogram steps over its range.
const MOST_DRIFT: f32 = 0.1;
const DRIFT_STEPS: usize = 160;
/// Stride of the pixels that are sampled.
const DRIFT_STRIDE: usize = 7;

/// Returns the brightness of most of an image relative to the one at rest; a press changes the smaller part. `values`
/// are 0 to 1, `at_rest` are intensities with 0 for unusable pixels. 1 if no pixel is usable.
pub(super) fn estimate_relative_brightness(at_rest: &[f32], values: &[f32]) -> f32 {
    let mut counts = [0u32; DRIFT_STEPS + 1];
    let of_ratio = |ratio: f32| ((ratio - 1.0) / MOST_DRIFT + 1.0) * 0.5 * DRIFT_STEPS as f32;
    let strides = at_rest.chunks(DRIFT_STRIDE).zip(values.chunks(DRIFT_STRIDE));
    for (rest, value) in strides.map(|(rest, value)| (rest[0], value[0])) {
        // Adding one half rounds to the nearest step. Negative values must be excluded before the cast would turn them
        // to 0.
        let step = of_ratio(WHITE * value / rest) + 0.5;
        if rest > 0.0 && step >= 0.0 && step < DRIFT_STEPS as f32 + 1.0 {
            counts[step as usize] += 1;
        }
    }
    // The mode: the densest window of the histogram, refined by its centre of mass. Of equal windows the first counts.
    const STRETCH: usize = 9;
    let sums = counts.windows(STRETCH).enumerate();
    let densest =
        sums.max_by_key(|(at, window)| (window.iter().sum::<u32>(), std::cmp::Reverse(*at)));
    let Some((at, window)) = densest.filter(|(_, window)| window.iter().any(|count| *count > 0))
    else {
        return 1.0;
    };
    let (mut sum, mut weight) = (0.0f32, 0.0f32);
    for (i, count) in window.iter().enumerate() {
        sum += *count as f32 * (at + i) as f32;
        weight += *count as f32;
    }
    (2.0 * sum / weight / DRIFT_STEPS as f32 - 1.0) * MOST_DRIFT + 1.0
}
