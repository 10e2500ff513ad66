//! Sweep rows computed by the Python benchmark. Each thread has an interpreter that receives variant numbers and
//! returns complete rows. Interpreters live as long as the sweep, because starting one takes longer than many rows.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::sync::Mutex;

use fabkit_sweep::{Plan, Row};
use serde_json::Value;

use super::SweepError;
use crate::benchmark::{self, BenchError};
use crate::programs::{Program, RelativeProgram};

/// Python program that starts a worker. `-c` puts the current folder first in the search path, as an empty entry; it is
/// removed so that files there cannot shadow modules.
const START_SCRIPT: &str = "import sys\nsys.path = [path for path in sys.path if path]\n\
    try:\n    from fabkit_bench._worker import main\nexcept ImportError as error:\n    \
    import json\n    print(json.dumps({'missing': str(error)}))\n    sys.exit(9)\nmain()\n";

/// Pool of idle workers, with what starting another one needs.
pub(super) struct BenchWorkers<'a> {
    source: String,
    python: Program,
    idle: Mutex<Vec<Worker>>,
    cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> BenchWorkers<'a> {
    /// Starts the first worker, so that a missing package is reported at once. Without `python`, the interpreter is
    /// taken from the environment.
    pub(super) fn new(
        plan: &Plan,
        python: Option<&Path>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
    ) -> Result<Self, SweepError> {
        let source = plan.source().to_json().map_err(|e| BenchError::NoAnswer(e.to_string()))?;
        let python = match python {
            Some(path) => Program::new(path.to_owned())
                .map_err(|RelativeProgram(path)| BenchError::RelativePython(path))?,
            None => benchmark::find_interpreter()?,
        };
        let idle = Mutex::new(vec![Worker::start(&python, &source)?]);
        Ok(Self { source, python, idle, cancelled })
    }

    /// Computes the row of a variant.
    ///
    /// # Errors
    /// [`SweepError::Cancelled`]; a worker that cannot be started, or that ended.
    pub(super) fn row(&self, number: usize) -> Result<Row, SweepError> {
        let idle = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let mut worker = match idle {
            Some(worker) => worker,
            None => Worker::start(&self.python, &self.source)?,
        };
        let answer = match worker.ask(&number.to_string()) {
            // A signal reaches the workers too, so that their end may be the cancellation.
            Err(_) if (self.cancelled)() => return Err(SweepError::Cancelled),
            answer => answer?,
        };
        let row = Row::from_line(answer["row"].as_str().unwrap_or_default());
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(worker);
        }
        row.map_err(SweepError::InvalidLine)
    }
}

/// One Python interpreter.
struct Worker {
    python: PathBuf,
    child: Child,
    ask: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Worker {
    fn start(program: &Program, source: &str) -> Result<Self, BenchError> {
        let python = program.path().to_owned();
        let missing = |why: &dyn std::fmt::Display| BenchError::NoPackage {
            python: python.clone(),
            why: why.to_string(),
        };
        let mut command = program.command();
        // The sweep already runs one worker for each thread.
        command.args(["-c", START_SCRIPT]).env("RAYON_NUM_THREADS", "1");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().map_err(|error| missing(&error))?;
        let (Some(ask), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(missing(&"it has no pipes"));
        };
        let mut worker =
            Self { python: python.clone(), child, ask, answers: BufReader::new(answers) };
        let hello = worker.ask(source)?;
        let version = hello["version"].as_str().unwrap_or_default();
        if version != fabkit_export::VERSION {
            return Err(missing(&format!(
                "its package is of version {version}, this is {}",
                fabkit_export::VERSION
            )));
        }
        Ok(worker)
    }

    /// Writes one line and reads the answer.
    fn ask(&mut self, line: &str) -> Result<Value, BenchError> {
        // A failed write means that the worker has ended; its reason is in the answer it wrote before.
        let _ = writeln!(self.ask, "{line}").and_then(|()| self.ask.flush());
        let mut answer = String::new();
        let read = self.answers.read_line(&mut answer);
        if !matches!(read, Ok(1..)) {
            let ended = self.child.wait().map_or_else(|e| e.to_string(), |s| s.to_string());
            return Err(BenchError::NoAnswer(ended));
        }
        let answer: Value =
            serde_json::from_str(&answer).map_err(|e| BenchError::NoAnswer(e.to_string()))?;
        if let Some(why) = answer["missing"].as_str() {
            return Err(BenchError::NoPackage { python: self.python.clone(), why: why.into() });
        }
        match answer["error"].as_str() {
            Some(said) => Err(BenchError::NoAnswer(said.into())),
            None => Ok(answer),
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // Errors are ignored: the process may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
