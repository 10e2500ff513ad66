//! How a command fails, as its user sees it: code, message and hint; and panics.

use std::any::Any;
use std::io::{self, Write};
use std::panic;
use std::sync::atomic::{AtomicBool, Ordering};

pub(crate) use fabkit_application::ErrorKind;
use fabkit_application::calibrating::CalibratingError;
use fabkit_application::diagnostics::{self, Diagnosed, SourceText};
use fabkit_application::sweep::panics::becomes_a_row;
use fabkit_application::text::InvalidDesign;
use fabkit_application::{Error, ErrorSubject, problem_json};
use serde_json::{Value, json};

use crate::hints::{self, REPORT};

/// The exit codes that scripts can rely on; see `fabkit --help`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
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

impl From<ErrorKind> for Exit {
    fn from(kind: ErrorKind) -> Self {
        match kind {
            ErrorKind::BadInput => Self::BadInput,
            ErrorKind::Limit => Self::Limit,
            ErrorKind::Io => Self::Io,
            ErrorKind::Bug => Self::Bug,
            ErrorKind::Interrupted => Self::Interrupted,
        }
    }
}

/// Why a command did not do what it was asked to.
#[derive(Debug)]
pub(crate) enum Failure {
    /// What it called failed.
    Application(Error),
    /// Something is wrong with the command line itself.
    Command {
        /// What it means for the caller.
        kind: ErrorKind,
        /// What is wrong.
        message: String,
        /// What to do about it.
        hint: Option<String>,
        /// The same for programs, where more is known than the kind.
        about: Option<Box<ErrorSubject>>,
    },
}

impl<E: Into<Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Application(error.into())
    }
}

impl Failure {
    /// A failure with a hint.
    pub(crate) fn new(kind: ErrorKind, message: impl ToString, hint: impl Into<String>) -> Self {
        Self::Command { kind, message: message.to_string(), hint: Some(hint.into()), about: None }
    }

    /// The same, with what programs want to know.
    #[must_use]
    pub(crate) fn about(mut self, known: ErrorSubject) -> Self {
        if let Self::Command { about, .. } = &mut self {
            *about = Some(Box::new(known));
        }
        self
    }

    /// A failure that speaks for itself.
    pub(crate) fn plain(kind: ErrorKind, message: impl ToString) -> Self {
        Self::Command { kind, message: message.to_string(), hint: None, about: None }
    }

    /// A text with problems.
    pub(crate) fn invalid(invalid: InvalidDesign, file: String, text: String) -> Self {
        Diagnosed::new(invalid, [SourceText { file, text }]).into()
    }

    /// Something that must not happen.
    pub(crate) fn bug(message: impl ToString) -> Self {
        Error::bug(message).into()
    }

    fn kind(&self) -> ErrorKind {
        match self {
            Self::Application(error) => error.kind(),
            Self::Command { kind, .. } => *kind,
        }
    }

    /// The code to leave with.
    pub(crate) fn exit(&self) -> Exit {
        self.kind().into()
    }

    fn message(&self) -> String {
        match self {
            Self::Application(error) => match error.downcast_ref() {
                Some(CalibratingError::Charuco) => {
                    "--detector opencv finds checkerboards, and this is a ChArUco board".into()
                }
                _ => error.to_string(),
            },
            Self::Command { message, .. } => message.clone(),
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Application(error) => hints::hint(error),
            Self::Command { hint, .. } => hint.clone(),
        }
    }

    /// For people, with a final newline.
    pub(crate) fn to_text(&self) -> String {
        if let Self::Application(error) = self
            && let Some(found) = error.downcast_ref::<Diagnosed>()
        {
            return diagnostics::list(&found.invalid.problems, &found.texts);
        }
        let hint = self.hint().map(|hint| format!("  = help: {hint}\n")).unwrap_or_default();
        format!("error: {}\n{hint}", self.message())
    }

    /// For scripts (`fabkit-error` version 2).
    pub(crate) fn to_json(&self) -> Value {
        let problems = match self {
            // Said in the words of the command line, where there is one failure.
            Self::Application(error)
                if error.parts().is_empty() && error.downcast_ref::<Diagnosed>().is_none() =>
            {
                let hint = self.hint();
                vec![error.subject().to_json(&self.message(), hint.as_deref())]
            }
            Self::Application(error) => problems_of(error),
            Self::Command { kind, message, hint, about } => {
                let subject = about.as_deref().cloned();
                let subject = subject.unwrap_or_else(|| ErrorSubject::of_kind(*kind));
                vec![subject.to_json(message, hint.as_deref())]
            }
        };
        document(self.kind(), problems)
    }
}

fn document(kind: ErrorKind, problems: Vec<Value>) -> Value {
    json!({
        "format": "fabkit-error",
        "version": 2,
        "exit_code": Exit::from(kind) as u8,
        "kind": kind.word(),
        "problems": problems,
    })
}

/// Each for itself, where there are several.
fn problems_of(error: &Error) -> Vec<Value> {
    if !error.parts().is_empty() {
        return error.parts().iter().flat_map(problems_of).collect();
    }
    match error.downcast_ref::<Diagnosed>() {
        Some(found) => found.invalid.problems.iter().map(problem_json).collect(),
        None => {
            let hint = hints::hint(error);
            vec![error.subject().to_json(&error.to_string(), hint.as_deref())]
        }
    }
}

/// Runs the command; a panic becomes a message, with `json` on standard output too, and [`Exit::Bug`].
///
/// Variants of sweeps that panic are rows, and nothing is said of them here.
pub(crate) fn guard(json: bool, command: impl FnOnce() -> u8 + panic::UnwindSafe) -> u8 {
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
        if json {
            let about = ErrorSubject::of_kind(ErrorKind::Bug);
            let problem = about.to_json(text_of(&*payload), Some(REPORT));
            let _ = writeln!(io::stdout(), "{:#}", document(ErrorKind::Bug, vec![problem]));
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
        assert_eq!(guard(false, command), 70);
        assert_eq!(guard(false, || 0), 0);
    }
}
