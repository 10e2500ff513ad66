//! Masses of bodies.

use fabkit_checks::UnknownProperty;
use fabkit_export::Inertia;
use fabkit_geometry::{
    Assembly, Body, BodyKind, MaterialProperty, Matrix3, MechanicalRole, OpticalClarity, Sensor,
    Vector3,
};

/// Conversion from g/cm3 to kg/mm3.
const KG_PER_MM3: f64 = 1e-6;
const MM_PER_M: f64 = 1000.0;

/// Density of screws, g/cm3: steel. This and the following densities apply to bought components without a known one;
/// chosen and rounded.
const STEEL: f64 = 7.85;
/// Density of inserts, nuts and spacers, g/cm3: brass.
const BRASS: f64 = 8.4;
/// Density of clear components, g/cm3: glass.
const GLASS: f64 = 2.2;
/// Density of flexible components, g/cm3: rubber and cables.
const FLEXIBLE: f64 = 1.6;
/// Density of anything else, g/cm3: electronics in plastic.
const UNKNOWN: f64 = 1.5;

/// Mass of a body, and its source.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mass {
    pub volume_mm3: f64,
    pub density_g_per_cm3: f64,
    /// Source of the density: `material` or `chosen`.
    pub source: &'static str,
    pub inertia: Inertia,
}

/// Computes a mass from the exact solid's moments in the sensor frame.
pub(super) fn mass(
    body: &Body,
    known: Option<f64>,
    (volume_mm3, centre_mm, inertia_mm5): (f64, Vector3<f64>, Matrix3<f64>),
) -> Mass {
    let (density_g_per_cm3, source) = match known {
        Some(density) => (density, "material"),
        None => (chosen_density(body), "chosen"),
    };
    let per_mm3 = density_g_per_cm3 * KG_PER_MM3;
    let inertia = Inertia {
        mass_kg: per_mm3 * volume_mm3,
        centre_m: centre_mm / MM_PER_M,
        // From kg mm2 to kg m2.
        about_centre: per_mm3 / (MM_PER_M * MM_PER_M) * inertia_mm5,
    };
    Mass { volume_mm3, density_g_per_cm3, source, inertia }
}

/// Chooses a density for a body whose material has none, g/cm3.
fn chosen_density(body: &Body) -> f64 {
    match body.duty {
        MechanicalRole::Fastener => STEEL,
        MechanicalRole::Threaded => BRASS,
        _ if body.kind != BodyKind::Bought => UNKNOWN,
        _ if body.assembly_compliance_mm > 0.0 => FLEXIBLE,
        _ if body.clarity() == OpticalClarity::Clear => GLASS,
        _ => UNKNOWN,
    }
}

/// Returns the densities of made and cast bodies that no source states, by material. Masses of robot files take a chosen
/// density in their place; that of bought components is no property of a named material.
///
/// ```
/// # let yaml = fabkit_designs::builtin_yaml("rtac0").ok_or("no such sensor")?;
/// let set = ["shell.material=unobtainium".to_owned()];
/// let sensor = fabkit_designs::load("rtac0.yaml", yaml, &set, &["fixtures"])?.sensor;
/// let unknown = fabkit_robots::unknown_densities(&sensor);
/// assert_eq!(unknown[0].subject(), "density of unobtainium");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn unknown_densities(sensor: &Sensor) -> Vec<UnknownProperty> {
    let known = fabkit_sweep::densities(sensor);
    let in_sensor = |body: &&Body| {
        body.kind != BodyKind::Bought
            && body.placements.iter().any(|place| place.assembly == Assembly::sensor())
    };
    let open = sensor.bodies.iter().filter(in_sensor);
    let open = open.filter(|body| !known.contains_key(body.name.as_str()));
    let open = open.map(|body| UnknownProperty::of_body(MaterialProperty::Density, body));
    UnknownProperty::merged(open)
}
