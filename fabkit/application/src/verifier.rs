//! Bridge to the Python package `fabkit_verify`, which rebuilds parts with independent geometry kernels.
//!
//! The package receives a folder of exported files and answers with one JSON document. OpenCascade is not linked here;
//! without the package's environment everything else works.

mod interpreter;

use std::ffi::{OsStr, OsString};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{self, Path, PathBuf};
use std::process::Stdio;
use std::sync::mpsc::{self, Sender};
use std::thread;
use std::time::Duration;

use fabkit_designs::Design;
use serde_json::Value;
use tempfile::TempDir;

use self::interpreter::Interpreter;
pub use self::interpreter::PYTHON_VARIABLE;
use fabkit_files::progress::{ProgressCallback, ProgressStep};
use fabkit_files::reading::{self, ExpectedFile, ReadError};
use fabkit_files::staging::OutputFile;
use fabkit_files::{ErrorKind, ErrorSubject, Explained};
use fabkit_text::escape_steering;

use crate::exports::{
    self, ExportOptions, ExportRunError, FolderError, ForeignFile, Format, Overwriting,
};

/// Limits for reading a kernel's STEP file.
const STEP_LIMITS: ExpectedFile =
    ExpectedFile { what: "a STEP file", max_bytes: 1 << 29, hint: "export fewer parts at once" };

/// Error of a verification.
#[derive(Debug, thiserror::Error)]
pub enum VerifierError {
    /// No interpreter with the package was found.
    #[error(
        "the verifier's Python environment is missing: make it with `cargo xtask verify-env` in fabkit's checkout; a fabkit outside its `target` folder needs {PYTHON_VARIABLE} with the absolute path of its interpreter"
    )]
    NoEnvironment,
    /// The named interpreter lacks the package.
    #[error(
        "{PYTHON_VARIABLE} names {}, which cannot import fabkit_verify; `cargo xtask verify-env` \
         makes an environment that can",
        .0.display()
    )]
    NoPackage(PathBuf),
    /// The named interpreter's path is relative: it would be another one in every folder.
    #[error(
        "{PYTHON_VARIABLE} is {}, which is no absolute path; interpreters are not searched for in \
         the current folder",
        .0.display()
    )]
    RelativePython(PathBuf),
    /// The design could not be exported.
    #[error(transparent)]
    Export(#[from] ExportRunError),
    /// The files for the verifier could not be written, or would replace files that fabkit did not write.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// Operating system error.
    #[error("cannot {action}: {source}")]
    Io {
        /// Attempted action, for example `run python`.
        action: String,
        /// Error of the system.
        source: io::Error,
    },
    /// A kernel's output file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The package ended without a valid answer.
    #[error("the verifier stopped without an answer ({0})")]
    NoAnswer(String),
    /// Parts that OpenCascade could not write.
    #[error("no STEP file of {}", .0.join("; "))]
    NoStep(Vec<String>),
}

impl Explained for VerifierError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoEnvironment | Self::NoPackage(_) | Self::RelativePython(_) => {
                ErrorKind::BadInput
            }
            Self::Export(error) => error.kind(),
            Self::Folder(error) => error.kind(),
            Self::Read(error) => error.kind(),
            Self::Io { .. } => ErrorKind::Io,
            Self::NoAnswer(_) | Self::NoStep(_) => ErrorKind::Bug,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Export(error) => error.hint(),
            Self::Folder(FolderError::Refused(_)) => Some("choose another folder".into()),
            Self::Folder(error) => error.hint(),
            Self::Read(error) => error.hint(),
            _ => None,
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::NoEnvironment => ErrorSubject::new("no_verifier"),
            Self::NoPackage(path) | Self::RelativePython(path) => {
                ErrorSubject::from_path("no_verifier", path)
            }
            Self::Export(error) => error.subject(),
            Self::Folder(error) => error.subject(),
            Self::Read(error) => error.subject(),
            other => ErrorSubject::from_kind(other.kind()),
        }
    }
}

/// Python interpreter with the package.
#[derive(Clone, Debug)]
pub struct Verifier {
    python: Interpreter,
}

/// Options of a verification.
#[derive(Clone, Debug, Default)]
pub struct VerifyOptions {
    /// Names of bodies; empty for all parts, layers and components.
    pub parts: Vec<String>,
    /// Names of kernels; empty for all.
    pub kernels: Vec<String>,
    /// Time limit of one kernel for one part, s.
    pub limit_s: Option<f64>,
    /// Folder in which the exported files are kept.
    pub keep: Option<PathBuf>,
    /// HTML report to write.
    pub report: Option<PathBuf>,
}

impl Verifier {
    /// Finds the interpreter: the absolute path in `FABKIT_PYTHON`, or else that of `.venv` in fabkit's checkout, for a
    /// program in its `target` folder. Nothing in the current folder is run.
    ///
    /// # Errors
    /// [`VerifierError::NoEnvironment`], [`VerifierError::NoPackage`], [`VerifierError::RelativePython`].
    pub fn find() -> Result<Self, VerifierError> {
        let folder = temporary_folder()?;
        Ok(Self { python: Interpreter::find(folder.path())? })
    }

    /// Exports a design, has it rebuilt and compared, and returns the package's document (`fabkit-verification` version
    /// 1).
    ///
    /// # Errors
    /// [`VerifierError`]. Disagreement is not an error.
    pub fn verify(
        &self,
        design: &Design,
        options: &VerifyOptions,
        progress: ProgressCallback,
    ) -> Result<Value, VerifierError> {
        let formats = vec![Format::Stl, Format::Tree, Format::Samples];
        let temporary = temporary_folder()?;
        let folder = options.keep.as_deref().unwrap_or(temporary.path());
        write_exports(design, &options.parts, formats, folder)?;
        let mut arguments = vec![OsStr::new("check").to_owned(), absolute(folder)?];
        for kernel in &options.kernels {
            arguments.extend(["--kernel".into(), kernel.into()]);
        }
        if let Some(seconds) = options.limit_s {
            arguments.extend(["--limit".into(), seconds.to_string().into()]);
        }
        if let Some(report) = &options.report {
            arguments.extend(["--report".into(), absolute(report)?]);
        }
        let threads = rayon::current_num_threads().min(2);
        arguments.extend(["--processes".into(), threads.to_string().into()]);
        self.run_package(&arguments, progress)
    }

    /// Makes STEP files of the parts with OpenCascade. An empty `parts` means all parts and, in addition, the whole
    /// sensor as one assembly.
    ///
    /// # Errors
    /// [`VerifierError`].
    pub fn step_files(
        &self,
        design: &Design,
        parts: &[String],
        progress: ProgressCallback,
    ) -> Result<Vec<ForeignFile>, VerifierError> {
        let sensor = &design.sensor;
        let wanted: Vec<&str> = sensor
            .bodies
            .iter()
            .filter(|body| match parts {
                [] => body.is_made(),
                named => named.contains(&body.name),
            })
            .map(|body| body.name.as_str())
            .collect();
        let folder = temporary_folder()?;
        let output = temporary_folder()?;
        write_exports(design, parts, vec![Format::Tree, Format::Samples], folder.path())?;
        let mut arguments =
            vec![OsStr::new("step").to_owned(), absolute(folder.path())?, absolute(output.path())?];
        for name in &wanted {
            arguments.extend(["--part".into(), (*name).into()]);
        }
        if parts.is_empty() {
            arguments.extend(["--assembly".into(), sensor.name.clone().into()]);
        }
        let answer = self.run_package(&arguments, progress)?;
        let files = answer["files"].as_array().cloned().unwrap_or_default();
        let failed: Vec<String> = files
            .iter()
            .filter(|file| file["passed"] != true)
            .map(|file| format!("{}: {}", text(&file["name"]), text(&file["reason"])))
            .collect();
        if !failed.is_empty() {
            return Err(VerifierError::NoStep(failed));
        }
        let read = |file: &Value| {
            let name = text(&file["name"]);
            let path = output.path().join(&name);
            let bytes = reading::read(&path, STEP_LIMITS)?;
            let parts = file["parts"].as_array().cloned().unwrap_or_default();
            let parts = parts.iter().map(text).collect();
            Ok(ForeignFile { file: OutputFile { name, bytes }, format: "step", parts })
        };
        files.iter().map(read).collect()
    }

    /// Runs the package in an empty folder and reads the document it prints.
    fn run_package(
        &self,
        arguments: &[OsString],
        progress: ProgressCallback,
    ) -> Result<Value, VerifierError> {
        let folder = temporary_folder()?;
        let failed = |source| VerifierError::Io {
            action: format!("run {}", self.python.path().display()),
            source,
        };
        let mut child = self
            .python
            .command(folder.path())
            .args(["-m", "fabkit_verify"])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let (sender, said) = mpsc::channel();
        if let Some(mut answer) = child.stdout.take() {
            let sender = sender.clone();
            thread::spawn(move || {
                let mut bytes = Vec::new();
                // An incomplete answer fails to parse below.
                let _ = answer.read_to_end(&mut bytes);
                sender.send(PackageMessage::Answer(bytes))
            });
        }
        if let Some(stderr) = child.stderr.take() {
            thread::spawn(move || forward_messages(stderr, &sender));
        }
        let mut answer = Vec::new();
        let mut tell = |said| match said {
            PackageMessage::Step { done, all, last } => {
                progress(ProgressStep { done, resumed: 0, total: all, last_name: &last })
            }
            PackageMessage::Answer(bytes) => answer = bytes,
        };
        // If the package is killed, processes of its kernels may survive and hold the error pipe open. Reading
        // therefore ends with the answer instead of the pipe.
        let until_answer =
            said.iter().map(|said| (matches!(said, PackageMessage::Answer(_)), said));
        for (is_last, said) in until_answer {
            tell(said);
            if is_last {
                break;
            }
        }
        while let Ok(said) = said.recv_timeout(MESSAGE_TIMEOUT) {
            tell(said);
        }
        let status = child.wait().map_err(failed)?;
        serde_json::from_slice(&answer).map_err(|_| VerifierError::NoAnswer(status.to_string()))
    }
}

/// Time that the package has for further messages after its answer.
const MESSAGE_TIMEOUT: Duration = Duration::from_secs(1);

/// Message from the package.
enum PackageMessage {
    /// Progress.
    Step { done: usize, all: usize, last: String },
    /// Complete standard output.
    Answer(Vec<u8>),
}

/// Prefix of a progress line; `DONE ALL NAME` follows.
const PROGRESS_PREFIX: &[u8] = b"fabkit-progress ";

/// Sends progress to `sender`, and passes all other lines on to standard error.
fn forward_messages(stderr: impl Read, sender: &Sender<PackageMessage>) {
    let mut stderr = BufReader::new(stderr);
    let mut line = Vec::new();
    // Failures to read or pass on a message must not stop the verification.
    while stderr.read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
        match parse_progress(&line) {
            Some((done, all, last)) => {
                let _ = sender.send(PackageMessage::Step { done, all, last: last.to_owned() });
            }
            None => {
                let line = String::from_utf8_lossy(&line);
                drop(io::stderr().write_all(escape_steering(&line).as_bytes()));
            }
        }
        line.clear();
    }
}

fn parse_progress(line: &[u8]) -> Option<(usize, usize, &str)> {
    let text = str::from_utf8(line.strip_prefix(PROGRESS_PREFIX)?).ok()?.trim_end();
    let (done, rest) = text.split_once(' ')?;
    let (all, last) = rest.split_once(' ')?;
    Some((done.parse().ok()?, all.parse().ok()?, last))
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// Makes a path absolute, because the package runs in another folder than this process.
fn absolute(path: &Path) -> Result<OsString, VerifierError> {
    let failed = |source| VerifierError::Io { action: format!("find {}", path.display()), source };
    Ok(path::absolute(path).map_err(failed)?.into())
}

fn temporary_folder() -> Result<TempDir, VerifierError> {
    let action = "make a temporary folder".to_owned();
    TempDir::with_prefix("fabkit-").map_err(|source| VerifierError::Io { action, source })
}

/// Exports nominal files: the design is compared, not its compensated copies.
fn write_exports(
    design: &Design,
    parts: &[String],
    formats: Vec<Format>,
    folder: &Path,
) -> Result<(), VerifierError> {
    let all = || design.sensor.bodies.iter().map(|body| body.name.to_owned()).collect();
    let options = ExportOptions {
        parts: if parts.is_empty() { all() } else { parts.to_vec() },
        formats,
        nominal: true,
        ..ExportOptions::default()
    };
    let exported = exports::export(design, &options, &|_| {})?;
    exports::write(&[(folder.to_owned(), &exported)], Overwriting::default(), &|| false)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_progress_are_told_apart_from_what_kernels_say() {
        assert_eq!(
            parse_progress(b"fabkit-progress 3 12 shell in cadquery\n"),
            Some((3, 12, "shell in cadquery"))
        );
        for other in
            ["fabkit-progress 3", "fabkit-progress x 12 y", "Warning: fabkit-progress 1 2 a"]
        {
            assert_eq!(parse_progress(other.as_bytes()), None, "{other}");
        }
    }
}
