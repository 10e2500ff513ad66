//! `fabkit export SENSOR[/FIXTURE][/PART]`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fabkit_application::designs::Design;
use fabkit_application::export::{Bed, FileEntry, Manifest, OtherFile, Otherness};
use fabkit_application::exporting::{
    self, DEFAULT_STOCK, ExportFailure, ExportOptions, Exported, Format, Overwriting, WrittenExport,
};
use fabkit_application::packaging::{self, GUIDE_FOLDER, Terms};
use fabkit_application::robots::robot_files;
use fabkit_application::source::{self, Faults, Target};
use fabkit_application::verifier::Verifier;
use fabkit_application::{bodies, guiding};
use serde_json::{Value, json};

use super::progress::Progress;
use super::{Outcome, packaged, profiled, typed};
use crate::cli::{Export, Global};
use crate::defaults::{self, Defaults};
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::Roles;
use crate::table::{Align::Left, Align::Right, grouped, size, table};

/// How far triangles are from the exact surface unless somebody says otherwise, mm.
const TOLERANCE_MM: f64 = 0.01;

/// Files that are named in one line.
const MOST_NAMED: usize = 8;

pub(super) fn run(args: &Export, global: &Global) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let target = Target::new(&args.sensor).with_preset(args.preset.as_deref());
    let with_fixtures = args.fixtures || args.all;
    if with_fixtures && (target.fixture.is_some() || target.part.is_some()) {
        let option = if args.all { "--all" } else { "--fixtures" };
        let message = format!("{option} is for a whole sensor, not for {}", args.sensor);
        let hint = format!("write `fabkit export {} {option}`", target.sensor);
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    if !args.robot.is_empty() && (target.fixture.is_some() || target.part.is_some()) {
        let message = format!("--robot is for a whole sensor, not for {}", args.sensor);
        let hint = format!("write `fabkit export {} --robot ...`", target.sensor);
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let chosen = Chosen::new(args, &Defaults::read()?)?;
    let profile = chosen.process.as_deref().map(source::read_profile).transpose()?;
    let (design, fixtures) = match with_fixtures {
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
        formats: match args.all {
            true => Format::published(),
            false => args.format.iter().filter_map(|format| format.own()).collect(),
        },
        tolerance_mm: chosen.tolerance_mm,
        edge_mm: args.edge,
        bed: chosen.bed,
        stock: chosen.stock,
        kerf_mm: chosen.kerf_mm,
        profile,
        profile_for_any_material: args.process_for_any_material,
        nominal: args.nominal,
    };
    options.formats.sort();
    options.formats.dedup();
    let designs = std::iter::once(&design).chain(fixtures.iter().map(|(_, design)| design));
    exporting::require_profile_applies(designs, &options)?;

    // A slip is told before anything takes time.
    for part in &options.parts {
        bodies::find(&design.sensor, part)?;
    }

    let progress = Progress::new(global, format!("exporting {}", args.sensor));
    let export = |design: &Design| {
        let own = args.all.then(|| options.for_sensor(&design.sensor));
        exporting::export(design, own.as_ref().unwrap_or(&options), &|part| progress.finished(part))
    };
    let make = || {
        let exported = export(&design)?;
        let of_fixtures = fixtures.iter().map(|(name, design)| Ok((*name, export(design)?)));
        Ok::<_, ExportFailure>((exported, of_fixtures.collect::<Result<Vec<_>, ExportFailure>>()?))
    };
    // Where nobody would read the answer, or whoever asks knows it, nobody looks.
    let is_told = !args.force && (global.json || !global.quiet);
    let look = || is_told.then(|| target.faults(&args.set, with_fixtures));
    let (exported, faults) = rayon::join(make, look);
    drop(progress);
    let (mut exported, mut of_fixtures) = exported?;
    let faults = match faults {
        Some(faults) => Some(faults?.map_err(Failure::bug)?),
        None => None,
    };
    if args.format.iter().any(|format| format.own().is_none()) {
        let verifier = Verifier::find()?;
        let step_files = |design: &Design, parts: &[String]| {
            let doing = format!("writing STEP files of {}", design.sensor.name);
            let progress = Progress::new(global, doing);
            verifier.step_files(design, parts, &|step| progress.show(step))
        };
        exported.add(step_files(&design, &options.parts)?)?;
        for ((_, exported), (_, design)) in of_fixtures.iter_mut().zip(&fixtures) {
            exported.add(step_files(design, &[])?)?;
        }
    }
    if !args.robot.is_empty() {
        let mut formats: Vec<_> = args.robot.iter().map(|robot| robot.format()).collect();
        formats.sort();
        formats.dedup();
        exported.add(robot_files(&design, &formats)?)?;
    }

    let mut guides = Vec::new();
    if args.all || args.guide {
        let progress = Progress::new(global, format!("drawing the guide of {}", args.sensor));
        let project = target.project(&args.set)?;
        let guide = |target: Target, design: &Design| {
            let lines = |names: &[&str], pins_in: Option<&str>| {
                typed::typed(names, pins_in, target, &args.set)
            };
            let calibration = guiding::calibration(&project, target, &lines);
            packaging::guide(design, calibration.as_ref(), &|step| progress.show(step))
        };
        guides.push((PathBuf::from(GUIDE_FOLDER), guide(target, &design)?));
        for (name, fixture) in &fixtures {
            let target = Target { fixture: Some(name), ..target };
            guides.push((Path::new(name).join(GUIDE_FOLDER), guide(target, fixture)?));
        }
    }
    let mut has_file = true;
    if args.all {
        let terms = Terms { license: args.license, authors: args.authors.clone() };
        has_file = packaging::complete(&mut exported, &design, &fixtures, &terms)?;
    }

    if args.zip.is_some() {
        let exports = std::iter::once((PathBuf::new(), &exported))
            .chain(of_fixtures.iter().map(|(name, exported)| (PathBuf::from(*name), exported)))
            .chain(guides.iter().map(|(folder, exported)| (folder.clone(), exported)));
        return packaged::zipped(args, &target, &design, exports.collect());
    }
    let folder = args.output.clone();
    let folder = folder.unwrap_or_else(|| default_folder(chosen.output, &target, &design));
    // Fixtures lie in folders below; the sensor's own list of contents comes last.
    let below = of_fixtures.iter().map(|(name, exported)| (folder.join(name), exported));
    let of_guides = guides.iter().map(|(name, exported)| (folder.join(name), exported));
    let exports: Vec<_> = below.chain(of_guides).chain([(folder.clone(), &exported)]).collect();
    let files = exports.iter().flat_map(|(folder, exported)| {
        exported.files.iter().map(move |file| (folder.join(&file.name), file.bytes.len() as u64))
    });
    let files: Vec<(PathBuf, u64)> = files.collect();
    Roles::default()
        .reads("SENSOR", target.files())
        .reads("--process", &chosen.process)
        .reads("defaults", (!chosen.from_file.is_empty()).then_some(defaults::FILE))
        .writes("-o", files.iter().map(|(place, _)| place))
        .check()?;
    interrupt::begin_writing()?;
    let how = Overwriting { clean: args.clean, force: args.force };
    let mut written = exporting::write(&exports, how, &interrupt::requested)?;
    let own = written.pop();

    let mut text = faults.as_ref().map(warning).unwrap_or_default();
    let mut manifests = BTreeMap::new();
    for ((name, exported), written) in of_fixtures.iter().zip(&written) {
        text += &format!("{name}\n{}{}", table_of(&exported.manifest), remains(exported, written));
        text.push('\n');
        manifests.insert(*name, &written.manifest);
    }
    text += &table_of(&exported.manifest);
    let bytes = files.iter().map(|(_, bytes)| bytes).sum();
    text += &format!(
        "{} files, {} in {} ({:.2} s)\n",
        files.len(),
        size(bytes),
        folder.display(),
        start.elapsed().as_secs_f64(),
    );
    if !guides.is_empty() {
        text += &format!("open {}\n", folder.join(GUIDE_FOLDER).join("index.html").display());
    }
    if !has_file {
        text += &packaged::no_file(&design);
    }
    let own = own.ok_or_else(|| Failure::bug("an export without a folder"))?;
    text += &remains(&exported, &own);
    if !chosen.from_file.is_empty() {
        text += &format!("from {}: {}\n", defaults::FILE, chosen.from_file.join(", "));
    }
    let mut json = json(&own, &folder, faults.as_ref());
    if with_fixtures {
        json["fixtures"] = json!(manifests);
    }
    if !chosen.from_file.is_empty() {
        json["defaults"] = json!({ "file": defaults::FILE, "keys": chosen.from_file });
    }
    Ok(Outcome { text, json, failed: false })
}

/// What options say; where they are not given, what the working folder's file says, else fabkit.
struct Chosen {
    tolerance_mm: f64,
    bed: Bed,
    stock: Bed,
    kerf_mm: Option<f64>,
    process: Option<PathBuf>,
    /// The folder that folders are made in.
    output: PathBuf,
    /// Which of them come from the file.
    from_file: Vec<&'static str>,
}

impl Chosen {
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
        // What `--nominal` rules out counts as given.
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
            tolerance_mm: args.tolerance.or(defaults.tolerance_mm).unwrap_or(TOLERANCE_MM),
            bed: sized(args.bed, defaults.bed_mm, Bed::default()),
            stock: sized(args.stock, defaults.stock_mm, DEFAULT_STOCK),
            kerf_mm: args.kerf.or(defaults.kerf_mm.filter(|_| !nominal)),
            process,
            output: defaults.output.clone().unwrap_or_else(|| "out".into()),
            from_file,
        })
    }
}

/// `out/rtac0`, `out/rtac0/pin-dome`.
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

/// What lies in the folder besides what was written now, and what no longer does.
fn remains(exported: &Exported, written: &WrittenExport) -> String {
    let kept = written.manifest.files.len().saturating_sub(exported.manifest.files.len());
    let mut text = String::new();
    if kept > 0 {
        text += &format!("{kept} files of an earlier export of the same design stay\n");
    }
    let mut line = |what: &str, names: Vec<&str>, hint: &str| {
        if !names.is_empty() {
            let more = names.len().saturating_sub(MOST_NAMED);
            let tail = if more > 0 { format!(" and {more} more") } else { String::new() };
            let names = names[..names.len() - more].join(", ");
            text += &format!("{what}: {names}{tail}{hint}\n");
        }
    };
    let of = |why: Otherness| {
        let others = written.manifest.others.iter().filter(move |other| other.why == why);
        others.map(|OtherFile { name, .. }| name.as_str()).collect()
    };
    let hint = "; --clean removes them";
    line("warning: of another version of the design or of the options", of(Otherness::Stale), hint);
    line("warning: changed since an earlier export", of(Otherness::Changed), "");
    line("not fabkit's", of(Otherness::Foreign), "");
    line("removed", written.removed.iter().map(String::as_str).collect(), "");
    text
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

/// The first line: what follows can be printed, and not be built as it is described.
fn warning(faults: &Faults) -> String {
    let [(name, first), others @ ..] = &faults.first[..] else { return String::new() };
    let errors =
        if faults.errors == 1 { "1 error".into() } else { format!("{} errors", faults.errors) };
    let also = others.iter().map(|(name, _)| format!(", {name}")).collect::<String>();
    format!(
        "warning: {name}{also} does not pass `fabkit check` ({errors}; the first: {first}); --force \
         silences this\n"
    )
}

fn json(written: &WrittenExport, folder: &Path, faults: Option<&Faults>) -> Value {
    json!({
        "format": "fabkit-export",
        "version": 2,
        "folder": folder.display().to_string(),
        "check": faults.map(|faults| json!({
            "passed": faults.errors == 0,
            "findings": faults.errors,
            "first": faults.first.first().map(|(_, message)| message),
        })),
        "manifest": written.manifest,
        "removed": written.removed,
    })
}
