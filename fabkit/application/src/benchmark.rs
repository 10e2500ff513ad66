//! Runs the Python benchmark `fabkit_bench` (extra `bench` of the Python package): finds an interpreter that has it,
//! starts it, and relays its messages and its result. The benchmark is Python because the learned models are.

use std::ffi::OsString;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::PathBuf;
use std::process::Stdio;
use std::thread;

use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use serde_json::Value;

use crate::programs::{PYTHON_VARIABLE, Program, RelativeProgram, find_python};

/// Returns the interpreter that runs the benchmark.
pub(crate) fn find_interpreter() -> Result<Program, BenchError> {
    let found = find_python().map_err(|RelativeProgram(path)| BenchError::RelativePython(path))?;
    found.ok_or_else(|| BenchError::NoPackage {
        python: "python3".into(),
        why: "it is in no folder of the search path".into(),
    })
}

/// Python program that starts the benchmark. `-c` puts the current folder first in the search path, as an empty entry;
/// it is removed so that files there cannot shadow modules.
const START_SCRIPT: &str = "import sys\nsys.path = [path for path in sys.path if path]\n\
    try:\n    from fabkit_bench.__main__ import main\nexcept ImportError as error:\n    \
    print(f'error: {error}', file=sys.stderr)\n    sys.exit(9)\nsys.exit(main())\n";
/// Exit status of `START_SCRIPT` when the package is missing.
const MISSING_PACKAGE_STATUS: i32 = 9;

/// Error of a benchmark run.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The interpreter or the package in it is missing.
    #[error("{} cannot run the bench: {why}", .python.display())]
    NoPackage {
        /// Interpreter that was tried.
        python: PathBuf,
        /// Message of the interpreter or of the operating system.
        why: String,
    },
    /// The path of the interpreter is relative: it would be another one in every folder.
    #[error(
        "the interpreter {} is no absolute path; interpreters are not searched for in the current folder",
        .0.display()
    )]
    RelativePython(PathBuf),
    /// The benchmark rejected its input.
    #[error("{message}")]
    Refused {
        /// Error message of the benchmark.
        message: String,
        /// Suggested remedy, if the benchmark gave one.
        hint: Option<String>,
    },
    /// The benchmark ended without a readable result; holds the status or the parse error.
    #[error("the bench stopped without an answer ({0})")]
    NoAnswer(String),
}

impl Explained for BenchError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoPackage { .. } | Self::RelativePython(_) | Self::Refused { .. } => {
                ErrorKind::BadInput
            }
            Self::NoAnswer(_) => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::NoPackage { .. } => Some(format!(
                "install the Python package with its extra `bench`, and name its interpreter by an absolute path in \
                 {PYTHON_VARIABLE}"
            )),
            Self::RelativePython(_) => {
                Some(format!("name it by an absolute path in {PYTHON_VARIABLE}"))
            }
            Self::Refused { hint, .. } => hint.clone(),
            Self::NoAnswer(_) => None,
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::NoPackage { python, .. } | Self::RelativePython(python) => {
                ErrorSubject::from_path("no_bench", python)
            }
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}

/// Runs the benchmark with `arguments`, which must request JSON, and returns its result. `tell` receives each progress
/// line.
///
/// # Errors
/// [`BenchError`].
pub fn run(arguments: &[OsString], tell: &(dyn Fn(&str) + Sync)) -> Result<Value, BenchError> {
    let python = find_interpreter()?;
    let missing = |why: String| BenchError::NoPackage { python: python.path().to_owned(), why };
    let mut command = python.command();
    command.args(["-c", START_SCRIPT]).args(arguments);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| missing(error.to_string()))?;
    let (out, err) = (child.stdout.take(), child.stderr.take());
    let mut answer = String::new();
    let failed = thread::scope(|scope| {
        // Standard error is read in a second thread, so that neither pipe fills up and blocks the child.
        let told = scope.spawn(|| {
            // All lines from the first error on belong to the error message.
            let mut failed: Vec<String> = Vec::new();
            for line in err.into_iter().flat_map(|err| BufReader::new(err).lines()).flatten() {
                if failed.is_empty() && !line.starts_with("error: ") {
                    tell(&line)
                } else {
                    failed.push(line)
                }
            }
            failed
        });
        if let Some(mut out) = out {
            // A failed read leaves incomplete JSON, which is reported below.
            let _ = out.read_to_string(&mut answer);
        }
        told.join().unwrap_or_default()
    });
    let status = child.wait().map_err(|error| BenchError::NoAnswer(error.to_string()))?;
    // Python's commands print hints on lines of their own, after the message.
    let (hints, said): (Vec<String>, Vec<String>) =
        failed.into_iter().partition(|line| line.trim_start().starts_with("= help: "));
    let said = said.join("\n");
    let said = said.strip_prefix("error: ").unwrap_or(&said).to_owned();
    match status.code() {
        Some(0) => serde_json::from_str(&answer).map_err(|e| BenchError::NoAnswer(e.to_string())),
        Some(MISSING_PACKAGE_STATUS) => Err(missing(said)),
        _ if said.is_empty() => Err(BenchError::NoAnswer(status.to_string())),
        _ => {
            let hint = hints.first().map(|hint| hint.trim_start().replacen("= help: ", "", 1));
            Err(BenchError::Refused { message: said, hint })
        }
    }
}
