//! Machine-readable part of an error: a stable code, and the file, value or name at fault.

use std::io;
use std::path::Path;

use fabkit_text::{Problem, number_and_unit};
use serde_json::{Value, json};

use crate::ErrorKind;

/// Subject of an error that is not one of a text's problems.
///
/// ```
/// use fabkit_files::ErrorSubject;
///
/// let subject = ErrorSubject {
///     path: Some("surface.radius".into()),
///     written: Some("900 mm".into()),
///     suggestion: Some("60 mm".into()),
///     ..ErrorSubject::new("out_of_range")
/// };
/// let json = subject.to_json("the radius is too large", None);
/// assert_eq!(json["value"], 900.0);
/// assert_eq!(json["unit"], "mm");
/// assert_eq!(json["suggestion"]["value"], "60 mm");
/// assert!(json["file"].is_null());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ErrorSubject {
    /// Short name of the kind of error, stable across versions.
    pub code: String,
    /// File or folder at fault.
    pub file: Option<String>,
    /// Wrong input, as written.
    pub written: Option<String>,
    /// Allowed words.
    pub choices: Vec<String>,
    /// Parameter or option at fault.
    pub path: Option<String>,
    /// Value to give instead.
    pub suggestion: Option<String>,
}

impl ErrorSubject {
    /// Creates a subject with nothing but the code.
    pub fn new(code: &str) -> Self {
        Self { code: code.into(), ..Self::default() }
    }

    /// Creates a subject that is a file or a folder.
    pub fn from_path(code: &str, file: &Path) -> Self {
        Self { file: Some(file.display().to_string()), ..Self::new(code) }
    }

    /// Creates a subject from the kind of failure alone.
    pub fn from_kind(kind: ErrorKind) -> Self {
        Self::new(kind.code())
    }

    /// Creates a subject from an error of the operating system about a file; `otherwise` is the code for uncommon
    /// errors.
    ///
    /// ```
    /// use std::io;
    /// use std::path::Path;
    ///
    /// use fabkit_files::ErrorSubject;
    ///
    /// let code = |kind: io::ErrorKind| {
    ///     ErrorSubject::from_io(Path::new("a.stl"), &kind.into(), "cannot_write").code
    /// };
    /// assert_eq!(code(io::ErrorKind::StorageFull), "disk_full");
    /// assert_eq!(code(io::ErrorKind::NotFound), "file_missing");
    /// assert_eq!(code(io::ErrorKind::BrokenPipe), "cannot_write");
    /// ```
    pub fn from_io(path: &Path, error: &io::Error, otherwise: &str) -> Self {
        let code = match error.kind() {
            io::ErrorKind::NotFound => "file_missing",
            io::ErrorKind::PermissionDenied => "permission_denied",
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "disk_full",
            _ => otherwise,
        };
        Self::from_path(code, path)
    }

    /// Converts to an entry of `problems` in a `fabkit-error` document.
    pub fn to_json(&self, message: &str, hint: Option<&str>) -> Value {
        let written = self.written.as_deref();
        let (value, unit) = written.map_or((Value::Null, None), split_amount);
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
            "limit": limit_json([None, None], &self.choices),
            "suggestion": suggestion.map(|value| json!({ "path": self.path, "value": value })),
        })
    }
}

/// Converts a problem of a text to an entry of `problems` in a `fabkit-error` document.
///
/// ```
/// use fabkit_files::problem_json;
/// use fabkit_text::YamlFault;
///
/// let problem = YamlFault::new(None, "lens.k1", "k1 is missing").in_file("camera.yaml");
/// let json = problem_json(&problem);
/// assert_eq!(json["code"], "bad_yaml");
/// assert_eq!(json["path"], "lens.k1");
/// assert!(json["line"].is_null() && json["value"].is_null() && json["limit"].is_null());
/// ```
pub fn problem_json(problem: &Problem) -> Value {
    let some = |text: &str| Some(text.to_owned()).filter(|text| !text.is_empty());
    let (value, unit) =
        some(&problem.value).map_or((Value::Null, None), |text| split_amount(&text));
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
        "limit": limit_json([facts.at_least.as_deref(), facts.at_most.as_deref()], &facts.choices),
        "suggestion": suggestion.map(|s| json!({ "path": s.path, "value": s.value })),
    })
}

/// Splits a text into number and unit; a text that is not a number is returned as it is.
///
/// ```
/// use fabkit_files::split_amount;
///
/// assert_eq!(split_amount("12.5 mm"), (12.5.into(), Some("mm".into())));
/// assert_eq!(split_amount("8"), (8.0.into(), None));
/// assert_eq!(split_amount("round"), ("round".into(), None));
/// ```
pub fn split_amount(text: &str) -> (Value, Option<String>) {
    match number_and_unit(text) {
        Some((number, unit)) => {
            (json!(number), Some(unit.to_owned()).filter(|unit| !unit.is_empty()))
        }
        None => (json!(text), None),
    }
}

/// Describes the allowed values as JSON: both ends in one unit, or words; null if neither is known.
///
/// ```
/// use fabkit_files::limit_json;
///
/// let limit = limit_json([Some("4 mm"), Some("60 mm")], &[]);
/// assert_eq!(limit["min"], 4.0);
/// assert_eq!(limit["max"], 60.0);
/// assert_eq!(limit["unit"], "mm");
/// assert_eq!(limit_json([None, None], &["round".into()])["choices"][0], "round");
/// assert!(limit_json([None, None], &[]).is_null());
/// ```
pub fn limit_json(ends: [Option<&str>; 2], choices: &[String]) -> Value {
    let [min, max] = ends.map(|end| end.and_then(number_and_unit));
    // Null rather than an object without content.
    if min.is_none() && max.is_none() && choices.is_empty() {
        return Value::Null;
    }
    // Both ends are written in the same unit.
    let unit = min.or(max).map(|(_, unit)| unit).filter(|unit| !unit.is_empty());
    let number = |end: Option<(f64, &str)>| end.map(|(number, _)| number);
    json!({ "min": number(min), "max": number(max), "unit": unit, "choices": choices })
}
