//! Request for a guide.

use fabkit_checks::Stage;

use crate::calibration::Calibration;
use crate::shop::Shop;

/// Request for a guide.
///
/// ```
/// use fabkit_guide::{Guide, NoShop, Request};
/// # let sensor = fabkit_checks::example::puck();
/// let stages = fabkit_checks::stages(&sensor)?;
/// // Densities come from the caller: 1.2 g/cm3 for resin.
/// let density = |material: &str| (material == "resin").then_some(1.2);
/// let request = Request {
///     design_hash: "00",
///     units: 1,
///     density: &density,
///     shop: &NoShop,
///     stages: &stages,
///     calibration: None,
/// };
/// let guide = Guide::new(&sensor, &request)?;
/// // The dish: 24 mm across and 4 mm high, less the puck of 20 x 2 mm.
/// let volume_mm3 = std::f64::consts::PI * (12.0 * 12.0 * 4.0 - 10.0 * 10.0 * 2.0);
/// assert!((guide.made[0].mass_g.ok_or("no density")? / (1.2e-3 * volume_mm3) - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
