//! What is mixed in a step.

use serde::Serialize;

/// One mix of a step.
#[derive(Clone, Debug, Serialize)]
pub struct Mixed {
    /// The step's number, from 1.
    pub step: usize,
    /// The layer that it becomes.
    pub layer: String,
    /// The layer's volume, mm3.
    pub volume_mm3: f64,
    /// Surplus in the masses, as a fraction of the layer's.
    pub waste: f64,
    /// How often it is mixed: once for each unit, or once for what is cast as a tool.
    pub batches: u32,
    /// Masses of one batch, waste included.
    pub components: Vec<Component>,
    /// Whether air is drawn out in a vacuum.
    pub degas: bool,
    /// How long air is given to leave it, h: in the vacuum, else at rest before it is poured; 0 of what is sprayed.
    pub air_h: f64,
    /// Where that is from: `chosen`.
    pub air_source: &'static str,
    /// Hours until it has cured.
    pub cure_h: f64,
    /// At how many degrees Celsius.
    pub cure_celsius: f64,
    /// How long it can be worked with after mixing, h; `null` where its maker does not say.
    pub pot_life_h: Option<f64>,
    /// How long hands need with it, h: until the step is done in which it cures.
    pub in_hand_h: f64,
}

/// Part of a mix.
#[derive(Clone, Debug, Serialize)]
pub struct Component {
    /// As it is sold.
    pub name: String,
    /// g.
    pub mass_g: f64,
}
