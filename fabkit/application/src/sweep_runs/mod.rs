//! Sweep folders: rows are stored as they are finished, then tables and a report are written.
//!
//! | path | holds |
//! |---|---|
//! | `sweep.csv`, `sweep.parquet` | one row for each variant, in order |
//! | `report.html` | what became of them, the Pareto front, plots |
//! | `sweep.json` | which plan it was, how many variants became what, and hashes of the above |
//! | `sweep.partial/` | until the above are there: the plan, and rows in files that appear whole |
//!
//! One process writes at a time ([`resumable`](fabkit_files::resumable)). A variant that makes fabkit panic becomes a
//! row with the location of the panic. Rows are pure functions of the plan, independent of the run, process or machine
//! that computed them: killed and resumed, a sweep ends with the same bytes as an undisturbed one.

mod bench_workers;
mod store;

use std::path::Path;
use std::sync::Mutex;

use fabkit_files::Error;
use fabkit_files::diagnostics::{DiagnosedDesign, SourceText};
use fabkit_files::memory::{self, MemoryHint};
use fabkit_files::progress::{ProgressCallback, ProgressStep};
use fabkit_files::reading::{self, ExpectedFile};
use fabkit_files::resumable::ResumableFolderError;
use fabkit_files::staging::write_each;
use fabkit_sweep::{Plan, PlanSource, Row, Status};
use fabkit_text::InvalidDesign;
use rayon::prelude::*;

use self::bench_workers::BenchWorkers;
pub use self::store::{KIND, Store, SweepError, SweepResult};
use crate::source::{MAX_YAML_BYTES, Source};

/// Memory of one row, in the tables and in the report, bytes.
const ROW_BYTES: u64 = 6000;
/// Memory of one variant while it is computed, its meshes included, bytes.
const VARIANT_BYTES: u64 = 40 * memory::MB;
/// Memory of one variant whose benchmark runs in an interpreter, bytes.
const BENCH_BYTES: u64 = 500 * memory::MB;
/// Largest number of rows that each thread loses when the run is killed.
const MAX_ROWS_PER_FILE: usize = 16;

/// Reads a plan and the sensor that it names. A sensor's path is relative to the plan's folder. `custom` names metrics
/// that the caller computes.
///
/// # Errors
/// Files that cannot be read, and all problems of the plan or its sensor.
pub fn read_plan(path: &Path, custom: &[String]) -> Result<Plan, Error> {
    let hint = "is it the right file? It names a sensor and its axes";
    let expected = ExpectedFile { what: "a plan of a sweep", max_bytes: MAX_YAML_BYTES, hint };
    let text = reading::read_text(path, expected)?;
    parse_plan(&path.display().to_string(), &text, path.parent().unwrap_or(Path::new("")), custom)
}

/// Reads a plan from text; `file` names it in messages.
///
/// # Errors
/// See [`read_plan`].
///
/// ```
/// use std::path::Path;
///
/// use fabkit_application::sweep_runs::parse_plan;
///
/// let text = "format: 1\nsensor: rtac0\naxes: {camera.depth: [6 mm, 7 mm]}\nmetrics: [coverage]\n";
/// let plan = parse_plan("sweep.yaml", text, Path::new("."), &[])?;
/// assert_eq!((plan.sensor(), plan.len()), ("rtac0", 2));
/// // The sensor's own errors are told as those of the plan are.
/// assert!(parse_plan("sweep.yaml", &text.replace("rtac0", "rtac"), Path::new("."), &[]).is_err());
/// # Ok::<(), fabkit_application::Error>(())
/// ```
pub fn parse_plan(file: &str, text: &str, folder: &Path, custom: &[String]) -> Result<Plan, Error> {
    let of_plan = || SourceText { file: file.into(), text: text.into() };
    let invalid = |invalid: InvalidDesign| DiagnosedDesign::new(invalid, [of_plan()]);
    let sensor = Plan::sensor_name(file, text).map_err(invalid)?;
    let beside = folder.join(&sensor);
    let is_file = Path::new(&sensor).extension().is_some_and(|e| e == "yaml" || e == "yml");
    let source =
        if is_file { Source::find(&beside.display().to_string())? } else { Source::find(&sensor)? };
    let SourceText { file: sensor_file, text: sensor_yaml } = source.text().clone();
    let plan = PlanSource {
        file: file.into(),
        text: text.into(),
        sensor_file,
        sensor_yaml,
        sensor_bases: Vec::new(),
        custom_metrics: custom.to_vec(),
        user: source.user().map(|user| (user.file.clone(), user.text.clone())),
    }
    .with_bases(source.bases());
    Plan::new(plan).map_err(|invalid| {
        let texts = std::iter::once(of_plan()).chain(source.texts().cloned());
        DiagnosedDesign::new(invalid, texts).into()
    })
}

/// Sweep to be run.
#[derive(Clone, Copy, Debug)]
pub struct Sweep<'a> {
    /// Plan with its variants and metrics.
    pub plan: &'a Plan,
    /// Resume an earlier run of the same plan.
    pub resume: bool,
    /// Interpreter for benchmarks; by default the one named by the environment.
    pub python: Option<&'a Path>,
}

/// Computes the missing rows on all threads, and writes the tables.
///
/// `cancelled` is called before each row; rows finished by then are kept for `resume`.
///
/// # Errors
/// [`SweepError`]: too little memory, a folder that is not empty or holds another sweep, files that cannot be written,
/// cancellation.
///
/// ```
/// use std::path::Path;
///
/// use fabkit_application::progress::ignore_progress;
/// use fabkit_application::sweep_runs::{Sweep, parse_plan, run};
///
/// let text = "format: 1\nsensor: rtac0\naxes: {camera.depth: [6 mm, 7 mm]}\nmetrics: [coverage]\n";
/// let plan = &parse_plan("sweep.yaml", text, Path::new("."), &[])?;
/// let folder = std::env::temp_dir().join(format!("fabkit-sweep-{}", std::process::id()));
/// let result = run(&folder, Sweep { plan, resume: false, python: None }, &ignore_progress, &|| false)?;
/// // Both variants can be built; the table has a line for each, and a header.
/// assert_eq!((result.variants, result.counts), (2, [2, 0, 0, 0]));
/// assert_eq!(std::fs::read_to_string(folder.join("sweep.csv"))?.lines().count(), 3);
/// std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn run(
    folder: &Path,
    sweep: Sweep,
    progress: ProgressCallback,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<SweepResult, SweepError> {
    let rows = ROW_BYTES * sweep.plan.len() as u64;
    let each =
        if sweep.plan.bench_metrics().next().is_some() { BENCH_BYTES } else { VARIANT_BYTES };
    memory::run_on_workers("the sweep", rows, each, MemoryHint::Variants, || {
        compute_rows(folder, sweep, progress, cancelled)
    })
}

/// Runs the sweep on the threads for which there is memory.
fn compute_rows(
    folder: &Path,
    sweep: Sweep,
    progress: ProgressCallback,
    cancelled: &(dyn Fn() -> bool + Sync),
) -> Result<SweepResult, SweepError> {
    let Sweep { plan, resume, python } = sweep;
    // Started before the folder is made: without an interpreter, no unfinished sweep is left behind.
    let is_benched = plan.bench_metrics().next().is_some();
    let benches = is_benched.then(|| BenchWorkers::new(plan, python, cancelled)).transpose()?;
    let store = Store::open(folder, plan, resume)?;
    let found = store.found();
    let done = Mutex::new(found);
    let missing = store.missing();
    // Rows per file: few enough that all threads have work until the end.
    let share = missing.len() / (4 * rayon::current_num_threads()).max(1);
    let together = if benches.is_some() { 1 } else { share.clamp(1, MAX_ROWS_PER_FILE) };
    missing.par_chunks(together).try_for_each(|numbers| {
        let mut rows: Vec<Row> = Vec::with_capacity(numbers.len());
        for number in numbers {
            if cancelled() {
                break;
            }
            rows.push(match &benches {
                Some(benches) => benches.row(*number)?,
                None => plan.evaluate(*number),
            });
            if let Ok(mut done) = done.lock() {
                *done += 1;
                progress(ProgressStep {
                    done: *done,
                    resumed: found,
                    total: plan.len(),
                    last_name: "",
                });
            }
        }
        let is_whole = rows.len() == numbers.len();
        store.store_rows(plan, &rows)?;
        if is_whole { Ok(()) } else { Err(SweepError::Cancelled) }
    })?;
    store.finish(plan, cancelled)
}

/// Writes the tables and the report for rows chosen by the caller, in a new folder.
///
/// # Errors
/// A folder that is not empty, or files that cannot be written.
pub fn write_rows(folder: &Path, plan: &Plan, rows: Vec<Row>) -> Result<SweepResult, SweepError> {
    if folder.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(ResumableFolderError::NotEmpty { folder: folder.into() }.into());
    }
    let (finished, files) = store::make_all_files(plan, rows)?;
    // The folder is empty: nothing of anybody's is replaced.
    write_each(files.iter().map(|file| (folder.join(&file.name), &file.bytes[..])), &|| false)?;
    Ok(finished)
}

/// Parses rows that other processes computed.
///
/// # Errors
/// [`SweepError::InvalidLine`] for a line that is not a row.
///
/// ```
/// use fabkit_application::sweep_runs::parse_rows;
/// let line = r#"{"variant": 0, "status": "ok", "error_code": null, "reason": null, "notes": [], "parameters": [],
///     "metrics": {}}"#;
/// assert_eq!(parse_rows(&[line.into()])?[0].variant, 0);
/// assert!(parse_rows(&["no row".into()]).is_err());
/// # Ok::<(), fabkit_application::sweep_runs::SweepError>(())
/// ```
pub fn parse_rows(lines: &[String]) -> Result<Vec<Row>, SweepError> {
    lines.iter().map(|line| Row::from_line(line).map_err(SweepError::InvalidLine)).collect()
}

/// Counts the rows of each status, in the order of [`Status::ALL`].
fn count_statuses(rows: &[Row]) -> [usize; 4] {
    Status::ALL.map(|status| rows.iter().filter(|row| row.status == status).count())
}
