//! Build plates: all printed parts in the quantity that one unit needs, laid out on beds.

use std::collections::BTreeMap;

use fabkit_designs::Design;
use fabkit_export::{Bed, BedPosition, DocumentInfo, PrintObject};
use fabkit_files::staging::OutputFile;
use fabkit_geometry::{Pose, Process};
use fabkit_mesh::PrintMesh;
use rayon::prelude::*;

use super::{
    ExportOptions, ExportRunError, Format, MadeFile, MeshedPart, limit_triangles, object, stock,
};

/// Processes whose parts lie on a bed.
const BED_PROCESSES: [Process; 2] = [Process::Fdm, Process::Sla];

/// Makes one 3MF file for each plate: `plate-fdm-black-pla-1.3mf` and so on. A printer holds one material at a time, so
/// parts share a plate only if process, machine and material agree.
pub(super) fn make_plates(
    design: &Design,
    hash: &str,
    options: &ExportOptions,
    meshed: &[MeshedPart],
) -> Result<Vec<MadeFile>, ExportRunError> {
    // Parts of a print group are left out: the packing would separate them.
    let groups = &design.sensor.print_groups;
    let in_group = |name: &str| groups.iter().any(|g| g.parts.iter().any(|part| part == name));
    let mut copies: BTreeMap<(usize, &str, &str), Vec<&MeshedPart>> = BTreeMap::new();
    for m in meshed.iter().filter(|m| !in_group(&m.body.name)) {
        let process = BED_PROCESSES.iter().position(|bed| m.body.process() == Some(*bed));
        let Some(process) = process else { continue };
        let machine = m.body.machine.as_ref().map_or("", |machine| &*machine.name);
        let plate = copies.entry((process, machine, m.body.material.as_str())).or_default();
        plate.extend(std::iter::repeat_n(m, m.body.quantity as usize));
    }
    // Every copy on a plate is a mesh of its own, rounded at its own position.
    limit_triangles(copies.values().flatten().map(|m| m.figures.triangles).sum())?;
    let words = stock::material_words(copies.keys().map(|(_, _, material)| *material));
    let machines = stock::material_words(copies.keys().map(|(_, machine, _)| *machine));
    let mut made = Vec::new();
    for ((process, machine, material), copies) in &copies {
        let stock = (BED_PROCESSES[*process], *material);
        // A user-defined process has its own name, which need not be repeated as the machine's.
        let made_on = match (stock.0.to_string(), *machine) {
            (process, "") => process,
            (process, machine) if machine.eq_ignore_ascii_case(&process) => process,
            (process, machine) => format!("{process}-{}", machines[machine]),
        };
        let name = format!("plate-{made_on}-{}", words[material]);
        made.extend(make_stock_plates(design, hash, options, (&name, stock), copies)?);
    }
    Ok(made)
}

/// Makes the plates of one process, machine and material.
fn make_stock_plates(
    design: &Design,
    hash: &str,
    options: &ExportOptions,
    (name, (process, material)): (&str, (Process, &str)),
    copies: &[&MeshedPart],
) -> Result<Vec<MadeFile>, ExportRunError> {
    let footprints: Vec<(&str, [f64; 2])> = copies
        .iter()
        .map(|m| {
            let [width_mm, depth_mm, _] = m.placed_mesh.bounds().size_mm();
            (m.body.name.as_str(), [width_mm, depth_mm])
        })
        .collect();
    let bed = find_bed(copies, options);
    let spots = fabkit_export::pack(&footprints, bed)?;
    let plates = spots.iter().map(|spot| spot.plate + 1).max().unwrap_or(0);
    let plate = |plate: usize| {
        let title = format!("{name}-{}", plate + 1);
        let here: Vec<_> = spots.iter().filter(|spot| spot.plate == plate).collect();
        let placed: Vec<_> =
            here.par_iter().map(|spot| place_copy(copies[spot.item], spot)).collect();
        let placed: Vec<PrintMesh> = placed.into_iter().collect::<Result<_, _>>()?;

        let bodies = || here.iter().map(|spot| &copies[spot.item].body);
        let objects: Vec<PrintObject> =
            here.iter().zip(&placed).map(|(spot, mesh)| object(copies[spot.item], mesh)).collect();
        let heading = format!("{}: {title}", design.sensor.title);
        let document = DocumentInfo { title: &heading, design_hash: hash };
        let name = Format::ThreeMf.file_name(&title);
        let bytes = fabkit_export::three_mf(document, &objects)
            .map_err(|source| ExportRunError::Write { file: name.clone(), source })?;
        Ok(MadeFile {
            file: OutputFile { name, bytes },
            format: Format::ThreeMf.word(),
            parts: bodies().map(|body| body.name.to_owned()).collect(),
            stock: Some((process, material.to_owned())),
        })
    };
    (0..plates).map(plate).collect()
}

/// Returns the bed of the machine on which the copies are made; the requested bed if the machine has none.
fn find_bed(copies: &[&MeshedPart], options: &ExportOptions) -> Bed {
    let machine = copies.first().and_then(|m| m.body.machine.as_ref());
    match machine.map(|machine| machine.bed_mm) {
        Some([Some(width_mm), Some(depth_mm), _]) => {
            Bed { size_mm: [width_mm, depth_mm], ..options.bed }
        }
        _ => options.bed,
    }
}

/// Places a copy on its plate. The mesh is moved before it is rounded to `f32` and checked again afterwards, because
/// rounding depends on the position.
fn place_copy(meshed: &MeshedPart, spot: &BedPosition) -> Result<PrintMesh, ExportRunError> {
    let [x_mm, y_mm] = spot.corner_mm;
    let moved = meshed.placed_mesh.placed(&Pose::translation(x_mm, y_mm, 0.0));
    let failed = |source| ExportRunError::Mesh { part: meshed.body.name.clone(), source };
    moved.to_print().map_err(failed)
}
