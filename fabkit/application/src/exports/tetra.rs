//! Tetrahedral meshes of the soft layers, for other solvers, with a JSON description.

use fabkit_designs::Design;
use fabkit_elastic::{SoftError, SoftStack};
use fabkit_export::TetraMesh;
use fabkit_files::resumable::seal_text;
use fabkit_files::staging::OutputFile;
use fabkit_tetra::{Quality, Tetrahedra};
use serde_json::json;

use super::formats::FormatWriter;
use super::{ExportOptions, ExportRunError, Format, MadeFile};

/// Default edge length of tetrahedra, mm.
pub const DEFAULT_EDGE_MM: f64 = 0.5;

/// Makes the requested tetrahedra files and `NAME.tetrahedra.json` beside them; nothing if none is requested.
pub(super) fn make_files(
    design: &Design,
    hash: &str,
    options: &ExportOptions,
) -> Result<Vec<MadeFile>, ExportRunError> {
    let writer = |format: &Format| match format.making() {
        FormatWriter::Tetrahedra(write) => Some((*format, write)),
        _ => None,
    };
    let writers: Vec<_> = options.formats.iter().filter_map(writer).collect();
    if writers.is_empty() {
        return Ok(Vec::new());
    }
    let sensor = &design.sensor;
    let stiff = || SoftError::NothingSoft { sensor: sensor.name.clone() };
    let touch = sensor.touch.as_ref().ok_or_else(stiff)?;
    let soft = SoftStack::at_tip(sensor)?;
    let mesh = Tetrahedra::new(&soft, touch, options.edge_mm.unwrap_or(DEFAULT_EDGE_MM))?;
    let quality = mesh.quality();
    let title = format!(
        "{}: soft layers in its sensor frame, millimetres (times 0.001 for metres), fabkit {}",
        sensor.name,
        fabkit_export::VERSION
    );
    let materials: Vec<String> = mesh.layers.iter().map(|layer| layer.name.clone()).collect();
    let mut notes = vec![format!("design {hash}")];
    for layer in &mesh.layers {
        notes.push(format!(
            "{}: {}, Young's modulus {} MPa, Poisson's ratio {}",
            layer.name, layer.material, layer.young_mpa, layer.poissons_ratio
        ));
    }
    notes.extend(mesh.simplifications.iter().map(|what| format!("left out: {what}")));
    let tetra = TetraMesh {
        title: &title,
        notes: &notes,
        points_mm: &mesh.points_mm,
        unit_mm: 1.0,
        cells: &mesh.cells,
        cell_materials: &mesh.cell_layers,
        materials: &materials,
        faces: &[("outer", &mesh.touched_faces), ("bonded", &mesh.bonded_faces)],
    };
    let file = |format: Format, bytes: Vec<u8>| MadeFile {
        file: OutputFile { name: format.file_name(&sensor.name), bytes },
        format: format.word(),
        parts: materials.clone(),
        stock: None,
    };
    let mut made: Vec<MadeFile> =
        writers.into_iter().map(|(format, write)| file(format, write(&tetra))).collect();
    let name = format!("{}.tetrahedra.json", sensor.name);
    let bytes = seal_text(&document(design, hash, &mesh, &quality));
    let about = OutputFile { name, bytes };
    made.push(MadeFile { file: about, format: "json", parts: materials, stock: None });
    Ok(made)
}

fn document(design: &Design, hash: &str, mesh: &Tetrahedra, quality: &Quality) -> String {
    let layers = mesh.layers.iter().zip(&quality.volume_mm3).enumerate();
    let layers = layers.map(|(i, (layer, volume_mm3))| {
        let body = design.sensor.body(&layer.name);
        json!({
            "id": i + 1,
            "name": layer.name,
            "material": layer.material,
            "young_mpa": layer.young_mpa,
            "poissons_ratio": layer.poissons_ratio,
            "volume_mm3": volume_mm3,
            "quantity": body.map(|body| body.quantity),
        })
    });
    let document = json!({
        "format": "fabkit-tetrahedra",
        "version": 1,
        "sensor": design.sensor.name,
        "design_hash": hash,
        "unit": "mm",
        "frame": "sensor",
        "edge_mm": mesh.edge_mm,
        "nodes": mesh.points_mm.len(),
        "tetrahedra": mesh.cells.len(),
        "least_dihedral_deg": quality.least_dihedral_deg,
        "most_dihedral_deg": quality.most_dihedral_deg,
        "least_volume_mm3": quality.least_volume_mm3,
        "layers": layers.collect::<Vec<_>>(),
        "sets": {
            "outer": { "triangles": mesh.touched_faces.len(), "nodes": Tetrahedra::collect_nodes(&mesh.touched_faces).len() },
            "bonded": { "triangles": mesh.bonded_faces.len(), "nodes": Tetrahedra::collect_nodes(&mesh.bonded_faces).len() },
        },
        "left_out": mesh.simplifications,
    });
    format!("{document:#}\n")
}
