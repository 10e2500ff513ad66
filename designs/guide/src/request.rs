//! What a guide is asked for.

use fabkit_checks::Stage;

use crate::calibration::Calibration;
use crate::shop::Shop;

/// What a guide is asked for.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// The design's hash, which tells it from others of its name.
    pub design_hash: &'a str,
    /// How many sensors are to be built; molds and tools are made once.
    pub units: u32,
    /// Density of a material that parts are made of, g/cm3, as far as anybody knows it.
    pub density: &'a dyn Fn(&str) -> Option<f64>,
    /// What stands where in each step: of the same sensor, as [`fabkit_checks::stages`] tells it.
    pub stages: &'a [Stage<'a>],
    /// What may be bought.
    pub shop: &'a dyn Shop,
    /// How it is calibrated, where it is.
    pub calibration: Option<&'a Calibration>,
}
