//! Light that goes sideways in a layer.

use rayon::prelude::*;

/// A blur reaches this many standard deviations.
const REACH: f64 = 3.0;

/// Spreads values over their neighbours as a normal distribution of so many pixels does, where `is_layer` says so: what
/// lies beside the layer neither gives nor takes. Row by row, `width` a row.
pub fn spread(values: &mut [f64], is_layer: &[bool], width: usize, sigma_px: f64) {
    let reach = (REACH * sigma_px).ceil();
    if width == 0 || !(reach >= 1.0 && sigma_px.is_finite()) {
        return;
    }
    let reach = reach as usize;
    let weights: Vec<f64> =
        (0..=reach).map(|k| (-0.5 * (k as f64 / sigma_px).powi(2)).exp()).collect();
    let height = values.len() / width;
    // Along rows, then along columns.
    for (stride, length) in [(1, width), (width, height)] {
        let before = values.to_vec();
        values.par_iter_mut().enumerate().filter(|(i, _)| is_layer[*i]).for_each(|(i, value)| {
            let at = i / stride % length;
            let (mut sum, mut all) = (0.0, 0.0);
            for to in at.saturating_sub(reach)..=(at + reach).min(length - 1) {
                let place = i + to * stride - at * stride;
                if is_layer[place] {
                    let weight = weights[to.abs_diff(at)];
                    sum += weight * before[place];
                    all += weight;
                }
            }
            *value = sum / all;
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dot_spreads_evenly_and_keeps_its_light() {
        let (width, sigma) = (61, 3.0);
        let mut values = vec![0.0; width * width];
        values[30 * width + 30] = 1.0;
        spread(&mut values, &vec![true; width * width], width, sigma);
        assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let variance: f64 =
            values.iter().enumerate().map(|(i, v)| v * ((i % width) as f64 - 30.0).powi(2)).sum();
        // Cut off at three standard deviations.
        assert!((variance.sqrt() / sigma - 1.0).abs() < 0.02, "{variance}");
        assert!((values[30 * width + 34] - values[34 * width + 30]).abs() < 1e-15);
    }

    #[test]
    fn what_is_even_stays_even_up_to_the_edge() {
        let is_layer: Vec<bool> = (0..400).map(|i| i % 20 < 12).collect();
        let mut values: Vec<f64> = is_layer.iter().map(|is| if *is { 7.0 } else { 1.0 }).collect();
        let before = values.clone();
        spread(&mut values, &is_layer, 20, 2.0);
        assert!(values.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-12));
        spread(&mut values, &is_layer, 20, 0.0);
        assert!(values.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
