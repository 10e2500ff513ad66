//! Change of each pixel between two images, independent of the illumination.

use super::{DetectionOptions, Polarity};
use crate::image::GreyImage;
use crate::significance::ImageNoise;

/// Smallest intensity of a saturated pixel, where white is 1: 8-bit cameras clip softly.
const SATURATED: f32 = 0.98;
/// Intensity added to both images before dividing: below it, a ratio is noise.
const DARK_FLOOR: f32 = 0.06;
/// Smallest intensity of the lit surface, as a fraction of its median: darker pixels belong to the housing.
const LIT: f32 = 0.3;
/// Smallest fraction of the image that must show a lit, unsaturated surface.
const MIN_USABLE: f64 = 0.02;
/// Standard deviation of the smoothing, px, for an image with 480 px on its shorter side.
const BLUR_PX: f32 = 1.0;
/// Number of cells across the shorter side for the estimate of the background.
const BACKGROUND_CELLS: usize = 60;
/// Radius of the median, in cells: 9 of 60 cells is five times a usual mark.
const MEDIAN_REACH: usize = 4;

/// Reason why a pair of images cannot be searched for pins.
///
/// ```
/// use fabkit_calibration::image::GreyImage;
/// use fabkit_calibration::pin_detection::{DetectionError, DetectionOptions, detect};
/// let grey = |value: f32| GreyImage::new(128, 96, vec![value; 128 * 96]).unwrap();
/// let refused = |a, b| detect(&grey(a), &grey(b), &DetectionOptions::default()).unwrap_err();
/// assert_eq!(refused(0.5, 0.5), DetectionError::Identical);
/// // White shows nothing of the surface.
/// let white = DetectionError::Exposure { usable_percent: 0.0, saturated_percent: 100.0 };
/// assert_eq!(refused(0.5, 1.0), white);
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DetectionError {
    /// The images have different sizes, so that they are not from one camera.
    #[error("{pressed:?} px, but the reference has {reference:?} px")]
    Size {
        /// Width and height of the image with contact, px.
        pressed: [usize; 2],
        /// Width and height of the reference, px.
        reference: [usize; 2],
    },
    /// The image with contact is the reference itself.
    #[error("the image is the reference itself: every pixel is the same")]
    Identical,
    /// Too little of the image shows a lit, unsaturated surface.
    #[error(
        "only {usable_percent:.1} % of the image shows a lit surface that is not saturated ({saturated_percent:.1} % is saturated); at least 2 % is needed"
    )]
    Exposure {
        /// Percentage of pixels that can be compared.
        usable_percent: f64,
        /// Percentage of pixels at the image sensor's limit in either image.
        saturated_percent: f64,
    },
}

/// Change of each pixel between the reference and the image with contact.
pub(super) struct ImageDifference {
    pub width: usize,
    pub height: usize,
    /// Logarithm of the ratio of intensities minus its local background; contacts are positive.
    pub change: Vec<f32>,
    /// True where the change is meaningful: lit and not saturated.
    pub usable: Vec<bool>,
    /// Standard deviation of `change` where nothing touches.
    pub noise: f64,
    /// Noise of a mark's contrast: `noise`, or that of the pixels and blocks of the two images if it is larger. Where most
    /// of two images is equal, as in smooth JPEG, the scatter of their difference says nothing.
    pub contrast_noise: f64,
    /// Standard deviation before smoothing, where neighbours are independent.
    pub raw_noise: f64,
    /// Shorter side of the whole image, px.
    pub shorter_side_px: usize,
    /// Fraction of lit pixels that are saturated, 0 to 1.
    pub saturated: f64,
}

impl ImageDifference {
    /// Computes the change of each pixel, and its noise.
    pub fn new(
        reference: &GreyImage,
        pressed: &GreyImage,
        options: &DetectionOptions,
    ) -> Result<Self, DetectionError> {
        let size = |image: &GreyImage| [image.width_px(), image.height_px()];
        if size(reference) != size(pressed) {
            return Err(DetectionError::Size {
                pressed: size(pressed),
                reference: size(reference),
            });
        }
        if reference == pressed {
            return Err(DetectionError::Identical);
        }
        let [width, height] = size(reference);
        let shorter_px = options.part_of_px.map_or(width.min(height), |px| px as usize);
        let blur_px = BLUR_PX * (shorter_px as f32 / 480.0).max(0.7);
        let (usable, saturated) = find_usable_pixels(reference, pressed, blur_px)?;
        let (smooth_reference, smooth_pressed) =
            (reference.blurred(blur_px), pressed.blurred(blur_px));
        let sign = match options.polarity {
            Polarity::Darker => 1.0,
            Polarity::Brighter => -1.0,
        };
        let pairs = smooth_reference.values().iter().zip(smooth_pressed.values());
        let mut change: Vec<f32> =
            pairs.map(|(r, p)| sign * ((r + DARK_FLOOR) / (p + DARK_FLOOR)).ln()).collect();
        subtract_background(&mut change, &usable, [width, height], background_cell_px(shorter_px));
        let noise = robust_sigma(change.iter().zip(&usable).filter(|(_, u)| **u).map(|(c, _)| *c));
        let pixel_noise = contrast_noise(reference, pressed, &usable, blur_px);
        // White noise smoothed by a Gaussian of s px keeps 1 / (2 s sqrt(pi)) of its deviation.
        let raw_noise = noise * 2.0 * f64::from(blur_px) * std::f64::consts::PI.sqrt();
        Ok(Self {
            width,
            height,
            change,
            usable,
            noise,
            contrast_noise: noise.max(pixel_noise),
            raw_noise,
            shorter_side_px: shorter_px,
            saturated,
        })
    }
}

/// Computes the noise of the smoothed logarithm of the ratio from the noise of the pixels and blocks of each image. Its
/// surroundings are so wide that they add none.
fn contrast_noise(
    reference: &GreyImage,
    pressed: &GreyImage,
    usable: &[bool],
    blur_px: f32,
) -> f64 {
    // A Gaussian keeps as much noise as the mean of this many pixels.
    let area_px = 4.0 * std::f64::consts::PI * f64::from(blur_px).powi(2);
    let variance = |image: &GreyImage| {
        let values = image.values();
        let lit = values.iter().zip(usable).filter(|(_, usable)| **usable);
        let (sum, count) =
            lit.fold((0.0, 0usize), |(sum, n), (value, _)| (sum + f64::from(*value), n + 1));
        let mean = sum / count.max(1) as f64 + f64::from(DARK_FLOOR);
        // Rendered images have no noise, and are not rounded to whole steps.
        let noise = ImageNoise::measure(values.iter().copied(), image.width_px(), 0.0);
        (noise.contrast_sigma([area_px, f64::INFINITY]) / mean).powi(2)
    };
    (variance(reference) + variance(pressed)).sqrt()
}

/// Finds the pixels that are lit in the reference and neither saturated in an image nor within the blur of a saturated
/// pixel. Also returns the fraction of lit pixels that are saturated.
fn find_usable_pixels(
    reference: &GreyImage,
    pressed: &GreyImage,
    blur_px: f32,
) -> Result<(Vec<bool>, f64), DetectionError> {
    let (width, height) = (reference.width_px(), reference.height_px());
    let pairs = reference.values().iter().zip(pressed.values());
    let clipped: Vec<bool> = pairs.map(|(r, p)| r.max(*p) >= SATURATED).collect();
    let mut lit: Vec<f32> = reference
        .values()
        .iter()
        .zip(&clipped)
        .filter(|(v, c)| **v > DARK_FLOOR && !**c)
        .map(|(v, _)| *v)
        .collect();
    // The median intensity of the lit surface is robust against reflections and dark borders.
    let threshold = LIT * median(&mut lit).unwrap_or(1.0);
    let reach = (2.0 * blur_px).ceil() as usize;
    let clipped_count = clipped.iter().filter(|clipped| **clipped).count();
    let mut usable: Vec<bool> = reference.values().iter().map(|v| *v > threshold).collect();
    // Saturated pixels count as lit even if only the second image is saturated there.
    let lit_count = usable.iter().zip(&clipped).filter(|(lit, clipped)| **lit || **clipped).count();
    for (i, _) in clipped.iter().enumerate().filter(|(_, clipped)| **clipped) {
        let (x, y) = (i % width, i / width);
        for row in y.saturating_sub(reach)..(y + reach + 1).min(height) {
            let columns = x.saturating_sub(reach)..(x + reach + 1).min(width);
            usable[row * width..][columns].fill(false);
        }
    }
    let percent =
        |flags: &[bool]| 100.0 * flags.iter().filter(|f| **f).count() as f64 / flags.len() as f64;
    let usable_percent = percent(&usable);
    if usable_percent < 100.0 * MIN_USABLE {
        let saturated_percent = percent(&clipped);
        return Err(DetectionError::Exposure { usable_percent, saturated_percent });
    }
    Ok((usable, clipped_count as f64 / lit_count.max(1) as f64))
}

/// Returns the side of the background's cells, px, from the image's shorter side. A part of an image that begins at a
/// multiple of it has the same cells as the whole.
pub fn background_cell_px(shorter_px: usize) -> usize {
    (shorter_px / BACKGROUND_CELLS).max(2)
}

/// Subtracts the median of the neighbourhood, estimated on cells and interpolated between them.
fn subtract_background(
    change: &mut [f32],
    usable: &[bool],
    [width, height]: [usize; 2],
    cell: usize,
) {
    let (columns, rows) = (width.div_ceil(cell), height.div_ceil(cell));
    let mut medians: Vec<Option<f32>> = Vec::with_capacity(columns * rows);
    let mut values = Vec::new();
    for i in 0..columns * rows {
        let (x0, y0) = (i % columns * cell, i / columns * cell);
        values.clear();
        for y in y0..(y0 + cell).min(height) {
            let inside = y * width + x0..y * width + (x0 + cell).min(width);
            values.extend(inside.filter(|i| usable[*i]).map(|i| change[i]));
        }
        medians.push(median(&mut values));
    }
    let around = |c: usize, r: usize, values: &mut Vec<f32>| {
        values.clear();
        for row in r.saturating_sub(MEDIAN_REACH)..(r + MEDIAN_REACH + 1).min(rows) {
            let span = c.saturating_sub(MEDIAN_REACH)..(c + MEDIAN_REACH + 1).min(columns);
            values.extend(medians[row * columns..][span].iter().flatten());
        }
        median(values).unwrap_or(0.0)
    };
    let background: Vec<f32> =
        (0..columns * rows).map(|i| around(i % columns, i / columns, &mut values)).collect();
    let place = |pixel: usize, cells: usize| {
        let at = (pixel as f32 + 0.5) / cell as f32 - 0.5;
        let low = (at.max(0.0) as usize).min(cells - 1);
        // Between the centres of the outermost cells and the border the background is constant.
        (low, (low + 1).min(cells - 1), (at - low as f32).clamp(0.0, 1.0))
    };
    for (y, row) in change.chunks_exact_mut(width).enumerate() {
        let (r0, r1, v) = place(y, rows);
        for (x, value) in row.iter_mut().enumerate() {
            let (c0, c1, u) = place(x, columns);
            let along = |r: usize| {
                background[r * columns + c0] * (1.0 - u) + background[r * columns + c1] * u
            };
            *value -= along(r0) * (1.0 - v) + along(r1) * v;
        }
    }
}

fn median(values: &mut [f32]) -> Option<f32> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// Estimates the standard deviation from the median of absolute values, which marks do not disturb. 1.4826 is its ratio
/// to the standard deviation of a normal distribution.
fn robust_sigma(values: impl Iterator<Item = f32>) -> f64 {
    let mut deviations: Vec<f32> = values.map(f32::abs).collect();
    1.4826 * f64::from(median(&mut deviations).unwrap_or(0.0))
}
