//! Overrides `--set path=value`.

use std::collections::BTreeMap;

use crate::parameter_table::{ParameterTable, read_plain_value};
use crate::parse::parse;
use crate::place::{LocatedProblem, TextPlace, WrittenText, WrittenValue};
use crate::{FieldShape, TextLayer, UNKNOWN_PARAMETER, ValueSource, to_printable};

/// File name in problems of overrides: the command's option.
pub const OVERRIDE_FILE_NAME: &str = "--set";

/// Merges `path=value` overrides over a document. Problems go to the document.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{
///     Dialect, FieldDeclaration, Parameter, ParameterTable, TextLayer, TextPlace, apply_overrides,
/// };
///
/// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
/// let shape = Length::shape(&(1.0..=20.0));
/// let radius = FieldDeclaration { name: "radius", summary: "Radius.".into(), shape };
/// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
/// let mut table = ParameterTable::new(vec![radius], place);
/// apply_overrides(&mut table, &["radius = 9 mm".into(), "raduis=8 mm".into(), "radius".into()]);
/// assert_eq!(table.written("radius").map(|value| value.text.to_printable()), Some("9 mm".into()));
/// let codes: Vec<&str> = table.found.iter().map(|found| found.problem.facts.code).collect();
/// assert_eq!(codes, ["unknown_parameter", "bad_override"]);
/// ```
pub fn apply_overrides(document: &mut ParameterTable, overrides: &[String]) {
    let place = TextPlace::new(TextLayer::Override, OVERRIDE_FILE_NAME, document.root.dialect);
    // First value of each path, to report paths that are set twice.
    let mut first: BTreeMap<&str, &str> = BTreeMap::new();
    for text in overrides {
        let Some((path, value)) = text.split_once('=') else {
            let message = format!("`{}` is not an override", to_printable(text));
            let found = place.problem("", &to_printable(text), message);
            let hint = "write `--set path=value`, for example `name=wide`";
            document.found.push(found.hint(hint).code("bad_override"));
            continue;
        };
        let (path, value) = (path.trim(), value.trim());
        if let Some(first) = first.insert(path, value) {
            let (path, first, second) =
                (to_printable(path), to_printable(first), to_printable(value));
            let message = format!("{path} is set twice: to `{first}` and to `{second}`");
            let found = place.problem(&path, &second, message).hint("keep one of them");
            document.found.push(found.code("set_twice"));
            continue;
        }
        match parse_override(document, path, value, &place) {
            Ok(written) => document.set(path, written),
            Err(found) => document.found.push(*found),
        }
    }
}

/// Reads one override as the value of its parameter.
fn parse_override(
    document: &ParameterTable,
    path: &str,
    value: &str,
    place: &TextPlace,
) -> Result<WrittenValue, Box<LocatedProblem>> {
    let problem = |code, message: String, hint: String| {
        Box::new(
            place.problem(&to_printable(path), &to_printable(value), message).hint(hint).code(code),
        )
    };
    // The declaration decides whether the text is parsed as a list.
    let is_list = match document.field(path).map(|field| &field.shape) {
        Some(FieldShape::Value { is_list, .. }) => *is_list,
        Some(FieldShape::Section(fields)) => {
            let keys: Vec<String> = fields.iter().map(|f| format!("{path}.{}", f.name)).collect();
            return Err(problem(
                "wrong_shape",
                format!("{path} is a section, not a value"),
                format!("set one of {}", keys.join(", ")),
            ));
        }
        None => {
            let message = format!("`{}` is not a parameter", to_printable(path));
            let found = problem(UNKNOWN_PARAMETER, message, suggest_hint(document, path));
            return Err(match document.find_correction(path) {
                // A machine-readable correction needs a value to set.
                Some(meant) if !value.is_empty() => {
                    Box::new(found.suggest(&meant, &to_printable(value)))
                }
                _ => found,
            });
        }
    };
    if value.is_empty() {
        let (message, hint) =
            (format!("{path} is set to nothing"), format!("write `{path}=VALUE`"));
        return Err(problem("no_value", message, hint));
    }
    let text = if is_list {
        let (node, _) = parse(value, place.dialect).map_err(|fault| {
            let message = format!("{path} cannot be read: {}", fault.message);
            problem("bad_yaml", message, "write `[a, b]`".into())
        })?;
        // Line and column inside an override mean nothing to the user.
        let without_position = |mut found: Box<LocatedProblem>| {
            (found.problem.line, found.problem.column) = (None, None);
            found
        };
        let (text, _) = read_plain_value(path, true, node, place).map_err(without_position)?;
        text.with_place(place)
    } else {
        WrittenText::Scalar(value.to_owned())
    };
    let source = ValueSource::user(OVERRIDE_FILE_NAME);
    Ok(WrittenValue::new(place.clone(), text, source))
}

impl WrittenText {
    /// Gives every list item the same place.
    fn with_place(self, place: &TextPlace) -> Self {
        match self {
            Self::Scalar(text) => Self::Scalar(text),
            Self::List(items) => {
                Self::List(items.into_iter().map(|(text, _)| (text, place.clone())).collect())
            }
        }
    }
}

/// Writes a hint for an unknown path.
fn suggest_hint(document: &ParameterTable, path: &str) -> String {
    if is_decided_by_the_file(path) {
        return "this is decided by the file, not by an override".into();
    }
    document.suggest_hint(path)
}

/// Returns whether a key selects how the file is read, so that it cannot be overridden.
fn is_decided_by_the_file(path: &str) -> bool {
    matches!(path, "format" | "family" | "extends")
}
