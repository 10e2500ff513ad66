//! Conversion of failures to exceptions of `fabkit.errors`.

use std::borrow::Cow;

use fabkit_application::diagnostics::{self, DiagnosedDesign};
use fabkit_application::geometry::Length;
use fabkit_application::text::{
    Json, OVERRIDE_FILE_NAME, Problem, Scalar, escape_steering, to_printable,
};
use fabkit_application::{Error, ErrorKind, ErrorSubject, UnknownName, problem_json};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::hints;

/// Failure of a call from Python.
#[derive(Debug)]
pub enum Failure {
    /// Error of the called function.
    Application(Error),
    /// Invalid argument.
    Call {
        /// Description of the problem.
        message: String,
        /// Suggested remedy.
        hint: Option<Cow<'static, str>>,
    },
}

impl<E: Into<Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Application(error.into())
    }
}

impl Failure {
    /// Makes the failure of an invalid argument.
    pub fn call(message: impl ToString) -> Self {
        Self::Call { message: message.to_string(), hint: None }
    }

    /// Makes the failure of a violated invariant.
    pub fn bug(message: impl ToString) -> Self {
        Error::bug(message).into()
    }

    fn kind(&self) -> ErrorKind {
        match self {
            Self::Application(error) => error.kind(),
            Self::Call { .. } => ErrorKind::BadInput,
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Application(error) => error.subject(),
            Self::Call { .. } => ErrorSubject::from_kind(self.kind()),
        }
    }

    fn message_and_hint(&self) -> (String, Option<String>) {
        match self {
            Self::Application(error) => (error.to_string(), hints::hint(error)),
            Self::Call { message, hint } => (message.clone(), hint.as_deref().map(str::to_owned)),
        }
    }
}

/// Suggests a known name for an unknown one.
#[pyfunction]
pub fn hint(name: &str, known: Vec<String>) -> String {
    UnknownName::new("name", name, known.iter().map(String::as_str)).hint()
}

/// Makes the exception of a failure: the text that the command would print and the problems that `--json` would list,
/// with hints that name Python arguments.
pub fn exception(py: Python<'_>, failure: impl Into<Failure>) -> PyErr {
    build_exception(py, &failure.into()).unwrap_or_else(|error| error)
}

fn build_exception(py: Python<'_>, failure: &Failure) -> PyResult<PyErr> {
    let found = match failure {
        Failure::Application(error) => error.downcast_ref(),
        Failure::Call { .. } => None,
    };
    let (text, problems) = match found {
        Some(found) => format_problems(found),
        None => {
            let (message, hint) = failure.message_and_hint();
            let problem = failure.subject().to_json(&message, hint.as_deref());
            let help = hint.map(|hint| format!("\n  = help: {hint}")).unwrap_or_default();
            (message + &help, vec![problem])
        }
    };
    let arguments = PyDict::new(py);
    // An exception that nobody catches is printed on a terminal.
    arguments.set_item("text", escape_steering(&text))?;
    arguments.set_item("code", failure.kind().word())?;
    arguments.set_item("problems", Json::from(problems).to_string())?;
    // The Python side chooses the class of the exception by the code.
    let exception = py.import("fabkit.errors")?.getattr("_of")?.call((), Some(&arguments))?;
    Ok(PyErr::from_value(exception))
}

fn format_problems(found: &DiagnosedDesign) -> (String, Vec<Json>) {
    let problems: Vec<Problem> = found.invalid.problems.iter().map(rename_overrides).collect();
    let listed = diagnostics::format_problems(&problems, found.invalid.unlisted(), &found.texts);
    let problems = problems.iter().map(problem_json).collect();
    let text = listed.strip_prefix("error: ").unwrap_or(&listed).trim_end_matches('\n').to_owned();
    (text, problems)
}

/// Replaces the command's name of the overrides by Python's keyword.
fn rename_overrides(problem: &Problem) -> Problem {
    let called = |text: &str| text.replace(OVERRIDE_FILE_NAME, "overrides");
    Problem {
        file: called(&problem.file),
        message: called(&problem.message),
        hint: problem.hint.as_deref().map(called),
        ..problem.clone()
    }
}

/// Parses a length with its unit, in mm; its limits are not checked.
#[pyfunction]
pub fn length_mm(py: Python<'_>, text: &str, name: &str) -> PyResult<f64> {
    <Length as Scalar>::parse(text).map(Length::mm).map_err(|refusal| {
        let message = format!("{name} is `{}`, which {}", to_printable(text), refusal.says);
        exception(py, Failure::Call { message, hint: refusal.hint.map(Cow::Owned) })
    })
}

/// Conversion of a result's error by [`exception`].
pub trait OrRaise<T> {
    /// Returns the value, or raises the failure as an exception.
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T, E: Into<Failure>> OrRaise<T> for Result<T, E> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| exception(py, error))
    }
}
