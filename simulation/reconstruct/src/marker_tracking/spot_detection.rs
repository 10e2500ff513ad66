//! Detection of spots that stand out from their surroundings as markers do.

use fabkit_calibration::significance::{Detected, ImageNoise, Significance};
use fabkit_geometry::Rgb;

use super::assignment::{Px, distance};
use super::scaling::Scaling;
use crate::CapturedImage;

/// Half side of the square inside a marker, in its radii.
const WITHIN: f64 = 0.6;
/// Half side of the square around a marker, in its radii, and its limit relative to the distance to the next marker.
const AROUND: [f64; 2] = [1.8, 0.7];
/// Minimum light, relative to white, for a pixel's colour to be used.
const LEAST_LIGHT: f32 = 0.06;
/// Minimum local light, relative to the mean of the image, for markers to be visible.
const MIN_LOCAL_LIGHT: f64 = 0.5;
/// Number of iterations for a marker's centre, and reach of its weights in their widths. The centre is the mean
/// position of the excess signal, weighted by a Gaussian as wide as the marker's radius around the last centre.
const MIDDLES: usize = 5;
const BELL_REACH: f64 = 2.5;
/// Limit of that reach and of the centre's shift, relative to the distance to the next marker.
const MAX_SHIFT: f64 = 0.4;
/// Radius that a pixel adds: that of a disc with the same second moment as a square pixel.
const PIXEL_RADIUS_PX: f64 = 0.58;
/// Standard deviation of rounding to intensity steps, in steps: that of a uniform distribution.
const STEPS_NOISE: f64 = 0.29;
/// Strides of rows and of pixels in the estimation of noise.
const NOISE_ROWS: usize = 7;
const NOISE_COLUMNS: usize = 3;
/// Quartile of the absolute value of a standard normal distribution. The quartile is used instead of the median since
/// most pixels of a small image may be near a marker.
const NORMAL_QUARTER: f64 = 0.3186;

/// Signal by which a pixel indicates a marker.
#[derive(Clone, Debug)]
pub(super) enum MarkerSignal {
    /// Brightness.
    Bright,
    /// Darkness relative to the surroundings at rest, as weights of the colours for each pixel of the reduced image.
    Dark(Vec<Rgb>),
    /// Share of one colour in the light, as weights of red, green and blue for all light and for that colour.
    Share([Rgb; 2]),
}

/// Size of a marker and distance to the next one in the image, px.
#[derive(Clone, Copy, Debug)]
pub(super) struct MarkerSize {
    pub radius_px: f64,
    pub pitch_px: f64,
}

/// A spot that stands out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blob {
    pub at: Px,
    /// Excess of the mean signal inside over that around.
    pub strength: f64,
    pub significance: Significance,
}

impl Detected for Blob {
    fn contrast(&self) -> f64 {
        self.strength
    }

    fn significance(&self) -> Significance {
        self.significance
    }
}

/// Weights of the colours' noise in the signal.
#[derive(Clone, Copy, Debug)]
pub(super) struct NoiseWeights {
    weights: Rgb,
    /// True if the largest of the colours is the signal; otherwise their sum is.
    is_largest: bool,
}

impl NoiseWeights {
    /// Computes the weights from the image at rest, reduced.
    pub(super) fn new(tells: &MarkerSignal, values: &[f32], channels: usize) -> Self {
        let mean = |of: &dyn Fn(usize) -> f64, count: usize| {
            (0..count).map(of).sum::<f64>() / count.max(1) as f64
        };
        match tells {
            MarkerSignal::Bright => Self { weights: [1.0; 3], is_largest: false },
            MarkerSignal::Dark(counts) => {
                let weights = [0, 1, 2].map(|k| mean(&|i| counts[i][k], counts.len()));
                Self { weights, is_largest: true }
            }
            MarkerSignal::Share([all, one]) => {
                let pixels = values.len() / channels;
                let light = |i: usize| f64::from(dot(&values[channels * i..], all));
                let light = mean(&light, pixels).max(f64::from(LEAST_LIGHT));
                Self { weights: one.map(|weight| weight / light), is_largest: false }
            }
        }
    }

    /// Measures the noise of blocks in an image, in units of the signal.
    pub(super) fn block_noise(&self, image: &CapturedImage, grey_step: f64) -> ImageNoise {
        let channel = |k: usize| {
            let values = image.values.iter().skip(k).step_by(image.channels).copied();
            (ImageNoise::measure(values, image.size_px[0], grey_step), self.weights[k].abs())
        };
        let channels: Vec<(ImageNoise, f64)> = (0..image.channels).map(channel).collect();
        let sigma = |(noise, weight): &(ImageNoise, f64)| noise.block_sigma * weight;
        let noise = match channels.iter().max_by(|a, b| sigma(a).total_cmp(&sigma(b))) {
            Some(largest) if self.is_largest => ImageNoise::of_sum(&[*largest]),
            _ => ImageNoise::of_sum(&channels),
        };
        // The noise of pixels is measured in the signal itself.
        ImageNoise { pixel_sigma: 0.0, ..noise }
    }
}

/// Signal of an image, with its integral image.
#[derive(Debug)]
pub(super) struct SignalImage<'a> {
    scaling: &'a Scaling,
    values: Vec<f32>,
    /// Integral image: sums over all pixels above and to the left, with one more row and column.
    sums: Vec<f64>,
    /// Standard deviation of a pixel's noise.
    noise: f64,
    /// Noise of blocks of pixels, in pixels of the whole image.
    blocks: ImageNoise,
    /// True if the signal is the sum of the colours.
    is_sum: bool,
}

impl<'a> SignalImage<'a> {
    pub(super) fn new(
        scaling: &'a Scaling,
        tells: &MarkerSignal,
        values: &[f32],
        channels: usize,
        blocks: ImageNoise,
    ) -> Self {
        let values = match (tells, channels) {
            (MarkerSignal::Bright, 1) => values.to_vec(),
            (MarkerSignal::Bright, _) => {
                values.chunks_exact(3).map(|rgb| rgb.iter().sum()).collect()
            }
            (MarkerSignal::Dark(counts), 1) => {
                let pixels = values.iter().zip(counts);
                pixels.map(|(grey, counts)| -grey * counts[0] as f32).collect()
            }
            (MarkerSignal::Dark(counts), _) => {
                // The shadow of one light source is dark in one colour, a marker is dark in all.
                let dark = |(rgb, counts): (&[f32], &Rgb)| {
                    -(0..3).map(|k| rgb[k] * counts[k] as f32).fold(0.0, f32::max)
                };
                values.chunks_exact(3).zip(counts).map(dark).collect()
            }
            (MarkerSignal::Share([all, one]), _) => colour_share(values, all, one),
        };
        let noise =
            noise_sigma(&values, scaling.binned_columns()).max(STEPS_NOISE * scaling.grey_step);
        let values = scaling.interpolate(values);
        let wide = scaling.columns + 1;
        let mut sums = vec![0.0; wide * (scaling.rows + 1)];
        for row in 0..scaling.rows {
            let line = &values[row * scaling.columns..][..scaling.columns];
            let (above, own) = sums[row * wide..][..2 * wide].split_at_mut(wide);
            let mut sum = 0.0;
            for (column, value) in line.iter().enumerate() {
                sum += f64::from(*value);
                own[column + 1] = above[column + 1] + sum;
            }
        }
        let is_sum = matches!(tells, MarkerSignal::Bright);
        Self { scaling, values, sums, noise, blocks, is_sum }
    }

    /// Returns the contrast of a strength of 1, as a fraction: of white where brightness is summed over colours.
    pub(super) fn contrast_unit(&self, channels: usize) -> f64 {
        if self.is_sum { (channels as f64).recip() } else { 1.0 }
    }

    /// Returns the standard deviation of a marker's strength by noise.
    pub(super) fn noise(&self, size: MarkerSize) -> f64 {
        // Interpolated pixels have no independent noise.
        let own = self.scaling.finer as f64;
        let [inside, all] =
            self.halves(size).map(|half| ((2 * half + 1) as f64 / own).powi(2).max(1.0));
        let all = all.max(inside + 1.0);
        let areas = [inside, all - inside];
        let pixels = self.noise * areas.map(f64::recip).iter().sum::<f64>().sqrt();
        // Reduced pixels are means of several of the image.
        let areas_px = areas.map(|area| area * (self.scaling.binned * self.scaling.binned) as f64);
        pixels.hypot(self.blocks.contrast_sigma(areas_px))
    }

    /// Returns sum and number of pixels of a square with a given half side, clipped to the image.
    fn square(&self, column: isize, row: isize, half: isize) -> (f64, f64) {
        let (columns, rows) = (self.scaling.columns as isize, self.scaling.rows as isize);
        let cut =
            |at: isize, most: isize| [(at - half).clamp(0, most), (at + half + 1).clamp(0, most)];
        let ([left, right], [top, bottom]) = (cut(column, columns), cut(row, rows));
        let at = |column: isize, row: isize| self.sums[(row * (columns + 1) + column) as usize];
        let sum = at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top);
        (sum, ((right - left) * (bottom - top)) as f64)
    }

    /// Returns the half sides of the squares inside and around a marker.
    fn halves(&self, size: MarkerSize) -> [isize; 2] {
        let [radius, pitch] =
            [apparent_radius_px(size), size.pitch_px].map(|px| px * self.scaling.per_px());
        let within = (WITHIN * radius).round();
        let around = (AROUND[0] * radius + 1.0).min(AROUND[1] * pitch).round().max(within + 1.0);
        [within as isize, around as isize]
    }

    /// Returns the excess of the mean signal inside over that around, and the mean around.
    fn strength(&self, column: isize, row: isize, [within, around]: [isize; 2]) -> (f64, f64) {
        let (inner, inside) = self.square(column, row, within);
        let (outer, all) = self.square(column, row, around);
        if inside == 0.0 || all == inside {
            return (0.0, 0.0);
        }
        let ground = (outer - inner) / (all - inside);
        (inner / inside - ground, ground)
    }

    /// Finds local maxima of the strength within `reach_px` of a place, with at least the strength `least`. `noise` is
    /// that of a marker of this size.
    pub(super) fn find_maxima(
        &self,
        at: &Px,
        reach_px: f64,
        size: MarkerSize,
        [least, noise]: [f64; 2],
    ) -> Vec<Blob> {
        let halves = self.halves(size);
        let middle = self.scaling.to_scaled(at);
        let reach = reach_px * self.scaling.per_px();
        let (columns, rows) = (self.scaling.columns as isize, self.scaling.rows as isize);
        let span = |middle: f64, most: isize| {
            let end = |at: f64| (at.round() as isize).clamp(0, most);
            [end(middle - reach), end(middle + reach + 1.0)]
        };
        let ([left, right], [top, bottom]) = (span(middle[0], columns), span(middle[1], rows));
        // A wide marker stands out over several pixels: a coarse grid finds it, and a search around its maxima refines
        // them.
        let step = 1 + halves[0] / 2;
        let (wide, high) = ((right - left + step - 1) / step, (bottom - top + step - 1) / step);
        let strength = |column: isize, row: isize| self.strength(column, row, halves).0;
        let mut strengths = Vec::with_capacity((wide * high) as usize);
        for row in 0..high {
            let row = top + step * row;
            strengths.extend((0..wide).map(|column| strength(left + step * column, row)));
        }
        let mut found = Vec::new();
        for row in 0..high {
            for column in 0..wide {
                let own = strengths[(row * wide + column) as usize];
                if own < least || !is_local_maximum(&strengths, [wide, high], [column, row]) {
                    continue;
                }
                let [column, row] = [left + step * column, top + step * row];
                let finer = (-step + 1..step).flat_map(|down| {
                    (-step + 1..step).map(move |across| [column + across, row + down])
                });
                let most = finer
                    .filter(|[column, row]| {
                        (0..columns).contains(column) && (0..rows).contains(row)
                    })
                    .map(|place| (strength(place[0], place[1]), place))
                    .fold(
                        (own, [column, row]),
                        |most, one| if one.0 > most.0 { one } else { most },
                    );
                let at = self.scaling.to_image(&most.1.map(|at| at as f64));
                if distance(&at, &self.scaling.to_image(&middle)) <= reach_px {
                    let significance = Significance::new(most.0, noise);
                    found.push(Blob { at, strength: most.0, significance });
                }
            }
        }
        found
    }

    /// Computes the centre of the signal near a place.
    pub(super) fn spot_centre(&self, at: &Px, size: MarkerSize) -> Px {
        let halves = self.halves(size);
        let bell = (apparent_radius_px(size) * self.scaling.per_px()).max(0.7);
        // The reach excludes the next marker, which may be much brighter.
        let apart = size.pitch_px * self.scaling.per_px();
        let reach = (BELL_REACH * bell).min(MAX_SHIFT * apart).ceil() as isize;
        let begin = self.scaling.to_scaled(at);
        let mut middle = begin;
        let (columns, rows) = (self.scaling.columns as isize, self.scaling.rows as isize);
        let (_, ground) =
            self.strength(middle[0].round() as isize, middle[1].round() as isize, halves);
        let weigh = |from: f64, at: isize| (-0.5 * ((at as f64 - from) / bell).powi(2)).exp();
        for _ in 0..MIDDLES {
            let [column, row] = middle.map(|at| at.round() as isize);
            let (mut sum, mut weights) = ([0.0; 2], 0.0);
            let across: Vec<(isize, f64)> = ((column - reach).max(0)
                ..(column + reach + 1).min(columns))
                .map(|at| (at, weigh(middle[0], at)))
                .collect();
            for down in (row - reach).max(0)..(row + reach + 1).min(rows) {
                let by_row = weigh(middle[1], down);
                for (at, by_column) in &across {
                    let value = f64::from(self.values[(down * columns + at) as usize]);
                    let weight = by_row * by_column * (value - ground).max(0.0);
                    sum[0] += weight * *at as f64;
                    sum[1] += weight * down as f64;
                    weights += weight;
                }
            }
            if weights <= 0.0 {
                break;
            }
            middle = sum.map(|part| part / weights);
        }
        // A centre that drifts too far is rejected.
        if distance(&middle, &begin) > MAX_SHIFT * apart {
            middle = begin;
        }
        self.scaling.to_image(&middle)
    }

    /// Returns the strength of a marker at a place.
    pub(super) fn strength_at(&self, at: &Px, size: MarkerSize) -> f64 {
        let [column, row] = self.scaling.to_scaled(at).map(|at| at.round() as isize);
        self.strength(column, row, self.halves(size)).0
    }
}

/// Returns whether a value of a grid is at least as large as its neighbours; of equal ones only the first is.
fn is_local_maximum(values: &[f64], [wide, high]: [isize; 2], [column, row]: [isize; 2]) -> bool {
    let own = values[(row * wide + column) as usize];
    ((row - 1).max(0)..(row + 2).min(high)).all(|other_row| {
        ((column - 1).max(0)..(column + 2).min(wide)).all(|other| {
            let value = values[(other_row * wide + other) as usize];
            value < own || (value == own && (other_row, other) >= (row, column))
        })
    })
}

/// Estimates the standard deviation of the pixels' noise from second differences along rows, which in flat parts come
/// from noise alone.
fn noise_sigma(values: &[f32], columns: usize) -> f64 {
    let rows = values.chunks_exact(columns).step_by(NOISE_ROWS);
    let bends = rows.flat_map(|row| {
        row.windows(3)
            .map(|three| (three[0] - 2.0 * three[1] + three[2]).abs())
            .step_by(NOISE_COLUMNS)
    });
    let mut bends: Vec<f32> = bends.collect();
    let quarter = bends.len() / 4;
    if bends.is_empty() {
        return 0.0;
    }
    let bend = *bends.select_nth_unstable_by(quarter, f32::total_cmp).1;
    // The second difference of independent noise has a variance of 1 + 4 + 1 = 6.
    f64::from(bend) / (NORMAL_QUARTER * 6.0_f64.sqrt())
}

/// Returns the apparent radius of a marker, which pixels widen.
fn apparent_radius_px(size: MarkerSize) -> f64 {
    size.radius_px.hypot(PIXEL_RADIUS_PX)
}

fn dot(rgb: &[f32], counts: &Rgb) -> f32 {
    (0..3).map(|k| rgb[k] * counts[k] as f32).sum()
}

/// Returns the share of one colour in each pixel's light; the mean share where there is too little light.
fn colour_share(values: &[f32], all: &Rgb, one: &Rgb) -> Vec<f32> {
    let of = |rgb: &[f32]| {
        let light = dot(rgb, all);
        if light > LEAST_LIGHT { (dot(rgb, one) / light).clamp(0.0, 1.0) } else { f32::NAN }
    };
    let mut shares: Vec<f32> = values.chunks_exact(3).map(of).collect();
    let (mut sum, mut count) = (0.0, 0usize);
    for share in shares.iter().filter(|share| !share.is_nan()) {
        sum += f64::from(*share);
        count += 1;
    }
    let mean = if count > 0 { (sum / count as f64) as f32 } else { 0.0 };
    shares.iter_mut().filter(|share| share.is_nan()).for_each(|share| *share = mean);
    shares
}

/// Returns weights for darkness: the inverse of the mean around each pixel of the reduced image, by colour, over
/// squares with a given half side. Limited in dark regions.
pub(super) fn darkness_weights(
    scaling: &Scaling,
    values: &[f32],
    channels: usize,
    half: usize,
) -> Vec<Rgb> {
    let coarse = scaling.coarse();
    let columns = coarse.columns;
    let mut counts = vec![[0.0; 3]; columns * coarse.rows];
    for channel in 0..channels {
        let own: Vec<f32> = values.iter().skip(channel).step_by(channels).copied().collect();
        let said = SignalImage::new(&coarse, &MarkerSignal::Bright, &own, 1, ImageNoise::default());
        // In darker places, noise would look like markers.
        let all = own.iter().copied().map(f64::from).sum::<f64>() / own.len().max(1) as f64;
        let least = (MIN_LOCAL_LIGHT * all).max(f64::from(LEAST_LIGHT));
        for (i, counts) in counts.iter_mut().enumerate() {
            let (column, row) = (i % columns, i / columns);
            let (sum, count) = said.square(column as isize, row as isize, half as isize);
            let mean = sum / count.max(1.0);
            counts[channel] = mean.max(least).recip();
        }
    }
    counts
}
