//! Export of a design's files: made in memory, then written all or none.

use std::path::PathBuf;
use std::sync::Arc;

use fabkit_application::UnknownName;
use fabkit_application::designs::Design;
use fabkit_application::export::Bed;
use fabkit_application::exports::{self, DEFAULT_STOCK, ExportOptions, Format, Overwriting};
use fabkit_application::progress::ignore_progress;
use fabkit_application::robots::{RobotFormat, robot_files};
use fabkit_application::source::read_profile;
use fabkit_application::staging::{OutputFile, write_all, write_each};
use fabkit_application::verifier::Verifier;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{Failure, exception};
use crate::running::{InterruptPolicy, run_on_thread, run_short};

/// Format that is made by another kernel and is therefore not in [`Format`].
const STEP: &str = "step";

/// Export options by name. Options left out have the command's defaults.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct ExportRequest {
    parts: Vec<String>,
    formats: Vec<String>,
    tolerance_mm: f64,
    nominal: bool,
    #[pyo3(default)]
    edge_mm: Option<f64>,
    #[pyo3(default)]
    process: Option<PathBuf>,
    #[pyo3(default)]
    process_for_any_material: bool,
    #[pyo3(default)]
    bed_mm: Option<[f64; 2]>,
    #[pyo3(default)]
    stock_mm: Option<[f64; 2]>,
    #[pyo3(default)]
    kerf_mm: Option<f64>,
}

impl ExportRequest {
    /// Converts to export options. Also returns whether STEP is requested, and the requested robot formats.
    fn options(self) -> Result<(ExportOptions, bool, Vec<RobotFormat>), Failure> {
        let usual = ExportOptions::default();
        let wants_step = self.formats.iter().any(|word| word == STEP);
        let is_asked = |robot: &RobotFormat| self.formats.iter().any(|word| word == robot.word());
        let robots: Vec<RobotFormat> = RobotFormat::ALL.into_iter().filter(is_asked).collect();
        let of_robots = || RobotFormat::ALL.iter().map(|format| format.word());
        let known =
            || Format::ALL.iter().map(|format| format.word()).chain([STEP]).chain(of_robots());
        // Words for STEP and robots have other makers; all remaining ones must be known formats.
        let is_own = |word: &&String| *word != STEP && of_robots().all(|robot| robot != *word);
        let mut formats = Vec::new();
        for word in self.formats.iter().filter(is_own) {
            let format = Format::ALL.iter().find(|format| format.word() == word);
            formats.push(*format.ok_or_else(|| UnknownName::new("format", word, known()))?);
        }
        formats.sort();
        formats.dedup();
        let lengths = self.bed_mm.into_iter().chain(self.stock_mm).flatten().chain(self.kerf_mm);
        if let Some(length) = lengths.into_iter().find(|mm| !(0.0..=5000.0).contains(mm)) {
            let message = format!("{length} mm; the limits are 0 mm and 5000 mm");
            return Err(Failure::call(message));
        }
        let options = ExportOptions {
            parts: self.parts,
            formats,
            tolerance_mm: self.tolerance_mm,
            edge_mm: self.edge_mm,
            bed: self.bed_mm.map_or(usual.bed, |size_mm| Bed { size_mm, ..usual.bed }),
            stock: self.stock_mm.map_or(DEFAULT_STOCK, |size_mm| Bed { size_mm, ..DEFAULT_STOCK }),
            kerf_mm: self.kerf_mm,
            profile: self.process.as_deref().map(read_profile).transpose()?,
            profile_for_any_material: self.process_for_any_material,
            nominal: self.nominal,
        };
        Ok((options, wants_step, robots))
    }
}

/// Files of an export, in memory.
#[pyclass(frozen, module = "fabkit._fabkit")]
pub struct Exported {
    exported: Arc<exports::Exported>,
}

pub fn exported(
    py: Python<'_>,
    design: &Arc<Design>,
    wish: ExportRequest,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Exported> {
    let design = Arc::clone(design);
    let exported = run_on_thread(py, InterruptPolicy::Abandon, progress, move |link| {
        let (options, wants_step, robots) = wish.options()?;
        exports::require_profile_applies([&*design], &options)?;
        let parts = design.sensor.parts().count();
        link.show(0, if options.parts.is_empty() { parts } else { options.parts.len() });
        let mut exported = exports::export(&design, &options, &|_| link.step())?;
        if wants_step {
            exported.add(Verifier::find()?.step_files(
                &design,
                &options.parts,
                &ignore_progress,
            )?)?;
        }
        if !robots.is_empty() {
            exported.add(robot_files(&design, &robots)?)?;
        }
        Ok(exported)
    })?;
    Ok(Exported { exported: Arc::new(exported) })
}

#[pymethods]
impl Exported {
    /// The manifest, as JSON.
    fn manifest(&self, py: Python<'_>) -> PyResult<String> {
        let bytes = run_short(py, || exports::manifest_bytes(&self.exported.manifest))?;
        let bytes = bytes.map_err(|error| exception(py, Failure::bug(error)))?;
        Ok(String::from_utf8(bytes)?)
    }

    /// Names and contents of the files, the manifest last.
    fn files<'py>(&self, py: Python<'py>) -> Vec<(String, Bound<'py, PyBytes>)> {
        let files = self.exported.files.iter();
        files.map(|file| (file.name.clone(), PyBytes::new(py, &file.bytes))).collect()
    }

    /// Writes all files or none. Returns the manifest as merged with the folder's.
    fn write(&self, py: Python<'_>, folder: PathBuf, clean: bool, force: bool) -> PyResult<String> {
        let exported = Arc::clone(&self.exported);
        run_on_thread(py, InterruptPolicy::Wait, None, move |link| {
            let how = Overwriting { clean, force };
            let exports = [(folder, &*exported)];
            let written = exports::write(&exports, how, &|| link.is_cancelled())?;
            let manifest = written.first().map_or(&exported.manifest, |written| &written.manifest);
            let bytes = exports::manifest_bytes(manifest)?;
            String::from_utf8(bytes).map_err(Failure::bug)
        })
    }
}

/// Writes files at places that the caller named, all or none.
#[pyfunction]
pub fn write_files(py: Python<'_>, folder: PathBuf, files: Vec<(String, Vec<u8>)>) -> PyResult<()> {
    run_on_thread(py, InterruptPolicy::Wait, None, move |link| {
        let files = files.iter().map(|(name, bytes)| (folder.join(name), &bytes[..]));
        Ok(write_each(files, &|| link.is_cancelled())?)
    })
}

/// Writes files into a folder under names of fabkit's choice, all or none. Files that fabkit did not write there stay.
#[pyfunction]
pub fn write_folder(
    py: Python<'_>,
    folder: PathBuf,
    files: Vec<(String, Vec<u8>)>,
) -> PyResult<()> {
    let files: Vec<OutputFile> =
        files.into_iter().map(|(name, bytes)| OutputFile { name, bytes }).collect();
    run_on_thread(py, InterruptPolicy::Wait, None, move |link| {
        Ok(write_all(&folder, &files, &|| link.is_cancelled())?)
    })
}
