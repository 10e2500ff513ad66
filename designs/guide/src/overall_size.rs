//! Size and mass of the finished sensor or fixture.

use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{Action, Assembly, Body, BodyKind, CompiledSolid, Sensor, Vector3};
use rayon::prelude::*;
use serde::Serialize;

use crate::bill_of_materials::{LINES, MM3_PER_CM3};
use crate::extent::extent;
use crate::{GuideError, Request};

/// Size and mass of an assembly.
///
/// ```
/// # use fabkit_guide::{Guide, NoShop, Request};
/// # let sensor = fabkit_checks::example::puck();
/// # let stages = fabkit_checks::stages(&sensor)?;
/// # let (density, shop, calibration) = (&|_: &str| None, &NoShop, None);
/// # let request = Request { design_hash: "00", units: 1, density, shop, stages: &stages, calibration };
/// // The dish reaches from z = -2 to 2 mm, the lid from there to 7 mm.
/// let outer = Guide::new(&sensor, &request)?.outer.ok_or("no assembly")?;
/// assert!((outer.size_mm[2] - 9.0).abs() < 1e-9);
/// // Without densities of dish and lid, the puck alone is weighed.
/// assert_eq!(outer.unweighed, ["dish", "lid"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct OverallSize {
    /// Name of the measured assembly.
    pub assembly: String,
    /// Dimensions along x, y and z of the assembly's frame, mm.
    pub size_mm: [f64; 3],
    /// Mass of parts and layers, taken as solid, g.
    pub mass_g: f64,
    /// Names of bodies left out of the mass, because the density of their material is not known.
    pub unweighed: Vec<String>,
}

/// Returns the name of the sensor's assembly, or of the first assembly of a fixture.
pub(crate) fn assembly(sensor: &Sensor) -> Option<&str> {
    let mut placed = sensor.bodies.iter().flat_map(|body| &body.placements);
    let first = placed.clone().next();
    // A fixture has no assembly `sensor`.
    let finished = placed.find(|place| place.assembly == Assembly::sensor());
    finished.or(first).map(|place| place.assembly.0.as_str())
}

/// Returns the density of a layer's mix as its step states it, g/cm3.
fn mix_density(sensor: &Sensor, layer: &str) -> Option<f64> {
    sensor.chain.iter().find_map(|step| match &step.action {
        Action::Pour(pour) if pour.layer == layer => Some(pour.mix.density_g_per_cm3),
        Action::Spray(spray) if spray.layer == layer => Some(spray.mix.density_g_per_cm3),
        _ => None,
    })
}

/// Measures the assembly; `None` if no body is placed in one.
///
/// # Errors
/// Bodies that are not valid solids.
pub(crate) fn measure(
    sensor: &Sensor,
    request: &Request<'_>,
) -> Result<Option<OverallSize>, GuideError> {
    let Some(name) = assembly(sensor) else { return Ok(None) };
    let here = |body: &&Body| body.placements.iter().any(|place| place.assembly.0 == name);
    let bodies: Vec<&Body> = sensor.bodies.iter().filter(here).collect();
    let weighed = |body: &&Body| -> Option<f64> {
        match body.kind {
            // Articles state no mass.
            BodyKind::Bought => None,
            BodyKind::Cast => mix_density(sensor, &body.name).or((request.density)(&body.material)),
            BodyKind::Made(_) => (request.density)(&body.material),
        }
    };
    let densities: Vec<Option<f64>> = bodies.iter().map(weighed).collect();
    let measured = bodies.par_iter().zip(&densities).map(|(body, density)| {
        let solid = CompiledSolid::new(&body.solid)
            .map_err(|source| GuideError::Solid { body: body.name.clone(), source })?;
        let places = body.placements.iter().filter(|place| place.assembly.0 == name);
        let mut ends: [[f64; 2]; 3] = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        let mut count = 0.0;
        for place in places {
            count += 1.0;
            let pose = place.assembly_from_body;
            for (axis, end) in ends.iter_mut().enumerate() {
                // Measured along the axis in the body's frame; the translation of the pose is added.
                let along = Vector3::ith(axis, 1.0);
                let shift = pose.translation_mm()[axis];
                if let Some([low, high]) = extent(&solid, &pose.inverse().vector(along)) {
                    *end = [end[0].min(low + shift), end[1].max(high + shift)];
                }
            }
        }
        let mass_g = match density {
            None => None,
            Some(density) => {
                let volume = ray_volume(&solid, LINES)
                    .map_err(|source| GuideError::Volume { body: body.name.clone(), source })?;
                Some(count * density * volume.value_mm3 / MM3_PER_CM3)
            }
        };
        Ok((ends, mass_g))
    });
    let measured: Vec<_> = measured.collect::<Result<_, GuideError>>()?;
    let size = |axis: usize| {
        let ends = measured.iter().map(|(ends, _)| ends[axis]);
        let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |sum, end| {
            [sum[0].min(end[0]), sum[1].max(end[1])]
        });
        (high - low).max(0.0)
    };
    let masses = bodies.iter().zip(&measured);
    let unweighed = masses.filter(|(_, (_, mass_g))| mass_g.is_none());
    Ok(Some(OverallSize {
        assembly: name.to_owned(),
        size_mm: [size(0), size(1), size(2)],
        mass_g: measured.iter().filter_map(|(_, mass_g)| *mass_g).sum(),
        unweighed: unweighed.map(|(body, _)| body.name.clone()).collect(),
    }))
}
