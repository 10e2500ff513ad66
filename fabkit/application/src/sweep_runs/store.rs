//! Folder of a sweep: stored rows, tables and report.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use fabkit_export::ExportError;
use fabkit_files::memory::MemoryError;
use fabkit_files::resumable::{
    FilesByPath, FolderKind, Piece, ResumableFolder, ResumableFolderError, SAME_VERSION_HINT,
};
use fabkit_files::staging::{OutputFile, StagingError};
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_sweep::{InvalidRow, PANIC, Plan, PlanSource, Row, Status, Table, report};
use serde_json::{Map, Value, json};

use super::count_statuses;
use crate::benchmark::BenchError;

/// Kind of a sweep's folder. Version 1 had no checksums.
pub const KIND: FolderKind = FolderKind { what: "sweep", name: "sweep", version: 2 };
/// Prefix of the names of row files.
const ROW_FILE_PREFIX: &str = "rows-";

/// Error of a sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Too little memory.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The folder holds something else, is in use, or cannot be written to.
    #[error(transparent)]
    Folder(#[from] ResumableFolderError),
    /// A row that cannot be stored.
    #[error(transparent)]
    Row(#[from] InvalidRow),
    /// A line from another process that is not a row.
    #[error(transparent)]
    InvalidLine(InvalidRow),
    /// A row from another process that does not belong to this plan.
    #[error("a worker sent a row of variant {variant}, {what}")]
    ForeignRow {
        /// Number of the variant as received.
        variant: usize,
        /// Contradiction to the plan.
        what: String,
    },
    /// A table that cannot be encoded.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The tables cannot be moved into place.
    #[error(transparent)]
    Staging(#[from] StagingError),
    /// Rows are missing.
    #[error("{missing} of {all} rows are missing")]
    Unfinished {
        /// Number of missing rows.
        missing: usize,
        /// Number of all rows.
        all: usize,
    },
    /// An interpreter that cannot run the benchmark, or gave up.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// The caller asked to stop.
    #[error("interrupted")]
    Cancelled,
}

impl Explained for SweepError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Memory(error) => error.kind(),
            Self::Folder(error) => error.kind(),
            Self::Staging(error) => error.kind(),
            Self::Bench(error) => error.kind(),
            Self::InvalidLine(_) | Self::ForeignRow { .. } => ErrorKind::Io,
            Self::Cancelled => ErrorKind::Interrupted,
            Self::Row(_) | Self::Export(_) | Self::Unfinished { .. } => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Memory(error) => error.hint(),
            Self::Folder(error) => error.hint(),
            Self::Staging(error) => error.hint(),
            Self::Bench(error) => error.hint(),
            Self::InvalidLine(_) | Self::ForeignRow { .. } => Some(SAME_VERSION_HINT.into()),
            Self::Cancelled => Some("what is finished stays, and can be gone on with".into()),
            Self::Row(_) | Self::Export(_) | Self::Unfinished { .. } => None,
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Bench(error) => error.subject(),
            Self::Folder(error) => error.subject(),
            Self::Staging(error) => error.subject(),
            Self::Memory(error) => error.subject(),
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}

/// Result of a finished sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepResult {
    /// Number of variants.
    pub variants: usize,
    /// Number of rows that an earlier run had finished.
    pub found: usize,
    /// Number of variants of each status, in the order of [`Status::ALL`].
    pub counts: [usize; 4],
    /// Number of failed variants that made fabkit panic.
    pub panicked: usize,
    /// Number of variants on the Pareto front.
    pub on_front: usize,
    /// Reason why no variant is feasible, if none is.
    pub none_left: Option<String>,
    /// Metrics without a value in any variant.
    pub empty_metrics: Vec<String>,
}

impl SweepResult {
    /// Reads the result from `sweep.json`.
    fn read(document: &Value) -> Option<Self> {
        let count = |value: &Value| value.as_u64().map(|count| count as usize);
        let mut counts = [0; 4];
        for (place, status) in counts.iter_mut().zip(Status::ALL) {
            *place = count(&document["status"][status.word()])?;
        }
        let names = document["empty_metrics"].as_array()?.iter();
        Some(Self {
            variants: count(&document["variants"])?,
            found: 0,
            counts,
            panicked: count(&document["panicked"])?,
            on_front: document["pareto"].as_array()?.len(),
            none_left: document["none_left"].as_str().map(str::to_owned),
            empty_metrics: names.filter_map(|name| name.as_str().map(str::to_owned)).collect(),
        })
    }
}

/// Open sweep. Its folder is locked until it is dropped.
#[derive(Debug)]
pub struct Store {
    folder: ResumableFolder,
    all: usize,
    /// Variants whose rows an earlier run left.
    found: BTreeSet<usize>,
    /// Result of an earlier run, if it finished.
    finished: Option<SweepResult>,
}

impl Store {
    /// Creates the folder with the plan in it, or opens a folder with the same plan.
    ///
    /// # Errors
    /// A folder that is not empty, is in use or, to resume, holds another sweep.
    pub fn open(folder: &Path, plan: &Plan, resume: bool) -> Result<Self, SweepError> {
        let folder = ResumableFolder::open(KIND, folder, document(plan), resume)?;
        let finished = folder.document().and_then(SweepResult::read);
        let mut store = Self { folder, all: plan.len(), found: BTreeSet::new(), finished };
        if store.finished.is_none() {
            store.found = store.read_rows(plan)?.into_keys().collect();
        }
        Ok(store)
    }

    /// Returns the number of rows that an earlier run had finished.
    pub fn found(&self) -> usize {
        if self.finished.is_some() { self.all } else { self.found.len() }
    }

    /// Returns the variants whose rows are missing, in order.
    pub fn missing(&self) -> Vec<usize> {
        match self.finished {
            Some(_) => Vec::new(),
            None => (0..self.all).filter(|number| !self.found.contains(number)).collect(),
        }
    }

    /// Stores rows in one file. Each variant's row must be stored by exactly one call.
    ///
    /// # Errors
    /// Rows that do not belong to the plan, or files that cannot be written.
    pub fn store_rows(&self, plan: &Plan, rows: &[Row]) -> Result<(), SweepError> {
        let Some(first) = rows.first() else { return Ok(()) };
        let mut text = String::new();
        for row in rows {
            let stranger = |what| SweepError::ForeignRow { variant: row.variant, what };
            check_row(plan, row).map_err(stranger)?;
            text += &row.to_line()?;
            text.push('\n');
        }
        let name = KIND.partial(&format!("{ROW_FILE_PREFIX}{:06}.jsonl", first.variant));
        Ok(self.folder.put(&name, text.as_bytes())?)
    }

    /// Writes the tables and the report, and removes the row files.
    ///
    /// # Errors
    /// Missing rows, or files that cannot be written.
    pub fn finish(
        self,
        plan: &Plan,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<SweepResult, SweepError> {
        if let Some(finished) = self.finished {
            // A run that was killed after writing the tables leaves the row files; they are removed now.
            self.folder.finish(Map::new())?;
            return Ok(SweepResult { found: self.all, ..finished });
        }
        let rows = self.read_rows(plan)?;
        if rows.len() < self.all {
            let missing = self.all - rows.len();
            return Err(SweepError::Unfinished { missing, all: self.all });
        }
        let Tables { finished, results, files } = make_tables(plan, rows.into_values().collect())?;
        for file in &files {
            if cancelled() {
                return Err(SweepError::Cancelled);
            }
            self.folder.put(&file.name, &file.bytes)?;
        }
        // The list of contents comes last: its existence proves that the other files are complete.
        self.folder.finish(results)?;
        Ok(SweepResult { found: self.found.len(), ..finished })
    }

    /// Reads all stored rows. Lines that are not rows of this plan are ignored, so that they are computed again.
    fn read_rows(&self, plan: &Plan) -> Result<BTreeMap<usize, Row>, SweepError> {
        let mut rows = BTreeMap::new();
        for name in self.folder.names(&KIND.partial(ROW_FILE_PREFIX)) {
            let text = String::from_utf8(self.folder.read(&name)?).unwrap_or_default();
            let read = text.lines().filter_map(|line| Row::from_line(line).ok());
            let of_plan = read.filter(|row| check_row(plan, row).is_ok());
            rows.extend(of_plan.map(|row| (row.variant, row)));
        }
        Ok(rows)
    }
}

/// Checks a row against the plan; the error says what contradicts it.
fn check_row(plan: &Plan, row: &Row) -> Result<(), String> {
    if row.variant >= plan.len() {
        return Err(format!("but there are {}", plan.len()));
    }
    if row.parameters != plan.variant(row.variant).values {
        return Err("with other values than the plan's".into());
    }
    match row.metrics.keys().find(|name| !plan.has_metric(name)) {
        Some(name) => Err(format!("with `{name}`, which is no metric of the plan")),
        None => Ok(()),
    }
}

/// Describes the plan, for comparison when it is resumed.
fn document(plan: &Plan) -> Value {
    let PlanSource { text, sensor_yaml, custom_metrics, .. } = plan.source();
    json!({
        "format": "fabkit-sweep",
        "version": KIND.version,
        "fabkit": fabkit_export::VERSION,
        "sensor": plan.sensor(),
        "sensor_hash": blake3::hash(sensor_yaml.as_bytes()).to_hex().as_str(),
        "plan": text.lines().collect::<Vec<_>>(),
        "plan_hash": plan.hash(),
        "custom_metrics": custom_metrics,
    })
}

/// Final files of a sweep.
struct Tables {
    finished: SweepResult,
    /// Entries of `sweep.json` besides the plan and its files.
    results: Map<String, Value>,
    files: [OutputFile; 3],
}

/// Makes tables, report and result from rows of any variants.
fn make_tables(plan: &Plan, rows: Vec<Row>) -> Result<Tables, SweepError> {
    let table = Table::new(plan, rows);
    let rows = table.rows();
    let counts = count_statuses(rows);
    let panicked = rows.iter().filter(|row| row.error_code.as_deref() == Some(PANIC)).count();
    let on_front = |(i, row): (usize, &Row)| table.is_on_front(i).then_some(row.variant);
    let front: Vec<usize> = rows.iter().enumerate().filter_map(on_front).collect();
    let by_status: Map<String, Value> =
        Status::ALL.iter().zip(counts).map(|(s, n)| (s.word().to_owned(), json!(n))).collect();
    let empty_metrics: Vec<String> = table.empty_metrics().into_iter().map(str::to_owned).collect();
    let results = [
        ("variants", json!(rows.len())),
        ("status", Value::Object(by_status)),
        ("panicked", json!(panicked)),
        ("pareto", json!(front)),
        ("empty_metrics", json!(empty_metrics)),
        ("none_left", json!(explain_infeasibility(rows))),
    ];
    let file = |name: &str, bytes: Vec<u8>| OutputFile { name: name.into(), bytes };
    let files = [
        file("sweep.csv", table.to_csv().into_bytes()),
        file("sweep.parquet", table.to_parquet()?),
        file("report.html", report(plan, &table).into_bytes()),
    ];
    let finished = SweepResult {
        variants: rows.len(),
        found: 0,
        counts,
        panicked,
        on_front: front.len(),
        none_left: explain_infeasibility(rows),
        empty_metrics,
    };
    let results = results.map(|(key, value)| (key.to_owned(), value)).into_iter().collect();
    Ok(Tables { finished, results, files })
}

/// Makes all files of a sweep whose rows are known at once, the list of contents last.
pub(super) fn make_all_files(
    plan: &Plan,
    rows: Vec<Row>,
) -> Result<(SweepResult, Vec<OutputFile>), SweepError> {
    let Tables { finished, results, files } = make_tables(plan, rows)?;
    let pieces = files.iter().map(|file| (file.name.clone(), Piece::from_bytes(&file.bytes)));
    let bytes = KIND.whole(&document(plan), results, &pieces.collect::<FilesByPath>());
    let mut files = Vec::from(files);
    files.push(OutputFile { name: KIND.document(), bytes });
    Ok((finished, files))
}

/// Explains why no variant is feasible, if none is: the constraints that exclude most, and an example of a variant that
/// cannot be built.
fn explain_infeasibility(rows: &[Row]) -> Option<String> {
    if rows.iter().any(|row| row.status == Status::Ok) {
        return None;
    }
    let all = rows.len();
    // A reason begins with the text of its constraint, followed by one of these endings.
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let excluded = rows.iter().filter(|row| row.status == Status::Excluded);
    for reason in excluded.flat_map(|row| row.reason.as_deref().unwrap_or_default().split("; ")) {
        let ends = [" does not hold", " cannot hold"];
        let text = ends.iter().find_map(|end| reason.split_once(end)).map_or(reason, |(t, _)| t);
        *counts.entry(text).or_default() += 1;
    }
    let mut counts: Vec<(&str, usize)> = counts.into_iter().collect();
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    let mut told: Vec<String> =
        counts.iter().map(|(text, count)| format!("`{text}` excludes {count} of {all}")).collect();
    let others: Vec<&Row> = rows.iter().filter(|row| row.status != Status::Excluded).collect();
    if let [first, ..] = others[..] {
        let why = first.reason.as_deref().unwrap_or_default();
        told.push(format!(
            "{} cannot be built, variant {} because {why}",
            others.len(),
            first.variant
        ));
    }
    Some(told.join(", "))
}
