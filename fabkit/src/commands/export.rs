//! `fabkit export SENSOR[/FIXTURE][/PART]`

use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use fabkit::designs::Design;
use fabkit::export::{Bed, FileEntry, Manifest};
use fabkit::exporting::{self, DEFAULT_STOCK, ExportFailure, ExportOptions};
use fabkit::staging::{OutputFile, write_all};
use fabkit::verifier::Verifier;
use serde_json::{Value, json};

use super::{Report, profiled};
use crate::cli::{Export, Global};
use crate::failure::{Exit, Failure};
use crate::interrupt;
use crate::source::{self, Target};
use crate::table::{Align::Left, Align::Right, grouped, size, table};

pub(super) fn run(args: &Export, global: &Global) -> Result<Report, Failure> {
    let start = Instant::now();
    let target = Target::new(&args.sensor).with_preset(args.preset.as_deref());
    if args.fixtures && (target.fixture.is_some() || target.part.is_some()) {
        let message = format!("--fixtures is for a whole sensor, not for {}", args.sensor);
        let hint = format!("write `fabkit export {} --fixtures`", target.sensor);
        return Err(Failure::new(Exit::BadInput, message, hint));
    }
    let profile = args.process.as_deref().map(source::read_profile).transpose()?;
    let (design, fixtures) = match args.fixtures {
        true => target.design_with_fixtures(&args.set)?,
        false => (target.design(&args.set)?, Vec::new()),
    };

    let mut options = ExportOptions {
        parts: target
            .part
            .map(str::to_owned)
            .into_iter()
            .chain(args.parts.iter().cloned())
            .collect(),
        formats: args.format.iter().filter_map(|format| format.own()).collect(),
        tolerance_mm: args.tolerance,
        bed: Bed { size_mm: args.bed, ..Bed::default() },
        stock: Bed { size_mm: args.stock, ..DEFAULT_STOCK },
        kerf_mm: args.kerf,
        profile,
        profile_for_any_material: args.process_for_any_material,
        nominal: args.nominal,
    };
    options.formats.sort();
    options.formats.dedup();
    let designs = std::iter::once(&design).chain(fixtures.iter().map(|(_, design)| design));
    exporting::require_profile_applies(designs, &options)?;

    let progress = Progress::new(global);
    let export =
        |design: &Design| exporting::export(design, &options, &|part| progress.finished(part));
    let exported = export(&design).and_then(|exported| {
        let of_fixtures = fixtures.iter().map(|(name, design)| Ok((*name, export(design)?)));
        Ok((exported, of_fixtures.collect::<Result<Vec<_>, ExportFailure>>()?))
    });
    progress.clear();
    let (mut exported, mut of_fixtures) = exported?;
    if args.format.iter().any(|format| format.own().is_none()) {
        let verifier = Verifier::find()?;
        exported.add(verifier.step_files(&design, &options.parts)?)?;
        for ((_, exported), (_, design)) in of_fixtures.iter_mut().zip(&fixtures) {
            exported.add(verifier.step_files(design, &[])?)?;
        }
    }

    let folder = args.output.clone().unwrap_or_else(|| default_folder(&target, &design));
    // The sensor's own list of contents comes last.
    let mut files: Vec<OutputFile> = Vec::new();
    for (name, exported) in &of_fixtures {
        files.extend(exported.files.iter().map(|file| OutputFile {
            name: format!("{name}/{}", file.name),
            bytes: file.bytes.clone(),
        }));
    }
    files.extend(exported.files);
    interrupt::begin_writing()?;
    write_all(&folder, &files, &interrupt::requested)?;

    let mut text = String::new();
    let mut manifests = BTreeMap::new();
    for (name, exported) in &of_fixtures {
        text += &format!("{name}\n{}\n", table_of(&exported.manifest));
        manifests.insert(*name, &exported.manifest);
    }
    text += &table_of(&exported.manifest);
    let bytes = files.iter().map(|file| file.bytes.len() as u64).sum();
    text += &format!(
        "{} files, {} in {} ({:.2} s)\n",
        files.len(),
        size(bytes),
        folder.display(),
        start.elapsed().as_secs_f64(),
    );
    let mut json = json(&exported.manifest, &folder);
    if args.fixtures {
        json["fixtures"] = json!(manifests);
    }
    Ok(Report { text, json, failed: false })
}

/// `out/rtac0`, `out/rtac0/pin-dome`.
fn default_folder(target: &Target, design: &Design) -> PathBuf {
    let (out, name) = (PathBuf::from("out"), &design.sensor.name);
    let sensor = target
        .fixture
        .and_then(|fixture| Some((name.strip_suffix(fixture)?.strip_suffix('-')?, fixture)));
    match sensor {
        Some((sensor, fixture)) => out.join(sensor).join(fixture),
        None => out.join(name),
    }
}

/// Parts with their files, and in what these differ from the design.
fn table_of(manifest: &Manifest) -> String {
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
    // Plates, stock sheets and documents.
    let is_layout = |file: &&FileEntry| !manifest.parts.iter().any(|part| is_of(file, &part.name));
    for file in manifest.files.iter().filter(is_layout) {
        // Landmarks and boards' artwork hold no pieces.
        let pieces = match file.parts.len() {
            0 => String::new(),
            1 => "1 piece, ".to_owned(),
            n => format!("{n} pieces, "),
        };
        text += &format!("{}: {pieces}{}\n", file.name, size(file.bytes));
    }
    text + &compensations(manifest) + &profiled::lines(manifest)
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
