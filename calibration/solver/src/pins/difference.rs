//! How much each pixel changed, whatever the light did.

use super::{DetectionOptions, Polarity};
use crate::image::GreyImage;

/// Brightness from which a pixel counts as saturated: 8-bit cameras clip softly.
const SATURATED: f32 = 0.98;
/// Added to both pictures before dividing: below it, a ratio is noise.
const DARK_FLOOR: f32 = 0.06;
/// A pixel darker than this part of the lit surface belongs to the housing.
const LIT: f32 = 0.3;
/// Smallest part of the picture that must show a lit, unsaturated surface.
const MIN_USABLE: f64 = 0.02;
/// Standard deviation of the smoothing, px of a picture with 480 px on its shorter side.
const BLUR_PX: f32 = 1.0;
/// Cells across the shorter side over which the background is estimated.
const CELLS: usize = 60;
/// Reach of the median in cells: 9 of 60 cells is five times a usual mark.
const MEDIAN_REACH: usize = 4;

/// Why no pins can be looked for in a pair of pictures.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DetectionError {
    /// The pictures are not from one camera.
    #[error("{pressed:?} px, but the reference has {reference:?} px")]
    Size {
        /// Width and height of the pressed picture, px.
        pressed: [usize; 2],
        /// Width and height of the reference, px.
        reference: [usize; 2],
    },
    /// The reference was given twice.
    #[error("the picture is the reference itself: every pixel is the same")]
    Identical,
    /// Nothing to see.
    #[error(
        "only {usable_percent:.1} % of the picture shows a lit surface that is not saturated ({saturated_percent:.1} % is saturated); at least 2 % is needed"
    )]
    Exposure {
        /// Pixels that can be compared.
        usable_percent: f64,
        /// Pixels at the sensor's limit in either picture.
        saturated_percent: f64,
    },
}

/// How much each pixel changed.
pub(super) struct Difference {
    pub width: usize,
    pub height: usize,
    /// Logarithm of the ratio of brightness above its local background; contacts are positive.
    pub change: Vec<f32>,
    /// Where the change means something: lit and not saturated.
    pub usable: Vec<bool>,
    /// Standard deviation of `change` where nothing touches.
    pub noise: f64,
    /// The same before smoothing, where neighbours are independent.
    pub raw_noise: f64,
    /// Shorter side of the whole picture, px.
    pub shorter_px: usize,
    /// Share of what is lit that is saturated, 0 to 1.
    pub saturated: f64,
}

impl Difference {
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
        let (usable, saturated) = usable(reference, pressed, blur_px)?;
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
        let noise = spread(change.iter().zip(&usable).filter(|(_, u)| **u).map(|(c, _)| *c));
        // White noise smoothed by a Gaussian of s px keeps 1 / (2 s sqrt(pi)) of its deviation.
        let raw_noise = noise * 2.0 * f64::from(blur_px) * std::f64::consts::PI.sqrt();
        Ok(Self { width, height, change, usable, noise, raw_noise, shorter_px, saturated })
    }
}

/// Lit in the reference, saturated in neither picture nor within the blur of a saturated pixel; and the share of what is
/// lit that is saturated.
fn usable(
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
    let threshold = LIT * median(&mut lit).unwrap_or(1.0);
    let reach = (2.0 * blur_px).ceil() as usize;
    let clipped_count = clipped.iter().filter(|clipped| **clipped).count();
    let mut usable: Vec<bool> = reference.values().iter().map(|v| *v > threshold).collect();
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

/// Side of the cells over which the background of a picture is estimated, px, from its shorter side: parts of a picture that
/// begin at a multiple of it have the same cells.
pub fn background_cell_px(shorter_px: usize) -> usize {
    (shorter_px / CELLS).max(2)
}

/// Takes away the median of the neighbourhood, estimated on cells and interpolated between them.
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

/// Standard deviation from the median of absolute deviations, which marks do not disturb.
fn spread(values: impl Iterator<Item = f32>) -> f64 {
    let mut deviations: Vec<f32> = values.map(f32::abs).collect();
    1.4826 * f64::from(median(&mut deviations).unwrap_or(0.0))
}
