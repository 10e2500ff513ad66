//! Partial compensation of the lateral spread of light in a layer.

/// Reach of the blur in standard deviations.
const REACH: f64 = 3.0;
/// Largest reach of the blur, px: it must not exceed the neighbouring tiles.
const MOST_REACH: usize = TILE_PX;
/// Side of the tiles, px. Only tiles with contact and their neighbours are sharpened, since the rest is noise.
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

    /// Sharpens values, row by row, in tiles with contact and their neighbours. Values beyond these tiles count as 0.
    pub fn apply(&self, values: &mut [f32], contact: &[bool]) {
        let tiles = ContactTiles::near(self.size_px, contact);
        let [width, height] = self.size_px;
        let reach = self.weights.len() / 2;
        if reach == 0 || !tiles.is_near.contains(&true) {
            return;
        }
        // Rows are blurred in runs of tiles, within a buffer padded by the reach, so that the inner loop needs no
        // bounds.
        let mut along = vec![0.0f32; values.len()];
        let mut row_values = vec![0.0f32; width + 2 * reach];
        for row in 0..height {
            for [from, to] in tiles.runs(row) {
                row_values[reach + from..reach + to]
                    .copy_from_slice(&values[row * width..][from..to]);
                // Pixels beside the run count as 0; columns that need them lie in tiles for which this is the rule
                // anyway.
                let sums = &mut along[row * width..][from..to];
                for (k, weight) in self.weights.iter().enumerate() {
                    for (sum, value) in sums.iter_mut().zip(&row_values[from + k..]) {
                        *sum += weight * value;
                    }
                }
                row_values[reach + from..reach + to].fill(0.0);
            }
        }
        let mut sums = vec![0.0f32; width];
        for row in 0..height {
            for [from, to] in tiles.runs(row) {
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
                for (value, spread) in here.iter_mut().zip(&sums[from..to]) {
                    *value += *value - spread;
                }
            }
        }
    }
}

/// Tiles that have contact or a neighbour with contact.
struct ContactTiles {
    width: usize,
    across: usize,
    is_near: Vec<bool>,
}

impl ContactTiles {
    fn near(size_px: [usize; 2], contact: &[bool]) -> Self {
        let [across, down] = size_px.map(|px| px.div_ceil(TILE_PX));
        let mut touched = vec![false; across * down];
        for (row, contacts) in contact.chunks(size_px[0]).enumerate() {
            for (column, contacts) in contacts.chunks(TILE_PX).enumerate() {
                touched[row / TILE_PX * across + column] |= contacts.contains(&true);
            }
        }
        let beside = |tile: usize| {
            let [column, row] = [tile % across, tile / across];
            let rows = row.saturating_sub(1)..=(row + 1).min(down - 1);
            let columns = column.saturating_sub(1)..=(column + 1).min(across - 1);
            rows.flat_map(|row| columns.clone().map(move |column| row * across + column))
                .any(|tile| touched[tile])
        };
        let is_near = (0..touched.len()).map(beside).collect();
        Self { width: size_px[0], across, is_near }
    }

    /// Returns the runs of such tiles in a pixel row, as first and last column (exclusive).
    fn runs(&self, row: usize) -> Vec<[usize; 2]> {
        let tiles = &self.is_near[row / TILE_PX * self.across..][..self.across];
        let mut runs: Vec<[usize; 2]> = Vec::new();
        for (tile, _) in tiles.iter().enumerate().filter(|(_, is_near)| **is_near) {
            let (from, to) = (tile * TILE_PX, ((tile + 1) * TILE_PX).min(self.width));
            match runs.last_mut() {
                Some([_, last]) if *last == from => *last = to,
                _ => runs.push([from, to]),
            }
        }
        runs
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
