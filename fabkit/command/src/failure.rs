//! Failures of a command as the user sees them: exit code, message and hint. Also handles panics.

use std::any::Any;
use std::panic;
use std::sync::atomic::{AtomicBool, Ordering};

pub(crate) use fabkit_application::ErrorKind;
use fabkit_application::calibration_runs::CalibrationRunError;
use fabkit_application::diagnostics::{DiagnosedDesign, SourceText, format_problems};
use fabkit_application::sweep::panics::is_caught;
use fabkit_application::text::InvalidDesign;
use fabkit_application::{Error, ErrorSubject, problem_json};
use serde_json::{Value, json};

use crate::hints::{self, REPORT};
use crate::terminal;

/// Exit codes on which scripts can rely; see `fabkit --help`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FailureCode {
    /// Unknown names, values out of range, designs that cannot be built.
    BadInput = 2,
    /// Input or output beyond fabkit's limits.
    Limit = 3,
    /// Files that cannot be read or written.
    Io = 4,
    /// A bug in fabkit (`EX_SOFTWARE` of BSD's sysexits).
    Bug = 70,
    /// Stopped by a signal, numbered as in shells: 128 + SIGINT.
    Interrupted = 130,
}

impl From<ErrorKind> for FailureCode {
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

/// Failure of a command.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Error of a called function.
    Application(Error),
    /// Problem of the command line itself.
    Command {
        /// Kind of error, which determines the exit code.
        kind: ErrorKind,
        /// Description of the problem.
        message: String,
        /// Suggested remedy.
        hint: Option<String>,
        /// Subject for programs, if more is known than the kind.
        about: Option<Box<ErrorSubject>>,
    },
}

impl<E: Into<Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Application(error.into())
    }
}

impl Failure {
    /// Makes a failure with a hint.
    pub(crate) fn new(kind: ErrorKind, message: impl ToString, hint: impl Into<String>) -> Self {
        Self::Command { kind, message: message.to_string(), hint: Some(hint.into()), about: None }
    }

    /// Adds a subject for programs.
    #[must_use]
    pub(crate) fn with_subject(mut self, known: ErrorSubject) -> Self {
        if let Self::Command { about, .. } = &mut self {
            *about = Some(Box::new(known));
        }
        self
    }

    /// Makes a failure without a hint.
    pub(crate) fn plain(kind: ErrorKind, message: impl ToString) -> Self {
        Self::Command { kind, message: message.to_string(), hint: None, about: None }
    }

    /// Makes the failure of an invalid text.
    pub(crate) fn invalid(invalid: InvalidDesign, file: String, text: String) -> Self {
        DiagnosedDesign::new(invalid, [SourceText { file, text }]).into()
    }

    /// Makes the failure of a violated invariant.
    pub(crate) fn bug(message: impl ToString) -> Self {
        Error::bug(message).into()
    }

    fn kind(&self) -> ErrorKind {
        match self {
            Self::Application(error) => error.kind(),
            Self::Command { kind, .. } => *kind,
        }
    }

    /// Returns the exit code.
    pub(crate) fn exit_code(&self) -> FailureCode {
        self.kind().into()
    }

    fn message(&self) -> String {
        match self {
            Self::Application(error) => match error.downcast_ref() {
                Some(CalibrationRunError::Charuco) => {
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

    /// Formats the failure for people, with a final newline.
    pub(crate) fn to_text(&self) -> String {
        if let Self::Application(error) = self
            && let Some(found) = error.downcast_ref::<DiagnosedDesign>()
        {
            return format_problems(
                &found.invalid.problems,
                found.invalid.unlisted(),
                &found.texts,
            );
        }
        let hint = self.hint().map(|hint| format!("  = help: {hint}\n")).unwrap_or_default();
        format!("error: {}\n{hint}", self.message())
    }

    /// Formats the failure for scripts (`fabkit-error` version 2).
    pub(crate) fn to_json(&self) -> Value {
        let problems = match self {
            // A single failure is reported in the words of the command line.
            Self::Application(error)
                if error.parts().is_empty()
                    && error.downcast_ref::<DiagnosedDesign>().is_none() =>
            {
                let hint = self.hint();
                vec![error.subject().to_json(&self.message(), hint.as_deref())]
            }
            Self::Application(error) => problems_of(error),
            Self::Command { kind, message, hint, about } => {
                let subject = about.as_deref().cloned();
                let subject = subject.unwrap_or_else(|| ErrorSubject::from_kind(*kind));
                vec![subject.to_json(message, hint.as_deref())]
            }
        };
        let unlisted = match self {
            Self::Application(error) => count_unlisted(error),
            Self::Command { .. } => 0,
        };
        document(self.kind(), problems, unlisted)
    }
}

fn document(kind: ErrorKind, problems: Vec<Value>, unlisted: usize) -> Value {
    json!({
        "format": "fabkit-error",
        "version": 2,
        "exit_code": FailureCode::from(kind) as u8,
        "kind": kind.word(),
        "problems": problems,
        "unlisted_problems": unlisted,
    })
}

/// Lists the problems of an error; several parts are listed separately.
fn problems_of(error: &Error) -> Vec<Value> {
    if !error.parts().is_empty() {
        return error.parts().iter().flat_map(problems_of).collect();
    }
    match error.downcast_ref::<DiagnosedDesign>() {
        Some(found) => found.invalid.problems.iter().map(problem_json).collect(),
        None => {
            let hint = hints::hint(error);
            vec![error.subject().to_json(&error.to_string(), hint.as_deref())]
        }
    }
}

/// Counts the problems that are not listed.
fn count_unlisted(error: &Error) -> usize {
    let own = error.downcast_ref::<DiagnosedDesign>().map_or(0, |found| found.invalid.unlisted());
    own + error.parts().iter().map(count_unlisted).sum::<usize>()
}

/// Runs the command. A panic becomes a message (with `json`, also a document on standard output) and [`Exit::Bug`].
///
/// Panics of sweep variants become rows and are not reported here.
pub(crate) fn catch_panics(json: bool, command: impl FnOnce() -> u8 + panic::UnwindSafe) -> u8 {
    static TOLD: AtomicBool = AtomicBool::new(false);
    panic::set_hook(Box::new(|info| {
        if is_caught(info) {
            return;
        }
        TOLD.store(true, Ordering::Relaxed);
        let place = info.location().map(|l| format!(" at {l}")).unwrap_or_default();
        let text = panic_text(info.payload());
        terminal::tell(&format!("error: {text}{place}\n  = help: {REPORT}\n"));
    }));
    panic::catch_unwind(command).unwrap_or_else(|payload| {
        // A panic that did not call the hook, such as a resumed one, is reported here.
        if !TOLD.load(Ordering::Relaxed) {
            let text = panic_text(&*payload);
            terminal::tell(&format!("error: {text}\n  = help: {REPORT}\n"));
        }
        if json {
            let about = ErrorSubject::from_kind(ErrorKind::Bug);
            let problem = about.to_json(panic_text(&*payload), Some(REPORT));
            let _ = terminal::print_json(&document(ErrorKind::Bug, vec![problem], 0));
        }
        FailureCode::Bug as u8
    })
}

fn panic_text(payload: &dyn Any) -> &str {
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
        assert_eq!(catch_panics(false, command), 70);
        assert_eq!(catch_panics(false, || 0), 0);
    }
}
