//! GLB files for viewers: all bodies of a sensor or fixture, placed in their assembly.

use fabkit_designs::Design;
use fabkit_export::{GlbBody, GlbPlacement, GlbScene};
use fabkit_files::staging::OutputFile;
use fabkit_geometry::measure::ray_volume;
use fabkit_geometry::{Body, CompiledSolid, OpticalClarity};
use fabkit_mesh::{PrintMesh, ShadedMesh};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::pieces::MIN_TOLERANCE_MM;
use super::topology::{self, TopologyCounts};
use super::{ExportOptions, ExportRunError, Format, MadeFile, limit_triangles};
use crate::images;

const MM3_PER_CM3: f64 = 1e3;

/// Chord tolerance of the GLB shown on web pages, mm: less than a pixel, and a third of the bytes.
const DISPLAY_TOLERANCE_MM: f64 = 0.05;
/// Number of rays for a displayed volume; its relative error is about 1e-4.
const VOLUME_RAYS: u32 = 20_000;

/// Body with its mesh in its own frame.
struct MeshedBody<'a> {
    body: &'a Body,
    mesh: ShadedMesh,
    extras: Value,
}

/// Makes the GLB of the default assembly's bodies, independent of the requested parts.
pub(super) fn make_file(
    design: &Design,
    design_hash: &str,
    options: &ExportOptions,
) -> Result<MadeFile, ExportRunError> {
    let sensor = &design.sensor;
    let assembly = images::default_assembly(sensor);
    let densities = fabkit_sweep::densities(&design.sensor);
    let standing = mesh_bodies(design, std::slice::from_ref(&assembly), |body| {
        let print = mesh_body(body, options.tolerance_mm)?;
        let density = densities.get(body.name.as_str()).copied();
        let extras = extras(body, size_mm(&print), print.volume_mm3(), density);
        Ok((print, extras))
    })?;
    let name = Format::Glb.file_name(&sensor.name);
    let scene =
        scene(design, design_hash, &assembly, &sensor.name, &standing, options.tolerance_mm);
    let failed = |source| ExportRunError::Write { file: name.clone(), source };
    let bytes = fabkit_export::glb(&[scene]).map_err(failed)?;
    let parts = standing.iter().map(|one| one.body.name.clone()).collect();
    Ok(MadeFile {
        file: OutputFile { name, bytes },
        format: Format::Glb.word(),
        parts,
        stock: None,
    })
}

/// Makes a GLB for web pages, with one scene for each assembly, in the given order; the first is shown first. Volumes
/// and sizes are those of the exact solids, and each body lists the parameters of its section.
///
/// # Errors
/// Bodies that cannot be meshed.
pub(crate) fn display_glb(
    design: &Design,
    design_hash: &str,
    assemblies: &[String],
) -> Result<Vec<u8>, ExportRunError> {
    let densities = fabkit_sweep::densities(&design.sensor);
    let standing = mesh_bodies(design, assemblies, |body| {
        let print = mesh_body(body, DISPLAY_TOLERANCE_MM)?;
        let solid = CompiledSolid::new(&body.solid).ok();
        let volume = solid.as_ref().and_then(|solid| ray_volume(solid, VOLUME_RAYS).ok());
        let volume_mm3 = volume.map_or_else(|| print.volume_mm3(), |volume| volume.value_mm3);
        let size_mm = exact_size_mm(&print, solid.as_ref());
        let density = densities.get(body.name.as_str()).copied();
        let mut extras = extras(body, size_mm, volume_mm3, density);
        let parameters = parameters(design, &body.name);
        if !parameters.is_empty() {
            extras["parameters"] = Value::Array(parameters);
        }
        Ok((print, extras))
    })?;
    let scenes: Vec<GlbScene> = assemblies
        .iter()
        .map(|assembly| {
            scene(design, design_hash, assembly, assembly, &standing, DISPLAY_TOLERANCE_MM)
        })
        .collect();
    let file = Format::Glb.file_name(&design.sensor.name);
    fabkit_export::glb(&scenes).map_err(|source| ExportRunError::Write { file, source })
}

/// Meshes all bodies placed in any of the assemblies, each once.
fn mesh_bodies<'a>(
    design: &'a Design,
    assemblies: &[String],
    made: impl Fn(&Body) -> Result<(PrintMesh, Value), ExportRunError> + Sync,
) -> Result<Vec<MeshedBody<'a>>, ExportRunError> {
    let stands = |body: &'_ &Body| {
        body.placements.iter().any(|place| assemblies.contains(&place.assembly.0))
    };
    let bodies: Vec<&Body> = design.sensor.bodies.iter().filter(stands).collect();
    let standing: Vec<Result<MeshedBody, ExportRunError>> = bodies
        .into_par_iter()
        .map(|body| {
            let (print, extras) =
                made(body).map_err(|failure| topology::attribute_failure(failure, design))?;
            Ok(MeshedBody { body, mesh: print.with_exact_normals(&body.solid), extras })
        })
        .collect();
    // Results are collected in order, so that the first error is the same for any number of threads.
    let standing = standing.into_iter().collect::<Result<Vec<_>, _>>()?;
    limit_triangles(standing.iter().map(|one| one.mesh.triangles.len()).sum())?;
    Ok(standing)
}

fn scene<'a>(
    design: &'a Design,
    design_hash: &str,
    assembly: &str,
    label: &'a str,
    standing: &'a [MeshedBody],
    tolerance_mm: f64,
) -> GlbScene<'a> {
    let sensor = &design.sensor;
    GlbScene {
        name: &sensor.name,
        label,
        upright_from_assembly: images::upright_rotation(sensor, assembly),
        bodies: standing.iter().filter_map(|one| one.glb_body(assembly)).collect(),
        extras: json!({
            "title": sensor.title,
            "reference": sensor.reference,
            "design_hash": design_hash,
            "assembly": assembly,
            "unit_of_meshes": "mm",
            "chord_tolerance_mm": tolerance_mm,
        }),
    }
}

/// Returns the sides of the mesh's bounding box in the body's frame, mm.
fn size_mm(print: &PrintMesh) -> [f64; 3] {
    let bounds = print.bounds();
    [0, 1, 2].map(|axis| bounds.max[axis] - bounds.min[axis])
}

/// Returns the sides of the exact solid's bounding box, mm. The compiled bounds are conservative where something is cut
/// off; a side on which they exceed the mesh is therefore taken from the mesh.
fn exact_size_mm(print: &PrintMesh, solid: Option<&CompiledSolid>) -> [f64; 3] {
    let meshed = print.bounds();
    let Some(known) = solid.map(CompiledSolid::bounds) else { return size_mm(print) };
    let side = |meshed: f64, known: f64| {
        if (meshed - known).abs() <= DISPLAY_TOLERANCE_MM { known } else { meshed }
    };
    [0, 1, 2].map(|axis| {
        side(meshed.max[axis], known.max[axis]) - side(meshed.min[axis], known.min[axis])
    })
}

/// Returns the parameters whose section is named like the body, in singular or plural.
fn parameters(design: &Design, body: &str) -> Vec<Value> {
    let is_own = |path: &str| {
        let section = path.split_once('.').map(|(section, _)| section.replace('_', "-"));
        section.is_some_and(|section| section == body || section.strip_suffix('s') == Some(body))
    };
    let own = design.parameters.iter().filter(|parameter| is_own(&parameter.path));
    own.map(|one| json!({ "path": one.path, "value": one.value, "summary": one.summary })).collect()
}

impl MeshedBody<'_> {
    /// Returns the body as placed in an assembly; `None` if it does not occur there.
    fn glb_body(&self, assembly: &str) -> Option<GlbBody<'_>> {
        let Body { name, material, color, opacity, substance, .. } = self.body;
        let places = self.body.placements.iter().filter(|place| place.assembly.0 == assembly);
        let places = places.map(|placement| GlbPlacement {
            assembly_from_body: placement.assembly_from_body,
            exploded_offset_mm: placement.explode_mm,
        });
        let places: Vec<GlbPlacement> = places.collect();
        (!places.is_empty()).then(|| GlbBody {
            name,
            // Bought components have no material; their name stands for their appearance.
            material: if material.is_empty() { name } else { material },
            color: *color,
            opacity: *opacity,
            refractive_index: substance.refractive_index,
            mesh: &self.mesh,
            placements: places,
            extras: self.extras.clone(),
        })
    }
}

/// Meshes the nominal solid. The tolerance is halved while the topology is wrong, as for parts' files.
fn mesh_body(body: &Body, mut tolerance_mm: f64) -> Result<PrintMesh, ExportRunError> {
    let counted = TopologyCounts::from_body(body, tolerance_mm);
    loop {
        match meshed_at(body, counted, tolerance_mm) {
            Err(failure) if failure.is_topology_failure() && tolerance_mm > MIN_TOLERANCE_MM => {
                tolerance_mm /= 2.0;
            }
            done => return done,
        }
    }
}

fn meshed_at(
    body: &Body,
    counted: Option<TopologyCounts>,
    tolerance_mm: f64,
) -> Result<PrintMesh, ExportRunError> {
    let mesh = fabkit_mesh::mesh(&body.solid, tolerance_mm).and_then(|mesh| mesh.to_print());
    let mesh = mesh.map_err(|source| ExportRunError::Mesh { part: body.name.clone(), source })?;
    limit_triangles(mesh.triangles().len())?;
    match counted.and_then(|counted| counted.failure(body, &mesh)) {
        Some(failure) => Err(failure),
        None => Ok(mesh),
    }
}

/// Collects the body's properties for viewers. Sizes are of the bounding box in the body's frame. The mass is of one
/// body, printed solid.
fn extras(
    body: &Body,
    size_mm: [f64; 3],
    volume_mm3: f64,
    density_g_per_cm3: Option<f64>,
) -> Value {
    let clarity = match body.clarity() {
        _ if body.has_unknown_transparency() => "not known",
        OpticalClarity::Clear => "clear",
        OpticalClarity::Translucent => "translucent",
        OpticalClarity::Opaque => "opaque",
    };
    let mut extras = json!({
        "kind": body.kind.word(),
        "summary": body.summary,
        "quantity": body.quantity,
        "clarity": clarity,
        "size_mm": size_mm.map(|side| rounded(side, 1e4)),
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

/// Rounds to multiples of 1/`parts`: the digits that a chord tolerance justifies.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}
