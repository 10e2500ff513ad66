//! Detection of the ends of columns of dyed liquid.
//!
//! A column's end only moves along its channel, so its row identifies it. The dye transmits red: along the channel, the
//! excess of red over green rises where the liquid begins. The end is where it reaches half of its value within the
//! liquid.

use fabkit_geometry::{LiquidColumn, Point3, Vector3};

use fabkit_calibration::significance::{LeftOut, Significance};

use super::assignment::{Px, add, distance};
use super::{TrackedMarker, TrackedMarkers};
use crate::CapturedImage;

/// Distance of a profile's points, px.
const STEP_PX: f64 = 0.5;
/// Reach of the search for the end to either side, in distances between channels.
const REACH: f64 = 2.0;
/// Width over which a profile is averaged, relative to the channel's width.
const PROFILE_WIDTH: f64 = 0.5;
/// Largest distance of a channel from its expected place, relative to the distance to the next one.
const MAX_SIDE_SHIFT: f64 = 0.4;
/// Minimum excess of red over green within dyed liquid.
const LEAST_DYE: f64 = 0.1;
/// Minimum significance of that excess.
const MIN_SIGMAS: f64 = 6.0;

#[derive(Clone, Debug)]
pub(super) struct ColumnTracker {
    ends: Vec<Option<ColumnEnd>>,
}

/// Expected end of a column.
#[derive(Clone, Debug)]
struct ColumnEnd {
    at: Px,
    /// Unit direction in the image in which the end moves outwards.
    way: Px,
    width_px: f64,
    reach_px: f64,
    /// Distance to the next channel, px.
    pitch_px: f64,
    way_mm: Vector3<f64>,
    px_per_mm: f64,
}

impl ColumnTracker {
    /// Returns the points whose pixels [`Self::new`] needs.
    pub(super) fn reference_points(columns: &[LiquidColumn]) -> Vec<Option<Point3<f64>>> {
        columns
            .iter()
            .flat_map(|column| [Some(column.end), Some(column.end + column.direction)])
            .collect()
    }

    pub(super) fn new(columns: &[LiquidColumn], pixels: &[Option<Px>]) -> Self {
        let at = |i: usize| Some((pixels[2 * i]?, pixels[2 * i + 1]?));
        let end = |(i, column): (usize, &LiquidColumn)| {
            let (own, further) = at(i)?;
            let px_per_mm = distance(&own, &further);
            let others = (0..columns.len()).filter(|j| *j != i).filter_map(|j| Some(at(j)?.0));
            let pitch_px = others.map(|other| distance(&own, &other)).fold(f64::INFINITY, f64::min);
            let width_px = column.width_mm * px_per_mm;
            // A single column has no neighbour; its width gives the scale.
            let pitch_px = pitch_px.min(4.0 * width_px);
            let way = [0, 1].map(|k| (further[k] - own[k]) / px_per_mm);
            let (way_mm, reach_px) = (column.direction, REACH * pitch_px);
            Some(ColumnEnd { at: own, way, width_px, reach_px, pitch_px, way_mm, px_per_mm })
        };
        Self { ends: columns.iter().enumerate().map(end).collect() }
    }

    pub(super) fn drawn_px(&self) -> Vec<Option<Px>> {
        self.ends.iter().map(|end| Some(end.as_ref()?.at)).collect()
    }

    pub(super) fn mm_per_px(&self) -> Vec<Option<[Vector3<f64>; 2]>> {
        let of = |end: &ColumnEnd| end.way.map(|part| part / end.px_per_mm * end.way_mm);
        self.ends.iter().map(|end| end.as_ref().map(of)).collect()
    }

    /// Finds the ends. A column whose dye does not stand out counts as left out.
    pub(super) fn find_ends(&self, image: &CapturedImage) -> TrackedMarkers {
        let mut left_out = LeftOut::default();
        let mut locate = |end: &Option<ColumnEnd>| {
            let (found, dye) = end.as_ref()?.locate(image);
            if found.is_none() && dye > 0.0 {
                left_out.count += 1;
                left_out.max_contrast = left_out.max_contrast.max(dye);
            }
            found
        };
        let markers = self.ends.iter().map(&mut locate).collect();
        TrackedMarkers { markers, left_out }
    }
}

impl ColumnEnd {
    /// Locates the end. Also returns the excess of red within the liquid.
    fn locate(&self, image: &CapturedImage) -> (Option<TrackedMarker>, f64) {
        let steps = (self.reach_px / STEP_PX).ceil() as isize;
        let across = [-self.way[1], self.way[0]];
        let beside = (MAX_SIDE_SHIFT * self.pitch_px).floor() as isize;
        // The camera may be slightly off its design, so the channel is searched sideways: it has most dye.
        let dye_at = |off: isize| {
            let inside =
                (-steps..-steps / 2).map(|step| self.red_excess(image, step, off as f64, &across));
            inside.sum::<f64>()
        };
        let offs: Vec<(isize, f64)> = (-beside..=beside).map(|off| (off, dye_at(off))).collect();
        let most = offs.iter().map(|(_, dye)| *dye).fold(0.0, f64::max);
        // Centre of the offsets with more than half of the most dye.
        let (sum, weights) = offs
            .iter()
            .filter(|(_, dye)| *dye > 0.5 * most)
            .fold((0.0, 0.0), |(sum, weights), (off, dye)| {
                (sum + dye * *off as f64, weights + dye)
            });
        if weights <= 0.0 {
            return (None, 0.0);
        }
        let middle = sum / weights;
        let half_width = (0.5 * PROFILE_WIDTH * self.width_px).floor().max(0.0) as isize;
        let profile: Vec<f64> = (-steps..=steps)
            .map(|step| {
                let offs = -half_width..=half_width;
                let many = (2 * half_width + 1) as f64;
                offs.map(|off| self.red_excess(image, step, middle + off as f64, &across))
                    .sum::<f64>()
                    / many
            })
            .collect();
        // The first quarter of the profile lies well within the liquid.
        let mut inside: Vec<f64> = profile[..profile.len() / 4].to_vec();
        let level = super::median(&mut inside).unwrap_or(0.0);
        let significance = Significance::new(level, profile_sigma(&profile));
        if level < LEAST_DYE || significance.sigmas() < MIN_SIGMAS {
            return (None, level);
        }
        // The first fall below half, from within the liquid outwards, interpolated between two points.
        let half = 0.5 * level;
        let last = profile.iter().position(|dye| *dye < half).filter(|last| *last > 0);
        let Some(last) = last else { return (None, level) };
        let part = (profile[last - 1] - half) / (profile[last - 1] - profile[last]);
        let along_px = ((last - 1) as f64 + part - steps as f64) * STEP_PX;
        let off = [0, 1].map(|k| along_px * self.way[k] + middle * across[k]);
        (Some(TrackedMarker { px: add(&self.at, &off), significance }), level)
    }

    /// Returns the excess of red over green, interpolated linearly; 0 outside the image.
    fn red_excess(&self, image: &CapturedImage, step: isize, off_px: f64, across: &Px) -> f64 {
        let along_px = step as f64 * STEP_PX;
        let at = [0, 1].map(|k| self.at[k] + along_px * self.way[k] + off_px * across[k]);
        let [width, height] = image.size_px;
        let (left, top) = (at[0].floor(), at[1].floor());
        if left < 0.0 || top < 0.0 || left + 1.0 >= width as f64 || top + 1.0 >= height as f64 {
            return 0.0;
        }
        let (x, y) = (at[0] - left, at[1] - top);
        let value = |column: usize, row: usize| {
            let pixel = &image.values[3 * (row * width + column)..];
            f64::from(pixel[0] - pixel[1])
        };
        let (column, row) = (left as usize, top as usize);
        (1.0 - y) * ((1.0 - x) * value(column, row) + x * value(column + 1, row))
            + y * ((1.0 - x) * value(column, row + 1) + x * value(column + 1, row + 1))
    }
}

/// Estimates the noise of a profile's points from second differences, of which most lie where it is even.
fn profile_sigma(profile: &[f64]) -> f64 {
    let bends = profile.windows(3).map(|three| (three[0] - 2.0 * three[1] + three[2]).abs());
    // 1.4826 / sqrt(6): median of absolute values to standard deviation, for a variance of 1 + 4 + 1.
    0.605 * super::median(&mut bends.collect::<Vec<_>>()).unwrap_or(0.0)
}
