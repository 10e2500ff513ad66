//! Stock: densities and rough prices of the materials of parts and layers.
//!
//! Densities are rounded values of makers' data sheets. Prices are list prices of small amounts in 2025, strongly
//! rounded: they serve to compare variants, not as a budget.

use std::collections::BTreeMap;

use fabkit_designs::Design;
use fabkit_geometry::{Action, Body, Process};

/// Properties of a stock material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stock {
    /// Word that occurs in the material's name, in lower case.
    word: &'static str,
    /// Density, g/cm3.
    pub density_g_per_cm3: f64,
    /// Price, US dollars per kg.
    pub usd_per_kg: f64,
}

const fn stock(word: &'static str, density_g_per_cm3: f64, usd_per_kg: f64) -> Stock {
    Stock { word, density_g_per_cm3, usd_per_kg }
}

/// Stock materials. The first whose word occurs in a material's name applies. For liquids the density of the mix takes
/// precedence, if a chain states it.
const STOCKS: &[Stock] = &[
    stock("petg", 1.27, 25.0),
    stock("pet film", 1.39, 15.0),
    stock("pla", 1.24, 25.0),
    stock("asa", 1.07, 30.0),
    stock("abs", 1.04, 25.0),
    stock("tango", 1.13, 350.0),
    stock("vero", 1.18, 300.0),
    stock("resin", 1.18, 60.0),
    stock("formlabs", 1.18, 150.0),
    stock("acrylic", 1.19, 20.0),
    stock("pmma", 1.19, 20.0),
    stock("plywood", 0.68, 8.0),
    stock("fr4", 1.85, 60.0),
    stock("sylgard", 1.03, 250.0),
    stock("ecoflex", 1.07, 45.0),
    stock("solaris", 0.99, 70.0),
    stock("moldstar", 1.12, 40.0),
    stock("psycho paint", 1.05, 60.0),
    stock("sil-poxy", 1.1, 200.0),
    stock("rtv", 0.98, 120.0),
    stock("ptg-501", 0.9, 60.0),
    stock("water", 1.0, 0.0),
];

/// Finds the stock of a material by its name.
pub fn find_stock(material: &str) -> Option<&'static Stock> {
    let name = material.to_lowercase();
    STOCKS.iter().find(|stock| name.contains(stock.word))
}

/// Returns the density of stock by a material's name, g/cm3, if it is known.
///
/// ```
/// use fabkit_sweep::stock_density_g_per_cm3;
/// // A word in the name decides.
/// assert_eq!(stock_density_g_per_cm3("Dow Sylgard 184"), Some(1.03));
/// assert_eq!(stock_density_g_per_cm3("black PLA"), Some(1.24));
/// assert_eq!(stock_density_g_per_cm3("unobtainium"), None);
/// ```
pub fn stock_density_g_per_cm3(material: &str) -> Option<f64> {
    find_stock(material).map(|stock| stock.density_g_per_cm3)
}

/// Speed of a process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProcessSpeed {
    /// Speed by volume, mm3 per hour; pieces are made one after the other.
    Volume(f64),
    /// Speed by height, mm per hour; all pieces are made together.
    Height(f64),
}

/// Returns the speed of a printer; `None` for other processes. The values are those of a 0.4 mm nozzle at 4 mm3/s,
/// usual desktop resin printers at 0.05 mm layers, and jetting at 0.027 mm layers.
pub fn process_speed(process: Process) -> Option<ProcessSpeed> {
    match process {
        Process::Fdm => Some(ProcessSpeed::Volume(4.0 * 3600.0)),
        Process::Sla => Some(ProcessSpeed::Height(20.0)),
        Process::PolyJet => Some(ProcessSpeed::Height(10.0)),
        Process::Laser | Process::Cnc | Process::Cast | Process::Pcb => None,
    }
}

/// Returns densities, g/cm3, by body, as far as they are known: of the mix of a layer, else of the design's own
/// materials, else of stock.
///
/// ```
/// use fabkit_sweep::densities;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let densities = densities(&project.design);
/// // Sylgard 184, between the two other gels.
/// assert_eq!(densities["transparent-gel"], 1.03);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn densities(design: &Design) -> BTreeMap<&str, f64> {
    let mixed = design.sensor.chain.iter().filter_map(|step| match &step.action {
        Action::Pour(pour) => Some((&*pour.layer, pour.mix.density_g_per_cm3)),
        Action::Spray(spray) => Some((&*spray.layer, spray.mix.density_g_per_cm3)),
        _ => None,
    });
    let mixed: BTreeMap<&str, f64> = mixed.collect();
    let named = |material: &str| {
        let known = design.materials.iter().map(|known| known.material());
        let own = known.filter(|known| known.name == material);
        own.map(|known| known.figures.density.0).next()
    };
    let of = |body: &Body| {
        let mixed = mixed.get(body.name.as_str()).copied();
        mixed.or_else(|| named(&body.material)).or_else(|| stock_density_g_per_cm3(&body.material))
    };
    let bodies = design.sensor.bodies.iter();
    bodies.filter_map(|body| Some((body.name.as_str(), of(body)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An unknown material leaves masses empty: acceptable for a user's design, a mistake in a built-in one.
    #[test]
    fn all_materials_of_built_in_sensors_are_known() {
        for name in fabkit_designs::builtin_names() {
            let yaml = fabkit_designs::builtin_yaml(name).unwrap();
            let sensor = fabkit_designs::load(name, yaml, &[], &["fixtures"]).unwrap().sensor;
            let parts = sensor.parts().map(|part| &part.material);
            for material in parts.chain(sensor.layers().map(|layer| &layer.material)) {
                assert!(find_stock(material).is_some(), "{name}: {material}");
            }
        }
    }
}
