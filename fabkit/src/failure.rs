//! How an operation fails, as its user sees it: code, message and hint; and panics.

use std::any::Any;
use std::io::{self, Write};
use std::panic;
use std::sync::atomic::{AtomicBool, Ordering};

use fabkit::bodies::UnknownName;
use fabkit::depth::RenderError;
use fabkit::export::ExportError;
use fabkit::exporting::{ExportFailure, FolderError};
use fabkit::mesh::MeshError;
use fabkit::pictures::PictureError;
use fabkit::staging::StagingError;
use fabkit::sweep::panics::becomes_a_row;
use fabkit::text::{InvalidDesign, Problem};
use fabkit::verifier::VerifierError;
use serde_json::json;

use crate::diagnostics::{self, SourceText};

/// The exit codes that scripts can rely on; see `fabkit --help`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Unknown names, values out of range, designs that cannot be.
    BadInput = 2,
    /// Input or output beyond what fabkit is willing to handle.
    Limit = 3,
    /// Files that cannot be read or written.
    Io = 4,
    /// A bug in fabkit (`EX_SOFTWARE` of BSD's sysexits).
    Bug = 70,
    /// Stopped by a signal, as shells number it: 128 + SIGINT.
    Interrupted = 130,
}

impl Exit {
    /// The word in JSON, for example `bad-input`.
    pub fn word(self) -> &'static str {
        match self {
            Self::BadInput => "bad-input",
            Self::Limit => "limit",
            Self::Io => "io",
            Self::Bug => "bug",
            Self::Interrupted => "interrupted",
        }
    }
}

/// Why a command did not do what it was asked to.
#[derive(Debug)]
pub enum Failure {
    /// A design with problems, and the files they may point into.
    Design(InvalidDesign, Vec<SourceText>),
    /// Everything else.
    Other {
        /// What it means for the caller.
        exit: Exit,
        /// What is wrong.
        message: String,
        /// What to do about it.
        hint: Option<String>,
    },
}

impl Failure {
    /// A failure with a hint.
    pub fn new(exit: Exit, message: impl ToString, hint: impl Into<String>) -> Self {
        Self::Other { exit, message: message.to_string(), hint: Some(hint.into()) }
    }

    /// A failure that speaks for itself.
    pub fn plain(exit: Exit, message: impl ToString) -> Self {
        Self::Other { exit, message: message.to_string(), hint: None }
    }

    /// Something that must not happen.
    pub fn bug(message: impl ToString) -> Self {
        Self::new(Exit::Bug, message, REPORT)
    }

    /// Several failures of one kind as one, each with its own message; `None` for none.
    pub fn all(failures: Vec<Self>) -> Option<Self> {
        let mut failures = failures.into_iter();
        let first = failures.next()?;
        Some(failures.fold(first, |all, next| match (all, next) {
            (Self::Other { exit, message, hint }, Self::Other { message: next, .. }) => {
                Self::Other { exit, message: format!("{message}\nerror: {next}"), hint }
            }
            (all, _) => all,
        }))
    }

    /// The code to leave with.
    pub fn exit(&self) -> Exit {
        match self {
            Self::Design(..) => Exit::BadInput,
            Self::Other { exit, .. } => *exit,
        }
    }

    /// For people, with a final newline.
    pub fn to_text(&self) -> String {
        match self {
            Self::Design(invalid, sources) => diagnostics::list(&invalid.problems, sources),
            Self::Other { message, hint, .. } => {
                let hint = hint.iter().map(|hint| format!("  = help: {hint}\n"));
                format!("error: {message}\n{}", hint.collect::<String>())
            }
        }
    }

    /// For scripts (`fabkit-error` version 1).
    pub fn to_json(&self) -> serde_json::Value {
        let problems = match self {
            Self::Design(invalid, _) => invalid.problems.iter().map(problem_json).collect(),
            Self::Other { message, hint, .. } => vec![json!({ "message": message, "hint": hint })],
        };
        json!({
            "format": "fabkit-error",
            "version": 1,
            "exit_code": self.exit() as u8,
            "kind": self.exit().word(),
            "problems": problems,
        })
    }
}

fn problem_json(problem: &Problem) -> serde_json::Value {
    json!({
        "file": problem.file,
        "line": problem.line,
        "column": problem.column,
        "path": problem.path,
        "value": problem.value,
        "message": problem.message,
        "hint": problem.hint,
    })
}

impl From<UnknownName> for Failure {
    fn from(unknown: UnknownName) -> Self {
        Self::new(Exit::BadInput, &unknown, unknown.hint())
    }
}

impl From<StagingError> for Failure {
    fn from(error: StagingError) -> Self {
        match (&error, error.hint()) {
            (StagingError::Cancelled, _) => Self::plain(Exit::Interrupted, "interrupted"),
            (_, Some(hint)) => Self::new(Exit::Io, &error, hint),
            (_, None) => Self::plain(Exit::Io, &error),
        }
    }
}

impl From<FolderError> for Failure {
    fn from(error: FolderError) -> Self {
        let hint = error.hint().unwrap_or_default();
        match error {
            FolderError::Export(failure) => failure.into(),
            FolderError::Staging(error) => error.into(),
            FolderError::Refused(_) => Self::new(Exit::BadInput, &error, hint),
        }
    }
}

impl From<ExportFailure> for Failure {
    fn from(failure: ExportFailure) -> Self {
        match failure {
            ExportFailure::Unknown(unknown) => unknown.into(),
            ExportFailure::TooManyTriangles { .. }
            | ExportFailure::Mesh { source: MeshError::TooFine { .. }, .. } => Self::new(
                Exit::Limit,
                &failure,
                "allow a larger --tolerance, or export fewer parts with --part",
            ),
            ExportFailure::Mesh { source: MeshError::Tolerance { .. }, .. } => {
                Self::plain(Exit::BadInput, &failure)
            }
            ExportFailure::Plate(_) => Self::new(
                Exit::BadInput,
                &failure,
                "name your printer's bed with --bed, or leave plates out with --format stl",
            ),
            ExportFailure::Picture { source, .. } => source.into(),
            ExportFailure::Stock(_) => Self::new(
                Exit::BadInput,
                &failure,
                "name your stock with --stock, or leave drawings out with --format stl,3mf",
            ),
            ExportFailure::Outline { source: ExportError::KerfTooWide { .. }, .. } => Self::new(
                Exit::BadInput,
                &failure,
                "name your laser's width with --kerf, or leave it out with --nominal",
            ),
            ExportFailure::CannotBeMade { ref changed, .. } => {
                let list = match &changed[..] {
                    [] => String::new(),
                    all => format!(" of {}", all.join(", ")),
                };
                let hint = format!(
                    "take values{list} nearer to those of the built-in sensor: holes meet each other, \
                     break out of the part, or leave too little between them"
                );
                Self::new(Exit::BadInput, &failure, hint)
            }
            ExportFailure::HolesBreakOut { .. } => Self::new(
                Exit::BadInput,
                &failure,
                "export this part without --process, and let the slicer make up for the printer",
            ),
            ExportFailure::ProfileWithoutFiles { .. } => Self::new(
                Exit::BadInput,
                &failure,
                "ask for --format stl or 3mf too, or leave --process out",
            ),
            ExportFailure::ProfileUnused { has_process: true, .. } => Self::new(
                Exit::BadInput,
                &failure,
                "measure a coupon of that material (`--set fixtures.coupon.material=NAME`), or \
                 apply this profile all the same with --process-for-any-material",
            ),
            ExportFailure::ProfileUnused { .. } => Self::new(
                Exit::BadInput,
                &failure,
                "leave --process out, or name the profile of the printer that makes these parts",
            ),
            ExportFailure::NoOutlines { .. } => {
                Self::new(Exit::BadInput, &failure, "printed parts have --format stl,3mf")
            }
            _ => Self::bug(failure),
        }
    }
}

impl From<VerifierError> for Failure {
    fn from(error: VerifierError) -> Self {
        match error {
            VerifierError::NoEnvironment
            | VerifierError::NoPackage(_)
            | VerifierError::RelativePython(_) => Self::plain(Exit::BadInput, error),
            VerifierError::Export(failure) => failure.into(),
            VerifierError::Folder(error @ FolderError::Refused(_)) => {
                Self::new(Exit::BadInput, error, "choose another folder with --keep")
            }
            VerifierError::Folder(error) => error.into(),
            VerifierError::Read(error) => error.into(),
            VerifierError::Io { .. } => Self::plain(Exit::Io, error),
            VerifierError::NoAnswer(_) | VerifierError::NoStep(_) => Self::bug(error),
        }
    }
}

impl From<PictureError> for Failure {
    fn from(error: PictureError) -> Self {
        match error {
            PictureError::Unknown(unknown) => unknown.into(),
            PictureError::Render(RenderError::NothingToDraw) => {
                Self::plain(Exit::BadInput, "nothing is left behind the section plane")
            }
            PictureError::Render(RenderError::NoPixels { .. }) => {
                Self::plain(Exit::BadInput, error)
            }
            PictureError::Render(RenderError::TooLarge { .. }) => {
                Self::new(Exit::Limit, error, "ask for a smaller picture")
            }
            _ => Self::bug(error),
        }
    }
}

const REPORT: &str = "this is a bug in fabkit; please report it with the command line and, if there \
                      is one, the sensor's file";

/// Runs the command; a panic becomes a message and [`Exit::Bug`].
///
/// Variants of sweeps that panic are rows, and nothing is said of them here.
pub(crate) fn guard(command: impl FnOnce() -> u8 + panic::UnwindSafe) -> u8 {
    static TOLD: AtomicBool = AtomicBool::new(false);
    panic::set_hook(Box::new(|info| {
        if becomes_a_row(info) {
            return;
        }
        TOLD.store(true, Ordering::Relaxed);
        let place = info.location().map(|l| format!(" at {l}")).unwrap_or_default();
        let text = text_of(info.payload());
        // If nobody can be told, the exit code still says it.
        let _ = write!(io::stderr(), "error: {text}{place}\n  = help: {REPORT}\n");
    }));
    panic::catch_unwind(command).unwrap_or_else(|payload| {
        if !TOLD.load(Ordering::Relaxed) {
            let text = text_of(&*payload);
            let _ = write!(io::stderr(), "error: {text}\n  = help: {REPORT}\n");
        }
        Exit::Bug as u8
    })
}

fn text_of(payload: &dyn Any) -> &str {
    payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("fabkit stopped")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_on_any_thread_leaves_with_its_own_code() {
        fn command() -> u8 {
            let (_, code): ((), _) = rayon::join(|| panic!("on purpose"), || 0);
            code
        }
        assert_eq!(guard(command), 70);
        assert_eq!(guard(|| 0), 0);
    }
}
