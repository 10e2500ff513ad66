//! `fabkit export SENSOR[/PART]`

use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use fabkit::export::{Bed, FileEntry, Manifest};
use fabkit::exporting::{self, DEFAULT_STOCK, ExportOptions};
use fabkit::staging::write_all;
use serde_json::{Value, json};

use super::Report;
use crate::cli::{Export, Global};
use crate::failure::Failure;
use crate::interrupt;
use crate::source::Target;
use crate::table::{Align::Left, Align::Right, grouped, size, table};

pub(super) fn run(args: &Export, global: &Global) -> Result<Report, Failure> {
    let start = Instant::now();
    let target = Target::new(&args.sensor);
    let design = target.design(&args.set)?;

    let mut options = ExportOptions {
        parts: target
            .part
            .map(str::to_owned)
            .into_iter()
            .chain(args.parts.iter().cloned())
            .collect(),
        formats: args.format.iter().map(|&format| format.into()).collect(),
        tolerance_mm: args.tolerance,
        bed: Bed { size_mm: args.bed, ..Bed::default() },
        stock: Bed { size_mm: args.stock, ..DEFAULT_STOCK },
        kerf_mm: args.kerf,
        nominal: args.nominal,
    };
    options.formats.sort();
    options.formats.dedup();

    let progress = Progress::new(global);
    let exported = exporting::export(&design, &options, &|part| progress.finished(part));
    progress.clear();
    let exported = exported?;

    let folder =
        args.output.clone().unwrap_or_else(|| PathBuf::from("out").join(&design.sensor.name));
    interrupt::begin_writing()?;
    write_all(&folder, &exported.files, &interrupt::requested)?;
    Ok(Report {
        text: text(&exported.manifest, &folder, start.elapsed()),
        json: json(&exported.manifest, &folder),
        failed: false,
    })
}

fn text(manifest: &Manifest, folder: &Path, elapsed: Duration) -> String {
    let mut rows =
        vec![["part", "n", "made", "triangles", "cm3", "files"].map(str::to_owned).to_vec()];
    for part in &manifest.parts {
        let files = manifest.files.iter().filter(|file| is_of(file, &part.name));
        let sizes: Vec<String> = files.map(|f| format!("{} {}", f.format, size(f.bytes))).collect();
        rows.push(vec![
            part.name.clone(),
            part.quantity.to_string(),
            part.process.clone(),
            grouped(part.mesh.triangles as u64),
            format!("{:.3}", part.mesh.volume_mm3 / 1000.0),
            sizes.join(", "),
        ]);
    }
    let mut text = table(&[Left, Right, Left, Right, Right, Left], &rows);
    // Plates and stock sheets.
    let is_layout = |file: &&FileEntry| !manifest.parts.iter().any(|part| is_of(file, &part.name));
    for file in manifest.files.iter().filter(is_layout) {
        text += &format!("{}: {} pieces, {}\n", file.name, file.parts.len(), size(file.bytes));
    }
    text += &compensations(manifest);
    let bytes = manifest.files.iter().map(|file| file.bytes).sum();
    text += &format!(
        "{} files, {} in {} ({:.2} s)\n",
        manifest.files.len() + 1,
        size(bytes),
        folder.display(),
        elapsed.as_secs_f64(),
    );
    text
}

/// Whether a file holds that part and nothing else; a plate may do so too, but has its own name.
fn is_of(file: &FileEntry, part: &str) -> bool {
    file.name.strip_prefix(part).is_some_and(|rest| rest.starts_with('.'))
}

/// One line for each way in which files differ from the nominal geometry, with the parts it is
/// about.
fn compensations(manifest: &Manifest) -> String {
    let mut parts_by_note: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for part in &manifest.parts {
        parts_by_note.entry(&part.compensation.note).or_default().push(&part.name);
    }
    parts_by_note.remove("none");
    let line = |(note, parts): (&str, Vec<&str>)| format!("{note}: {}\n", parts.join(", "));
    parts_by_note.into_iter().map(line).collect()
}

fn json(manifest: &Manifest, folder: &Path) -> Value {
    json!({
        "format": "fabkit-export",
        "version": 1,
        "folder": folder.display().to_string(),
        "manifest": manifest,
    })
}

/// One line on a terminal that says how far the export is.
struct Progress {
    shown: bool,
    finished: AtomicUsize,
}

impl Progress {
    fn new(global: &Global) -> Self {
        let shown = !global.quiet && !global.json && io::stderr().is_terminal();
        Self { shown, finished: AtomicUsize::new(0) }
    }

    fn clear(&self) {
        self.write("");
    }

    /// Goes back to the start of the line and clears it first. Progress that cannot be shown is
    /// no reason to stop.
    fn write(&self, line: &str) {
        if self.shown {
            let _ = write!(io::stderr(), "\r\x1b[K{line}");
        }
    }

    fn finished(&self, part: &str) {
        let count = self.finished.fetch_add(1, Ordering::Relaxed) + 1;
        self.write(&format!("{count} parts, {part}"));
    }
}
