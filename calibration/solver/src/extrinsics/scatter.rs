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
///
/// ```
/// use fabkit_calibration::extrinsics::pin_scatter;
/// use fabkit_calibration::model::{Contact, Observation};
/// use fabkit_camera::Point2;
/// use fabkit_geometry::Point3;
/// let observe = |capture, x_px| {
///     let contact_in_sensor_mm = Point3::new(0.0, 0.0, 15.0);
///     let contact = Contact { capture, hole: 1, contact_in_sensor_mm, axis_in_sensor: None };
///     Observation { contact, pixel: Point2::new(x_px, 240.0), sigma_px: 0.3 }
/// };
/// // 1 px on each side of the mean: two squares, and one degree of freedom.
/// let scatter = pin_scatter(&[observe(0, 319.0), observe(1, 321.0)]).unwrap();
/// assert_eq!((scatter.rms_px, scatter.degrees_of_freedom), (2f64.sqrt(), 1));
/// assert_eq!(pin_scatter(&[observe(0, 319.0)]), None);
/// ```
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
