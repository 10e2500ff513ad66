//! Repeatability of pins, a lower bound for the held-out errors of every model.

use nalgebra::Vector2;

use crate::model::Observation;

/// Scatter of the marks of the same pin, pushed home in several captures, about their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinScatter {
    /// Root mean square distance from the mean, px, both coordinates together, corrected for the means being estimated
    /// from the same pins. No model can have smaller residuals on new captures.
    pub rms_px: f64,
    /// Degrees of freedom: number of pins less the number of holes that they are in.
    pub degrees_of_freedom: usize,
}

/// Computes the scatter over all holes with pins in two or more captures; `None` if there is no such hole.
pub fn pin_scatter(observations: &[Observation]) -> Option<PinScatter> {
    let mut sorted: Vec<&Observation> = observations.iter().collect();
    // Pins of different length in one hole are different pins.
    let key = |o: &Observation| (o.contact.hole, o.contact.contact_in_sensor_mm);
    let bits = |o: &Observation| (key(o).0, key(o).1.coords.map(f64::to_bits).data.0);
    sorted.sort_by_key(|o| bits(o));
    let (mut squares, mut degrees_of_freedom) = (0.0, 0);
    for same in sorted.chunk_by(|a, b| key(a) == key(b)) {
        let mean: Vector2<f64> =
            same.iter().map(|o| o.pixel.coords).sum::<Vector2<f64>>() / same.len() as f64;
        squares += same.iter().map(|o| (o.pixel.coords - mean).norm_squared()).sum::<f64>();
        // Each mean takes up one observation.
        degrees_of_freedom += same.len() - 1;
    }
    (degrees_of_freedom > 0).then(|| PinScatter {
        rms_px: (squares / degrees_of_freedom as f64).sqrt(),
        degrees_of_freedom,
    })
}
