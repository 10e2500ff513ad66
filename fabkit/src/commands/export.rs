//! `fabkit export SENSOR[/PART]`

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use fabkit::export::{Bed, Manifest};
use fabkit::exporting::{self, ExportOptions};
use fabkit::staging::write_all;
use serde_json::{Value, json};

use super::Report;
use crate::cli::{Export, Global};
use crate::failure::Failure;
use crate::table::{Align::Left, Align::Right, grouped, size, table};
use crate::{interrupt, source};

pub(super) fn run(args: &Export, global: &Global) -> Result<Report, Failure> {
    let start = Instant::now();
    let (sensor, part) = source::split_part(&args.sensor);
    let design = source::load(sensor, &args.set)?;

    let mut options = ExportOptions {
        parts: part.map(str::to_owned).into_iter().chain(args.parts.iter().cloned()).collect(),
        formats: args.format.iter().map(|&format| format.into()).collect(),
        tolerance_mm: args.tolerance,
        bed: Bed { size_mm: args.bed, ..Bed::default() },
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
        let files = manifest.files.iter().filter(|f| f.parts == [part.name.as_str()]);
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
    for plate in manifest.files.iter().filter(|file| file.name.starts_with("plate-")) {
        text += &format!("{}: {} pieces, {}\n", plate.name, plate.parts.len(), size(plate.bytes));
    }
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
