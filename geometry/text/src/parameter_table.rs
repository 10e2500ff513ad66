//! Table of values by dotted path, merged from several layers of YAML.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use fabkit_geometry::{Angle, Length};

use crate::expression::Formula;
use crate::place::{LocatedProblem, TextPlace, WrittenText, WrittenValue, WrittenValues};
use crate::tree::{YamlContent, YamlEntry, YamlNode};
use crate::unknown_path::{describe_alternatives, find_similar_paths};
use crate::{
    FieldDeclaration, FieldShape, Refusal, Scalar, SourceKind, TextLayer, UNKNOWN_PARAMETER,
    ValueKind, ValueSource, did_you_mean, find_similar, join, to_printable,
};

/// All written values, from every layer.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{
///     Dialect, FieldDeclaration, Parameter, ParameterTable, TextLayer, TextPlace, read_mapping,
/// };
///
/// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
/// let shape = Length::shape(&(1.0..=20.0));
/// let radius = FieldDeclaration { name: "radius", summary: "Radius.".into(), shape };
/// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
/// let mut table = ParameterTable::new(vec![radius], place.clone());
/// let entries = read_mapping("radius: 7 mm\nradus: 8 mm\n", &place, &mut table.found);
/// table.merge(entries.unwrap_or_default(), &place);
/// assert_eq!(table.paths(), ["radius"]);
/// assert_eq!(table.written("radius").map(|value| value.text.to_printable()), Some("7 mm".into()));
/// assert_eq!(table.found[0].problem.hint.as_deref(), Some("did you mean `radius`?"));
/// ```
#[derive(Clone, Debug)]
pub struct ParameterTable {
    /// Keys of the file. Shared by the copies that are made to try other values.
    fields: Arc<Vec<FieldDeclaration>>,
    /// Place of the whole document.
    pub root: TextPlace,
    /// Values, shared by the copies that are made to try other values.
    values: WrittenValues,
    sections: BTreeMap<String, TextPlace>,
    /// Paths where something unreadable was written: already reported, so not reported as missing.
    broken: BTreeSet<String>,
    /// Problems so far.
    pub found: Vec<LocatedProblem>,
}

impl ParameterTable {
    /// Creates an empty table for `fields`; `root` is the place of the whole document.
    pub fn new(fields: Vec<FieldDeclaration>, root: TextPlace) -> Self {
        Self {
            fields: Arc::new(fields),
            root,
            values: BTreeMap::new(),
            sections: BTreeMap::new(),
            broken: BTreeSet::new(),
            found: Vec::new(),
        }
    }

    /// Adds a key at the top level.
    pub fn add_field(&mut self, field: FieldDeclaration) {
        // Copies the list if other documents share it.
        Arc::make_mut(&mut self.fields).push(field);
    }

    /// Returns the value written at a path.
    pub(crate) fn value(&self, path: &str) -> Option<&WrittenValue> {
        self.values.get(path).map(Arc::as_ref)
    }

    /// Returns the value written at a path, to be kept.
    pub(crate) fn shared_value(&self, path: &str) -> Option<Arc<WrittenValue>> {
        self.values.get(path).cloned()
    }

    /// Returns all written values, by path.
    pub(crate) fn values(&self) -> &WrittenValues {
        &self.values
    }

    /// Replaces the expressions at `path` by their values. For lists, each value comes with its item number.
    pub(crate) fn replace_expressions(
        &mut self,
        path: &str,
        values: Vec<(Option<usize>, String)>,
        formula: Formula,
    ) {
        let Some(written) = self.values.get_mut(path).map(Arc::make_mut) else { return };
        for (item, value) in values {
            match (item, &mut written.text) {
                (None, text) => *text = WrittenText::Scalar(value),
                (Some(i), WrittenText::List(items)) => {
                    if let Some((text, _)) = items.get_mut(i) {
                        *text = value;
                    }
                }
                // Item numbers come from lists only.
                (Some(_), WrittenText::Scalar(_)) => {}
            }
        }
        written.formula = Some(formula);
    }

    /// Returns every path that `formula` depends on, directly or through other expressions.
    pub(crate) fn collect_inputs(&self, formula: &Formula) -> BTreeSet<String> {
        collect_inputs(&self.values, formula)
    }

    /// Returns the paths that `formula` names. Those that the user changed in a layer above the expression come first.
    pub(crate) fn ordered_inputs(&self, formula: &Formula) -> Vec<String> {
        let mut inputs: Vec<String> = find_changed_inputs(&self.values, formula);
        let direct = formula.inputs.iter().filter(|path| !inputs.contains(path)).cloned();
        // Collected first, because `inputs` is borrowed by the filter.
        inputs.extend(direct.collect::<Vec<_>>());
        inputs
    }

    /// Removes the unreadable value at `path` and marks the path as broken. The problem has been reported already.
    pub(crate) fn mark_unreadable(&mut self, path: &str) {
        // Removed as well, so that no later step uses the text.
        self.values.remove(path);
        self.broken.insert(path.to_owned());
    }

    /// Writes a hint for an unknown path: similar paths if there are any, otherwise the keys that exist.
    pub(crate) fn suggest_hint(&self, path: &str) -> String {
        let paths = self.paths();
        let near = find_similar_paths(path, &paths);
        if near.is_empty() {
            describe_alternatives(path, &paths, self.root.dialect.absent)
        } else {
            did_you_mean(&near)
        }
    }

    /// Returns the path that a program may replace an unknown path with: a misspelt last word, or a misspelt section.
    pub(crate) fn find_correction(&self, path: &str) -> Option<String> {
        let paths = self.paths();
        let (section, word) = path.rsplit_once('.').unwrap_or(("", path));
        let split = |path: &str| {
            let (section, word) = path.rsplit_once('.').unwrap_or(("", path));
            (section.to_owned(), word.to_owned())
        };
        let all: Vec<(String, String)> = paths.iter().map(|path| split(path)).collect();
        let words = all.iter().filter(|(other, _)| other == section).map(|(_, word)| &**word);
        // First a slip in the last word, within the right section.
        if let Some(meant) = find_similar(word, words).first() {
            return Some(join(section, meant));
        }
        // Then the right word below a misspelt section.
        let sections = all.iter().filter(|(_, other)| other == word).map(|(section, _)| &**section);
        find_similar(section, sections).first().map(|meant| join(meant, word))
    }

    /// Returns the place of a section that was written.
    pub(crate) fn section(&self, path: &str) -> Option<&TextPlace> {
        self.sections.get(path)
    }

    /// Returns whether this path, or a section that contains it, was written but could not be read.
    pub(crate) fn is_unreadable(&self, path: &str) -> bool {
        // Every prefix that ends before a dot, and the path itself.
        let ends = path.match_indices('.').map(|(i, _)| i).chain([path.len()]);
        ends.into_iter().any(|end| self.broken.contains(&path[..end]))
    }

    /// Returns the written values, by path.
    pub fn into_values(self) -> WrittenValues {
        self.values
    }

    /// Merges the entries of one text over the present values.
    pub fn merge(&mut self, entries: Vec<YamlEntry>, place: &TextPlace) {
        let fields = Arc::clone(&self.fields);
        // Listed once for all unknown keys: a text may have thousands.
        let paths = self.paths();
        self.merge_section(&paths, &fields, "", entries, place);
    }

    /// Writes one value over the present one.
    pub(crate) fn set(&mut self, path: &str, written: impl Into<Arc<WrittenValue>>) {
        self.values.insert(path.to_owned(), written.into());
    }

    /// Returns the field declared at a path, if there is one.
    pub(crate) fn field(&self, path: &str) -> Option<&FieldDeclaration> {
        let (first, rest) = match path.split_once('.') {
            Some((first, rest)) => (first, Some(rest)),
            None => (path, None),
        };
        let mut field = self.fields.iter().find(|f| f.name == first)?;
        for key in rest.into_iter().flat_map(|rest| rest.split('.')) {
            let FieldShape::Section(fields) = &field.shape else { return None };
            field = fields.iter().find(|f| f.name == key)?;
        }
        Some(field)
    }

    /// Returns the path of every value, in order of declaration.
    pub fn paths(&self) -> Vec<String> {
        let mut paths = Vec::new();
        collect_value_paths(&self.fields, "", &mut paths);
        paths
    }

    /// Returns the value written at a path, if any.
    pub fn written(&self, path: &str) -> Option<&WrittenValue> {
        self.value(path)
    }

    /// Merges the entries of one text at the height of `layer`: over lower layers, but below `layer` itself and those
    /// above it.
    ///
    /// ```
    /// use fabkit_text::{
    ///     Dialect, FieldDeclaration, Parameter, ParameterTable, TextLayer, TextPlace, ValueKind,
    ///     read_mapping,
    /// };
    ///
    /// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
    /// let count = |name| FieldDeclaration { name, summary: String::new(), shape: u32::shape(&(1..=9)) };
    /// let mut table = ParameterTable::new(
    ///     vec![count("rows"), count("columns")],
    ///     TextPlace::new(TextLayer::File, "pins.yaml", PINS),
    /// );
    /// let entries = |yaml, place| read_mapping(yaml, place, &mut Vec::new()).unwrap_or_default();
    /// let base = TextPlace::new(TextLayer::Base, "built in", PINS);
    /// let file = table.root.clone();
    /// table.merge(entries("rows: 2\n", &file), &file);
    /// table.merge_below(entries("rows: 5\ncolumns: 6\n", &base), &base, TextLayer::Base);
    /// assert_eq!(table.number("rows", ValueKind::Count), Some(2.0));
    /// assert_eq!(table.number("columns", ValueKind::Count), Some(6.0));
    /// ```
    pub fn merge_below(&mut self, entries: Vec<YamlEntry>, place: &TextPlace, layer: TextLayer) {
        let mut laid = Self::new(Vec::new(), self.root.clone());
        laid.fields = Arc::clone(&self.fields);
        laid.merge(entries, place);
        self.found.append(&mut laid.found);
        for (path, written) in laid.values {
            // Values of `layer` and of those above it stay.
            let is_free = self.values.get(&path).is_none_or(|old| layer.overrides(old.place.layer));
            if is_free {
                self.values.insert(path, written);
            }
        }
    }

    /// Merges the entries of one section. `all` are the paths of all values, for suggestions.
    fn merge_section(
        &mut self,
        all: &[String],
        fields: &[FieldDeclaration],
        section: &str,
        entries: Vec<YamlEntry>,
        place: &TextPlace,
    ) {
        for YamlEntry { key, key_position, value } in entries {
            let path = join(section, &key);
            let key_place = place.at(key_position);
            // Unknown keys are reported, and the others are still read.
            let Some(field) = fields.iter().find(|f| f.name == key) else {
                let text = value.text().unwrap_or_default();
                self.unknown_key(all, fields, section, (&key, text), &key_place);
                continue;
            };
            match (&field.shape, value.content) {
                (_, YamlContent::Nothing) => {
                    let message = format!("{path} has no value");
                    let hint = match place.dialect.base {
                        "" => "write a value after the colon".into(),
                        base => format!(
                            "write a value after the colon, or remove the line if the file extends {base}"
                        ),
                    };
                    let found = key_place.problem(&path, "", message).hint(hint);
                    self.report_unreadable(&path, found.code("no_value"));
                }
                (FieldShape::Section(inner), YamlContent::Map(entries)) => {
                    self.sections.insert(path.clone(), key_place);
                    self.merge_section(all, inner, &path, entries, place);
                }
                (FieldShape::Section(inner), _) => {
                    let keys = names(inner);
                    let message = format!("{path} is a section, not a value");
                    let found = place.at(value.position).problem(&path, "", message);
                    let hint = format!("its keys are {keys}");
                    self.report_unreadable(&path, found.hint(hint).code("wrong_shape"));
                }
                // A mapping in place of a value is its long form.
                (FieldShape::Value { kind, is_list, .. }, YamlContent::Map(entries)) => {
                    match self.read_map(&path, (*kind, *is_list), entries, &key_place, place) {
                        Some(written) => self.set(&path, written),
                        None => {
                            self.broken.insert(path);
                        }
                    }
                }
                (FieldShape::Value { is_list, .. }, content) => {
                    let node = YamlNode { position: value.position, content };
                    match read_plain_value(&path, *is_list, node, place) {
                        Ok((text, place)) => {
                            let source = ValueSource::user("");
                            self.set(&path, WrittenValue::new(place, text, source));
                        }
                        Err(found) => self.report_unreadable(&path, *found),
                    }
                }
            }
        }
    }

    /// Reports a key that the section does not have, with a suggestion.
    fn unknown_key(
        &mut self,
        all: &[String],
        fields: &[FieldDeclaration],
        section: &str,
        (key, value): (&str, &str),
        place: &TextPlace,
    ) {
        let message = match section {
            "" => format!("`{}` is not a key of a {}", to_printable(key), place.dialect.noun),
            _ => format!("`{}` is not a key of {section}", to_printable(key)),
        };
        let near = find_similar(key, fields.iter().map(|f| f.name));
        let mut other = near.first().map(|meant| join(section, meant));
        let hint = if let Some(meant) = near.first() {
            // A misspelt key counts as written, so that it is not also reported as missing.
            self.broken.insert(join(section, meant));
            did_you_mean(&near)
        } else {
            // The key may be right but in the wrong section.
            let is_meant = |path: &&str| path.rsplit('.').next() == Some(key);
            let elsewhere: Vec<&str> =
                all.iter().map(String::as_str).filter(is_meant).take(3).collect();
            other = elsewhere.first().map(|path| (*path).to_owned());
            if elsewhere.is_empty() {
                match place.dialect.absent.iter().find(|(name, _)| *name == key) {
                    Some((_, why)) => {
                        format!("fabkit has none: {why}; the keys are {}", names(fields))
                    }
                    None => format!("the keys are {}", names(fields)),
                }
            } else {
                did_you_mean(&elsewhere)
            }
        };
        let path = join(section, &to_printable(key));
        let found = place.problem(&path, &to_printable(key), message).hint(hint);
        let found = found.code(UNKNOWN_PARAMETER);
        self.found.push(match other {
            Some(other) if !value.is_empty() => found.suggest(&other, &to_printable(value)),
            _ => found,
        });
    }

    /// Reports a problem and marks its path as unreadable.
    fn report_unreadable(&mut self, path: &str, found: LocatedProblem) {
        self.broken.insert(path.to_owned());
        self.found.push(found);
    }

    /// Reads a value in its long form, `{value, source, note, tolerance}`.
    fn read_map(
        &mut self,
        path: &str,
        (kind, is_list): (ValueKind, bool),
        entries: Vec<YamlEntry>,
        key_place: &TextPlace,
        place: &TextPlace,
    ) -> Option<WrittenValue> {
        const KEYS: [&str; 4] = ["value", "source", "note", "tolerance"];
        let mut text = None;
        let mut source = ValueSource::user("");
        let mut has_value = false;
        for YamlEntry { key, key_position, value } in entries {
            let at = place.at(value.position);
            match (&*key, value.content) {
                // Reported below as a missing value.
                ("value", YamlContent::Nothing) => {}
                ("value", content) => {
                    has_value = true;
                    let node = YamlNode { position: value.position, content };
                    match read_plain_value(path, is_list, node, place) {
                        Ok(read) => text = Some(read),
                        Err(found) => self.found.push(*found),
                    }
                }
                ("source", YamlContent::Scalar(word)) => {
                    match SourceKind::ALL.into_iter().find(|kind| kind.word() == word) {
                        Some(kind) => source.kind = kind,
                        None => {
                            let words = SourceKind::ALL.map(SourceKind::word);
                            let message = format!(
                                "the source of {path} is `{}`; it must be one of {}",
                                to_printable(&word),
                                words.join(", ")
                            );
                            let hint = crate::suggestion(&word, words, "write one of");
                            let path = join(path, "source");
                            let found = at.problem(&path, &to_printable(&word), message).hint(hint);
                            let found = found.code("unknown_choice");
                            self.found.push(found);
                        }
                    }
                }
                ("note", YamlContent::Scalar(note)) => match parse_note(&note) {
                    Ok(note) => source.note = note,
                    Err(says) => {
                        let message = format!("the note of {path} {says}");
                        let found = at.problem(&join(path, "note"), &to_printable(&note), message);
                        self.found.push(found.hint("write one short line"));
                    }
                },
                ("tolerance", YamlContent::Scalar(text)) => {
                    match parse_tolerance(kind, is_list, &text) {
                        Ok(text) => source.tolerance = Some(text),
                        Err(Refusal { says, hint, code, .. }) => {
                            let text = to_printable(&text);
                            let message =
                                format!("the tolerance of {path} is `{text}`, which {says}");
                            let found = at.problem(&join(path, "tolerance"), &text, message);
                            self.found.push(found.hint(hint.unwrap_or_default()).code(code));
                        }
                    }
                }
                ("source" | "note" | "tolerance", _) => {
                    let message = format!("the {key} of {path} is not a text");
                    let found = at.problem(&join(path, &key), "", message);
                    let found = found.hint("write it as one line of text");
                    self.found.push(found.code("wrong_shape"));
                }
                _ => {
                    let known = crate::suggestion(&key, KEYS, "a value may have");
                    let message =
                        format!("`{}` is not known; {path} is a single value", to_printable(&key));
                    let path = join(path, &to_printable(&key));
                    let found = place.at(key_position).problem(&path, &to_printable(&key), message);
                    self.found.push(found.hint(known).code(UNKNOWN_PARAMETER));
                }
            }
        }
        if !has_value {
            let message = format!("{path} has no `value`");
            let found = key_place.problem(path, "", message);
            let hint = "write `{value: ..., source: ..., note: ...}`";
            self.found.push(found.hint(hint).code("no_value"));
        }
        let (text, place) = text?;
        Some(WrittenValue::new(place, text, source))
    }
}

/// Reads a value in its short form: one scalar, or one list.
pub(crate) fn read_plain_value(
    path: &str,
    is_list: bool,
    node: YamlNode,
    place: &TextPlace,
) -> Result<(WrittenText, TextPlace), Box<LocatedProblem>> {
    let at = place.at(node.position);
    match (is_list, node.content) {
        (false, YamlContent::Scalar(text)) => Ok((WrittenText::Scalar(text), at)),
        (true, YamlContent::List(items)) => {
            let item = |(i, item): (usize, YamlNode)| match item.content {
                YamlContent::Scalar(text) => Ok((text, place.at(item.position))),
                _ => {
                    let path = format!("{path}[{i}]");
                    let message = format!("{path} is not a single value");
                    let found = place.at(item.position).problem(&path, "", message);
                    let hint = "write the items as `[a, b, c]`";
                    Err(Box::new(found.hint(hint).code("wrong_shape")))
                }
            };
            let items: Result<Vec<_>, _> = items.into_iter().enumerate().map(item).collect();
            Ok((WrittenText::List(items?), at))
        }
        (true, content) => {
            let text = if let YamlContent::Scalar(text) = content {
                to_printable(&text)
            } else {
                "".into()
            };
            let message = format!("{path} is a list, not a single value");
            let found = at.problem(path, &text, message).hint("write `[a, b, c]`");
            Err(Box::new(found.code("wrong_shape")))
        }
        (false, _) => {
            let message = format!("{path} is a single value, not a list or a section");
            let found = at.problem(path, "", message);
            let hint = format!("write `{path}` with one value");
            Err(Box::new(found.hint(hint).code("wrong_shape")))
        }
    }
}

/// Maximum length of a note, characters.
const MAX_NOTE_CHARACTERS: usize = 500;

/// Returns the note without white space around it, or what is wrong with it.
fn parse_note(note: &str) -> Result<String, String> {
    let note = note.trim();
    if note.chars().count() > MAX_NOTE_CHARACTERS {
        return Err(format!("is longer than {MAX_NOTE_CHARACTERS} characters"));
    }
    if note.chars().any(char::is_control) {
        return Err("contains a control character".into());
    }
    Ok(note.to_owned())
}

/// Checks a tolerance (a length or an angle, 0 or more) and returns its text as written.
fn parse_tolerance(kind: ValueKind, is_list: bool, text: &str) -> Result<String, Refusal> {
    let value = match (kind, is_list) {
        (ValueKind::Length, false) => Length::parse(text)?.mm(),
        (ValueKind::Angle, false) => Angle::parse(text)?.deg(),
        _ => {
            return Err(Refusal::new(
                "says nothing of what is no single length or angle",
                "remove it",
            ));
        }
    };
    if value >= 0.0 {
        Ok(text.trim().to_owned())
    } else {
        Err(Refusal::new("is below 0", "write how far it may be off either way"))
    }
}

/// Joins the names of fields.
fn names(fields: &[FieldDeclaration]) -> String {
    fields.iter().map(|f| f.name).collect::<Vec<_>>().join(", ")
}

/// Returns every path that `formula` depends on, directly or through other expressions.
fn collect_inputs(values: &WrittenValues, formula: &Formula) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    let mut next: Vec<&String> = formula.inputs.iter().collect();
    while let Some(path) = next.pop() {
        // Each path is visited once, so that cycles end.
        if all.insert(path.clone())
            && let Some(formula) = values.get(path).and_then(|written| written.formula.as_ref())
        {
            next.extend(&formula.inputs);
        }
    }
    all
}

/// Returns the plain inputs of `formula`, direct or indirect, that were written in a layer above the expression: those
/// the user has just changed.
pub(crate) fn find_changed_inputs(values: &WrittenValues, formula: &Formula) -> Vec<String> {
    let mut changed: Vec<String> = collect_inputs(values, formula).into_iter().collect();
    let below = formula.layer;
    changed.retain(|path| {
        values.get(path).is_some_and(|w| w.formula.is_none() && w.place.layer.overrides(below))
    });
    changed
}

/// Appends the paths of all values below a section.
fn collect_value_paths(fields: &[FieldDeclaration], section: &str, paths: &mut Vec<String>) {
    for field in fields {
        let path = join(section, field.name);
        match &field.shape {
            FieldShape::Section(inner) => collect_value_paths(inner, &path, paths),
            FieldShape::Value { .. } => paths.push(path),
        }
    }
}
