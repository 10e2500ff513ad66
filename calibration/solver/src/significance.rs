//! Significance of detections: how far a spot stands out of an image's own noise.
//!
//! A detector compares the contrast of a spot with the noise that this contrast has in this image. The noise has two
//! parts ([`ImageNoise`]). One is independent from pixel to pixel. The other is common to the pixels of a block: JPEG and
//! video coders round the coefficients of each block of 8 x 8 or 16 x 16 px by themselves, and in a smooth image their
//! steps are all that there is.
//!
//! A [`Significance`] is made from a contrast and its noise only, and [`Detections`] from all candidates only. So no spot is
//! reported without its significance, and none is dropped without being counted.

/// Number of rows that are evaluated: noise is the same in all, and images are searched hundreds of times a second.
const ROWS: usize = 16;
/// Largest period of a lattice of blocks, px: that of colours that are stored at half the resolution.
const LATTICE_PX: usize = 16;
/// Smallest mean step at the borders of blocks, relative to that elsewhere, at which a lattice is recognised. A phase of an
/// image with 320 columns has 320 steps, whose mean scatters by 4.2 % (0.75 / sqrt(320)): this is six times as much.
const LATTICE_STEP: f64 = 1.25;
/// Smallest number of steps of a phase for that: images of some 100 px and more have as many.
const LATTICE_STEPS: usize = 100;
/// Smallest step in the same place, in steps of intensity: an image without noise has no scatter to compare with.
const LATTICE_GREY: f64 = 0.1;
/// Limit of a step, relative to the median: beyond, it is an edge in the scene.
const EDGE: f32 = 6.0;
/// Quartile of the absolute value of a standard normal distribution. The quartile is used instead of the median since
/// most pixels of a small image may be near a spot.
const NORMAL_QUARTER: f64 = 0.3186;
/// Mean of the absolute value of a standard normal distribution.
const NORMAL_MEAN: f64 = 0.7979;
/// Standard deviation of rounding to whole steps, in steps: that of a uniform distribution.
const ROUNDING: f64 = 0.2887;

/// Noise of an image, measured in it.
///
/// ```
/// use fabkit_calibration::significance::ImageNoise;
/// // A ramp over blocks of 8 px, each rounded to a value of its own, as JPEG leaves it.
/// let block = |i: usize| [0.0, 0.02, -0.02, 0.01, -0.01][(i % 320 / 8 * 7 + i / 320 / 8 * 3) % 5];
/// let values: Vec<f32> = (0..320 * 240).map(|i| 0.5 + block(i)).collect();
/// let noise = ImageNoise::measure(values.iter().copied(), 320, 1.0 / 255.0);
/// assert_eq!(noise.block_px, Some(8));
/// assert!((0.005..0.03).contains(&noise.block_sigma));
/// // The mean of a wide spot has less noise than that of a narrow one.
/// assert!(noise.contrast_sigma([900.0, 3000.0]) < noise.contrast_sigma([9.0, 30.0]));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImageNoise {
    /// Standard deviation of a pixel, independent from pixel to pixel.
    pub pixel_sigma: f64,
    /// Standard deviation of a block; 0 where no lattice of blocks is recognised.
    pub block_sigma: f64,
    /// Side of a block, px: 8 or 16; `None` where no lattice is recognised.
    pub block_px: Option<usize>,
}

impl ImageNoise {
    /// Measures the noise of the pixels of one colour, row by row, with so many columns. `grey_step` is the distance of
    /// two intensities that the file can hold.
    pub fn measure(
        values: impl ExactSizeIterator<Item = f32> + Clone,
        columns: usize,
        grey_step: f64,
    ) -> Self {
        let rounding = ROUNDING * grey_step;
        let rows = values.len() / columns.max(1);
        // An odd stride samples rows of blocks at different places of theirs.
        let stride = (rows / ROWS) | 1;
        let mut bends = Vec::with_capacity(2 * ROWS * columns);
        let mut steps = Vec::with_capacity(2 * ROWS * columns);
        let mut line = Vec::with_capacity(columns);
        for row in (0..rows).step_by(stride) {
            line.clear();
            line.extend(values.clone().skip(row * columns).take(columns));
            bends.extend(line.windows(3).map(|v| (v[0] - 2.0 * v[1] + v[2]).abs()));
            // Step between the middle two of four pixels, beyond the slope beside it.
            let step = |v: &[f32]| (1.5 * (v[2] - v[1]) + 0.5 * (v[0] - v[3])).abs();
            steps.extend(line.windows(4).enumerate().map(|(i, v)| (i + 2, step(v))));
        }
        // The second difference of independent noise has a variance of 1 + 4 + 1 = 6.
        let quarter = quantile(&mut bends, 0.25);
        let pixel_sigma = (f64::from(quarter) / (NORMAL_QUARTER * 6.0_f64.sqrt())).max(rounding);
        let (block_px, block_sigma) =
            find_lattice(&steps, grey_step).map_or((None, 0.0), |(px, sigma)| (Some(px), sigma));
        Self { pixel_sigma, block_sigma, block_px }
    }

    /// Returns the noise of the difference between the means of two areas, given their numbers of pixels.
    #[must_use]
    pub fn contrast_sigma(&self, areas_px: [f64; 2]) -> f64 {
        let block_area = self.block_px.map_or(1.0, |px| (px * px) as f64);
        let of = |px: f64| {
            let blocks = (px / block_area).max(1.0);
            self.pixel_sigma.powi(2) / px.max(1.0) + self.block_sigma.powi(2) / blocks
        };
        areas_px.map(of).iter().sum::<f64>().sqrt()
    }

    /// Returns the noise of values that are weighted sums of these colours.
    ///
    /// ```
    /// use fabkit_calibration::significance::ImageNoise;
    /// let one = ImageNoise { pixel_sigma: 3.0, block_sigma: 1.0, block_px: Some(8) };
    /// let other = ImageNoise { pixel_sigma: 2.0, block_sigma: 0.0, block_px: None };
    /// let sum = ImageNoise::of_sum(&[(one, 1.0), (other, 2.0)]);
    /// assert_eq!((sum.pixel_sigma, sum.block_sigma, sum.block_px), (5.0, 1.0, Some(8)));
    /// ```
    #[must_use]
    pub fn of_sum(parts: &[(Self, f64)]) -> Self {
        let root = |sigma: fn(&Self) -> f64| {
            let squares = parts.iter().map(|(noise, weight)| (weight * sigma(noise)).powi(2));
            squares.sum::<f64>().sqrt()
        };
        Self {
            pixel_sigma: root(|noise| noise.pixel_sigma),
            block_sigma: root(|noise| noise.block_sigma),
            block_px: parts.iter().filter_map(|(noise, _)| noise.block_px).max(),
        }
    }
}

/// Finds the lattice of blocks in steps between columns. Returns the side of a block, px, and the standard deviation of
/// its values.
fn find_lattice(steps: &[(usize, f32)], grey_step: f64) -> Option<(usize, f64)> {
    let mut sizes: Vec<f32> = steps.iter().map(|(_, step)| *step).collect();
    let cap = (EDGE * quantile(&mut sizes, 0.5)).max(EDGE * grey_step as f32);
    let (mut sums, mut counts) = ([0.0; LATTICE_PX], [0usize; LATTICE_PX]);
    for (column, step) in steps {
        sums[column % LATTICE_PX] += f64::from(step.min(cap));
        counts[column % LATTICE_PX] += 1;
    }
    let means: Vec<f64> = sums.iter().zip(counts).map(|(sum, n)| sum / n.max(1) as f64).collect();
    // Few steps scatter so far that some phase always seems to be a border.
    let fewest = counts.iter().min().copied().unwrap_or(0);
    if fewest < LATTICE_STEPS {
        return None;
    }
    let phase = (0..LATTICE_PX).max_by(|a, b| means[*a].total_cmp(&means[*b]))?;
    // A step at a border reaches the slopes of the columns beside it.
    let is_inside = |at: usize| !matches!((at + LATTICE_PX - phase) % 8, 0 | 1 | 7);
    let inside: Vec<f64> =
        (0..LATTICE_PX).filter(|at| is_inside(*at)).map(|at| means[at]).collect();
    let usual = inside.iter().sum::<f64>() / inside.len() as f64;
    let most = inside.iter().copied().fold(0.0, f64::max);
    let is_border = |mean: f64| {
        mean > LATTICE_STEP * usual && mean > most && mean > usual + LATTICE_GREY * grey_step
    };
    if !is_border(means[phase]) {
        return None;
    }
    let px = if is_border(means[(phase + 8) % LATTICE_PX]) { 8 } else { LATTICE_PX };
    // A block's own value and its neighbour's are independent, so their difference has twice the variance.
    let excess = means[phase].powi(2) - usual.powi(2);
    Some((px, excess.max(0.0).sqrt() / NORMAL_MEAN / 2.0_f64.sqrt()))
}

fn quantile(values: &mut [f32], part: f64) -> f32 {
    let at = (values.len() as f64 * part) as usize;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(at, f32::total_cmp).1 }
}

/// Contrast of a detection in standard deviations of the noise that it has in its image.
///
/// ```
/// use fabkit_calibration::significance::Significance;
/// assert_eq!(Significance::new(0.08, 0.01).sigmas(), 8.0);
/// // Contrast without noise is certain, and no contrast is nothing.
/// assert_eq!(Significance::new(0.08, 0.0).sigmas(), Significance::MOST);
/// assert_eq!(Significance::new(0.0, 0.0).sigmas(), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Significance(f64);

impl Significance {
    /// Largest value, which contrast without noise has: rendered images have none.
    pub const MOST: f64 = 1e6;

    /// Computes the significance of a contrast from the noise of that contrast.
    #[must_use]
    pub fn new(contrast: f64, noise: f64) -> Self {
        let ratio = if contrast > 0.0 { contrast / noise.max(0.0) } else { 0.0 };
        Self(ratio.min(Self::MOST))
    }

    /// Number of standard deviations.
    #[must_use]
    pub fn sigmas(self) -> f64 {
        self.0
    }
}

/// What a detector finds.
pub trait Detected {
    /// Contrast with the surroundings, in the detector's unit.
    fn contrast(&self) -> f64;
    /// Significance of that contrast.
    fn significance(&self) -> Significance;
}

/// Detections of an image together with the fainter candidates that were left out.
///
/// ```
/// use fabkit_calibration::significance::{Detected, Detections, Significance};
/// struct Spot(f64);
/// impl Detected for Spot {
///     fn contrast(&self) -> f64 {
///         self.0
///     }
///     fn significance(&self) -> Significance {
///         Significance::new(self.0, 0.01)
///     }
/// }
/// let found = Detections::split(vec![Spot(0.3), Spot(0.04), Spot(0.2), Spot(0.03)], |spot| {
///     spot.contrast() > 0.1 && spot.significance().sigmas() >= 6.0
/// });
/// assert_eq!((found.kept().len(), found.left_out().len()), (2, 2));
/// let (_, left_out) = found.into_parts();
/// assert_eq!(left_out.to_string(), "2 fainter spots of up to 4 % contrast were left out");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Detections<T> {
    kept: Vec<T>,
    left_out: Vec<T>,
}

impl<T: Detected> Detections<T> {
    /// Splits all candidates into those that are kept and those that are left out, each in the given order.
    #[must_use]
    pub fn split(candidates: Vec<T>, is_kept: impl Fn(&T) -> bool) -> Self {
        let (kept, left_out) = candidates.into_iter().partition(is_kept);
        Self { kept, left_out }
    }

    /// Returns the detections.
    #[must_use]
    pub fn kept(&self) -> &[T] {
        &self.kept
    }

    /// Returns the candidates that were left out.
    #[must_use]
    pub fn left_out(&self) -> &[T] {
        &self.left_out
    }

    /// Summarises what was left out.
    #[must_use]
    pub fn summary(&self) -> LeftOut {
        let contrasts = self.left_out.iter().map(Detected::contrast);
        LeftOut { count: self.left_out.len(), max_contrast: contrasts.fold(0.0, f64::max) }
    }

    /// Returns the detections together with what was left out.
    #[must_use]
    pub fn into_parts(self) -> (Vec<T>, LeftOut) {
        let left_out = self.summary();
        (self.kept, left_out)
    }
}

/// Number and contrast of candidates that were left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LeftOut {
    /// Number of candidates.
    pub count: usize,
    /// Contrast of the strongest, as a fraction.
    pub max_contrast: f64,
}

impl std::fmt::Display for LeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = 100.0 * self.max_contrast;
        match self.count {
            0 => write!(f, "no fainter spot was left out"),
            1 => write!(f, "1 fainter spot of {percent:.0} % contrast was left out"),
            n => write!(f, "{n} fainter spots of up to {percent:.0} % contrast were left out"),
        }
    }
}
