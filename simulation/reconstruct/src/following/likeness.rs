//! Marks that look like themselves: where a contact's own edge is as dark as they are, what is darkest is not enough.

use fabkit_geometry::Rgb;

use super::matching::Px;
use super::scaling::Scaling;

/// Half of the side of what is compared, of a mark's radius.
const WIDE: f64 = 1.3;
/// As far as what is darkest may lie beside a mark, as a part of the distance between marks.
const BESIDE: f64 = 0.3;
/// Every so many-th place is looked at first, and those around the best after that.
const STEP: isize = 2;
/// What goes together less than this with the mark at rest is something else.
const LEAST: f64 = 0.5;

/// What a mark looks like at rest.
#[derive(Clone, Debug)]
pub(super) struct Likeness {
    at: [isize; 2],
    half: isize,
    /// Pixels of each colour, row by row, without their mean; the squares of all together are 1.
    looks: Vec<f32>,
}

/// A shrunken picture in colours, each over what there is of it at rest.
pub(super) struct Evened {
    columns: isize,
    rows: isize,
    /// One colour after the other.
    values: [Vec<f32>; 3],
}

impl Evened {
    pub(super) fn new(scaling: &Scaling, values: &[f32], counts: &[Rgb]) -> Self {
        let coarse = scaling.coarse();
        let of = |k: usize| {
            let pixels = values.chunks_exact(3).zip(counts);
            pixels.map(|(rgb, counts)| rgb[k] * counts[k] as f32).collect()
        };
        let (columns, rows) = (coarse.columns as isize, coarse.rows as isize);
        Self { columns, rows, values: [of(0), of(1), of(2)] }
    }

    /// What lies around a pixel, as in [`Likeness::looks`]; nothing at the edge, or where all is the same.
    fn looks(&self, [column, row]: [isize; 2], half: isize) -> Option<Vec<f32>> {
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
        let norm = looks.iter().map(|value| value * value).sum::<f32>().sqrt();
        (norm > 0.0).then(|| {
            looks.iter_mut().for_each(|value| *value /= norm);
            looks
        })
    }
}

impl Likeness {
    pub(super) fn new(scaling: &Scaling, evened: &Evened, at: &Px, radius_px: f64) -> Option<Self> {
        let coarse = scaling.coarse();
        let half = (WIDE * radius_px * coarse.per_px()).round() as isize + 1;
        let at = coarse.within(at).map(|at| at.round() as isize);
        Some(Self { at, half, looks: evened.looks(at, half)? })
    }

    /// How far from where it was at rest what looks like it lies, px, around a place that is so far from there.
    pub(super) fn moved(
        &self,
        scaling: &Scaling,
        evened: &Evened,
        by_px: &Px,
        pitch_px: f64,
    ) -> Option<Px> {
        let per_px = scaling.coarse().per_px();
        let middle = [0, 1].map(|k| self.at[k] + (by_px[k] * per_px).round() as isize);
        let reach = (BESIDE * pitch_px * per_px).round() as isize;
        let alike = |at: [isize; 2]| {
            evened.looks(at, self.half).map_or(-1.0, |looks| {
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
        // From the place itself, so that it is among those that are looked at.
        let reach = reach / STEP * STEP;
        let (_, coarsely) = best(middle, reach, STEP as usize);
        let (most, at) = best(coarsely, STEP - 1, 1);
        if f64::from(most) < LEAST {
            return None;
        }
        // Between pixels: the top of the parabola through a place and its neighbours.
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
