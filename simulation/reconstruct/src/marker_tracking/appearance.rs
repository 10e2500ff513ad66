//! Correlation of markers with their appearance at rest. It is needed where the edge of a contact is as dark as a
//! marker.

use fabkit_geometry::Rgb;

use super::assignment::Px;
use super::scaling::Scaling;

/// Half side of the compared patch, in marker radii.
const PATCH_RADII: f64 = 1.3;
/// Largest distance between the darkest place and the marker, relative to the distance between markers.
const SEARCH_RADIUS: f64 = 0.3;
/// Step of the coarse search; places around its best result are searched afterwards.
const STEP: isize = 2;
/// Minimum correlation with the marker at rest.
const MIN_CORRELATION: f64 = 0.5;

/// Appearance of a marker at rest.
#[derive(Clone, Debug)]
pub(super) struct Appearance {
    at: [isize; 2],
    half: isize,
    /// Pixels of each colour, row by row, with zero mean and a common norm of 1.
    looks: Vec<f32>,
}

/// A reduced colour image, relative to its local brightness at rest.
pub(super) struct NormalisedImage {
    columns: isize,
    rows: isize,
    /// Pixel values, one plane for each colour.
    values: [Vec<f32>; 3],
}

impl NormalisedImage {
    pub(super) fn new(scaling: &Scaling, values: &[f32], counts: &[Rgb]) -> Self {
        let coarse = scaling.coarse();
        let of = |k: usize| {
            let pixels = values.chunks_exact(3).zip(counts);
            pixels.map(|(rgb, counts)| rgb[k] * counts[k] as f32).collect()
        };
        let (columns, rows) = (coarse.columns as isize, coarse.rows as isize);
        Self { columns, rows, values: [of(0), of(1), of(2)] }
    }

    /// Returns the normalised patch around a pixel, as in [`Appearance::looks`]; `None` at the border, and for a uniform
    /// patch.
    fn patch(&self, [column, row]: [isize; 2], half: isize) -> Option<Vec<f32>> {
        let fits = |at: isize, most: isize| at >= half && at + half < most;
        if !fits(column, self.columns) || !fits(row, self.rows) {
            return None;
        }
        let side = (2 * half + 1) as usize;
        let mut looks = Vec::with_capacity(3 * side * side);
        for values in &self.values {
            let begin = looks.len();
            for row in row - half..=row + half {
                let first = (row * self.columns + column - half) as usize;
                looks.extend_from_slice(&values[first..first + side]);
            }
            let mean = looks[begin..].iter().sum::<f32>() / (side * side) as f32;
            looks[begin..].iter_mut().for_each(|value| *value -= mean);
        }
        // One norm for all colours keeps their relative contrast.
        let norm = looks.iter().map(|value| value * value).sum::<f32>().sqrt();
        (norm > 0.0).then(|| {
            looks.iter_mut().for_each(|value| *value /= norm);
            looks
        })
    }
}

impl Appearance {
    pub(super) fn new(
        scaling: &Scaling,
        evened: &NormalisedImage,
        at: &Px,
        radius_px: f64,
    ) -> Option<Self> {
        let coarse = scaling.coarse();
        let half = (PATCH_RADII * radius_px * coarse.per_px()).round() as isize + 1;
        let at = coarse.to_scaled(at).map(|at| at.round() as isize);
        Some(Self { at, half, looks: evened.patch(at, half)? })
    }

    /// Finds the displacement from rest, px, of the patch that correlates best, near the displacement `by_px`.
    pub(super) fn find_displacement(
        &self,
        scaling: &Scaling,
        evened: &NormalisedImage,
        by_px: &Px,
        pitch_px: f64,
    ) -> Option<Px> {
        let per_px = scaling.coarse().per_px();
        let middle = [0, 1].map(|k| self.at[k] + (by_px[k] * per_px).round() as isize);
        let reach = (SEARCH_RADIUS * pitch_px * per_px).round() as isize;
        let alike = |at: [isize; 2]| {
            // Places without a full patch get the lowest correlation.
            evened.patch(at, self.half).map_or(-1.0, |looks| {
                looks.iter().zip(&self.looks).map(|(a, b)| a * b).sum::<f32>()
            })
        };
        let best = |middle: [isize; 2], reach: isize, step: usize| {
            let along = || (-reach..=reach).step_by(step);
            let places = along().flat_map(|y| along().map(move |x| [middle[0] + x, middle[1] + y]));
            places
                .map(|at| (alike(at), at))
                .fold((-1.0, middle), |most, one| if one.0 > most.0 { one } else { most })
        };
        // A multiple of the step puts the place itself on the coarse grid.
        let reach = reach / STEP * STEP;
        let (_, coarsely) = best(middle, reach, STEP as usize);
        let (most, at) = best(coarsely, STEP - 1, 1);
        if f64::from(most) < MIN_CORRELATION {
            return None;
        }
        // The maximum of a parabola through three neighbours gives the fraction of a pixel.
        let top = |k: usize| {
            let mut beside = [at, at];
            beside[0][k] -= 1;
            beside[1][k] += 1;
            let [before, after] = beside.map(alike).map(f64::from);
            let bend = before - 2.0 * f64::from(most) + after;
            if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 }
        };
        Some([0, 1].map(|k| ((at[k] - self.at[k]) as f64 + top(k)) / per_px))
    }
}
