//! Request for a guide.

use fabkit_checks::Stage;

use crate::calibration::Calibration;
use crate::shop::Shop;

/// Request for a guide.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// Hash that distinguishes the design from others of its name.
    pub design_hash: &'a str,
    /// Number of sensors to build; molds and tools are made once.
    pub units: u32,
    /// Returns the density of a material, g/cm3, if it is known.
    pub density: &'a dyn Fn(&str) -> Option<f64>,
    /// Placed bodies before and after each step of the same sensor, from [`fabkit_checks::stages`].
    pub stages: &'a [Stage<'a>],
    /// Articles that can be bought.
    pub shop: &'a dyn Shop,
    /// Calibration of the sensor, if there is one.
    pub calibration: Option<&'a Calibration>,
}
