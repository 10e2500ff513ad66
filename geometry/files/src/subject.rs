//! What programs are told of a failure: a code that stays, and the file, value or name that is wrong.

use std::io;
use std::path::Path;

use fabkit_text::{Problem, number_and_unit};
use serde_json::{Value, json};

use crate::ErrorKind;

/// What a failure is about, where it is not one of a text's problems.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ErrorSubject {
    /// A short name of the kind of failure; it stays from version to version.
    pub code: String,
    /// The file or folder that is wrong.
    pub file: Option<String>,
    /// What was given and is wrong, as written.
    pub written: Option<String>,
    /// The words that could have been given.
    pub choices: Vec<String>,
    /// The parameter or option that is wrong.
    pub path: Option<String>,
    /// What to give instead.
    pub suggestion: Option<String>,
}

impl ErrorSubject {
    /// A subject of which the code alone is known.
    pub fn new(code: &str) -> Self {
        Self { code: code.into(), ..Self::default() }
    }

    /// A subject that is a file or a folder.
    pub fn at(code: &str, file: &Path) -> Self {
        Self { file: Some(file.display().to_string()), ..Self::new(code) }
    }

    /// A subject of which not more than the kind of failure is known.
    pub fn of_kind(kind: ErrorKind) -> Self {
        Self::new(kind.code())
    }

    /// A file of which the system said something; `otherwise` is the code for what is not usual.
    pub fn of_io(path: &Path, error: &io::Error, otherwise: &str) -> Self {
        let code = match error.kind() {
            io::ErrorKind::NotFound => "file_missing",
            io::ErrorKind::PermissionDenied => "permission_denied",
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "disk_full",
            _ => otherwise,
        };
        Self::at(code, path)
    }

    /// One entry of `problems` in a `fabkit-error` document.
    pub fn to_json(&self, message: &str, hint: Option<&str>) -> Value {
        let written = self.written.as_deref();
        let (value, unit) = written.map_or((Value::Null, None), amount);
        let suggestion = self.suggestion.as_ref();
        json!({
            "code": self.code,
            "message": message,
            "hint": hint,
            "file": self.file,
            "line": null,
            "column": null,
            "path": self.path,
            "value": value,
            "unit": unit,
            "written": written,
            "limit": limit([None, None], &self.choices),
            "suggestion": suggestion.map(|value| json!({ "path": self.path, "value": value })),
        })
    }
}

/// The same entry for a problem of a text.
pub fn problem_json(problem: &Problem) -> Value {
    let some = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
    let (value, unit) = some(&problem.value).map_or((Value::Null, None), |text| amount(&text));
    let facts = &problem.facts;
    let suggestion = facts.suggestion.as_ref();
    json!({
        "code": facts.code,
        "message": problem.message,
        "hint": problem.hint,
        "file": some(&problem.file),
        "line": problem.line,
        "column": problem.column,
        "path": some(&problem.path),
        "value": value,
        "unit": unit,
        "written": some(&problem.value),
        "limit": limit([facts.at_least.as_deref(), facts.at_most.as_deref()], &facts.choices),
        "suggestion": suggestion.map(|s| json!({ "path": s.path, "value": s.value })),
    })
}

/// Splits a number from its unit; a text that is no number stays as it is.
pub fn amount(text: &str) -> (Value, Option<String>) {
    match number_and_unit(text) {
        Some((number, unit)) => {
            (json!(number), Some(unit.to_owned()).filter(|unit| !unit.is_empty()))
        }
        None => (json!(text), None),
    }
}

/// Says what is allowed: both ends in one unit, or words; null where neither is known.
pub fn limit(ends: [Option<&str>; 2], choices: &[String]) -> Value {
    let [min, max] = ends.map(|end| end.and_then(number_and_unit));
    if min.is_none() && max.is_none() && choices.is_empty() {
        return Value::Null;
    }
    let unit = min.or(max).map(|(_, unit)| unit).filter(|unit| !unit.is_empty());
    let number = |end: Option<(f64, &str)>| end.map(|(number, _)| number);
    json!({ "min": number(min), "max": number(max), "unit": unit, "choices": choices })
}
