//! Means of images over cells, and their similarity under exchanged colours and turns.

use fabkit_geometry::Rgb;

use crate::CapturedImage;

/// Number of columns of cells. Drawn light varies over millimetres, and a cell averages noise and marks.
const COLUMNS: u32 = 48;
/// Similarity of a pattern with itself after a change from which the change cannot be seen. Between the largest of
/// changes that can be told apart in built-in sensors (0.78) and the smallest of those that cannot (0.99).
const INDISTINGUISHABLE: f64 = 0.9;
/// Differences of similarity up to which changes count as equally good: what units differ by among themselves.
const EQUALLY_GOOD: f64 = 0.03;

/// Mean values of cells, row by row, each with red, green and blue (three times the same for grey images).
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub size: [usize; 2],
    pub values: Vec<Rgb>,
}

/// Order of colours and turn that are applied to an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rearrangement {
    colors: [usize; 3],
    /// Whether rows and columns are exchanged first, and then columns and rows reversed.
    is_transposed: bool,
    is_reversed: [bool; 2],
}

/// The change that fits best.
pub(super) struct BestFit {
    pub as_given: f64,
    /// Best change that can be told from the image as it is, with its equals; `None` if there is none.
    pub best: Option<(f64, Vec<Rearrangement>)>,
    /// Whether orders of colours, and turns, can be told apart at all.
    pub tells_colors: bool,
    pub tells_turns: bool,
}

/// Returns the number of columns and rows of cells of an image.
pub(super) fn grid_size([width, height]: [u32; 2]) -> [u32; 2] {
    let columns = COLUMNS.min(width).max(1);
    let rows = (f64::from(columns) * f64::from(height) / f64::from(width.max(1))).round() as u32;
    [columns, rows.clamp(1, height.max(1))]
}

impl Cells {
    /// Averages an image over cells. Values are 0 to 1.
    pub fn from_image(image: &CapturedImage) -> Self {
        let [width, height] = image.size_px;
        let size = grid_size(image.size_px.map(|px| px as u32)).map(|count| count as usize);
        let [columns, rows] = size;
        let (mut sums, mut counts) =
            (vec![[0.0f64; 3]; columns * rows], vec![0.0f64; columns * rows]);
        for (i, pixel) in image.values.chunks_exact(image.channels.max(1)).enumerate() {
            let cell = i / width * rows / height.max(1) * columns + i % width * columns / width;
            let (Some(sum), Some(count)) = (sums.get_mut(cell), counts.get_mut(cell)) else {
                break;
            };
            // Values that are no numbers are reported elsewhere and must not spoil the means.
            let value = |k: usize| f64::from(pixel[k.min(pixel.len() - 1)]);
            if (0..3).all(|k| value(k).is_finite()) {
                (0..3).for_each(|k| sum[k] += value(k));
                *count += 1.0;
            }
        }
        let values =
            sums.iter().zip(&counts).map(|(sum, count)| sum.map(|sum| sum / count.max(1.0)));
        Self { size, values: values.collect() }
    }

    /// Returns the luminance of cells without colours.
    pub fn to_grey(&self) -> Self {
        let grey = |rgb: &Rgb| [0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; 3];
        Self { size: self.size, values: self.values.iter().map(grey).collect() }
    }

    /// Returns the value of a cell after a change.
    fn rearranged(&self, cell: usize, change: &Rearrangement) -> Rgb {
        let [columns, rows] = self.size;
        let mut at = [cell % columns, cell / columns];
        if change.is_transposed {
            at.reverse();
        }
        let [x, y] = [0, 1]
            .map(|k| if change.is_reversed[k] { [columns, rows][k] - 1 - at[k] } else { at[k] });
        let value = self.values[y * columns + x];
        change.colors.map(|k| value[k])
    }

    /// Returns the correlation with another image's cells after a change, over the cells of `among`. The mean of each
    /// colour is removed, since exposure and white balance differ between units.
    fn similarity(&self, other: &Self, change: &Rearrangement, among: &[bool]) -> f64 {
        let pairs: Vec<[Rgb; 2]> = (0..self.values.len())
            .filter(|cell| among[*cell])
            .map(|cell| [self.values[cell], other.rearranged(cell, change)])
            .collect();
        let mut means = [[0.0; 3]; 2];
        for pair in &pairs {
            (0..6).for_each(|k| means[k / 3][k % 3] += pair[k / 3][k % 3] / pairs.len() as f64);
        }
        let [mut both, mut squares] = [0.0, 0.0].map(|zero| [zero; 2]);
        for pair in &pairs {
            for k in 0..3 {
                let [a, b] = [0, 1].map(|of| pair[of][k] - means[of][k]);
                both[0] += a * b;
                squares[0] += a * a;
                squares[1] += b * b;
            }
        }
        let scale = (squares[0] * squares[1]).sqrt();
        // An even image resembles nothing.
        if scale > 0.0 { both[0] / scale } else { 0.0 }
    }

    /// Finds the change after which `other` resembles these cells best.
    pub fn find_best_fit(&self, other: &Self, among: &[bool]) -> BestFit {
        let changes = Rearrangement::all(self.size, self.has_colors() && other.has_colors());
        let as_given = self.similarity(other, &changes[0], among);
        let visible: Vec<&Rearrangement> = changes[1..]
            .iter()
            .filter(|change| self.similarity(self, change, among) < INDISTINGUISHABLE)
            .collect();
        let scored: Vec<(f64, Rearrangement)> = visible
            .iter()
            .map(|change| (self.similarity(other, change, among), **change))
            .collect();
        let best = scored.iter().map(|(score, _)| *score).max_by(f64::total_cmp);
        BestFit {
            as_given,
            best: best.map(|best| {
                let equal = scored.iter().filter(|(score, _)| *score > best - EQUALLY_GOOD);
                (best, equal.map(|(_, change)| *change).collect())
            }),
            tells_colors: visible.iter().any(|change| change.colors != [0, 1, 2]),
            tells_turns: visible.iter().any(|change| change.colors == [0, 1, 2]),
        }
    }

    fn has_colors(&self) -> bool {
        self.values.iter().any(|[r, g, b]| r != g || g != b)
    }
}

impl Rearrangement {
    /// Lists all changes; the first changes nothing.
    fn all([columns, rows]: [usize; 2], is_colored: bool) -> Vec<Self> {
        const COLORS: [[usize; 3]; 6] =
            [[0, 1, 2], [2, 1, 0], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1]];
        let orders = if is_colored { &COLORS[..] } else { &COLORS[..1] };
        // Images that are not square would have another size.
        let transpositions = if columns == rows { &[false, true][..] } else { &[false][..] };
        let mut all = Vec::new();
        for colors in orders {
            for is_transposed in transpositions {
                for is_reversed in [[false, false], [true, true], [true, false], [false, true]] {
                    all.push(Self { colors: *colors, is_transposed: *is_transposed, is_reversed });
                }
            }
        }
        all
    }

    /// Returns the change in words: what has to be done to the image.
    pub fn words(&self) -> String {
        let colors = match self.colors {
            [0, 1, 2] => None,
            [2, 1, 0] => Some("with red and blue exchanged (BGR)"),
            [0, 2, 1] => Some("with green and blue exchanged"),
            [1, 0, 2] => Some("with red and green exchanged"),
            _ => Some("with all colours exchanged"),
        };
        let turn = match (self.is_transposed, self.is_reversed) {
            (false, [false, false]) => None,
            (false, [true, true]) => Some("turned by 180 degrees"),
            (false, [true, false]) => Some("mirrored left to right"),
            (false, [false, true]) => Some("mirrored top to bottom"),
            (true, [false, false] | [true, true]) => Some("mirrored at a diagonal"),
            (true, _) => Some("turned by 90 degrees"),
        };
        let parts: Vec<&str> = [turn, colors].into_iter().flatten().collect();
        parts.join(" and ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red from the left, green from the top, blue from the right: mirrored, red and blue change places.
    fn lamps() -> Cells {
        let value = |i: usize| {
            let [x, y] = [(i % 12) as f64 / 11.0, (i / 12) as f64 / 8.0];
            [(1.0 - x).powi(2), (1.0 - y).powi(2), x * x]
        };
        Cells { size: [12, 9], values: (0..108).map(value).collect() }
    }

    #[test]
    fn best_fit_names_what_was_done_to_an_image() {
        let (drawn, among) = (lamps(), vec![true; 108]);
        let fit = drawn.find_best_fit(&drawn, &among);
        assert!(fit.tells_colors && fit.tells_turns && (fit.as_given - 1.0).abs() < 1e-12);
        assert!(fit.best.is_some_and(|(best, _)| best < INDISTINGUISHABLE));
        for change in Rearrangement::all([12, 9], true) {
            // All of these changes undo themselves, cycles of three colours apart.
            if matches!(change.colors, [1, 2, 0] | [2, 0, 1]) {
                continue;
            }
            let values = (0..108).map(|cell| drawn.rearranged(cell, &change)).collect();
            let fit = drawn.find_best_fit(&Cells { size: [12, 9], values }, &among);
            let is_visible = drawn.similarity(&drawn, &change, &among) < INDISTINGUISHABLE;
            assert_eq!(is_visible, fit.as_given < INDISTINGUISHABLE, "{change:?}");
            if let Some((best, changes)) = fit.best.filter(|_| is_visible) {
                assert!(best > 1.0 - 1e-9 && changes.contains(&change), "{change:?}");
            }
        }
        // Symmetric lamps: an image that is mirrored and has red and blue exchanged is the same image.
        let mirrored =
            Rearrangement { colors: [2, 1, 0], is_transposed: false, is_reversed: [true, false] };
        assert!(drawn.similarity(&drawn, &mirrored, &among) > 1.0 - 1e-9);
    }

    #[test]
    fn light_that_is_the_same_from_all_sides_tells_no_turns() {
        let value = |i: usize| {
            let [x, y] = [(i % 9) as f64 - 4.0, (i / 9) as f64 - 4.0];
            [1.0 - 0.01 * (x * x + y * y); 3]
        };
        let round = Cells { size: [9, 9], values: (0..81).map(value).collect() };
        let fit = round.find_best_fit(&round, &[true; 81]);
        assert!(!fit.tells_colors && !fit.tells_turns && fit.best.is_none());
    }

    #[test]
    fn cells_are_means() {
        let values = (0..96 * 72).map(|i| if i % 2 == 0 { 0.2 } else { 0.4 }).collect();
        let cells = Cells::from_image(&CapturedImage { size_px: [96, 72], channels: 1, values });
        assert_eq!(cells.size, [48, 36]);
        assert!(cells.values.iter().flatten().all(|value| (value - 0.3).abs() < 1e-6));
    }
}
