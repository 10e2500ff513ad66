//! Metrics of volume, mass, cost and time for everything that a lab makes, including molds and tools.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{
    Action, Body, BodyKind, CompiledSolid, InvalidSolid, MaterialProperty, Process, Sensor, Solid,
};

use super::ComputedMetrics;
use super::stock::{self, ProcessSpeed};

/// Number of lines through each body: accurate to a percent for thin sheets, to some thousandths for other bodies.
const LINES: u32 = 2_000;

const MM3_PER_CM3: f64 = 1e3;
const G_PER_KG: f64 = 1e3;

#[derive(Default)]
struct Sum {
    volume_mm3: f64,
    /// Mass, g; `None` once a material is unknown, because an incomplete sum would mislead.
    mass_g: Option<f64>,
}

/// Computes the group's metrics; those that need an unknown density or price are missing, and a note says what would
/// settle it.
pub(super) fn compute<'a>(
    sensor: &'a Sensor,
    computed: &mut ComputedMetrics,
) -> Result<(), InvalidSolid> {
    let mut by_material: BTreeMap<&'a str, Sum> = BTreeMap::new();
    let mut cost_usd = Some(0.0);
    let mut unknown = BTreeSet::new();
    let densities = stock::densities(sensor);
    let mut add = |body: &'a Body, volume_mm3: f64, waste: f64| -> Option<f64> {
        let is_cast = body.kind == BodyKind::Cast;
        let mut ask = |property: MaterialProperty, answer: Option<f64>| {
            if answer.is_none() {
                unknown.insert((property, &*body.material, is_cast));
            }
            answer
        };
        let density = densities.get(body.name.as_str()).copied();
        let density = ask(MaterialProperty::Density, density);
        let usd_per_kg = ask(MaterialProperty::Price, body.substance.usd_per_kg);
        let mass_g = density.map(|density| density * volume_mm3 / MM3_PER_CM3);
        let none = Sum { volume_mm3: 0.0, mass_g: Some(0.0) };
        let sum = by_material.entry(&*body.material).or_insert(none);
        sum.volume_mm3 += volume_mm3;
        sum.mass_g = sum.mass_g.zip(mass_g).map(|(a, b)| a + b);
        // Waste costs money, but is not part of the mass.
        let usd = usd_per_kg.zip(mass_g).map(|(price, g)| g * (1.0 + waste) / G_PER_KG * price);
        cost_usd = cost_usd.zip(usd).map(|(a, b)| a + b);
        mass_g
    };

    let mut parts = Sum { volume_mm3: 0.0, mass_g: Some(0.0) };
    let mut print_h = 0.0;
    let mut tallest_h: BTreeMap<Process, f64> = BTreeMap::new();
    for part in sensor.parts() {
        let volume_mm3 = volume(&part.solid)? * f64::from(part.quantity);
        let mass_g = add(part, volume_mm3, 0.0);
        parts.volume_mm3 += volume_mm3;
        parts.mass_g = parts.mass_g.zip(mass_g).map(|(a, b)| a + b);
        let Some(process) = part.process() else { continue };
        match stock::process_speed(process) {
            Some(ProcessSpeed::Volume(mm3_per_h)) => print_h += volume_mm3 / mm3_per_h,
            // Parts on one bed print together: the tallest one of each process counts.
            Some(ProcessSpeed::Height(mm_per_h)) => {
                let on_bed =
                    CompiledSolid::new(&part.solid.clone().placed(part.bed_from_body))?.bounds();
                let hours = (on_bed.max.z - on_bed.min.z) / mm_per_h;
                let tallest = tallest_h.entry(process).or_insert(0.0);
                *tallest = tallest.max(hours);
            }
            None => {}
        }
    }
    let wastes = wastes(sensor);
    let mut layers = Sum { volume_mm3: 0.0, mass_g: Some(0.0) };
    for layer in sensor.layers() {
        let volume_mm3 = volume(&layer.solid)?;
        let waste = wastes.get(layer.name.as_str()).copied().unwrap_or(0.0);
        let mass_g = add(layer, volume_mm3, waste);
        layers.volume_mm3 += volume_mm3;
        layers.mass_g = layers.mass_g.zip(mass_g).map(|(a, b)| a + b);
    }

    for (name, sum) in [("parts", &parts), ("layers", &layers)] {
        computed.put(&format!("{name}_volume_mm3"), sum.volume_mm3);
        if let Some(mass_g) = sum.mass_g {
            computed.put(&format!("{name}_mass_g"), mass_g);
        }
    }
    for (material, sum) in &by_material {
        computed.put(&format!("volume_mm3[{material}]"), sum.volume_mm3);
        if let Some(mass_g) = sum.mass_g {
            computed.put(&format!("mass_g[{material}]"), mass_g);
        }
    }
    if let Some(usd) = cost_usd {
        computed.put("material_cost_usd", usd);
    }
    computed.put("print_time_h", print_h + tallest_h.values().sum::<f64>());
    for (property, material, is_cast) in unknown {
        let remedy = property.remedy(material, is_cast);
        computed.notes.push(format!("not known: {property} of {material}; {remedy}"));
    }
    Ok(())
}

fn volume(solid: &Solid) -> Result<f64, InvalidSolid> {
    // A body without bounds has no volume, and cannot be made either.
    Ok(ray_volume(&CompiledSolid::new(solid)?, LINES)
        .map_or(f64::INFINITY, |volume| volume.value_mm3))
}

/// Returns the waste of the layers that are poured or sprayed, as a fraction.
fn wastes(sensor: &Sensor) -> BTreeMap<&str, f64> {
    let wastes = sensor.chain.iter().filter_map(|step| match &step.action {
        Action::Pour(pour) => Some((&*pour.layer, pour.waste)),
        Action::Spray(spray) => Some((&*spray.layer, spray.waste)),
        _ => None,
    });
    wastes.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn computed(lines: &str) -> ComputedMetrics {
        let yaml = format!(
            "format: 1\nextends: rtac0\nname: own\n{lines}parts:\n  shell: {{material: Blue stuff}}\n"
        );
        let sensor = fabkit_designs::load("own.yaml", &yaml, &[], &["fixtures"]).unwrap().sensor;
        let mut computed = ComputedMetrics::default();
        compute(&sensor, &mut computed).unwrap();
        computed
    }

    #[test]
    fn an_unknown_density_is_named_and_counts_neither_as_zero_nor_as_a_guess() {
        let unknown = computed("");
        let asks = |property: &str| {
            format!(
                "not known: {property} of Blue stuff; name a material of the list that \
                 docs/reference/own.md gives, or state `{property}` of `Blue stuff` below `materials:`"
            )
        };
        assert_eq!(unknown.notes, [asks("density"), asks("price")]);
        for missing in ["parts_mass_g", "material_cost_usd", "mass_g[Blue stuff]"] {
            assert!(!unknown.values.contains_key(missing), "{missing}");
        }
        assert!(unknown.values["layers_mass_g"] > 0.0 && unknown.values["mass_g[PLA]"] > 0.0);

        let own =
            "materials:\n  Blue stuff: {sort: plastic, density: 2000 kg/m3, price: 10 USD/kg}\n";
        let known = computed(own);
        assert_eq!(known.notes, [""; 0]);
        let ratio = known.values["mass_g[Blue stuff]"] / known.values["volume_mm3[Blue stuff]"];
        assert!((ratio - 2.0 / MM3_PER_CM3).abs() < 1e-12, "{ratio}");
        // Twice the price of one material is as much more as that material costs.
        let dear = computed(&own.replace("10 USD", "20 USD")).values["material_cost_usd"];
        let more = dear - known.values["material_cost_usd"];
        let costs = known.values["mass_g[Blue stuff]"] / G_PER_KG * 10.0;
        assert!((more - costs).abs() < 1e-9, "{more} {costs}");
    }

    #[test]
    fn densities_and_prices_of_files_have_limits() {
        for (figure, says) in [
            ("density: 50 g/cm3", "between 0.05 g/cm3 and 25 g/cm3"),
            ("price: -1 USD/kg", "between 0 USD/kg and 100000 USD/kg"),
            ("price: 10 EUR/kg", "is in `EUR/kg`"),
        ] {
            let yaml = format!(
                "format: 1\nextends: rtac0\nname: own\nmaterials:\n  Blue stuff: {{sort: plastic, {figure}}}\n"
            );
            let wrong = fabkit_designs::load("own.yaml", &yaml, &[], &["fixtures"]).unwrap_err();
            let wrong = wrong.problems[0].to_string();
            assert!(wrong.contains(says), "{wrong}");
        }
    }
}
