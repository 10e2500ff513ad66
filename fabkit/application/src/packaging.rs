//! What a lab publishes beside the parts: the guide, the sensor's file, its camera, licence and citation, as one
//! folder or one archive.

mod citation;
mod resolved;

use fabkit_camera::CameraEstimate;
use fabkit_camera::files::{self, CameraFormat};
use fabkit_designs::{Design, design_hash};
use fabkit_export::Manifest;
use fabkit_files::progress::OnProgress;
use fabkit_files::staging::OutputFile;
use fabkit_guide::Calibration;
use fabkit_scene::ground_truth::Viewpoint;

use crate::exporting::{ExportFailure, Exported, ForeignFile};
use crate::guiding;
use crate::source::NamedDesigns;

pub use citation::{DEFAULT_LICENSE, LICENSES, License};
pub use resolved::resolved_yaml;

/// The folder of a guide, within that of its design.
pub const GUIDE_FOLDER: &str = "guide";

/// Who publishes a package, and on what terms.
#[derive(Clone, Debug)]
pub struct Terms {
    /// The licence of what the package describes.
    pub license: License,
    /// Who made the design; nobody is named where nobody is given.
    pub authors: Vec<String>,
}

/// Adds what belongs to a package besides parts: licence, citation, the nominal camera, and the sensor's file,
/// from which the same design is made again. Whether that file is there is returned: a file whose parameters
/// cannot be said in one text has none.
///
/// # Errors
/// [`ExportFailure`] for a camera that cannot be, and for names that are there already.
pub fn complete(
    exported: &mut Exported,
    design: &Design,
    fixtures: &NamedDesigns,
    terms: &Terms,
) -> Result<bool, ExportFailure> {
    let camera = Viewpoint::new(&design.sensor.camera, None, None)?;
    let camera = files::write(&CameraEstimate::from(*camera.camera()), CameraFormat::Fabkit);
    let name = &design.sensor.name;
    let resolved = resolved_yaml(design, fixtures);
    let has_file = resolved.is_some();
    let texts = [
        ("LICENSE.txt".to_owned(), Some(terms.license_text(design))),
        ("CITATION.cff".to_owned(), Some(terms.citation(design))),
        ("nominal-camera.yaml".to_owned(), camera.ok()),
        (format!("{name}.yaml"), resolved),
    ];
    let file = |(name, text): (String, Option<String>)| {
        let format = if name.ends_with(".yaml") { "yaml" } else { "text" };
        let file = OutputFile { name, bytes: text?.into_bytes() };
        Some(ForeignFile { file, format, parts: Vec::new() })
    };
    exported.add(texts.into_iter().filter_map(file).collect())?;
    Ok(has_file)
}

/// A guide's files with a list of contents of their own, for a folder of their own; with
/// [`guiding::calibration`] of the same design.
///
/// # Errors
/// Bodies that cannot be drawn or measured, as [`ExportFailure::Guide`].
pub fn guide(
    design: &Design,
    calibration: Option<&Calibration>,
    progress: OnProgress,
) -> Result<Exported, ExportFailure> {
    fn failed(source: impl std::error::Error) -> ExportFailure {
        ExportFailure::Guide { reason: source.to_string() }
    }
    let stages = guiding::stages(design).map_err(failed)?;
    let facts = guiding::facts(design, &stages, calibration, 1).map_err(failed)?;
    let files = guiding::files(design, &stages, &facts, progress).map_err(failed)?;
    let sensor = &design.sensor;
    let manifest = Manifest {
        sensor: sensor.name.clone(),
        title: sensor.title.clone(),
        reference: sensor.reference.clone(),
        design_hash: design_hash(design),
        options: None,
        parameters: Vec::new(),
        profile: None,
        parts: Vec::new(),
        files: Vec::new(),
        others: Vec::new(),
    };
    let mut exported = Exported::empty(manifest)?;
    let format = |name: &str| match name.rsplit_once('.') {
        Some((_, "html")) => "html",
        Some((_, "json")) => "json",
        _ => "csv",
    };
    let file = |file: OutputFile| {
        let format = format(&file.name);
        ForeignFile { file, format, parts: Vec::new() }
    };
    exported.add(files.into_iter().map(file).collect())?;
    Ok(exported)
}

/// All files of several exports in one archive: the same bytes for the same files, with a fixed time.
///
/// # Errors
/// [`ExportFailure::Write`] beyond 4 GiB or 65,535 files.
pub fn archive(name: &str, exports: &[(String, &Exported)]) -> Result<Vec<u8>, ExportFailure> {
    let named = exports.iter().flat_map(|(folder, exported)| {
        exported.files.iter().map(move |file| (format!("{folder}/{}", file.name), &file.bytes[..]))
    });
    let mut named: Vec<(String, &[u8])> = named.collect();
    named.sort();
    let parts: Vec<(&str, &[u8])> = named.iter().map(|(name, bytes)| (&**name, *bytes)).collect();
    fabkit_export::zip(&parts)
        .map_err(|source| ExportFailure::Write { file: name.to_owned(), source })
}

/// Whether a key of a sensor's file is of its fixtures.
fn is_of_fixtures(path: &str) -> bool {
    path.strip_prefix(fabkit_fixtures::KEY).is_some_and(|rest| rest.starts_with('.'))
}

/// BLAKE3 of a file's content, in hex.
pub fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}
