//! Partial compensation of the lateral spread of light in a layer.

/// Reach of the blur in standard deviations.
const REACH: f64 = 3.0;
/// Largest reach of the blur, px: it must not exceed the neighbouring tiles.
const MOST_REACH: usize = TILE_PX;
/// Side of the tiles, px. Only tiles with contact are sharpened, since the rest is noise.
const TILE_PX: usize = 16;

/// Sharpener for a Gaussian spread, one step of van Cittert's method (1931): the difference between an image and its
/// blurred version is added. More steps would amplify noise.
#[derive(Clone, Debug)]
pub(super) struct Sharpener {
    size_px: [usize; 2],
    /// Weights of the blur from the farthest pixel before to the farthest after; their sum is 1.
    weights: Vec<f32>,
}

impl Sharpener {
    /// Creates a sharpener for a standard deviation, px; 0 changes nothing.
    pub fn new(size_px: [usize; 2], sigma_px: f64) -> Self {
        let reach = (REACH * sigma_px).ceil();
        let reach = if reach.is_finite() { (reach as usize).min(MOST_REACH) } else { 0 };
        let offset = |i: usize| i as f64 - reach as f64;
        let weight =
            |i: usize| if reach == 0 { 1.0 } else { (-0.5 * (offset(i) / sigma_px).powi(2)).exp() };
        let all: Vec<f64> = (0..=2 * reach).map(weight).collect();
        let sum: f64 = all.iter().sum();
        Self { size_px, weights: all.into_iter().map(|weight| (weight / sum) as f32).collect() }
    }

    /// Sharpens values, row by row, in tiles with contact; beside them, the correction falls to 0 over one tile. Values
    /// beyond the image count as 0.
    pub fn apply(&self, values: &mut [f32], contact: &[bool]) {
        let tiles = ContactTiles::near(self.size_px, contact);
        let [width, height] = self.size_px;
        let reach = self.weights.len() / 2;
        if reach == 0 || !tiles.is_touched.contains(&true) {
            return;
        }
        // Rows are blurred in runs of tiles, within a buffer padded by the reach, so that the inner loop needs no
        // bounds. The reach is one tile at most.
        let mut along = vec![0.0f32; values.len()];
        let mut row_values = vec![0.0f32; width + 2 * reach];
        for row in 0..height {
            for [from, to] in tiles.runs(row, 2) {
                let [first, last] = [from.saturating_sub(reach), (to + reach).min(width)];
                row_values[reach + first..reach + last]
                    .copy_from_slice(&values[row * width..][first..last]);
                let sums = &mut along[row * width..][from..to];
                for (k, weight) in self.weights.iter().enumerate() {
                    for (sum, value) in sums.iter_mut().zip(&row_values[from + k..]) {
                        *sum += weight * value;
                    }
                }
            }
        }
        let mut sums = vec![0.0f32; width];
        for row in 0..height {
            for [from, to] in tiles.runs(row, 1) {
                sums[from..to].fill(0.0);
                for (k, weight) in self.weights.iter().enumerate() {
                    let Some(other) = (row + k).checked_sub(reach).filter(|row| *row < height)
                    else {
                        continue;
                    };
                    let there = &along[other * width..][from..to];
                    for (sum, value) in sums[from..to].iter_mut().zip(there) {
                        *sum += weight * value;
                    }
                }
                let here = &mut values[row * width..][from..to];
                let parts = tiles.parts(row, [from, to]);
                for ((value, spread), part) in here.iter_mut().zip(&sums[from..to]).zip(parts) {
                    *value += part * (*value - spread);
                }
            }
        }
    }
}

/// Tiles with contact, and those around them.
struct ContactTiles {
    width: usize,
    across: usize,
    down: usize,
    is_touched: Vec<bool>,
}

impl ContactTiles {
    fn near(size_px: [usize; 2], contact: &[bool]) -> Self {
        let [across, down] = size_px.map(|px| px.div_ceil(TILE_PX));
        let mut is_touched = vec![false; across * down];
        for (row, contacts) in contact.chunks(size_px[0]).enumerate() {
            for (column, contacts) in contacts.chunks(TILE_PX).enumerate() {
                is_touched[row / TILE_PX * across + column] |= contacts.contains(&true);
            }
        }
        Self { width: size_px[0], across, down, is_touched }
    }

    /// Returns whether a tile with contact lies in a range of tiles, from first to last (exclusive).
    fn is_touched_in(&self, columns: [usize; 2], rows: [usize; 2]) -> bool {
        let columns = columns[0]..columns[1].min(self.across);
        (rows[0]..rows[1].min(self.down))
            .any(|row| columns.clone().any(|column| self.is_touched[row * self.across + column]))
    }

    /// Returns the runs of tiles in a pixel row that have contact in a tile up to one column and `rows` rows away, as
    /// first and last column (exclusive).
    fn runs(&self, row: usize, rows: usize) -> Vec<[usize; 2]> {
        let row = row / TILE_PX;
        let rows = [row.saturating_sub(rows), row + rows + 1];
        let mut runs: Vec<[usize; 2]> = Vec::new();
        for tile in 0..self.across {
            if !self.is_touched_in([tile.saturating_sub(1), tile + 2], rows) {
                continue;
            }
            let (from, to) = (tile * TILE_PX, ((tile + 1) * TILE_PX).min(self.width));
            match runs.last_mut() {
                Some([_, last]) if *last == from => *last = to,
                _ => runs.push([from, to]),
            }
        }
        runs
    }

    /// Returns the part of the correction that each pixel of a run gets. It is interpolated between the corners of tiles: 1
    /// at those of a tile with contact and 0 at all others, so that it is 1 in such a tile and steps nowhere.
    fn parts(&self, row: usize, [from, to]: [usize; 2]) -> impl Iterator<Item = f32> {
        let corner = |column: usize, row: usize| {
            let around = [column, row].map(|at| [at.saturating_sub(1), at + 1]);
            f32::from(u8::from(self.is_touched_in(around[0], around[1])))
        };
        let tile_row = row / TILE_PX;
        let down = (row % TILE_PX) as f32 / TILE_PX as f32;
        let first = from / TILE_PX;
        let edge = |column: usize| {
            (1.0 - down) * corner(column, tile_row) + down * corner(column, tile_row + 1)
        };
        let edges: Vec<f32> = (first..=to.div_ceil(TILE_PX)).map(edge).collect();
        (from..to).map(move |column| {
            let (tile, across) = (column / TILE_PX - first, column % TILE_PX);
            let across = across as f32 / TILE_PX as f32;
            (1.0 - across) * edges[tile] + across * edges[tile + 1]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A peak that was spread by a Gaussian becomes narrower and higher, and nothing changes far from contact.
    #[test]
    fn sharpening_narrows_a_blurred_peak() {
        let (size, sigma) = ([200, 120], 4.0f64);
        let at = |i: usize, sigma: f64| {
            let [x, y] = [(i % 200) as f64 - 90.0, (i / 200) as f64 - 60.0];
            (-0.5 * (x * x + y * y) / (sigma * sigma)).exp() as f32
        };
        // A normal distribution of 6 px, spread by 4: of 7.2 px, and lower by (6 / 7.2)^2.
        let wide = (36.0 + sigma * sigma).sqrt();
        let mut seen: Vec<f32> =
            (0..200 * 120).map(|i| at(i, wide) * (36.0 / (wide * wide)) as f32).collect();
        let contact: Vec<bool> = seen.iter().map(|value| *value > 0.2).collect();
        let truth: Vec<f32> = (0..200 * 120).map(|i| at(i, 6.0)).collect();
        let off = |seen: &[f32]| {
            seen.iter().zip(&truth).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>()
        };
        let (before, first) = (off(&seen), seen[0]);
        Sharpener::new(size, sigma).apply(&mut seen, &contact);
        assert!(off(&seen) < 0.5 * before, "{} {before}", off(&seen));
        assert_eq!(seen[0], first);
        // By hand, in the middle: once more than what spreading again leaves, (36 / 68)^1 of the height.
        let expected = 2.0 * 36.0 / 52.0 - 36.0 / 68.0;
        assert!(
            (f64::from(seen[60 * 200 + 90]) - expected).abs() < 0.01,
            "{}",
            seen[60 * 200 + 90]
        );
    }

    /// A wide ball leaves a smooth loss of light; sharpening leaves it smooth, at the borders of tiles, too.
    #[test]
    fn nothing_steps_beside_contact() {
        let (size, wide) = ([240, 200], 30.0f64);
        let at = |i: usize| {
            let [x, y] = [(i % 240) as f64 - 121.0, (i / 240) as f64 - 97.0];
            (20.0 * (-0.5 * (x * x + y * y) / (wide * wide)).exp()) as f32
        };
        let mut seen: Vec<f32> = (0..240 * 200).map(at).collect();
        let contact: Vec<bool> = seen.iter().map(|value| *value > 8.0).collect();
        Sharpener::new(size, 5.0).apply(&mut seen, &contact);
        let mut most = 0.0f32;
        for row in 2..198 {
            for column in 2..238 {
                let value = |by: [isize; 2]| seen[((row + by[1]) * 240 + column + by[0]) as usize];
                for [x, y] in [[1, 0], [0, 1]] {
                    let bend = value([x, y]) - 2.0 * value([0, 0]) + value([-x, -y]);
                    most = most.max(bend.abs());
                }
            }
        }
        // The Gaussian bends by 20 / 30^2 = 0.022 at most. The correction is half the variance of the blur times the bend in
        // both directions, 25 * 0.022 = 0.55 in the middle and half of that beside contact; that part falls to 0 over 16 px,
        // and its slope of 0.55 / 16 = 0.035 begins and ends at once.
        assert!(most < 0.022 + 0.035 + 0.01, "{most}");
    }

    #[test]
    fn without_spread_or_contact_nothing_changes() {
        let values: Vec<f32> = (0..64 * 64).map(|i| (i % 7) as f32).collect();
        for (sigma, touched) in [(0.0, true), (3.0, false), (f64::NAN, true)] {
            let mut same = values.clone();
            Sharpener::new([64, 64], sigma).apply(&mut same, &vec![touched; 64 * 64]);
            assert_eq!(same, values);
        }
    }
}
