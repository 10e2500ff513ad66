//! A design as one file for viewers: every body of the sensor, or of the fixture, where it stands.

use std::collections::BTreeMap;

use fabkit_designs::Design;
use fabkit_export::{GlbBody, GlbPlace, GlbScene};
use fabkit_geometry::{Action, Body, Clarity, Placement};
use fabkit_mesh::{PrintMesh, ShadedMesh};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::pieces::FINEST_MM;
use super::topology::{self, Counted};
use super::{ExportFailure, ExportOptions, Format, Made, limit_triangles};
use crate::pictures;
use crate::staging::OutputFile;

const MM3_PER_CM3: f64 = 1e3;

/// A body with its mesh in its own frame, and where it stands.
struct Standing<'a> {
    body: &'a Body,
    places: Vec<&'a Placement>,
    mesh: ShadedMesh,
    extras: Value,
}

/// The file of all bodies of the assembly that pictures show, whichever parts are exported besides.
pub(super) fn made(
    design: &Design,
    design_hash: &str,
    options: &ExportOptions,
) -> Result<Made, ExportFailure> {
    let sensor = &design.sensor;
    let assembly = pictures::default_assembly(sensor);
    let densities = densities(design);
    let stands = |body: &'_ &Body| body.placements.iter().any(|p| p.assembly.0 == assembly);
    let bodies: Vec<&Body> = sensor.bodies.iter().filter(stands).collect();
    let standing: Vec<Result<Standing, ExportFailure>> = bodies
        .into_par_iter()
        .map(|body| {
            let places = body.placements.iter().filter(|p| p.assembly.0 == assembly).collect();
            let print = meshed(body, options.tolerance_mm)
                .map_err(|failure| topology::by_values(failure, design))?;
            let mesh = print.shaded(&body.solid);
            let extras = extras(body, &print, densities.get(body.name.as_str()).copied());
            Ok(Standing { body, places, mesh, extras })
        })
        .collect();
    // One after the other, so that the first error is the same on any number of threads.
    let standing = standing.into_iter().collect::<Result<Vec<_>, _>>()?;
    limit_triangles(standing.iter().map(|one| one.mesh.triangles.len()).sum())?;

    let name = Format::Glb.file_name(&sensor.name);
    let scene = GlbScene {
        name: &sensor.name,
        upright_from_assembly: pictures::poured_upright(sensor, &assembly),
        bodies: standing.iter().map(Standing::shown).collect(),
        extras: json!({
            "title": sensor.title,
            "reference": sensor.reference,
            "design_hash": design_hash,
            "assembly": assembly,
            "unit_of_meshes": "mm",
            "chord_tolerance_mm": options.tolerance_mm,
        }),
    };
    let failed = |source| ExportFailure::Write { file: name.clone(), source };
    let bytes = fabkit_export::glb(&scene).map_err(failed)?;
    let parts = standing.iter().map(|one| one.body.name.clone()).collect();
    Ok(Made { file: OutputFile { name, bytes }, format: Format::Glb.word(), parts, stock: None })
}

impl Standing<'_> {
    fn shown(&self) -> GlbBody<'_> {
        let Body { name, material, color, opacity, substance, .. } = self.body;
        let place = |placement: &&Placement| GlbPlace {
            assembly_from_body: placement.assembly_from_body,
            apart_mm: placement.explode_mm,
        };
        GlbBody {
            name,
            // What is bought has none: it looks as it does.
            material: if material.is_empty() { name } else { material },
            color: *color,
            opacity: *opacity,
            refractive_index: substance.refractive_index,
            mesh: &self.mesh,
            places: self.places.iter().map(place).collect(),
            extras: self.extras.clone(),
        }
    }
}

/// The nominal solid, finer where its topology is not the design's, as parts' files are.
fn meshed(body: &Body, mut tolerance_mm: f64) -> Result<PrintMesh, ExportFailure> {
    let counted = Counted::of(body, tolerance_mm);
    loop {
        match meshed_at(body, counted, tolerance_mm) {
            Err(failure) if failure.is_of_topology() && tolerance_mm > FINEST_MM => {
                tolerance_mm /= 2.0;
            }
            done => return done,
        }
    }
}

fn meshed_at(
    body: &Body,
    counted: Option<Counted>,
    tolerance_mm: f64,
) -> Result<PrintMesh, ExportFailure> {
    let mesh = fabkit_mesh::mesh(&body.solid, tolerance_mm).and_then(|mesh| mesh.to_print());
    let mesh = mesh.map_err(|source| ExportFailure::Mesh { part: body.name.clone(), source })?;
    limit_triangles(mesh.triangles().len())?;
    match counted.and_then(|counted| counted.failure(body, &mesh)) {
        Some(failure) => Err(failure),
        None => Ok(mesh),
    }
}

/// Densities, g/cm3, by body, as far as they are known: of what is mixed for a layer, of the design's own
/// materials, and of usual stock.
fn densities(design: &Design) -> BTreeMap<&str, f64> {
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
        mixed
            .or_else(|| named(&body.material))
            .or_else(|| fabkit_sweep::stock_density_g_per_cm3(&body.material))
    };
    let bodies = design.sensor.bodies.iter();
    bodies.filter_map(|body| Some((body.name.as_str(), of(body)?))).collect()
}

/// What a viewer can tell of a body. Sizes are those of the box around it in its own frame; a mass is that of
/// one, without hollows that a slicer leaves.
fn extras(body: &Body, print: &PrintMesh, density_g_per_cm3: Option<f64>) -> Value {
    let clarity = match body.clarity() {
        Clarity::Clear => "clear",
        Clarity::Translucent => "translucent",
        Clarity::Opaque => "opaque",
    };
    let bounds = print.bounds();
    let size_mm = [0, 1, 2].map(|axis| rounded(bounds.max[axis] - bounds.min[axis], 1e4));
    let volume_mm3 = print.volume_mm3();
    let mut extras = json!({
        "kind": body.kind.word(),
        "summary": body.summary,
        "quantity": body.quantity,
        "clarity": clarity,
        "size_mm": size_mm,
        "volume_mm3": rounded(volume_mm3, 1e3),
    });
    let mut put = |key: &str, value: Value| extras[key] = value;
    if let Some(process) = body.process() {
        put("process", json!(process.to_string()));
    }
    if !body.material.is_empty() {
        put("material", json!(body.material));
    }
    if let Some(density) = density_g_per_cm3 {
        put("mass_g", json!(rounded(volume_mm3 / MM3_PER_CM3 * density, 1e4)));
    }
    if let Some(index) = body.substance.refractive_index {
        put("refractive_index", json!(index));
    }
    extras
}

/// To as many parts of a unit as say something, at a chord tolerance.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}
