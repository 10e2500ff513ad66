//! Scaling of images to the resolution that marker tracking needs.

use super::assignment::Px;
use crate::CapturedImage;

/// Radius of the narrowest marker in the scaled image, px, if the image has that many.
const RADIUS_PX: f64 = 3.0;
/// Largest reduction of images.
const MOST_BINNED: usize = 4;
/// Radius of markers below which the image is interpolated, px, and number of interpolated pixels for each.
const NARROW_PX: f64 = 1.2;
const FINER: usize = 3;

/// Scaling between images and the pixels that are evaluated.
#[derive(Clone, Debug)]
pub(super) struct Scaling {
    pub size_px: [usize; 2],
    /// Number of pixels along a side that are averaged to one.
    pub binned: usize,
    /// Number of interpolated pixels for each averaged one, along a side.
    pub finer: usize,
    pub columns: usize,
    pub rows: usize,
    /// Distance of the intensities that the chip resolves, relative to white.
    pub grey_step: f64,
}

impl Scaling {
    pub(super) fn new(size_px: [usize; 2], narrowest_px: f64, grey_bits: u32) -> Self {
        let binned = ((narrowest_px / RADIUS_PX) as usize).clamp(1, MOST_BINNED);
        let finer = if narrowest_px < NARROW_PX { FINER } else { 1 };
        // Incomplete bins at the right and lower border are dropped.
        let [columns, rows] = size_px.map(|px| px / binned * finer);
        // Stored images have eight bits, even if the chip has more.
        let grey_step = 1.0 / f64::from((1u32 << grey_bits.min(8)) - 1);
        Self { size_px, binned, finer, columns, rows, grey_step }
    }

    /// Returns the scaling without interpolated pixels.
    pub(super) fn coarse(&self) -> Self {
        let (columns, rows) = (self.columns / self.finer, self.rows / self.finer);
        Self { finer: 1, columns, rows, ..self.clone() }
    }

    pub(super) fn binned_columns(&self) -> usize {
        self.columns / self.finer
    }

    /// Returns the number of scaled pixels per image pixel, along a side.
    pub(super) fn per_px(&self) -> f64 {
        self.finer as f64 / self.binned as f64
    }

    /// Converts a position in the image to the scaled image. Pixel centres have integer coordinates, hence the halves.
    pub(super) fn to_scaled(&self, at: &Px) -> Px {
        at.map(|px| (px + 0.5) * self.per_px() - 0.5)
    }

    /// Converts a position in the scaled image to the image.
    pub(super) fn to_image(&self, at: &Px) -> Px {
        at.map(|px| (px + 0.5) / self.per_px() - 0.5)
    }

    /// Returns the averaged pixels, with the channels of each pixel together.
    pub(super) fn values(&self, image: &CapturedImage) -> Vec<f32> {
        let (channels, binned) = (image.channels, self.binned);
        if binned == 1 {
            return image.values.clone();
        }
        let [columns, rows] = self.size_px.map(|px| px / binned);
        let mut values = vec![0.0; columns * rows * channels];
        let line = columns * channels;
        for row in 0..rows * binned {
            let from = &image.values[row * self.size_px[0] * channels..];
            let to = &mut values[row / binned * line..][..line];
            let (from, to) = (from.chunks_exact(binned * channels), to.chunks_exact_mut(channels));
            for (from, to) in from.zip(to) {
                for pixel in from.chunks_exact(channels) {
                    to.iter_mut().zip(pixel).for_each(|(to, from)| *to += from);
                }
            }
        }
        let part = 1.0 / (binned * binned) as f32;
        values.iter_mut().for_each(|value| *value *= part);
        values
    }

    /// Interpolates averaged pixels linearly.
    pub(super) fn interpolate(&self, values: Vec<f32>) -> Vec<f32> {
        if self.finer == 1 {
            return values;
        }
        let [columns, rows] = [self.columns, self.rows].map(|count| count / self.finer);
        let between = |i: usize, count: usize| {
            // Positions refer to pixel centres; the border repeats its outermost pixels.
            let at = ((i as f64 + 0.5) / self.finer as f64 - 0.5).clamp(0.0, (count - 1) as f64);
            (at as usize, (at as usize + 1).min(count - 1), at.fract() as f32)
        };
        let across: Vec<_> = (0..self.columns).map(|column| between(column, columns)).collect();
        let mut finer = Vec::with_capacity(self.columns * self.rows);
        for row in 0..self.rows {
            let (above, below, y) = between(row, rows);
            let [above, below] = [above, below].map(|row| &values[row * columns..][..columns]);
            finer.extend(across.iter().map(|&(left, right, x)| {
                let mix = |row: &[f32]| (1.0 - x) * row[left] + x * row[right];
                (1.0 - y) * mix(above) + y * mix(below)
            }));
        }
        finer
    }
}
