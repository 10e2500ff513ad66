//! Pictures that are brighter or darker as a whole than the one at rest.

/// Of a grey value of 255 in a picture.
const WHITE: f32 = 255.0;
/// Where the picture at rest is darker, nothing is said, grey.
pub(super) const LEAST_GREY: f64 = 8.0;
/// Pictures are brighter or darker than the one at rest as a whole by this part at most; steps in which that is looked for.
const MOST_DRIFT: f32 = 0.1;
const DRIFT_STEPS: usize = 160;
/// Every so many-th pixel is asked for it.
const DRIFT_STRIDE: usize = 7;

/// How much brighter most of a picture is than the one at rest: what a press changes is the smaller part. Values from 0 to
/// 1 beside grey values at rest, 0 where nothing is said.
pub(super) fn brighter(at_rest: &[f32], values: &[f32]) -> f32 {
    let mut counts = [0u32; DRIFT_STEPS + 1];
    let of_ratio = |ratio: f32| ((ratio - 1.0) / MOST_DRIFT + 1.0) * 0.5 * DRIFT_STEPS as f32;
    let strides = at_rest.chunks(DRIFT_STRIDE).zip(values.chunks(DRIFT_STRIDE));
    for (rest, value) in strides.map(|(rest, value)| (rest[0], value[0])) {
        // Rounded: what is below half a step is cut off.
        let step = of_ratio(WHITE * value / rest) + 0.5;
        if rest > 0.0 && step >= 0.0 && step < DRIFT_STEPS as f32 + 1.0 {
            counts[step as usize] += 1;
        }
    }
    // The densest stretch of some steps, and its middle by weight.
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
