//! `fabkit export SENSOR[/FIXTURE][/PART]`

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::time::Instant;

use fabkit_application::designs::Design;
use fabkit_application::export::{Bed, FileEntry, Manifest, UnlistedFile, UnlistedReason};
use fabkit_application::exports::{
    self, DEFAULT_STOCK, ExportOptions, ExportRunError, Exported, Format, Overwriting,
    WrittenExport,
};
use fabkit_application::packaging::{self, GUIDE_FOLDER, Terms};
use fabkit_application::progress::ProgressStep;
use fabkit_application::robots::{robot_files, unknown_densities};
use fabkit_application::source::{self, CheckErrors, NamedDesigns, Target};
use fabkit_application::verifier::Verifier;
use fabkit_application::{bodies, documents, guides};
use serde_json::{Value, json};

use super::progress::Progress;
use super::{Outcome, archive, profile_report, typed};
use crate::cli::{Export, Global};
use crate::defaults::{self, Defaults};
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;
use crate::table::{Align::Left, Align::Right, format_count, format_size, group_digits, table};

/// Default chord tolerance, mm.
const DEFAULT_TOLERANCE_MM: f64 = 0.01;

/// Largest number of file names in one line.
const MOST_NAMED: usize = 8;

pub(super) fn run(args: &Export, global: &Global) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let target = Target::new(&args.sensor).with_preset(args.preset.as_deref());
    require_whole_sensor(args, &target)?;
    let chosen = ExportSettings::new(args, &Defaults::read()?)?;
    let order = ExportJob::new(args, global, target, &chosen)?;
    let made = order.make()?;
    if args.zip.is_some() {
        let below = made.fixtures().chain(made.guides());
        let exports = std::iter::once((PathBuf::new(), &made.own)).chain(below);
        return archive::write_archive(args, &target, &order.design, exports.collect());
    }
    let folder = args.output.clone();
    let folder =
        folder.unwrap_or_else(|| default_folder(chosen.output.clone(), &target, &order.design));
    let written = write(args, &target, &chosen, &made, &folder)?;

    let mut text = made.faults.as_ref().map(format_warning).unwrap_or_default();
    for ((name, exported), written) in made.of_fixtures.iter().zip(&written.of_fixtures) {
        text += &format!(
            "{name}\n{}{}",
            parts_table(&exported.manifest),
            format_remaining_files(exported, written)
        );
        text.push('\n');
    }
    text += &parts_table(&made.own.manifest);
    text += &format!(
        "{}, {} in {} ({:.2} s)\n",
        format_count(written.files, "file"),
        format_size(written.bytes),
        folder.display(),
        start.elapsed().as_secs_f64(),
    );
    if !made.guides.is_empty() {
        text += &format!("open {}\n", folder.join(GUIDE_FOLDER).join("index.html").display());
    }
    if !made.has_file {
        text += &archive::missing_file_warning(&order.design);
    }
    text += &format_remaining_files(&made.own, &written.own);
    if !chosen.from_file.is_empty() {
        text += &format!("from {}: {}\n", defaults::FILE, chosen.from_file.join(", "));
    }
    let mut json = json(&written.own, &folder, made.faults.as_ref());
    if order.with_fixtures {
        let names = made.of_fixtures.iter().map(|(name, _)| *name);
        let manifests = written.of_fixtures.iter().map(|written| &written.manifest);
        json["fixtures"] = json!(names.zip(manifests).collect::<BTreeMap<_, _>>());
    }
    if !order.args.robot.is_empty() {
        let unknown = unknown_densities(&order.design.sensor);
        json["not_known"] = unknown.iter().map(documents::unknown_property).collect();
    }
    if !chosen.from_file.is_empty() {
        json["defaults"] = json!({ "file": defaults::FILE, "keys": chosen.from_file });
    }
    Ok(Outcome { text, json, failed: false })
}

/// Refuses options that apply only to a whole sensor, if a part or fixture is exported.
fn require_whole_sensor(args: &Export, target: &Target) -> Result<(), Failure> {
    if target.fixture.is_none() && target.part.is_none() {
        return Ok(());
    }
    let (option, values) = if args.all {
        ("--all", "")
    } else if args.fixtures {
        ("--fixtures", "")
    } else if !args.robot.is_empty() {
        ("--robot", " ...")
    } else {
        return Ok(());
    };
    let message = format!("{option} is for a whole sensor, not for {}", args.sensor);
    let hint = format!("write `fabkit export {} {option}{values}`", target.sensor);
    Err(Failure::new(ErrorKind::BadInput, message, hint))
}

/// Designs and options of the export.
struct ExportJob<'a> {
    args: &'a Export,
    global: &'a Global,
    target: Target<'a>,
    with_fixtures: bool,
    design: Design,
    fixtures: NamedDesigns,
    options: ExportOptions,
}

impl<'a> ExportJob<'a> {
    /// Builds the designs and checks the options, before anything takes time.
    fn new(
        args: &'a Export,
        global: &'a Global,
        target: Target<'a>,
        chosen: &ExportSettings,
    ) -> Result<Self, Failure> {
        let profile = chosen.process.as_deref().map(source::read_profile).transpose()?;
        let with_fixtures = args.fixtures || args.all;
        let (design, fixtures) = if with_fixtures {
            target.design_with_fixtures(&args.set)?
        } else {
            (target.design(&args.set)?, Vec::new())
        };
        let part = target.part.map(str::to_owned);
        let mut formats = if args.all {
            Format::published()
        } else {
            args.format.iter().filter_map(|format| format.own()).collect()
        };
        formats.sort();
        formats.dedup();
        let options = ExportOptions {
            parts: part.into_iter().chain(args.parts.iter().cloned()).collect(),
            formats,
            tolerance_mm: chosen.tolerance_mm,
            edge_mm: args.edge,
            bed: chosen.bed,
            stock: chosen.stock,
            kerf_mm: chosen.kerf_mm,
            profile,
            profile_for_any_material: args.process_for_any_material,
            nominal: args.nominal,
        };
        let designs = std::iter::once(&design).chain(fixtures.iter().map(|(_, design)| design));
        exports::require_profile_applies(designs, &options)?;
        if let Some(part) = target.part {
            bodies::find_target(&design.sensor, part)?;
        }
        for part in &options.parts {
            bodies::find(&design.sensor, part)?;
        }
        Ok(Self { args, global, target, with_fixtures, design, fixtures, options })
    }

    /// Makes all files in memory.
    fn make(&self) -> Result<MadeExports, Failure> {
        let mut made = self.make_parts()?;
        if self.args.format.iter().any(|format| format.own().is_none()) {
            self.add_step_files(&mut made)?;
        }
        if !self.args.robot.is_empty() {
            let mut formats: Vec<_> = self.args.robot.iter().map(|robot| robot.format()).collect();
            formats.sort();
            formats.dedup();
            // Robot files describe the whole sensor, so they belong to its own folder.
            made.own.add(robot_files(&self.design, &formats)?)?;
        }
        if self.args.all || self.args.guide {
            made.guides = self.make_guides()?;
        }
        if self.args.all {
            let terms = Terms { license: self.args.license, authors: self.args.authors.clone() };
            made.has_file =
                packaging::add_package_files(&mut made.own, &self.design, &self.fixtures, &terms)?;
        }
        Ok(made)
    }

    /// Makes the files in fabkit's own formats, and in parallel applies the rules of `check`.
    fn make_parts(&self) -> Result<MadeExports, Failure> {
        let progress = Progress::new(self.global, format!("exporting {}", self.args.sensor));
        let export = |design: &Design| {
            let own = self.args.all.then(|| self.options.for_sensor(&design.sensor));
            let options = own.as_ref().unwrap_or(&self.options);
            exports::export(design, options, &|part| progress.count_piece(part))
        };
        let make = || {
            let exported = export(&self.design)?;
            let fixtures = self.fixtures.iter();
            let of_fixtures = fixtures.map(|(name, design)| Ok((*name, export(design)?)));
            Ok::<_, ExportRunError>((
                exported,
                of_fixtures.collect::<Result<Vec<_>, ExportRunError>>()?,
            ))
        };
        // The check is skipped if its result would not be shown, or if `--force` says that it is known.
        let is_told = !self.args.force && (self.global.json || !self.global.quiet);
        let look = || is_told.then(|| self.target.find_errors(&self.args.set, self.with_fixtures));
        let (exported, faults) = rayon::join(make, look);
        drop(progress);
        let (own, of_fixtures) = exported?;
        let faults = match faults {
            Some(faults) => Some(faults?.map_err(Failure::bug)?),
            None => None,
        };
        Ok(MadeExports { own, of_fixtures, guides: Vec::new(), has_file: true, faults })
    }

    fn add_step_files(&self, made: &mut MadeExports) -> Result<(), Failure> {
        let verifier = Verifier::find()?;
        let step_files = |design: &Design, parts: &[String]| {
            let doing = format!("writing STEP files of {}", design.sensor.name);
            let progress = Progress::new(self.global, doing);
            verifier.step_files(design, parts, &|step| progress.show(step))
        };
        made.own.add(step_files(&self.design, &self.options.parts)?)?;
        for ((_, exported), (_, design)) in made.of_fixtures.iter_mut().zip(&self.fixtures) {
            exported.add(step_files(design, &[])?)?;
        }
        Ok(())
    }

    /// Makes the guides of the sensor and its fixtures, with their folders.
    fn make_guides(&self) -> Result<Vec<(PathBuf, Exported)>, Failure> {
        let set = &self.args.set;
        let doing = format!("drawing the guide of {}", self.args.sensor);
        let progress = Progress::new(self.global, doing);
        let project = self.target.project(set)?;
        let guide = |target: Target, design: &Design| {
            let lines = |names: &[&str], pins_in: Option<&str>| {
                typed::calibration_commands(names, pins_in, target, set)
            };
            let calibration = guides::describe_calibration(&project, target, &lines);
            // The guide says it on its own, whatever the terminal is told.
            let faults = target.find_errors(set, false)?.map_err(Failure::bug)?;
            let show = |step: ProgressStep| progress.show(step);
            Ok::<_, Failure>(packaging::make_guide(design, calibration.as_ref(), &faults, &show)?)
        };
        let mut guides = vec![(PathBuf::from(GUIDE_FOLDER), guide(self.target, &self.design)?)];
        for (name, fixture) in &self.fixtures {
            let target = Target { fixture: Some(name), ..self.target };
            guides.push((Path::new(name).join(GUIDE_FOLDER), guide(target, fixture)?));
        }
        Ok(guides)
    }
}

/// Files that were made, with their folders relative to the sensor's.
struct MadeExports {
    own: Exported,
    of_fixtures: Vec<(&'static str, Exported)>,
    guides: Vec<(PathBuf, Exported)>,
    /// True if the package contains a sensor file.
    has_file: bool,
    /// Findings of `check`, if it was run.
    faults: Option<CheckErrors>,
}

impl MadeExports {
    fn fixtures(&self) -> impl Iterator<Item = (PathBuf, &Exported)> {
        self.of_fixtures.iter().map(|(name, exported)| (PathBuf::from(*name), exported))
    }

    fn guides(&self) -> impl Iterator<Item = (PathBuf, &Exported)> {
        self.guides.iter().map(|(folder, exported)| (folder.clone(), exported))
    }
}

/// Result of writing: the sensor's folder and those of its fixtures.
struct WrittenExports {
    own: WrittenExport,
    of_fixtures: Vec<WrittenExport>,
    files: usize,
    bytes: u64,
}

/// Writes all folders, or leaves them as they were.
fn write(
    args: &Export,
    target: &Target,
    chosen: &ExportSettings,
    made: &MadeExports,
    folder: &Path,
) -> Result<WrittenExports, Failure> {
    // Fixtures lie in subfolders. The sensor's own manifest comes last.
    let below = made.fixtures().chain(made.guides());
    let below = below.map(|(name, exported)| (folder.join(name), exported));
    let exports: Vec<_> = below.chain([(folder.to_owned(), &made.own)]).collect();
    let files = exports.iter().flat_map(|(folder, exported)| {
        exported.files.iter().map(move |file| (folder.join(&file.name), file.bytes.len() as u64))
    });
    let files: Vec<(PathBuf, u64)> = files.collect();
    FileRoles::default()
        .reads("SENSOR", target.files())
        .reads("--process", &chosen.process)
        .reads("defaults", (!chosen.from_file.is_empty()).then_some(defaults::FILE))
        .writes("-o", files.iter().map(|(place, _)| place))
        .check()?;
    interrupt::begin_writing()?;
    let how = Overwriting { clean: args.clean, force: args.force };
    let mut written = exports::write(&exports, how, &interrupt::is_requested)?;
    let own = written.pop().ok_or_else(|| Failure::bug("an export without a folder"))?;
    // The guides' entries follow those of the fixtures and are not reported.
    written.truncate(made.of_fixtures.len());
    let bytes = files.iter().map(|(_, bytes)| bytes).sum();
    Ok(WrittenExports { own, of_fixtures: written, files: files.len(), bytes })
}

/// Effective settings: from options, else from the defaults file of the working folder, else fabkit's own.
struct ExportSettings {
    tolerance_mm: f64,
    bed: Bed,
    stock: Bed,
    kerf_mm: Option<f64>,
    process: Option<PathBuf>,
    /// Folder in which the export's folders are made.
    output: PathBuf,
    /// Keys that were taken from the defaults file.
    from_file: Vec<&'static str>,
}

impl ExportSettings {
    fn new(args: &Export, defaults: &Defaults) -> Result<Self, Failure> {
        let mut from_file = Vec::new();
        let mut or = |key: &'static str, is_given: bool, is_there: bool| {
            if !is_given && is_there {
                from_file.push(key);
            }
        };
        or("tolerance", args.tolerance.is_some(), defaults.tolerance_mm.is_some());
        or("bed", args.bed.is_some(), defaults.bed_mm.is_some());
        or("stock", args.stock.is_some(), defaults.stock_mm.is_some());
        // `--nominal` excludes these settings, so that the file's are not used either.
        or("kerf", args.nominal || args.kerf.is_some(), defaults.kerf_mm.is_some());
        or("profile", args.nominal || args.process.is_some(), defaults.profile.is_some());
        or("output", args.output.is_some(), defaults.output.is_some());
        let nominal = args.nominal;
        let process = args.process.clone().or(defaults.profile.clone().filter(|_| !nominal));
        if args.process_for_any_material && process.is_none() {
            let message = "--process-for-any-material is given without --process <FILE.yaml>";
            let hint =
                "name the profile, or leave the option out; `fabkit export --help` lists both";
            return Err(Failure::new(ErrorKind::BadInput, message, hint));
        }
        let sized = |given: Option<[f64; 2]>, default: Option<[f64; 2]>, bed: Bed| Bed {
            size_mm: given.or(default).unwrap_or(bed.size_mm),
            ..bed
        };
        Ok(Self {
            tolerance_mm: args.tolerance.or(defaults.tolerance_mm).unwrap_or(DEFAULT_TOLERANCE_MM),
            bed: sized(args.bed, defaults.bed_mm, Bed::default()),
            stock: sized(args.stock, defaults.stock_mm, DEFAULT_STOCK),
            kerf_mm: args.kerf.or(defaults.kerf_mm.filter(|_| !nominal)),
            process,
            output: defaults.output.clone().unwrap_or_else(|| "out".into()),
            from_file,
        })
    }
}

/// Returns the default folder, for example `out/rtac0` or `out/rtac0/pin-dome`.
fn default_folder(out: PathBuf, target: &Target, design: &Design) -> PathBuf {
    let name = &design.sensor.name;
    let sensor = target
        .fixture
        .and_then(|fixture| Some((name.strip_suffix(fixture)?.strip_suffix('-')?, fixture)));
    match sensor {
        Some((sensor, fixture)) => out.join(sensor).join(fixture),
        None => out.join(name),
    }
}

/// Lists other files in the folder, and files that were removed.
fn format_remaining_files(exported: &Exported, written: &WrittenExport) -> String {
    let kept = written.manifest.files.len().saturating_sub(exported.manifest.files.len());
    let mut text = String::new();
    if kept > 0 {
        text += &format!("files kept from an earlier export of the same design: {kept}\n");
    }
    let mut line = |what: &str, names: Vec<&str>, hint: &str| {
        if !names.is_empty() {
            let more = names.len().saturating_sub(MOST_NAMED);
            let tail = if more > 0 { format!(" and {more} more") } else { String::new() };
            let names = names[..names.len() - more].join(", ");
            text += &format!("{what}: {names}{tail}{hint}\n");
        }
    };
    let of = |why: UnlistedReason| {
        let others = written.manifest.others.iter().filter(move |other| other.why == why);
        others.map(|UnlistedFile { name, .. }| name.as_str()).collect()
    };
    let hint = "; --clean removes them";
    line(
        "warning: files of another version of the design or of other options",
        of(UnlistedReason::Stale),
        hint,
    );
    line("warning: files changed since an earlier export", of(UnlistedReason::Changed), "");
    line("files that fabkit did not write", of(UnlistedReason::Foreign), "");
    line("removed", written.removed.iter().map(String::as_str).collect(), "");
    text
}

/// Formats the table of parts with their files, and the compensations.
fn parts_table(manifest: &Manifest) -> String {
    let mut rows =
        vec![["part", "n", "made", "triangles", "cm3", "files"].map(str::to_owned).to_vec()];
    for part in &manifest.parts {
        let files = manifest.files.iter().filter(|file| is_file_of_part(file, &part.name));
        let sizes: Vec<String> =
            files.map(|f| format!("{} {}", f.format, format_size(f.bytes))).collect();
        rows.push(vec![
            part.name.clone(),
            part.quantity.to_string(),
            part.process.clone(),
            group_digits(part.mesh.triangles as u64),
            format!("{:.3}", part.mesh.volume_mm3 / 1000.0),
            sizes.join(", "),
        ]);
    }
    let mut text = table(&[Left, Right, Left, Right, Right, Left], &rows);
    // Files without a part of their own: plates, stock sheets and documents.
    let is_layout =
        |file: &&FileEntry| !manifest.parts.iter().any(|part| is_file_of_part(file, &part.name));
    for file in manifest.files.iter().filter(is_layout) {
        // Landmarks and the artwork of boards contain no pieces.
        let pieces = match file.parts.len() {
            0 => String::new(),
            1 => "1 piece, ".to_owned(),
            n => format!("{n} pieces, "),
        };
        text += &format!("{}: {pieces}{}\n", file.name, format_size(file.bytes));
    }
    text + &compensations(manifest) + &profile_report::format_profile_report(manifest)
}

/// Returns whether a file holds exactly that part. A plate may hold only one part, but has its own name.
fn is_file_of_part(file: &FileEntry, part: &str) -> bool {
    file.name.strip_prefix(part).is_some_and(|rest| rest.starts_with('.'))
}

/// Formats one line for each kind of compensation, with the parts concerned.
fn compensations(manifest: &Manifest) -> String {
    let mut parts_by_note: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for part in &manifest.parts {
        parts_by_note.entry(&part.compensation.note).or_default().push(&part.name);
    }
    parts_by_note.remove("none");
    let line = |(note, parts): (&str, Vec<&str>)| format!("{note}: {}\n", parts.join(", "));
    let lines: String = parts_by_note.into_iter().map(line).collect();
    let nominal = manifest.files.iter().filter(|file| file.geometry.as_deref() == Some("nominal"));
    let formats: BTreeSet<&str> = nominal.map(|file| file.format.as_str()).collect();
    if formats.is_empty() {
        return lines;
    }
    format!("{lines}as designed, without this, in {}\n", Vec::from_iter(formats).join(", "))
}

/// Formats the warning in the first line: the exported parts can be printed, but not be assembled as described.
fn format_warning(faults: &CheckErrors) -> String {
    match faults.to_sentence() {
        Some(sentence) => format!("warning: {sentence}; --force silences this\n"),
        None => String::new(),
    }
}

fn json(written: &WrittenExport, folder: &Path, faults: Option<&CheckErrors>) -> Value {
    json!({
        "format": "fabkit-export",
        "version": 2,
        "folder": folder.display().to_string(),
        "check": faults.map(|faults| json!({
            "passed": faults.count() == 0,
            "findings": faults.count(),
            "first": faults.messages().next(),
        })),
        "manifest": written.manifest,
        "removed": written.removed,
    })
}
