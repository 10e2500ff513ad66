//! Sideways scattering of light in a layer.

use rayon::prelude::*;

/// Radius of the blur, in standard deviations.
const REACH: f64 = 3.0;

/// Gaussian blur within a layer. Pixels outside the layer neither give nor take light, and a uniform layer stays
/// uniform up to its edge.
///
/// The blur is linear: the difference of two images is blurred into the difference of the blurred images.
///
/// ```
/// use fabkit_light::LayerBlur;
/// let mut values = vec![0.0, 0.0, 9.0, 0.0, 0.0, 4.0];
/// // The last pixel is beside the layer.
/// let spread = LayerBlur::new(vec![true, true, true, true, true, false], 6, 0.5);
/// spread.apply(&mut values);
/// assert!(values[2] < 9.0 && values[1] > 0.5 && values[5] == 4.0);
/// ```
#[derive(Clone, Debug)]
pub struct LayerBlur {
    width: usize,
    /// Weight of a neighbour by its distance; empty if nothing is blurred.
    weights: Vec<f64>,
    is_layer: Vec<bool>,
    /// Reciprocal of the summed weights of all neighbours in the layer, along rows and along columns; 0 outside the
    /// layer.
    shares: [Vec<f64>; 2],
}

impl LayerBlur {
    /// Creates the blur for an image with `width` columns and a standard deviation in px.
    ///
    /// ```
    /// use fabkit_light::LayerBlur;
    ///
    /// // A standard deviation of zero leaves values alone.
    /// let mut values = [0.0, 9.0, 0.0];
    /// LayerBlur::new(vec![true; 3], 3, 0.0).apply(&mut values);
    /// assert_eq!(values, [0.0, 9.0, 0.0]);
    /// // With one of 1 px, neighbours of one row get the same share.
    /// LayerBlur::new(vec![true; 3], 3, 1.0).apply(&mut values);
    /// assert!(values[1] > values[0] && (values[0] - values[2]).abs() < 1e-12);
    /// ```
    pub fn new(is_layer: Vec<bool>, width: usize, sigma_px: f64) -> Self {
        let reach = (REACH * sigma_px).ceil();
        // The negated comparison catches NaN too.
        if width == 0 || !(reach >= 1.0 && sigma_px.is_finite()) {
            return Self { width, weights: Vec::new(), is_layer, shares: [Vec::new(), Vec::new()] };
        }
        let weights: Vec<f64> =
            (0..=reach as usize).map(|k| (-0.5 * (k as f64 / sigma_px).powi(2)).exp()).collect();
        let ones: Vec<f64> = is_layer.iter().map(|is| f64::from(u8::from(*is))).collect();
        let mut own = Self { width, weights, is_layer, shares: [Vec::new(), Vec::new()] };
        let height = ones.len() / width;
        let share = |sums: Vec<f64>| -> Vec<f64> {
            let each = sums.into_iter().zip(&own.is_layer);
            each.map(|(sum, is)| if *is { sum.recip() } else { 0.0 }).collect()
        };
        let whole = ([0, height], [0, width]);
        // If every pixel sees the layer, all rows have the same sums, and so have all columns.
        let sums = if own.is_layer.iter().all(|is| *is) {
            let row = own.blur_rows(&ones[..width.min(ones.len())], ([0, 1], [0, width]));
            let column = Self { width: 1, ..own.clone() }
                .blur_columns(&ones[..height], ([0, height], [0, 1]));
            let of_columns = column.iter().flat_map(|sum| std::iter::repeat_n(*sum, width));
            [row.repeat(height), of_columns.collect()]
        } else {
            [own.blur_rows(&ones, whole), own.blur_columns(&ones, whole)]
        };
        own.shares = sums.map(share);
        own
    }

    /// Blurs values in place, row by row. If most are zero, only the rows and columns around the others are visited.
    ///
    /// ```
    /// use fabkit_light::LayerBlur;
    ///
    /// // A uniform layer stays as it is, up to its edge: pixels beside it take no light.
    /// let blur = LayerBlur::new(vec![true, true, true, false], 4, 1.0);
    /// let mut values = [7.0, 7.0, 7.0, 0.0];
    /// blur.apply(&mut values);
    /// assert!(values[..3].iter().all(|value| (value - 7.0).abs() < 1e-12) && values[3] == 0.0);
    /// ```
    pub fn apply(&self, values: &mut [f64]) {
        let Some((rows, columns)) = self.nonzero_range(values) else { return };
        // Pixels outside the layer give no light.
        let beside = |values: &[f64]| -> Vec<f64> {
            let each = values.iter().zip(&self.is_layer);
            each.map(|(value, is)| if *is { *value } else { 0.0 }).collect()
        };
        let [of_rows, of_columns] = &self.shares;
        let mut spread = self.blur_rows(&beside(values), (rows, columns));
        spread.iter_mut().zip(of_rows).for_each(|(sum, share)| *sum *= share);
        let spread = self.blur_columns(&spread, (rows, columns));
        for row in rows[0]..rows[1] {
            for i in row * self.width + columns[0]..row * self.width + columns[1] {
                if self.is_layer[i] {
                    values[i] = spread[i] * of_columns[i];
                }
            }
        }
    }

    /// Returns the ranges of rows and columns that non-zero values reach; `None` if all values are zero.
    fn nonzero_range(&self, values: &[f64]) -> Option<([usize; 2], [usize; 2])> {
        let reach = self.weights.len().checked_sub(1)?;
        let (mut rows, mut columns) = ([usize::MAX, 0], [usize::MAX, 0]);
        for (row, of_row) in values.chunks(self.width).enumerate() {
            // Differences of two images are mostly exact zeros.
            let is_some = |value: &f64| *value != 0.0;
            let Some(first) = of_row.iter().position(is_some) else { continue };
            let last = of_row.iter().rposition(is_some).unwrap_or(first);
            rows = [rows[0].min(row), row + 1];
            columns = [columns[0].min(first), columns[1].max(last + 1)];
        }
        let height = values.len() / self.width;
        let grown = |[first, end]: [usize; 2], most: usize| {
            [first.saturating_sub(reach), (end + reach).min(most)]
        };
        (rows[0] < rows[1]).then(|| (grown(rows, height), grown(columns, self.width)))
    }

    /// Sums the weighted neighbours in the same row.
    fn blur_rows(&self, values: &[f64], (rows, columns): ([usize; 2], [usize; 2])) -> Vec<f64> {
        let mut sums = vec![0.0; values.len()];
        let each = sums.par_chunks_mut(self.width).zip(values.par_chunks(self.width)).enumerate();
        each.filter(|(row, _)| (rows[0]..rows[1]).contains(row)).for_each(|(_, (to, from))| {
            let [first, end] = columns;
            for (k, weight) in self.weights.iter().enumerate() {
                // Adds the neighbour on the right, then that on the left unless both are the same pixel.
                add_weighted(
                    &mut to[first..end.min(self.width.saturating_sub(k)).max(first)],
                    &from[(first + k).min(self.width)..],
                    *weight,
                );
                if k > 0 {
                    let first = first.max(k);
                    add_weighted(&mut to[first.min(end)..end], &from[first - k..], *weight);
                }
            }
        });
        sums
    }

    /// Sums the weighted neighbours in the same column.
    fn blur_columns(&self, values: &[f64], (rows, columns): ([usize; 2], [usize; 2])) -> Vec<f64> {
        let mut sums = vec![0.0; values.len()];
        let (width, height) = (self.width, values.len() / self.width);
        let each = sums.par_chunks_mut(width).enumerate();
        each.filter(|(row, _)| (rows[0]..rows[1]).contains(row)).for_each(|(row, to)| {
            let [first, end] = columns;
            let reach = self.weights.len() - 1;
            for other in row.saturating_sub(reach)..(row + reach + 1).min(height) {
                let from = &values[other * width + first..other * width + end];
                add_weighted(&mut to[first..end], from, self.weights[other.abs_diff(row)]);
            }
        });
        sums
    }
}

/// Adds weighted values.
fn add_weighted(to: &mut [f64], from: &[f64], weight: f64) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dot_spreads_evenly_and_keeps_its_light() {
        let (width, sigma) = (61, 3.0);
        let mut values = vec![0.0; width * width];
        values[30 * width + 30] = 1.0;
        LayerBlur::new(vec![true; width * width], width, sigma).apply(&mut values);
        assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let variance: f64 =
            values.iter().enumerate().map(|(i, v)| v * ((i % width) as f64 - 30.0).powi(2)).sum();
        // The tolerance allows for the cut-off at three standard deviations.
        assert!((variance.sqrt() / sigma - 1.0).abs() < 0.02, "{variance}");
        assert!((values[30 * width + 34] - values[34 * width + 30]).abs() < 1e-15);
    }

    #[test]
    fn uniform_layers_stay_uniform_up_to_the_edge() {
        let is_layer: Vec<bool> = (0..400).map(|i| i % 20 < 12).collect();
        let mut values: Vec<f64> = is_layer.iter().map(|is| if *is { 7.0 } else { 1.0 }).collect();
        let before = values.clone();
        LayerBlur::new(is_layer.clone(), 20, 2.0).apply(&mut values);
        assert!(values.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-12));
        LayerBlur::new(is_layer, 20, 0.0).apply(&mut values);
        assert!(values.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn the_result_is_the_weighted_mean_of_neighbours_in_the_layer() {
        // Computed directly from the definition, pixel by pixel, with holes and an edge.
        let (width, height, sigma) = (40, 30, 1.7);
        let is_layer: Vec<bool> =
            (0..width * height).map(|i| (i * 7) % 11 > 2 && i % width < 36).collect();
        let before: Vec<f64> = (0..width * height)
            .map(|i| if (200..700).contains(&i) { ((i * 37) % 101) as f64 } else { 0.0 })
            .collect();
        let reach = 6i64;
        let pass = |values: &[f64], way: (i64, i64)| -> Vec<f64> {
            (0..width * height)
                .map(|i| {
                    let (mut sum, mut all) = (0.0, 0.0);
                    for k in -reach..=reach {
                        let (x, y) =
                            ((i % width) as i64 + k * way.0, (i / width) as i64 + k * way.1);
                        let is_in =
                            (0..width as i64).contains(&x) && (0..height as i64).contains(&y);
                        let at = (y * width as i64 + x) as usize;
                        if is_in && is_layer[at] {
                            let weight = (-0.5 * (k as f64 / sigma).powi(2)).exp();
                            sum += weight * values[at];
                            all += weight;
                        }
                    }
                    if is_layer[i] { sum / all } else { values[i] }
                })
                .collect()
        };
        let expected = pass(&pass(&before, (1, 0)), (0, 1));
        let mut found = before.clone();
        LayerBlur::new(is_layer, width, sigma).apply(&mut found);
        assert!(expected.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
