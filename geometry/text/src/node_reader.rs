//! Key-by-key reading of YAML, for files whose form no declaration describes.

use crate::parse::parse;
use crate::place::{LocatedProblem, TextPlace};
use crate::reader::read_scalar_text;
use crate::tree::{Position, YamlContent, YamlEntry, YamlNode};
use crate::{InvalidDesign, ParameterTable, Reader, Scalar, Section, to_printable};

/// Parses a text whose top level is a mapping. Reports the problem and returns `None` if it is not.
///
/// ```
/// use fabkit_text::{Dialect, TextLayer, TextPlace, read_mapping};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, " and `rows: N`");
/// let place = TextPlace::new(TextLayer::File, "pins.yaml", PINS);
/// let mut found = Vec::new();
/// let entries = read_mapping("rows: 4\ncolumns: 5\n", &place, &mut found).unwrap_or_default();
/// assert_eq!((entries.len(), entries[1].key.as_str(), found.len()), (2, "columns", 0));
/// assert!(read_mapping("just words", &place, &mut found).is_none());
/// assert_eq!(found[0].problem.hint.as_deref(), Some("begin with `format: 1` and `rows: N`"));
/// ```
pub fn read_mapping(
    yaml: &str,
    place: &TextPlace,
    found: &mut Vec<LocatedProblem>,
) -> Option<Vec<YamlEntry>> {
    let (node, duplicates) = parse(yaml, place.dialect)
        .map_err(|fault| found.push(LocatedProblem::from_fault(fault, place)))
        .ok()?;
    found.extend(duplicates.into_iter().map(|fault| LocatedProblem::from_fault(fault, place)));
    let (message, at) = match node.content {
        YamlContent::Map(entries) => return Some(entries),
        YamlContent::Nothing => ("the file is empty", place.clone()),
        _ => ("the file is not a list of keys and values", place.at(node.position)),
    };
    let format = place.dialect.format;
    let hint = format!("begin with `format: {format}`{}", place.dialect.begin);
    found.push(at.problem("", "", message.into()).hint(hint).code("wrong_shape"));
    None
}

/// Removes `format:` from the entries and reports a missing or wrong one.
///
/// ```
/// use fabkit_text::{Dialect, TextLayer, TextPlace, read_mapping, take_format};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let place = TextPlace::new(TextLayer::File, "pins.yaml", PINS);
/// let mut found = Vec::new();
/// let mut entries = read_mapping("format: 2\nrows: 4\n", &place, &mut found).unwrap_or_default();
/// take_format(&mut entries, &place, &mut found);
/// assert_eq!((entries.len(), entries[0].key.as_str()), (1, "rows"));
/// assert_eq!(found[0].problem.message, "format is `2`; this version of fabkit reads 1");
/// ```
pub fn take_format(
    entries: &mut Vec<YamlEntry>,
    place: &TextPlace,
    found: &mut Vec<LocatedProblem>,
) {
    let format = place.dialect.format;
    let hint = format!("begin the file with `format: {format}`");
    let before = found.len();
    match take_word(entries, "format", place, found) {
        Some((word, _)) if word == format.to_string() => {}
        Some((word, at)) => {
            let word = to_printable(&word);
            let message = format!("format is `{word}`; this version of fabkit reads {format}");
            found.push(at.problem("format", &word, message).hint(hint).code("wrong_format"));
        }
        // The value was not a word, which has been reported.
        None if found.len() > before => {}
        None => {
            let missing = place.problem("format", "", "the format is missing".into());
            found.push(missing.hint(hint).code("wrong_format"));
        }
    }
}

/// Removes `key` from the entries and returns its word with its place. Reports a value that is not a single word;
/// returns `None` without a report if the key is absent.
///
/// ```
/// use fabkit_text::{Dialect, TextLayer, TextPlace, read_mapping, take_word};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let place = TextPlace::new(TextLayer::File, "pins.yaml", PINS);
/// let mut found = Vec::new();
/// let mut entries = read_mapping("name: fine\nrows: [1]\n", &place, &mut found).unwrap_or_default();
/// let mut take = |key| take_word(&mut entries, key, &place, &mut found).map(|(word, _)| word);
/// assert_eq!(take("name").as_deref(), Some("fine"));
/// assert_eq!((take("columns"), take("rows")), (None, None));
/// // Only the list is a mistake: a key may be absent.
/// assert_eq!((found.len(), found[0].problem.path.as_str()), (1, "rows"));
/// ```
pub fn take_word(
    entries: &mut Vec<YamlEntry>,
    key: &str,
    place: &TextPlace,
    found: &mut Vec<LocatedProblem>,
) -> Option<(String, TextPlace)> {
    let i = entries.iter().position(|entry| entry.key == key)?;
    let entry = entries.remove(i);
    match entry.value.content {
        YamlContent::Scalar(word) => Some((word, place.at(entry.value.position))),
        _ => {
            let at = place.at(entry.key_position);
            let message = format!("{key} must be followed by one word");
            let hint = format!("write `{key}: WORD`");
            found.push(at.problem(key, "", message).hint(hint).code("wrong_shape"));
            None
        }
    }
}

/// Reads a file that is one section, with `format:` before it.
///
/// # Errors
/// All problems, each with place, value, limit and a hint.
///
/// ```
/// use fabkit_text::{Dialect, TextLayer, TextPlace, parameters, read_section};
///
/// parameters! {
///     /// A field of pins.
///     pub struct Pins {
///         /// Rows.
///         rows: u32 = 1..=9,
///         /// Columns.
///         columns: u32 = 1..=9,
///     }
/// }
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let place = TextPlace::new(TextLayer::File, "pins.yaml", PINS);
/// let invalid = read_section::<Pins>("rows: 90\nrwos: 9\n", &place).unwrap_err();
/// let paths: Vec<&str> = invalid.problems.iter().map(|problem| &*problem.path).collect();
/// assert_eq!(paths, ["format", "columns", "rows", "rwos"]);
/// ```
pub fn read_section<P: Section>(yaml: &str, place: &TextPlace) -> Result<P, InvalidDesign> {
    let mut document = ParameterTable::new(P::fields(), place.clone());
    let mut found = Vec::new();
    let Some(mut entries) = read_mapping(yaml, place, &mut found) else {
        return Err(InvalidDesign::new(LocatedProblem::sort(found)));
    };
    take_format(&mut entries, place, &mut found);
    document.merge(entries, place);
    document.found.extend(found);
    let mut reader = Reader::new(document);
    // Read even if the top of the file is faulty, to report all problems at once.
    let section = P::read(&mut reader, "", "", &());
    let report = reader.finish(None);
    section.filter(|_| report.is_clean()).ok_or_else(|| report.into_invalid())
}

/// Reader of single nodes that collects their problems.
///
/// ```
/// use fabkit_text::{Dialect, NodeReader, TextLayer, TextPlace, parse};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let (tree, _) = parse("rows: 12\ncolumns: 5\nturns: +5\n", PINS)?;
/// let mut reader = NodeReader::new(TextPlace::new(TextLayer::File, "pins.yaml", PINS));
/// let mut count = |key| tree.get(key).and_then(|node| reader.read_count(key, node, [1, 9]));
/// // A count is written with digits only.
/// assert_eq!([count("rows"), count("columns"), count("turns")], [None, Some(5), None]);
/// let invalid = reader.into_invalid();
/// let says = "pins.yaml:1:7: rows is 12; it must be a whole number from 1 to 9";
/// assert_eq!(invalid.problems[0].to_string(), says);
/// # Ok::<(), fabkit_text::YamlFault>(())
/// ```
#[derive(Debug)]
pub struct NodeReader {
    /// Place of the whole text.
    pub place: TextPlace,
    /// Problems so far.
    pub found: Vec<LocatedProblem>,
}

impl NodeReader {
    /// Creates a reader without problems.
    pub fn new(place: TextPlace) -> Self {
        Self { place, found: Vec::new() }
    }

    /// Reports a problem with its hint.
    pub fn report_problem(
        &mut self,
        at: Position,
        path: &str,
        value: &str,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) {
        let found =
            self.place.at(at).problem(&to_printable(path), &to_printable(value), message.into());
        self.found.push(found.hint(hint));
    }

    /// Parses one value and checks its limits; reports and returns `None` if it is wrong.
    ///
    /// ```
    /// use fabkit_geometry::Length;
    /// use fabkit_text::{Dialect, NodeReader, Position, TextLayer, TextPlace};
    ///
    /// const PIN: &Dialect = &Dialect::new("pin", 1, "");
    /// let mut reader = NodeReader::new(TextPlace::new(TextLayer::File, "pin.yaml", PIN));
    /// let at = Position { line: 2, column: 9 };
    /// let radius = reader.read_value::<Length>(at, "radius", "9 cm", &(4.0..=60.0));
    /// assert_eq!(radius, None);
    /// let facts = &reader.found[0].problem.facts;
    /// assert_eq!((facts.code, facts.at_most.as_deref()), ("out_of_range", Some("60 mm")));
    /// assert_eq!(facts.suggestion.as_ref().map(|meant| meant.value.as_str()), Some("60 mm"));
    /// ```
    pub fn read_value<T: Scalar>(
        &mut self,
        at: Position,
        path: &str,
        text: &str,
        limits: &T::Limits,
    ) -> Option<T> {
        let place = self.place.at(at);
        read_scalar_text(path, text, limits, &place).map_err(|found| self.found.push(*found)).ok()
    }

    /// Returns the text of one scalar, trimmed of white space.
    pub fn read_scalar<'n>(&mut self, key: &str, node: &'n YamlNode) -> Option<&'n str> {
        match &node.content {
            YamlContent::Scalar(text) => Some(text.trim()),
            _ => {
                let message = format!("{key} must be one value");
                self.report_problem(
                    node.position,
                    key,
                    "",
                    message,
                    format!("write `{key}: VALUE`"),
                );
                None
            }
        }
    }

    /// Returns the entries of a mapping.
    pub fn read_map<'n>(&mut self, key: &str, node: &'n YamlNode) -> &'n [YamlEntry] {
        if !matches!(node.content, YamlContent::Map(_)) {
            let hint = format!("write `{key}:`, then indented lines `NAME: ...`");
            self.report_problem(
                node.position,
                key,
                "",
                format!("{key} must be keys with values"),
                hint,
            );
        }
        node.entries()
    }

    /// Returns the items of a list.
    ///
    /// ```
    /// use fabkit_text::{Dialect, NodeReader, TextLayer, TextPlace, parse};
    ///
    /// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
    /// let (tree, _) = parse("heights: [1 mm, 2 mm]\nnames: left\n", PINS)?;
    /// let mut reader = NodeReader::new(TextPlace::new(TextLayer::File, "pins.yaml", PINS));
    /// let mut items = |key| tree.get(key).map(|node| reader.read_list(key, node).len());
    /// assert_eq!([items("heights"), items("names")], [Some(2), Some(0)]);
    /// assert_eq!(reader.found[0].problem.message, "names must be a list");
    /// # Ok::<(), fabkit_text::YamlFault>(())
    /// ```
    pub fn read_list<'n>(&mut self, key: &str, node: &'n YamlNode) -> &'n [YamlNode] {
        if !node.is_list() {
            let hint = format!("write `{key}: [a, b]`");
            self.report_problem(node.position, key, "", format!("{key} must be a list"), hint);
        }
        node.items()
    }

    /// Parses a whole number within inclusive limits, of digits only: no sign.
    pub fn read_count(&mut self, key: &str, node: &YamlNode, [low, high]: [u64; 2]) -> Option<u64> {
        let text = self.read_scalar(key, node)?;
        // `parse` itself accepts `+5`.
        let is_digits = text.bytes().all(|byte| byte.is_ascii_digit());
        let count = text.parse().ok().filter(|n| is_digits && (low..=high).contains(n));
        if count.is_none() {
            let message = format!(
                "{key} is {}; it must be a whole number from {low} to {high}",
                to_printable(text)
            );
            self.report_problem(node.position, key, text, message, "write digits only");
        }
        count
    }

    /// Returns `value` if there are no problems.
    ///
    /// # Errors
    /// All problems, in the order of the file.
    ///
    /// ```
    /// use fabkit_text::{Dialect, NodeReader, Position, TextLayer, TextPlace};
    ///
    /// const PIN: &Dialect = &Dialect::new("pin", 1, "");
    /// let reader = || NodeReader::new(TextPlace::new(TextLayer::File, "pin.yaml", PIN));
    /// assert_eq!(reader().finish(Some(7))?, 7);
    /// let mut strict = reader();
    /// strict.report_problem(Position { line: 1, column: 1 }, "colour", "red", "unknown", "remove it");
    /// assert!(strict.finish(Some(7)).is_err());
    /// # Ok::<(), fabkit_text::InvalidDesign>(())
    /// ```
    pub fn finish<T>(self, value: Option<T>) -> Result<T, InvalidDesign> {
        // A value may exist although problems were found.
        value.filter(|_| self.found.is_empty()).ok_or_else(|| self.into_invalid())
    }

    /// Returns all problems, in the order of the file.
    pub fn into_invalid(self) -> InvalidDesign {
        InvalidDesign::new(LocatedProblem::sort(self.found))
    }
}
