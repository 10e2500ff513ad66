//! Connected regions that changed, and the centre of each.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Point2, Vector2};

use super::difference::ImageDifference;
use super::{Detection, DetectionOptions, PinMark, RejectionReason};
use crate::significance::{Detections, Significance};

/// Smallest significance of a mark: independent noise reaches 6 standard deviations once in a thousand million pixels.
const MIN_SIGMAS: f64 = 6.0;
/// Smallest contrast of a mark, relative to the strongest change of the image. Pins of one press are alike: the faintest
/// of 15 published captures of R-Tac0 has 0.55 of the strongest, the faintest of 63 on 9DTact's board 0.76; edges and
/// strained places beside pins stay below 0.25.
const LEAST_OF_STRONGEST: f64 = 1.0 / 3.0;
/// Smallest contrast of a change that is counted as left out, relative to the smallest of any mark.
const LEAST_LEFT_OUT: f64 = 0.5;
/// Fraction of a mark's own contrast above which its pixels define the centre. It is relative, so that a deep and a
/// light press of the same pin have the same centre.
const CENTRE_LEVEL: f32 = 0.5;
/// Largest ratio of length to width of a pin's mark; beyond, it is an edge.
const MAX_ELONGATION: f64 = 3.0;
/// Largest ratio of length to width of a mark that is cut by the housing.
const MAX_CUT_ELONGATION: f64 = 4.5;
/// Largest hidden fraction of the outline: beyond, the centre is unknown.
const MAX_HIDDEN: f64 = 0.6;
/// Hidden fraction of the outline up to which nothing is missing: the blur of an edge touches the mark.
const MIN_HIDDEN: f64 = 0.08;
/// Standard deviation of the centre, in diameters, of a mark whose outline is all hidden.
const HIDDEN_SIGMA: f64 = 0.3;
/// Smallest standard deviation of a centre, px, because pixels are not points.
const SIGMA_FLOOR_PX: f64 = 0.02;

/// Finds the marks of pins, and the changes that are not pins.
pub(super) fn find(difference: &ImageDifference, options: &DetectionOptions) -> Detection {
    let side = difference.shorter_side_px as f64;
    let diameters_px = [options.min_diameter * side, options.max_diameter * side];
    let usable = || difference.change.iter().zip(&difference.usable).filter(|(_, usable)| **usable);
    let strongest = usable().map(|(change, _)| f64::from(*change)).fold(0.0, f64::max);
    let min_contrast = options
        .min_contrast
        .max(options.certain_contrast.min(LEAST_OF_STRONGEST * strongest))
        .max(MIN_SIGMAS * difference.contrast_noise);
    // Below, a change cannot be told from noise, so that there is nothing to count.
    let seed =
        (LEAST_LEFT_OUT * options.min_contrast).max(MIN_SIGMAS * difference.contrast_noise) as f32;
    let mut visited = vec![false; difference.change.len()];
    let mut marks = Vec::new();
    let mut rejected = Vec::new();
    // From the strongest down: the first pixel of a mark in this order is its peak.
    let mut peaks: Vec<usize> = (0..difference.change.len())
        .filter(|i| difference.usable[*i] && difference.change[*i] >= seed)
        .collect();
    peaks.sort_by(|a, b| difference.change[*b].total_cmp(&difference.change[*a]).then(a.cmp(b)));
    for peak in peaks {
        if visited[peak] {
            continue;
        }
        let level = CENTRE_LEVEL * difference.change[peak];
        let region = grow_region(difference, peak, level);
        // Shoulders of a mark that has been measured are not marks of their own.
        let fresh = region.pixels.iter().all(|i| !visited[*i]);
        region.pixels.iter().for_each(|i| visited[*i] = true);
        if !fresh {
            continue;
        }
        match measure(difference, &region, level, diameters_px) {
            Ok(mark) => marks.push(mark),
            // What is fainter than a mark is no reason to doubt a capture.
            Err(reason) if f64::from(difference.change[peak]) >= min_contrast => {
                rejected.push((at(difference, peak), reason));
            }
            Err(_) => {}
        }
    }
    // Roughly the volume of the mark: contrast times area.
    let strength = |mark: &PinMark| mark.contrast * mark.diameter_px.powi(2);
    marks.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
    // The comparison is that of the seeds: contrasts are computed in single precision.
    let marks = Detections::split(marks, |mark| mark.contrast as f32 >= min_contrast as f32);
    Detection { marks, rejected, noise: difference.noise, saturated_fraction: difference.saturated }
}

struct Region {
    pixels: Vec<usize>,
    /// Number of steps from the region to a usable pixel below the level.
    open_steps: usize,
    /// Number of steps to an unusable pixel or over the border.
    hidden_steps: usize,
}

/// Collects all usable pixels above the level that are connected with the peak by sides.
fn grow_region(difference: &ImageDifference, peak: usize, level: f32) -> Region {
    let (width, height) = (difference.width, difference.height);
    let mut inside = std::collections::BTreeSet::from([peak]);
    let mut pixels = vec![peak];
    let (mut open_steps, mut hidden_steps) = (0, 0);
    let mut next = 0;
    while let Some(&i) = pixels.get(next) {
        next += 1;
        let (x, y) = (i % width, i / width);
        let neighbours = [
            (x > 0).then(|| i - 1),
            (x + 1 < width).then_some(i + 1),
            (y > 0).then(|| i - width),
            (y + 1 < height).then_some(i + width),
        ];
        for neighbour in neighbours {
            match neighbour.filter(|j| difference.usable[*j]) {
                None => hidden_steps += 1,
                Some(j) if difference.change[j] < level => open_steps += 1,
                Some(j) => {
                    if inside.insert(j) {
                        pixels.push(j);
                    }
                }
            }
        }
    }
    Region { pixels, open_steps, hidden_steps }
}

/// Measures the mark of a region, or returns the reason why it is not a pin's.
fn measure(
    difference: &ImageDifference,
    region: &Region,
    level: f32,
    [min_px, max_px]: [f64; 2],
) -> Result<PinMark, RejectionReason> {
    let diameter_px = (region.pixels.len() as f64 * 4.0 / PI).sqrt();
    if diameter_px < min_px {
        return Err(RejectionReason::TooSmall);
    }
    if diameter_px > max_px {
        return Err(RejectionReason::TooLarge);
    }
    let hidden_outline =
        region.hidden_steps as f64 / (region.hidden_steps + region.open_steps) as f64;
    if hidden_outline > MAX_HIDDEN {
        return Err(RejectionReason::Hidden);
    }
    let (mut sum, mut first, mut second) = (0.0, Vector2::zeros(), Matrix2::zeros());
    let (mut area_first, mut area_second) = (Vector2::zeros(), Matrix2::zeros());
    let origin = at(difference, region.pixels[0]);
    for &i in &region.pixels {
        // Weights fall to 0 at the region's edge, so that pixels entering or leaving it do not shift the centre.
        let weight = f64::from(difference.change[i] - level);
        let offset = at(difference, i) - origin;
        sum += weight;
        first += weight * offset;
        second += weight * offset * offset.transpose();
        area_first += offset;
        area_second += offset * offset.transpose();
    }
    let centre = first / sum;
    let count = region.pixels.len() as f64;
    let area_centre = area_first / count;
    let shape = area_second / count - area_centre * area_centre.transpose();
    let axes = shape.symmetric_eigenvalues();
    // 1/12 is the variance of a single row of pixels.
    let elongation = (axes.max() / axes.min().max(1.0 / 12.0)).sqrt();
    let limit = if hidden_outline > MIN_HIDDEN { MAX_CUT_ELONGATION } else { MAX_ELONGATION };
    if elongation > limit {
        return Err(RejectionReason::Elongated);
    }
    // c = sum w x / sum w: independent noise s in each w moves it by s sqrt(sum (x - c)^2) / sum w.
    let unweighted = area_second - count * (2.0 * area_centre * centre.transpose())
        + count * centre * centre.transpose();
    let lever_px = (unweighted.trace() / 2.0).max(0.0).sqrt();
    let noise_px = difference.raw_noise * lever_px / sum;
    let hidden = if hidden_outline > MIN_HIDDEN { hidden_outline } else { 0.0 };
    let hidden_px = HIDDEN_SIGMA * hidden * diameter_px;
    let sigma_px = (noise_px.powi(2) + hidden_px.powi(2) + SIGMA_FLOOR_PX.powi(2)).sqrt();
    let contrast = f64::from(level / CENTRE_LEVEL);
    let significance = Significance::new(contrast, difference.contrast_noise);
    let pixel = origin + centre;
    Ok(PinMark { pixel, sigma_px, contrast, significance, diameter_px, hidden_outline })
}

fn at(difference: &ImageDifference, i: usize) -> Point2<f64> {
    Point2::new((i % difference.width) as f64, (i / difference.width) as f64)
}
