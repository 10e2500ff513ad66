//! Mixes of steps.

use serde::Serialize;

/// Mix of one step.
///
/// ```
/// # use fabkit_guide::{Guide, NoShop, Request};
/// # let sensor = fabkit_checks::example::puck();
/// # let stages = fabkit_checks::stages(&sensor)?;
/// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
/// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
/// let mix = &Guide::new(&sensor, &request)?.mixes[0];
/// assert_eq!((&*mix.layer, mix.step, mix.cure_h), ("puck", 1, 4.0));
/// // pi 10^2 2 mm3, and 5 min in the vacuum.
/// assert!((mix.volume_mm3 - 628.3).abs() < 0.1);
/// assert!(mix.degas && (mix.air_h - 5.0 / 60.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct StepMix {
    /// Number of the step, from 1.
    pub step: usize,
    /// Layer that the mix becomes.
    pub layer: String,
    /// Volume of the layer, mm3.
    pub volume_mm3: f64,
    /// Surplus in the masses, as a fraction of the layer's.
    pub waste: f64,
    /// Number of batches: one for each unit, or one for a layer that is cast as a tool.
    pub batches: u32,
    /// Masses of one batch, waste included.
    pub components: Vec<MixComponent>,
    /// True if it is degassed in a vacuum.
    pub degas: bool,
    /// Time for air to leave the mix, h: in the vacuum, otherwise at rest before pouring; 0 for sprays.
    pub air_h: f64,
    /// Source of that time: `chosen`.
    pub air_source: &'static str,
    /// Duration of the cure, h.
    pub cure_h: f64,
    /// Temperature of the cure, degrees Celsius.
    pub cure_celsius: f64,
    /// Pot life after mixing, h; `null` if its maker does not state it.
    pub pot_life_h: Option<f64>,
    /// Time for which the mix is handled, h: until the end of the work in the step in which it cures.
    pub in_hand_h: f64,
}

/// Component of a mix.
#[derive(Clone, Debug, Serialize)]
pub struct MixComponent {
    /// Trade name.
    pub name: String,
    /// Mass, g.
    pub mass_g: f64,
}
