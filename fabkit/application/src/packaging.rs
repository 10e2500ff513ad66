//! Package for publication: guide, sensor file, nominal camera, licence and citation beside the parts, as one folder or
//! one archive.

mod citation;
mod resolved;

use fabkit_camera::CameraEstimate;
use fabkit_camera::files::{self, CameraFormat};
use fabkit_designs::{Design, design_hash};
use fabkit_export::Manifest;
use fabkit_files::progress::ProgressCallback;
use fabkit_files::staging::OutputFile;
use fabkit_guide::Calibration;
use fabkit_scene::ground_truth::Viewpoint;

use crate::exports::{ExportRunError, Exported, ForeignFile};
use crate::guides;
use crate::source::{CheckErrors, NamedDesigns};

pub use citation::{DEFAULT_LICENSE, LICENSES, License};
pub use resolved::resolved_yaml;

/// Folder of a guide within its design's folder.
pub const GUIDE_FOLDER: &str = "guide";

/// Licence and authors of a package.
#[derive(Clone, Debug)]
pub struct Terms {
    /// Licence of the package's content.
    pub license: License,
    /// Authors of the design; if empty, nobody is named.
    pub authors: Vec<String>,
}

/// Adds the other files of a package: licence, citation, nominal camera, and a sensor file that reproduces the same
/// design. Returns whether that sensor file exists: parameters that one text cannot express have none.
///
/// # Errors
/// [`ExportRunError`] for an invalid camera, and for file names that exist already.
pub fn add_package_files(
    exported: &mut Exported,
    design: &Design,
    fixtures: &NamedDesigns,
    terms: &Terms,
) -> Result<bool, ExportRunError> {
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

/// Makes a guide's files with their own manifest, for a separate folder. `calibration` is [`guides::describe_calibration`] of
/// the same design, `faults` are the errors that `check` finds in it.
///
/// # Errors
/// Bodies that cannot be drawn or measured, as [`ExportRunError::Guide`].
pub fn make_guide(
    design: &Design,
    calibration: Option<&Calibration>,
    faults: &CheckErrors,
    progress: ProgressCallback,
) -> Result<Exported, ExportRunError> {
    fn failed(source: impl std::error::Error) -> ExportRunError {
        ExportRunError::Guide { reason: source.to_string() }
    }
    let stages = guides::find_stages(design).map_err(failed)?;
    let facts = guides::collect_facts(design, &stages, calibration, 1, faults).map_err(failed)?;
    let files = guides::files(design, &stages, &facts, progress).map_err(failed)?;
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

/// Packs all files of several exports in one ZIP archive. Its bytes depend only on the files: they are sorted and have
/// a fixed time.
///
/// # Errors
/// [`ExportRunError::Write`] beyond 4 GiB or 65,535 files.
///
/// ```
/// use fabkit_application::exports::{ExportOptions, Format, export};
/// use fabkit_application::{packaging::archive, source::Target};
///
/// let options = ExportOptions { parts: vec!["base".into()], formats: vec![Format::Stl], ..ExportOptions::default() };
/// let exported = export(&Target::new("rtac0").design(&[])?, &options, &|_| ())?;
/// let pack = || archive("rtac0.zip", &[("rtac0".into(), &exported)]);
/// assert_eq!(pack()?[..2], *b"PK");
/// // Nothing in it depends on the time.
/// assert_eq!(pack()?, pack()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn archive(name: &str, exports: &[(String, &Exported)]) -> Result<Vec<u8>, ExportRunError> {
    let named = exports.iter().flat_map(|(folder, exported)| {
        exported.files.iter().map(move |file| (format!("{folder}/{}", file.name), &file.bytes[..]))
    });
    let mut named: Vec<(String, &[u8])> = named.collect();
    named.sort();
    let parts: Vec<(&str, &[u8])> = named.iter().map(|(name, bytes)| (&**name, *bytes)).collect();
    fabkit_export::zip(&parts)
        .map_err(|source| ExportRunError::Write { file: name.to_owned(), source })
}

/// Returns whether a key of a sensor file belongs to its fixtures.
fn is_fixture_key(path: &str) -> bool {
    path.strip_prefix(fabkit_fixtures::KEY).is_some_and(|rest| rest.starts_with('.'))
}

/// Returns the BLAKE3 hash of a file's content, in hex.
///
/// ```
/// use fabkit_application::packaging::hash_hex;
/// // The first digits of BLAKE3 of nothing, as its authors publish them.
/// assert!(hash_hex(b"").starts_with("af1349b9f5f9a1a6"));
/// ```
pub fn hash_hex(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}
