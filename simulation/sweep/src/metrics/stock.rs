//! Speeds of processes, and densities of bodies.

use std::collections::BTreeMap;

use fabkit_geometry::{Action, Body, BodyKind, Process, Sensor};

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

/// Returns densities, g/cm3, of parts and layers by name, as far as they are known: of the mix of a layer, else of the
/// material. Bought bodies have none, because they are drawn well enough for fits alone.
///
/// ```
/// use fabkit_sweep::densities;
///
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// # let project = fabkit_fixtures::load("rtac0.yaml", yaml, &[])?;
/// let densities = densities(&project.design.sensor);
/// // Sylgard 184, between the two other gels.
/// assert_eq!(densities["transparent-gel"], 1.03);
/// assert_eq!(densities["shell"], 1.24); // black PLA
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn densities(sensor: &Sensor) -> BTreeMap<&str, f64> {
    let mixed = sensor.chain.iter().filter_map(|step| match &step.action {
        Action::Pour(pour) => Some((&*pour.layer, pour.mix.density_g_per_cm3)),
        Action::Spray(spray) => Some((&*spray.layer, spray.mix.density_g_per_cm3)),
        _ => None,
    });
    let mixed: BTreeMap<&str, f64> = mixed.collect();
    let density =
        |body: &Body| mixed.get(body.name.as_str()).copied().or(body.substance.density_g_per_cm3);
    let bodies = sensor.bodies.iter().filter(|body| body.kind != BodyKind::Bought);
    bodies.filter_map(|body| Some((body.name.as_str(), density(body)?))).collect()
}

#[cfg(test)]
mod tests {
    use fabkit_geometry::Assembly;

    use super::*;

    /// An unknown material leaves masses empty: acceptable for a user's design, a mistake in a built-in one.
    #[test]
    fn figures_of_all_materials_of_built_in_sensors_are_known() {
        for name in fabkit_designs::builtin_names() {
            let yaml = fabkit_designs::builtin_yaml(name).unwrap();
            let sensor = fabkit_designs::load(name, yaml, &[], &["fixtures"]).unwrap().sensor;
            for body in sensor.parts().chain(sensor.layers()) {
                let Body { material, substance, .. } = body;
                assert!(substance.density_g_per_cm3.is_some(), "{name}: density of {material}");
                assert!(substance.usd_per_kg.is_some(), "{name}: price of {material}");
            }
            // What the camera looks through is known, too.
            let sensor_bodies = sensor.bodies.iter().filter(|body| {
                body.placements.iter().any(|place| place.assembly == Assembly::sensor())
            });
            for body in sensor_bodies {
                assert!(!body.has_unknown_transparency(), "{name}: {}", body.name);
            }
        }
    }
}
