//! The folder of a sweep.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use fabkit_export::ExportError;
use fabkit_sweep::{InvalidRow, Plan, Row, Status, Table, report};
use serde_json::{Value, json};

use super::counts;
use crate::staging::{OutputFile, StagingError, write_all};

const FINISHED: &str = "sweep.json";
const PARTIAL: &str = "sweep.partial";
const PLAN: &str = "plan.json";

/// Why there is no sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Something is there already.
    #[error("{} is not empty", .folder.display())]
    NotEmpty {
        /// Where.
        folder: PathBuf,
    },
    /// A sweep is there, but another one.
    #[error(
        "{} holds another sweep, whose plan has the hash {found}; this one has {wanted}",
        .folder.display()
    )]
    OtherPlan {
        /// Where.
        folder: PathBuf,
        /// BLAKE3 of the plan that is there, shortened.
        found: String,
        /// BLAKE3 of the plan asked for, shortened.
        wanted: String,
    },
    /// The operating system said no.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// For example `write`.
        action: &'static str,
        /// Which file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A row that cannot be written down.
    #[error(transparent)]
    Row(#[from] InvalidRow),
    /// A table that cannot be written down.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The tables cannot be put in their places.
    #[error(transparent)]
    Staging(#[from] StagingError),
    /// Rows are missing.
    #[error("{missing} of {all} rows are missing")]
    Unfinished {
        /// How many.
        missing: usize,
        /// Of how many.
        all: usize,
    },
    /// The caller asked to stop.
    #[error("stopped; `--resume` goes on from here")]
    Cancelled,
}

/// What a finished sweep came to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finished {
    /// How many variants there are.
    pub variants: usize,
    /// Rows that an earlier run had finished.
    pub found: usize,
    /// How many variants became what, in the order of [`Status::ALL`].
    pub counts: [usize; 4],
    /// How many are on the Pareto front.
    pub on_front: usize,
    /// Why no variant is left, if none is.
    pub none_left: Option<String>,
    /// Metrics that no variant has.
    pub empty_metrics: Vec<String>,
}

/// An open sweep.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    hash: String,
    all: usize,
    /// Rows by number, of earlier runs.
    found: BTreeMap<usize, ()>,
}

impl Store {
    /// Makes the folder and leaves the plan in it, or finds the same plan there.
    ///
    /// # Errors
    /// A folder that is not empty, or, to resume, one that holds another sweep.
    pub fn open(folder: &Path, plan: &Plan, resume: bool) -> Result<Self, SweepError> {
        let mut store = Self {
            folder: folder.into(),
            hash: plan.hash(),
            all: plan.len(),
            found: BTreeMap::new(),
        };
        let there = match store.hash_there(FINISHED)? {
            None => store.hash_there(&format!("{PARTIAL}/{PLAN}"))?,
            finished => finished,
        };
        match there {
            Some(found) if resume && found == store.hash => store.find_rows()?,
            Some(found) if resume => {
                let short = |hash: &str| hash.chars().take(16).collect();
                let (found, wanted) = (short(&found), short(&store.hash));
                return Err(SweepError::OtherPlan { folder: folder.into(), found, wanted });
            }
            Some(_) => return Err(SweepError::NotEmpty { folder: folder.into() }),
            None if store.is_empty()? => {}
            None => return Err(SweepError::NotEmpty { folder: folder.into() }),
        }
        let partial = folder.join(PARTIAL);
        fs::create_dir_all(&partial).map_err(|e| failed("create the folder", &partial, e))?;
        let document =
            json!({ "format": "fabkit-sweep-plan", "version": 1, "plan_hash": store.hash });
        store.replace(PLAN, format!("{document:#}\n").as_bytes())?;
        Ok(store)
    }

    /// How many rows an earlier run had finished.
    pub fn found(&self) -> usize {
        self.found.len()
    }

    /// The variants whose rows are missing, in order.
    pub fn missing(&self) -> Vec<usize> {
        (0..self.all).filter(|number| !self.found.contains_key(number)).collect()
    }

    /// Keeps rows. Each variant's row is kept by one call.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn put(&self, rows: &[Row]) -> Result<(), SweepError> {
        let Some(first) = rows.first() else { return Ok(()) };
        let mut text = String::new();
        for row in rows {
            text += &row.to_line()?;
            text.push('\n');
        }
        self.replace(&format!("rows-{:06}.jsonl", first.variant), text.as_bytes())
    }

    /// Writes the tables and the report, and removes the rows' own files.
    ///
    /// # Errors
    /// Rows that are missing; files that cannot be written.
    pub fn finish(self, plan: &Plan, cancelled: &dyn Fn() -> bool) -> Result<Finished, SweepError> {
        let rows = self.read_rows()?;
        if rows.len() < self.all {
            let missing = self.all - rows.len();
            return Err(SweepError::Unfinished { missing, all: self.all });
        }
        let finished = write_tables(&self.folder, plan, rows.into_values().collect(), cancelled)?;
        let partial = self.folder.join(PARTIAL);
        fs::remove_dir_all(&partial).map_err(|e| failed("remove", &partial, e))?;
        Ok(Finished { found: self.found.len(), ..finished })
    }

    /// The plan's hash that a document names.
    fn hash_there(&self, name: &str) -> Result<Option<String>, SweepError> {
        let path = self.folder.join(name);
        match fs::read(&path) {
            Ok(bytes) => {
                let document: Value = serde_json::from_slice(&bytes).unwrap_or_default();
                Ok(Some(document["plan_hash"].as_str().unwrap_or_default().to_owned()))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed("read", &path, error)),
        }
    }

    fn is_empty(&self) -> Result<bool, SweepError> {
        match fs::read_dir(&self.folder) {
            // What a run leaves that was killed before it had a plan.
            Ok(entries) => Ok(entries.flatten().all(|entry| entry.file_name() == PARTIAL)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(true),
            Err(error) => Err(failed("read the folder", &self.folder, error)),
        }
    }

    fn find_rows(&mut self) -> Result<(), SweepError> {
        self.found = self.read_rows()?.into_keys().map(|number| (number, ())).collect();
        Ok(())
    }

    /// All rows that are there. A file that cannot be read as rows is as good as none.
    fn read_rows(&self) -> Result<BTreeMap<usize, Row>, SweepError> {
        let partial = self.folder.join(PARTIAL);
        let mut rows = BTreeMap::new();
        let entries = match fs::read_dir(&partial) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(rows),
            Err(error) => return Err(failed("read the folder", &partial, error)),
        };
        for entry in entries {
            let path = entry.map_err(|e| failed("read the folder", &partial, e))?.path();
            if path.extension().is_none_or(|extension| extension != "jsonl") {
                continue;
            }
            let text = fs::read_to_string(&path).map_err(|e| failed("read", &path, e))?;
            let read = text.lines().filter_map(|line| Row::from_line(line).ok());
            rows.extend(read.filter(|row| row.variant < self.all).map(|row| (row.variant, row)));
        }
        Ok(rows)
    }

    /// Writes beside the place, syncs, and renames.
    fn replace(&self, name: &str, bytes: &[u8]) -> Result<(), SweepError> {
        let partial = self.folder.join(PARTIAL);
        let place = partial.join(name);
        let temporary = partial.join(format!(".{name}.new"));
        let written = File::create(&temporary).and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        });
        let renamed = written.and_then(|()| fs::rename(&temporary, &place));
        renamed.map_err(|error| {
            // Nothing half-written stays behind a full disk.
            let _ = fs::remove_file(&temporary);
            failed("write", &place, error)
        })
    }
}

fn failed(action: &'static str, path: &Path, source: io::Error) -> SweepError {
    SweepError::Io { action, path: path.into(), source }
}

/// Writes the tables and the report of rows, whichever variants they are of.
pub(super) fn write_tables(
    folder: &Path,
    plan: &Plan,
    rows: Vec<Row>,
    cancelled: &dyn Fn() -> bool,
) -> Result<Finished, SweepError> {
    let table = Table::new(plan, rows);
    let rows = table.rows();
    let counts = counts(rows);
    let on_front = |(i, row): (usize, &Row)| table.is_on_front(i).then_some(row.variant);
    let front: Vec<usize> = rows.iter().enumerate().filter_map(on_front).collect();
    let by_status: serde_json::Map<String, Value> =
        Status::ALL.iter().zip(counts).map(|(s, n)| (s.word().to_owned(), json!(n))).collect();
    let empty_metrics: Vec<String> = table.empty_metrics().into_iter().map(str::to_owned).collect();
    let document = json!({
        "format": "fabkit-sweep",
        "version": 1,
        "fabkit": fabkit_export::VERSION,
        "sensor": plan.sensor(),
        "plan_hash": plan.hash(),
        "variants": rows.len(),
        "status": by_status,
        "pareto": front,
        "empty_metrics": empty_metrics,
    });
    let file = |name: &str, bytes: Vec<u8>| OutputFile { name: name.into(), bytes };
    let files = [
        file("sweep.csv", table.to_csv().into_bytes()),
        file("sweep.parquet", table.to_parquet()?),
        file("report.html", report(plan, &table).into_bytes()),
        file(FINISHED, format!("{document:#}\n").into_bytes()),
    ];
    write_all(folder, &files, cancelled)?;
    Ok(Finished {
        variants: rows.len(),
        found: 0,
        counts,
        on_front: front.len(),
        none_left: none_left(rows),
        empty_metrics,
    })
}

/// Why no variant is left, if none is: the constraints that exclude most, or an example of why others
/// cannot be built.
fn none_left(rows: &[Row]) -> Option<String> {
    if rows.iter().any(|row| row.status == Status::Ok) {
        return None;
    }
    let all = rows.len();
    // The reasons begin with the constraint's own text.
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
