//! How well pins repeat: the floor under every model.

use nalgebra::Vector2;

use crate::model::Observation;

/// How far the same pin, pushed home again in other captures, is seen from its own mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinScatter {
    /// Root mean square distance from the mean, px, both coordinates together, corrected for the
    /// means being estimated from the same pins. No model can have smaller residuals on new
    /// captures.
    pub rms_px: f64,
    /// How many distances it rests on: pins less the number of holes they are in.
    pub degrees_of_freedom: usize,
}

/// The scatter over all holes with pins in two or more captures; `None` if there is no such hole.
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
        degrees_of_freedom += same.len() - 1;
    }
    (degrees_of_freedom > 0).then(|| PinScatter {
        rms_px: (squares / degrees_of_freedom as f64).sqrt(),
        degrees_of_freedom,
    })
}
