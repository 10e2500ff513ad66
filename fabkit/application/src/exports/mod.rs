//! Export: makes all files of a design.

mod boards;
mod compensation;
mod failure;
mod folder;
mod formats;
mod glb;
mod light;
mod options;
mod pieces;
mod plates;
mod profile_report;
mod sheets;
mod slicer_settings;
mod stock;
mod tetra;
mod topology;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};

use fabkit_designs::{Companion, Design};
use fabkit_export::{
    Compensation, DocumentInfo, FileEntry, MachineEntry, Manifest, MeshFigures, PartEntry,
    PrintObject, SettingEntry,
};
use fabkit_geometry::{Body, Pose, Process, Sensor};
use fabkit_mesh::{PrintMesh, TriMesh};
use rayon::prelude::*;

pub use self::boards::{FinishedBoard, lay_out_board, lay_out_boards};
use self::compensation::{compute_compensation, fit_holes};
pub use self::failure::ExportRunError;
pub use self::folder::{FolderError, FolderRefusal, Overwriting, WrittenExport, write};
pub use self::formats::Format;
use self::formats::{FormatWriter, PartFile};
pub(crate) use self::glb::display_glb as shown_glb;
pub use self::options::{DEFAULT_STOCK, ExportOptions};
pub use self::profile_report::require_profile_applies;
use self::sheets::CutSheet;
pub(crate) use self::sheets::plan as sheet_plan;
pub use self::tetra::DEFAULT_EDGE_MM;
use fabkit_designs::design_hash;
use fabkit_files::resumable::seal_text;
pub use fabkit_files::staging::ForeignFile;
use fabkit_files::staging::OutputFile;
use fabkit_files::{UnknownName, memory};

use self::topology::TopologyCounts;
use crate::bodies;

/// Largest number of triangles in one export, including copies on plates.
pub const MAX_TRIANGLES: usize = 5_000_000;
/// Memory of one triangle in meshes and files, bytes; measured at small tolerances.
const TRIANGLE_BYTES: u64 = 380;

/// File name of the manifest.
pub const MANIFEST_NAME: &str = fabkit_files::staging::MANIFEST_FILE;

/// Callback with the name of each part whose files are ready; called from many threads.
pub type OnFinished<'a> = &'a (dyn Fn(&str) + Sync);

/// Files of an export, in memory.
///
/// ```
/// use fabkit_application::exports::{ExportOptions, ForeignFile, Format, export};
/// use fabkit_application::{source::Target, staging::OutputFile};
///
/// let options = ExportOptions { parts: vec!["base".into()], formats: vec![Format::Stl], ..ExportOptions::default() };
/// let mut exported = export(&Target::new("rtac0").design(&[])?, &options, &|_| ())?;
/// let file = OutputFile { name: "notes.txt".into(), bytes: b"printed on Monday".to_vec() };
/// exported.add(vec![ForeignFile { file, format: "text", parts: Vec::new() }])?;
/// let names: Vec<&str> = exported.files.iter().map(|file| &*file.name).collect();
/// // The manifest lists all others, and is last.
/// assert_eq!(names, ["base.stl", "notes.txt", "manifest.json"]);
/// assert_eq!(exported.manifest.files.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Exported {
    /// All files, sorted by name, the manifest last.
    pub files: Vec<OutputFile>,
    /// Manifest of the export.
    pub manifest: Manifest,
    /// Names of all bodies of the design, in its order.
    pub bodies: Vec<String>,
}

impl Exported {
    /// Makes an export that holds nothing but its manifest.
    ///
    /// # Errors
    /// [`ExportRunError::Write`] if the manifest cannot be encoded.
    pub fn empty(manifest: Manifest) -> Result<Self, ExportRunError> {
        let files = vec![manifest_file(&manifest)?];
        Ok(Self { files, manifest, bodies: Vec::new() })
    }

    /// Adds files and lists them in the manifest.
    ///
    /// # Errors
    /// [`ExportRunError::DuplicateFile`] for a name that exists already.
    pub fn add(&mut self, files: Vec<ForeignFile>) -> Result<(), ExportRunError> {
        // Drops the old manifest, which is the last file; it is encoded anew below.
        self.files.pop();
        for ForeignFile { file, format, parts } in files {
            if self.files.iter().any(|there| there.name == file.name) {
                return Err(ExportRunError::DuplicateFile(file.name));
            }
            self.manifest.files.push(file_entry(&file, format, parts, None));
            self.files.push(file);
        }
        self.files.sort_by(|a, b| a.name.cmp(&b.name));
        self.manifest.files.sort_by(|a, b| a.name.cmp(&b.name));
        state_geometry(&mut self.manifest);
        self.files.push(manifest_file(&self.manifest)?);
        Ok(())
    }
}

fn file_entry(
    file: &OutputFile,
    format: &str,
    parts: Vec<String>,
    stock: Option<(Process, String)>,
) -> FileEntry {
    let (process, material) =
        stock.map(|(process, material)| (process.to_string(), material)).unzip();
    FileEntry {
        name: file.name.clone(),
        parts,
        process,
        material,
        format: format.into(),
        geometry: None,
        bytes: file.bytes.len() as u64,
        blake3: blake3::hash(&file.bytes).to_hex().to_string(),
    }
}

/// States for each file of a compensated part whether it is compensated, too: formats differ, and so do the sizes of the
/// part in them.
fn state_geometry(manifest: &mut Manifest) {
    let compensated: BTreeSet<&str> = manifest
        .parts
        .iter()
        .filter(|part| part.compensation.note != "none")
        .map(|part| part.name.as_str())
        .collect();
    for file in &mut manifest.files {
        if file.parts.iter().any(|part| compensated.contains(part.as_str())) {
            let is_compensated = Format::ALL
                .iter()
                .any(|format| format.word() == file.format && format.is_compensated());
            let word = if is_compensated { "compensated" } else { "nominal" };
            file.geometry = Some(word.to_owned());
        }
    }
}

fn manifest_file(manifest: &Manifest) -> Result<OutputFile, ExportRunError> {
    Ok(OutputFile { name: MANIFEST_NAME.to_owned(), bytes: manifest_bytes(manifest)? })
}

/// Encodes `manifest.json`: the document with its own hash as the last key.
///
/// # Errors
/// [`ExportRunError::Write`] if the manifest cannot be encoded.
pub fn manifest_bytes(manifest: &Manifest) -> Result<Vec<u8>, ExportRunError> {
    let failed = |source| ExportRunError::Write { file: MANIFEST_NAME.to_owned(), source };
    let text = manifest.to_json().map_err(failed)?;
    Ok(seal_text(&String::from_utf8_lossy(&text)))
}

/// Body with its mesh as placed in its files: on z = 0, with its bounding box in the corner of the positive octant,
/// where the 3MF specification (section 3.3) wants it.
struct MeshedPart<'a> {
    body: &'a Body,
    placed_mesh: TriMesh,
    print: PrintMesh,
    file_from_part: Pose,
    figures: MeshFigures,
    compensation: Compensation,
    sheet: Option<CutSheet>,
    /// Slicer settings, if a 3MF file is requested.
    instructions: slicer_settings::SlicerInstructions,
}

/// File with its entries for the manifest.
struct MadeFile {
    file: OutputFile,
    format: &'static str,
    parts: Vec<String>,
    /// Process and material, where several pieces are made together.
    stock: Option<(Process, String)>,
}

/// Makes all files of a design in memory, in parallel on the current rayon pool.
///
/// A piece whose mesh differs from the design in holes, pieces or cavities is meshed again with a finer tolerance,
/// which the manifest records.
///
/// The bytes depend only on the design and the options. Plates are made if 3MF is requested and all parts are exported;
/// they hold each printed part in the quantity that one unit needs.
///
/// # Errors
/// The first failure in the order of the design.
pub fn export(
    design: &Design,
    options: &ExportOptions,
    finished: OnFinished,
) -> Result<Exported, ExportRunError> {
    let sensor = &design.sensor;
    let chosen = select_bodies(sensor, &options.parts)?;
    let hash = design_hash(design);

    let triangles = AtomicUsize::new(0);
    type OnePiece<'a> = (Vec<MeshedPart<'a>>, Vec<MadeFile>);
    let results: Vec<Result<OnePiece, ExportRunError>> = pieces::pieces(sensor, chosen)?
        .into_par_iter()
        .map(|piece| {
            // Stops early if the pieces finished so far already exceed the limit.
            limit_triangles(triangles.load(Ordering::Relaxed))?;
            let mut meshed = piece
                .mesh_bodies(options)
                .map_err(|failure| topology::attribute_failure(failure, design))?;
            if options.formats.contains(&Format::ThreeMf) {
                for one in &mut meshed {
                    one.instructions = slicer_settings::slicer_instructions(sensor, one.body)?;
                }
            }
            let more = meshed.iter().map(|body| body.figures.triangles).sum::<usize>();
            limit_triangles(more + triangles.fetch_add(more, Ordering::Relaxed))?;
            let mut files = Vec::new();
            for body in &meshed {
                // A group's parts share one 3MF file, which is made below.
                let alone = |format: &&Format| piece.group.is_none() || **format != Format::ThreeMf;
                let formats = options.formats.iter().filter(alone);
                files.extend(make_part_files(design, &hash, options, formats, body)?);
                finished(&body.body.name);
            }
            if options.formats.contains(&Format::ThreeMf) {
                files.extend(piece.group_file(&sensor.title, &hash, &meshed)?);
            }
            Ok((meshed, files))
        })
        .collect();
    // Results are collected in order, so that the first error is the same for any number of threads.
    let (meshed, files): (Vec<_>, Vec<_>) =
        results.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().unzip();

    let meshed: Vec<MeshedPart> = meshed.into_iter().flatten().collect();
    let mut made: Vec<MadeFile> = files.into_iter().flatten().collect();
    if options.parts.is_empty() && options.formats.contains(&Format::ThreeMf) {
        made.extend(plates::make_plates(design, &hash, options, &meshed)?);
    }
    if options.parts.is_empty() {
        made.extend(sheets::nested_files(design, &hash, options, &meshed)?);
    }
    for format in &options.formats {
        if let FormatWriter::Whole(make) = format.making() {
            made.extend(make(design, &hash, options)?);
        }
    }
    made.extend(tetra::make_files(design, &hash, options)?);
    if made.is_empty() && !meshed.is_empty() && !options.formats.is_empty() {
        // Only outlines were requested, and none of these parts is cut from a sheet.
        let parts = meshed.iter().map(|m| m.body.name.to_owned()).collect();
        return Err(ExportRunError::NoOutlines { parts });
    }
    if options.parts.is_empty() {
        // Some companions are computed only now, so they are made in parallel.
        made.par_extend(design.companions.par_iter().map(wrap_companion));
    }
    assemble(design, options, hash, &meshed, made)
}

/// Returns the requested bodies in the design's order, each once; all parts if none is named.
fn select_bodies<'a>(sensor: &'a Sensor, parts: &[String]) -> Result<Vec<&'a Body>, UnknownName> {
    for name in parts {
        bodies::find(sensor, name)?;
    }
    let asked: BTreeSet<&str> = parts.iter().map(String::as_str).collect();
    let is_asked = |body: &&Body| {
        if asked.is_empty() { body.is_made() } else { asked.contains(body.name.as_str()) }
    };
    Ok(sensor.bodies.iter().filter(is_asked).collect())
}

/// Wraps a file that comes with the design. Its format is its file extension.
fn wrap_companion(companion: &Companion) -> MadeFile {
    let (name, bytes) = (companion.name.clone(), companion.bytes().to_vec());
    let format = match name.rsplit_once('.') {
        Some((_, "json")) => "json",
        Some((_, "csv")) => "csv",
        Some((_, "svg")) => "svg",
        Some((_, "dxf")) => "dxf",
        Some((_, "pdf")) => "pdf",
        Some((_, "yaml")) => "yaml",
        _ => "other",
    };
    MadeFile { file: OutputFile { name, bytes }, format, parts: Vec::new(), stock: None }
}

/// Mesh of a body, compensated and rotated, but not yet shifted to its place in the files.
struct RotatedMesh<'a> {
    body: &'a Body,
    mesh: TriMesh,
    compensation: Compensation,
    sheet: Option<CutSheet>,
}

fn rotate_mesh<'a>(
    body: &'a Body,
    bed_from_body: &Pose,
    options: &ExportOptions,
    tolerance_mm: f64,
) -> Result<RotatedMesh<'a>, ExportRunError> {
    let is_drawn = options.formats.iter().any(|format| format.is_drawing());
    let mut compensation = compute_compensation(body, options, is_drawn);
    let sheet = if is_drawn { sheets::cut_sheet(body, &compensation)? } else { None };

    let fitted = fit_holes(body, bed_from_body, options, &mut compensation);
    let stretch = compensation.print.as_ref().map_or([1.0; 3], |print| print.scale);
    // Scaling enlarges mesh errors by the same factor.
    let coarser = compensation.scale * stretch.into_iter().fold(1.0, f64::max);
    let mut mesh =
        fabkit_mesh::mesh(fitted.as_ref().unwrap_or(&body.solid), tolerance_mm / coarser)
            .map_err(|source| ExportRunError::Mesh { part: body.name.clone(), source })?;
    if compensation.scale != 1.0 {
        mesh = mesh.scaled(compensation.scale);
    }
    let mut mesh = mesh.placed(bed_from_body);
    if compensation.print.is_some() {
        mesh = mesh.stretched(stretch);
    }
    Ok(RotatedMesh { body, mesh, compensation, sheet })
}

/// Shifts the mesh to its place, rounds it to the files' precision, checks its topology, and measures it.
fn finish_mesh<'a>(
    turned: RotatedMesh<'a>,
    counted: Option<TopologyCounts>,
    shift: &Pose,
    bed_from_body: &Pose,
    tolerance_mm: f64,
) -> Result<MeshedPart<'a>, ExportRunError> {
    let RotatedMesh { body, mesh, compensation, sheet } = turned;
    let lying = mesh.placed(shift);
    let failed = |source| ExportRunError::Mesh { part: body.name.clone(), source };
    let print = lying.to_print().map_err(failed)?;
    if let Some(failure) = counted.and_then(|counted| counted.failure(body, &print)) {
        // With a profile, the fitted holes are the likely cause.
        let Some(print) = &compensation.print else { return Err(failure) };
        let (part, profile) = (body.name.clone(), print.profile.clone());
        return Err(ExportRunError::HolesBreakOut { part, profile });
    }
    let figures = figures(&print, tolerance_mm);
    limit_triangles(figures.triangles)?;
    let file_from_part = shift.then_in(match &compensation.print {
        None => *bed_from_body,
        // The mesh was stretched about the bed's origin. A rigid pose can only follow the stretched position of the
        // part's origin.
        Some(print) => {
            let [x, y, z] = [0, 1, 2].map(|i| {
                let at_mm = bed_from_body.translation_mm()[i];
                (print.scale[i] - 1.0) * at_mm
            });
            Pose::translation(x, y, z).then_in(*bed_from_body)
        }
    });
    let told = slicer_settings::SlicerInstructions::default();
    Ok(MeshedPart {
        body,
        placed_mesh: lying,
        print,
        file_from_part,
        figures,
        compensation,
        sheet,
        instructions: told,
    })
}

impl MeshedPart<'_> {
    /// Returns the figures of the nominal solid's mesh, for readers who rebuild it.
    fn nominal_figures(&self, options: &ExportOptions) -> Result<MeshFigures, ExportRunError> {
        if self.compensation.print.is_some() {
            // The mesh without a profile is made again, so that its figures agree with a plain export to the last
            // digit.
            let plain = ExportOptions { profile: None, ..options.clone() };
            let piece = pieces::Piece { group: None, bodies: vec![self.body] };
            return piece.mesh_bodies(&plain)?[0].nominal_figures(&plain);
        }
        let scale = self.compensation.scale;
        Ok(MeshFigures {
            chord_tolerance_mm: self.figures.chord_tolerance_mm / scale,
            volume_mm3: self.figures.volume_mm3 / scale.powi(3),
            area_mm2: self.figures.area_mm2 / scale.powi(2),
            ..self.figures
        })
    }
}

fn figures(print: &PrintMesh, chord_tolerance_mm: f64) -> MeshFigures {
    MeshFigures {
        chord_tolerance_mm,
        triangles: print.triangles().len(),
        volume_mm3: print.volume_mm3(),
        area_mm2: print.area_mm2(),
        genus: print.genus(),
    }
}

/// Fails if the triangles exceed [`MAX_TRIANGLES`] or the free memory: all of them are in memory until the last file is
/// made.
fn limit_triangles(found: usize) -> Result<(), ExportRunError> {
    let room = usize::try_from(memory::available_bytes() / TRIANGLE_BYTES).unwrap_or(usize::MAX);
    let most = room.min(MAX_TRIANGLES);
    if found > most { Err(ExportRunError::TooManyTriangles { most }) } else { Ok(()) }
}

fn make_part_files<'a>(
    design: &Design,
    hash: &str,
    options: &ExportOptions,
    formats: impl Iterator<Item = &'a Format>,
    meshed: &MeshedPart,
) -> Result<Vec<MadeFile>, ExportRunError> {
    let body = &meshed.body;
    let title = format!("{}: {}", design.sensor.title, &body.name);
    let document = DocumentInfo { title: &title, design_hash: hash };
    let make = |format: Format| {
        let name = format.file_name(&body.name);
        let part = PartFile { name, document, design, options, meshed };
        let bytes = match (format.making(), &meshed.sheet) {
            (FormatWriter::Part(make), _) => make(&part)?,
            (FormatWriter::Outlines(write), Some(sheet)) => {
                part.wrap_result(write(document, &sheet.drawing()))?
            }
            _ => return Ok(None),
        };
        let file = OutputFile { name: part.name, bytes };
        let parts = vec![body.name.clone()];
        Ok(Some(MadeFile { file, format: format.word(), parts, stock: None }))
    };
    formats.filter_map(|&format| make(format).transpose()).collect()
}

fn object<'a>(meshed: &'a MeshedPart, mesh: &'a PrintMesh) -> PrintObject<'a> {
    let MeshedPart { body, instructions: told, .. } = meshed;
    let (name, material, settings) = (&body.name, &body.material, told.settings);
    PrintObject {
        name,
        material,
        color: body.color,
        mesh,
        settings,
        settings_note: &told.reasons_text,
    }
}

fn assemble(
    design: &Design,
    options: &ExportOptions,
    design_hash: String,
    meshed: &[MeshedPart],
    made: Vec<MadeFile>,
) -> Result<Exported, ExportRunError> {
    let mut by_name: BTreeMap<String, (FileEntry, OutputFile)> = BTreeMap::new();
    for MadeFile { file, format, parts, stock } in made {
        let entry = file_entry(&file, format, parts, stock);
        // The map also sorts the files by name.
        if let Some((earlier, _)) = by_name.insert(file.name.clone(), (entry, file)) {
            return Err(ExportRunError::DuplicateFile(earlier.name));
        }
    }
    let (entries, mut files): (Vec<_>, Vec<_>) = by_name.into_values().unzip();

    let parameters = design
        .parameters
        .iter()
        .map(|s| SettingEntry { path: s.path.clone(), value: s.value.clone() })
        .collect();
    let sensor = &design.sensor;
    let mut manifest = Manifest {
        sensor: sensor.name.clone(),
        title: sensor.title.clone(),
        reference: sensor.reference.clone(),
        design_hash,
        options: Some(options.manifest_entry()),
        parameters,
        profile: profile_report::manifest_entry(meshed.iter().map(|m| m.body), options),
        parts: meshed.iter().map(part_entry).collect(),
        files: entries,
        others: Vec::new(),
    };
    state_geometry(&mut manifest);
    files.push(manifest_file(&manifest)?);
    let bodies = sensor.bodies.iter().map(|body| body.name.to_owned()).collect();
    Ok(Exported { files, manifest, bodies })
}

fn part_entry(meshed: &MeshedPart) -> PartEntry {
    let body = &meshed.body;
    PartEntry {
        name: body.name.clone(),
        kind: body.kind.word().into(),
        summary: body.summary.clone(),
        process: body.process_word(),
        material: body.material.clone(),
        quantity: body.quantity,
        compensation: meshed.compensation.clone(),
        file_from_part: meshed.file_from_part,
        bounds_in_file_mm: meshed.placed_mesh.bounds(),
        mesh: meshed.figures,
        sheet: meshed.sheet.as_ref().map(CutSheet::figures),
        machine: body
            .machine
            .as_ref()
            .map(|machine| MachineEntry { name: machine.name.clone(), note: machine.note.clone() }),
    }
}
