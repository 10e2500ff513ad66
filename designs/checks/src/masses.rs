//! Masses of the components of each mixture.

use fabkit_geometry::measure::{VolumeEstimate, ray_volume};
use fabkit_geometry::{Action, CompiledSolid, Cure, Mix, Sensor};
use rayon::prelude::*;

/// Number of lines through a layer; gives about 1e-5 of its volume.
const LINES: u32 = 60_000;

/// A mixture that one step of the chain needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    /// Name of the step.
    pub step: String,
    /// Name of the layer that the mixture becomes.
    pub layer: String,
    /// Exact volume of the layer, integrated along lines, mm3.
    pub volume: VolumeEstimate,
    /// Surplus as a fraction of the layer's mass.
    pub waste: f64,
    /// Name and mass of each component, surplus included, g.
    pub components_g: Vec<(String, f64)>,
    /// Whether the mixture is degassed in a vacuum.
    pub degas: bool,
    /// Cure of the mixture.
    pub cure: Cure,
}

/// Computes the mixtures of all pours and sprays whose layers exist and are valid, in the chain's order.
///
/// ```
/// use fabkit_checks::batches;
/// # let sensor = fabkit_checks::example::puck();
/// let batch = &batches(&sensor)[0];
/// // pi 10^2 2 mm3 of a 1 : 1 mixture of 1 g/cm3, and a tenth more.
/// assert_eq!(batch.layer, "puck");
/// assert!((batch.components_g[0].1 - 0.5 * 0.6283 * 1.1).abs() < 1e-3);
/// ```
pub fn batches(sensor: &Sensor) -> Vec<Batch> {
    // Collected first, so that volumes are computed in parallel.
    let liquids: Vec<(&str, &str, &Mix, f64, Cure)> = sensor
        .chain
        .iter()
        .filter_map(|step| match &step.action {
            Action::Pour(p) => {
                Some((step.name.as_str(), p.layer.as_str(), &p.mix, p.waste, p.cure))
            }
            Action::Spray(s) => {
                Some((step.name.as_str(), s.layer.as_str(), &s.mix, s.waste, s.cure))
            }
            _ => None,
        })
        .collect();
    liquids
        .into_par_iter()
        .filter_map(|(step, layer, mix, waste, cure)| {
            let solid = &sensor.layers().find(|l| l.name == layer)?.solid;
            let volume = ray_volume(&CompiledSolid::new(solid).ok()?, LINES).ok()?;
            let names = mix.by_mass.iter().map(|(name, _)| name.clone());
            Some(Batch {
                step: step.into(),
                layer: layer.into(),
                volume,
                waste,
                components_g: names.zip(mix.masses_g(volume.value_mm3, waste)).collect(),
                degas: mix.degas,
                cure,
            })
        })
        .collect()
}
