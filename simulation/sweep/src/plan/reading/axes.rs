//! Reading of a plan's axes.

use fabkit_text::{
    NodeReader, Position, ValueKind, YamlContent, YamlEntry, YamlNode, did_you_mean, suggestion,
    to_printable,
};

use super::super::axis::{PlanAxis, Range, Values};
use super::super::{KnownNames, Sampling, quantity};
use super::{LIMITS, find, is_value_of};

const KEYS: [&str; 4] = ["from", "to", "steps", "scale"];

/// Reads all axes of a plan.
pub(super) fn read(
    reading: &mut NodeReader,
    node: &YamlNode,
    known: &KnownNames,
    sampling: Sampling,
) -> Vec<PlanAxis> {
    let entries = reading.read_map("axes", node);
    let [most, _] = LIMITS;
    if entries.is_empty() && matches!(node.content, YamlContent::Map(_)) || entries.len() > most {
        let message = format!("there are {} axes; there must be 1 to {most}", entries.len());
        let hint = "name the parameters to vary, for example `camera.depth: [6 mm, 8 mm]`";
        reading.report_problem(node.position, "axes", "", message, hint);
    }
    let axes = entries.iter().filter_map(|entry| axis(reading, entry, known, sampling));
    axes.collect()
}

/// Reads one axis; `None` if it is invalid.
fn axis(
    reading: &mut NodeReader,
    entry: &YamlEntry,
    known: &KnownNames,
    sampling: Sampling,
) -> Option<PlanAxis> {
    let path = entry.key.as_str();
    let Some(base) = known.parameters.get(path) else {
        let message = format!("the axis `{}` is not a parameter of the sensor", to_printable(path));
        let hint = parameter_hint(path, known);
        reading.report_problem(entry.key_position, path, path, message, hint);
        return None;
    };
    let kind = base.kind;
    let values = match &entry.value.content {
        YamlContent::List(items) if !items.is_empty() => {
            let mut texts = Vec::new();
            for item in items {
                let text = value_text(reading, path, item)?;
                if !is_value_of(kind, &text) {
                    let message = format!(
                        "{path} takes {}, not `{}`",
                        quantity::example(kind),
                        to_printable(&text)
                    );
                    let hint = format!("the sensor has {}", base.value);
                    reading.report_problem(item.position, path, &text, message, hint);
                    return None;
                }
                texts.push(text);
            }
            Values::List(texts)
        }
        YamlContent::Map(parts) => {
            Values::Range(range(reading, path, kind, parts, entry, sampling)?)
        }
        _ => {
            let message = format!("the axis {path} has no values");
            let hint = "write `[a, b, c]`, or `{from: a, to: b, steps: 5}`";
            reading.report_problem(entry.key_position, path, "", message, hint);
            return None;
        }
    };
    Some(PlanAxis { path: path.into(), kind, values })
}

/// Reads a range; `None` if it is invalid.
fn range(
    reading: &mut NodeReader,
    path: &str,
    kind: ValueKind,
    parts: &[YamlEntry],
    entry: &YamlEntry,
    sampling: Sampling,
) -> Option<Range> {
    let before = reading.found.len();
    if !quantity::is_numeric(kind) {
        let message = format!("{path} is no number and has no range");
        reading.report_problem(entry.key_position, path, "", message, "write `[a, b, c]`");
        return None;
    }
    for part in parts {
        if !KEYS.contains(&&*part.key) {
            let message = format!("`{}` is not a key of an axis", to_printable(&part.key));
            let hint = suggestion(&part.key, KEYS, "the keys are");
            reading.report_problem(part.key_position, path, &part.key, message, hint);
        }
    }
    let mut end = |key: &str| {
        let Some(part) = find(parts, key) else {
            let message = format!("the axis {path} lacks `{key}`");
            let hint = "write `{from: a, to: b, steps: 5}`";
            reading.report_problem(entry.key_position, path, "", message, hint);
            return None;
        };
        let text = reading.read_scalar(key, &part.value)?;
        let number = quantity::parse(kind, text);
        if number.is_none() {
            let message = format!(
                "`{key}` of {path} is `{}`, not {}",
                to_printable(text),
                quantity::example(kind)
            );
            let hint = "write a number with its unit, as in the sensor's file";
            reading.report_problem(part.value.position, path, text, message, hint);
        }
        number
    };
    let (from, to) = (end("from"), end("to"));
    let log = match find(parts, "scale").and_then(|part| {
        reading.read_scalar("scale", &part.value).map(|word| (word, part.value.position))
    }) {
        None | Some(("linear", _)) => false,
        Some(("log", at)) => {
            if from.into_iter().chain(to).any(|end| end <= 0.0) {
                let message = format!("{path} reaches 0 or less, where there is no logarithm");
                reading.report_problem(at, path, "log", message, "begin above 0");
            }
            true
        }
        Some((word, at)) => {
            let message = format!("`{}` is no scale", to_printable(word));
            reading.report_problem(at, path, word, message, "write `linear` or `log`");
            false
        }
    };
    let (from, to) = (from?, to?);
    // Also true for equal ends, which leave no range.
    if from >= to {
        let message = format!("the axis {path} goes from {from} to {to}; it must grow");
        reading.report_problem(entry.key_position, path, "", message, "exchange the two ends");
        return None;
    }
    let steps = steps(reading, path, kind, parts, entry.key_position, ([from, to], log), sampling);
    (reading.found.len() == before).then_some(Range { from, to, log, steps })
}

/// Reads the number of steps; `None` for a range that is only sampled.
fn steps(
    reading: &mut NodeReader,
    path: &str,
    kind: ValueKind,
    parts: &[YamlEntry],
    at: Position,
    ([from, to], log): ([f64; 2], bool),
    sampling: Sampling,
) -> Option<usize> {
    let [_, most] = LIMITS;
    let whole = (kind == ValueKind::Count && !log).then_some((to - from) as usize + 1);
    let Some(part) = find(parts, "steps") else {
        // A range of whole numbers has a natural number of steps; other ranges without steps can only be sampled.
        if whole.is_none() && sampling == Sampling::Grid {
            let message = format!("the axis {path} lacks `steps`");
            let hint = "write `steps: 5`, or draw a sample with `sample: 1000`";
            reading.report_problem(at, path, "", message, hint);
        }
        return whole;
    };
    let steps = reading.read_count("steps", &part.value, [2, most as u64])? as usize;
    if let Some(whole) = whole
        && !(whole - 1).is_multiple_of(steps - 1)
    {
        let message = format!("{steps} steps from {from} to {to} are no whole numbers");
        let hint = format!("leave `steps` out for all {whole}, or list the values");
        reading.report_problem(part.value.position, path, "", message, hint);
    }
    Some(steps)
}

/// Converts one value or a list of values to the text of an override.
pub(super) fn value_text(reading: &mut NodeReader, path: &str, node: &YamlNode) -> Option<String> {
    match &node.content {
        YamlContent::Scalar(text) => Some(text.trim().to_owned()),
        YamlContent::List(items) => {
            let mut texts = Vec::new();
            for item in items {
                texts.push(reading.read_scalar(path, item)?.to_owned());
            }
            Some(format!("[{}]", texts.join(", ")))
        }
        YamlContent::Map(_) | YamlContent::Nothing => {
            let message = format!("{path} must be one value or a list");
            reading.report_problem(
                node.position,
                path,
                "",
                message,
                format!("write `{path}: VALUE`"),
            );
            None
        }
    }
}

/// Suggests parameters with a similar path or the same last word.
fn parameter_hint(path: &str, known: &KnownNames) -> String {
    let paths: Vec<&str> = known.parameters.keys().map(String::as_str).collect();
    let hint = suggestion(path, paths.iter().copied(), "");
    if hint.starts_with("did you mean") {
        return hint;
    }
    // Compares the last word alone: `radius` suggests `surface.radius`.
    let last = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
    let word = last(path);
    let same: Vec<&str> = paths.into_iter().filter(|path| last(path) == word).take(3).collect();
    if same.is_empty() {
        "`fabkit show SENSOR` lists every parameter".into()
    } else {
        did_you_mean(&same)
    }
}
