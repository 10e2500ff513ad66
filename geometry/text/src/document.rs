//! One table of values by dotted path, from several layers of YAML.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use fabkit_geometry::{Angle, Length};

use crate::expression::Formula;
use crate::place::{Found, Place, Written, WrittenText};
use crate::tree::{Content, Entry, Node};
use crate::unknown::{instead, meant};
use crate::{
    Field, Kind, Refusal, Scalar, Shape, Source, SourceKind, TextLayer, did_you_mean, join, shown,
    similar, UNKNOWN_PARAMETER,
};

/// All values that were written, whichever layer they come from.
#[derive(Clone, Debug)]
pub struct Document {
    /// Shared by the copies that are made to try other values.
    fields: Arc<Vec<Field>>,
    /// Where the whole document is.
    pub root: Place,
    values: BTreeMap<String, Written>,
    sections: BTreeMap<String, Place>,
    /// Paths at which something was written that cannot be read: reported, hence not missing.
    broken: BTreeSet<String>,
    /// What is wrong so far.
    pub found: Vec<Found>,
}

impl Document {
    /// An empty table of these keys; `root` is where the whole document is.
    pub fn new(fields: Vec<Field>, root: Place) -> Self {
        Self {
            fields: Arc::new(fields),
            root,
            values: BTreeMap::new(),
            sections: BTreeMap::new(),
            broken: BTreeSet::new(),
            found: Vec::new(),
        }
    }

    /// Adds a key at the top.
    pub fn add_field(&mut self, field: Field) {
        Arc::make_mut(&mut self.fields).push(field);
    }

    pub(crate) fn value(&self, path: &str) -> Option<&Written> {
        self.values.get(path)
    }

    /// Everything that was written, by path.
    pub(crate) fn values(&self) -> &BTreeMap<String, Written> {
        &self.values
    }

    /// Puts values in place of the expressions at a path; of lists with the number of the item.
    pub(crate) fn put_values(
        &mut self,
        path: &str,
        values: Vec<(Option<usize>, String)>,
        formula: Formula,
    ) {
        let Some(written) = self.values.get_mut(path) else { return };
        for (item, value) in values {
            match (item, &mut written.text) {
                (None, text) => *text = WrittenText::Scalar(value),
                (Some(i), WrittenText::List(items)) => {
                    if let Some((text, _)) = items.get_mut(i) {
                        *text = value;
                    }
                }
                (Some(_), WrittenText::Scalar(_)) => {}
            }
        }
        written.formula = Some(formula);
    }

    /// Everything that a value follows from, near and far.
    pub(crate) fn all_inputs(&self, formula: &Formula) -> BTreeSet<String> {
        all_inputs(&self.values, formula)
    }

    /// What stands in an expression: what the user wrote last before everything else.
    pub(crate) fn inputs(&self, formula: &Formula) -> Vec<String> {
        let mut inputs: Vec<String> = changed_above(&self.values, formula);
        let direct = formula.inputs.iter().filter(|path| !inputs.contains(path)).cloned();
        inputs.extend(direct.collect::<Vec<_>>());
        inputs
    }

    /// Takes away what stands at a path, which cannot be read; that has been reported.
    pub(crate) fn break_off(&mut self, path: &str) {
        self.values.remove(path);
        self.broken.insert(path.to_owned());
    }

    /// What somebody who wrote an unknown path may have meant.
    pub(crate) fn suggest(&self, path: &str) -> String {
        let paths = self.paths();
        let near = meant(path, &paths);
        match near.is_empty() {
            true => instead(path, &paths, self.root.dialect.absent),
            false => did_you_mean(&near),
        }
    }

    /// What a program may take an unknown path for: a slip in its last word, or in its sections.
    pub(crate) fn mistyped(&self, path: &str) -> Option<String> {
        let paths = self.paths();
        let (section, word) = path.rsplit_once('.').unwrap_or(("", path));
        let split = |path: &str| {
            let (section, word) = path.rsplit_once('.').unwrap_or(("", path));
            (section.to_owned(), word.to_owned())
        };
        let all: Vec<(String, String)> = paths.iter().map(|path| split(path)).collect();
        let words = all.iter().filter(|(other, _)| other == section).map(|(_, word)| &**word);
        if let Some(meant) = similar(word, words).first() {
            return Some(join(section, meant));
        }
        let sections = all.iter().filter(|(_, other)| other == word).map(|(section, _)| &**section);
        similar(section, sections).first().map(|meant| join(meant, word))
    }

    pub(crate) fn section(&self, path: &str) -> Option<&Place> {
        self.sections.get(path)
    }

    /// Whether this path, or a section it lies in, was written but not understood.
    pub(crate) fn is_broken(&self, path: &str) -> bool {
        let ends = path.match_indices('.').map(|(i, _)| i).chain([path.len()]);
        ends.into_iter().any(|end| self.broken.contains(&path[..end]))
    }

    /// What was written, by path.
    pub fn into_values(self) -> BTreeMap<String, Written> {
        self.values
    }

    /// Lays the entries of one text over what is there.
    pub fn lay(&mut self, entries: Vec<Entry>, place: &Place) {
        let fields = Arc::clone(&self.fields);
        self.lay_section(&fields, &fields, "", entries, place);
    }

    /// Puts one value over what is there.
    pub(crate) fn set(&mut self, path: &str, written: Written) {
        self.values.insert(path.to_owned(), written);
    }

    /// What stands behind a path, if it is known.
    pub(crate) fn field(&self, path: &str) -> Option<&Field> {
        let (first, rest) = match path.split_once('.') {
            Some((first, rest)) => (first, Some(rest)),
            None => (path, None),
        };
        let mut field = self.fields.iter().find(|f| f.name == first)?;
        for key in rest.into_iter().flat_map(|rest| rest.split('.')) {
            let Shape::Section(fields) = &field.shape else { return None };
            field = fields.iter().find(|f| f.name == key)?;
        }
        Some(field)
    }

    /// Every path of a value, in order.
    pub fn paths(&self) -> Vec<String> {
        let mut paths = Vec::new();
        value_paths(&self.fields, "", &mut paths);
        paths
    }

    /// What was written at a path, if anything was.
    pub fn written(&self, path: &str) -> Option<&Written> {
        self.values.get(path)
    }

    /// Lays the entries of one text below `layer`: over what lower layers say, under what that layer and
    /// those above it say.
    pub fn lay_under(&mut self, entries: Vec<Entry>, place: &Place, layer: TextLayer) {
        let mut laid = Self::new(Vec::new(), self.root.clone());
        laid.fields = Arc::clone(&self.fields);
        laid.lay(entries, place);
        self.found.append(&mut laid.found);
        for (path, written) in laid.values {
            let is_free = self.values.get(&path).is_none_or(|old| layer.is_over(old.place.layer));
            if is_free {
                self.values.insert(path, written);
            }
        }
    }

    fn lay_section(
        &mut self,
        all: &[Field],
        fields: &[Field],
        section: &str,
        entries: Vec<Entry>,
        place: &Place,
    ) {
        for Entry { key, key_position, value } in entries {
            let path = join(section, &key);
            let key_place = place.at(key_position);
            let Some(field) = fields.iter().find(|f| f.name == key) else {
                let text = value.text().unwrap_or_default();
                self.unknown_key(all, fields, section, (&key, text), &key_place);
                continue;
            };
            match (&field.shape, value.content) {
                (_, Content::Nothing) => {
                    let message = format!("{path} has no value");
                    let hint = match place.dialect.base {
                        "" => "write a value after the colon".into(),
                        base => format!(
                            "write a value after the colon, or remove the line if the file extends {base}"
                        ),
                    };
                    let found = key_place.problem(&path, "", message).hint(hint);
                    self.break_at(&path, found.code("no_value"));
                }
                (Shape::Section(inner), Content::Map(entries)) => {
                    self.sections.insert(path.clone(), key_place);
                    self.lay_section(all, inner, &path, entries, place);
                }
                (Shape::Section(inner), _) => {
                    let keys = names(inner);
                    let message = format!("{path} is a section, not a value");
                    let found = place.at(value.position).problem(&path, "", message);
                    let hint = format!("its keys are {keys}");
                    self.break_at(&path, found.hint(hint).code("wrong_shape"));
                }
                (Shape::Value { kind, is_list, .. }, Content::Map(entries)) => {
                    match self.read_map(&path, (*kind, *is_list), entries, &key_place, place) {
                        Some(written) => self.set(&path, written),
                        None => {
                            self.broken.insert(path);
                        }
                    }
                }
                (Shape::Value { is_list, .. }, content) => {
                    let node = Node { position: value.position, content };
                    match plain(&path, *is_list, node, place) {
                        Ok((text, place)) => {
                            let source = Source::user("");
                            self.set(&path, Written::new(place, text, source));
                        }
                        Err(found) => self.break_at(&path, *found),
                    }
                }
            }
        }
    }

    fn unknown_key(
        &mut self,
        all: &[Field],
        fields: &[Field],
        section: &str,
        (key, value): (&str, &str),
        place: &Place,
    ) {
        let message = match section {
            "" => format!("`{}` is not a key of a {}", shown(key), place.dialect.noun),
            _ => format!("`{}` is not a key of {section}", shown(key)),
        };
        let near = similar(key, fields.iter().map(|f| f.name));
        let mut other = near.first().map(|meant| join(section, meant));
        let hint = if let Some(meant) = near.first() {
            // Mistyped rather than missing: one slip, one problem.
            self.broken.insert(join(section, meant));
            did_you_mean(&near)
        } else {
            // Perhaps the right word in the wrong section.
            let mut paths = Vec::new();
            value_paths(all, "", &mut paths);
            let is_meant = |path: &&str| path.rsplit('.').next() == Some(key);
            let elsewhere: Vec<&str> =
                paths.iter().map(String::as_str).filter(is_meant).take(3).collect();
            other = elsewhere.first().map(|path| (*path).to_owned());
            match elsewhere.is_empty() {
                true => match place.dialect.absent.iter().find(|(name, _)| *name == key) {
                    Some((_, why)) => {
                        format!("fabkit has none: {why}; the keys are {}", names(fields))
                    }
                    None => format!("the keys are {}", names(fields)),
                },
                false => did_you_mean(&elsewhere),
            }
        };
        let path = join(section, &shown(key));
        let found = place.problem(&path, &shown(key), message).hint(hint);
        let found = found.code(UNKNOWN_PARAMETER);
        self.found.push(match other {
            Some(other) if !value.is_empty() => found.suggest(&other, &shown(value)),
            _ => found,
        });
    }

    fn break_at(&mut self, path: &str, found: Found) {
        self.broken.insert(path.to_owned());
        self.found.push(found);
    }

    /// Reads `{value, source, note, tolerance}`.
    fn read_map(
        &mut self,
        path: &str,
        (kind, is_list): (Kind, bool),
        entries: Vec<Entry>,
        key_place: &Place,
        place: &Place,
    ) -> Option<Written> {
        const KEYS: [&str; 4] = ["value", "source", "note", "tolerance"];
        let mut text = None;
        let mut source = Source::user("");
        let mut has_value = false;
        for Entry { key, key_position, value } in entries {
            let at = place.at(value.position);
            match (&*key, value.content) {
                ("value", Content::Nothing) => {}
                ("value", content) => {
                    has_value = true;
                    let node = Node { position: value.position, content };
                    match plain(path, is_list, node, place) {
                        Ok(read) => text = Some(read),
                        Err(found) => self.found.push(*found),
                    }
                }
                ("source", Content::Scalar(word)) => {
                    match SourceKind::ALL.into_iter().find(|kind| kind.word() == word) {
                        Some(kind) => source.kind = kind,
                        None => {
                            let words = SourceKind::ALL.map(SourceKind::word);
                            let message = format!(
                                "the source of {path} is `{}`; it must be one of {}",
                                shown(&word),
                                words.join(", ")
                            );
                            let hint = crate::suggestion(&word, words, "write one of");
                            let path = join(path, "source");
                            let found = at.problem(&path, &shown(&word), message).hint(hint);
                            let found = found.code("unknown_choice");
                            self.found.push(found);
                        }
                    }
                }
                ("note", Content::Scalar(note)) => match note_text(&note) {
                    Ok(note) => source.note = note,
                    Err(says) => {
                        let message = format!("the note of {path} {says}");
                        let found = at.problem(&join(path, "note"), &shown(&note), message);
                        self.found.push(found.hint("write one short line"));
                    }
                },
                ("tolerance", Content::Scalar(text)) => match tolerance(kind, is_list, &text) {
                    Ok(text) => source.tolerance = Some(text),
                    Err(Refusal { says, hint, code, .. }) => {
                        let text = shown(&text);
                        let message = format!("the tolerance of {path} is `{text}`, which {says}");
                        let found = at.problem(&join(path, "tolerance"), &text, message);
                        self.found.push(found.hint(hint.unwrap_or_default()).code(code));
                    }
                },
                ("source" | "note" | "tolerance", _) => {
                    let message = format!("the {key} of {path} is not a text");
                    let found = at.problem(&join(path, &key), "", message);
                    let found = found.hint("write it as one line of text");
                    self.found.push(found.code("wrong_shape"));
                }
                _ => {
                    let known = crate::suggestion(&key, KEYS, "a value may have");
                    let message =
                        format!("`{}` is not known; {path} is a single value", shown(&key));
                    let path = join(path, &shown(&key));
                    let found = place.at(key_position).problem(&path, &shown(&key), message);
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
        Some(Written::new(place, text, source))
    }
}

/// Reads a value in its plain form.
pub(crate) fn plain(
    path: &str,
    is_list: bool,
    node: Node,
    place: &Place,
) -> Result<(WrittenText, Place), Box<Found>> {
    let at = place.at(node.position);
    match (is_list, node.content) {
        (false, Content::Scalar(text)) => Ok((WrittenText::Scalar(text), at)),
        (true, Content::List(items)) => {
            let item = |(i, item): (usize, Node)| match item.content {
                Content::Scalar(text) => Ok((text, place.at(item.position))),
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
            let text = if let Content::Scalar(text) = content { shown(&text) } else { "".into() };
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

/// Longest note, characters.
const LONGEST_NOTE: usize = 500;

fn note_text(note: &str) -> Result<String, String> {
    let note = note.trim();
    if note.chars().count() > LONGEST_NOTE {
        return Err(format!("is longer than {LONGEST_NOTE} characters"));
    }
    if note.chars().any(char::is_control) {
        return Err("contains a control character".into());
    }
    Ok(note.to_owned())
}

/// How far what is made may be from a value, as it was written.
fn tolerance(kind: Kind, is_list: bool, text: &str) -> Result<String, Refusal> {
    let value = match (kind, is_list) {
        (Kind::Length, false) => Length::parse(text)?.mm(),
        (Kind::Angle, false) => Angle::parse(text)?.deg(),
        _ => {
            return Err(Refusal::new(
                "says nothing of what is no single length or angle",
                "remove it",
            ));
        }
    };
    match value >= 0.0 {
        true => Ok(text.trim().to_owned()),
        false => Err(Refusal::new("is below 0", "write how far it may be off either way")),
    }
}

fn names(fields: &[Field]) -> String {
    fields.iter().map(|f| f.name).collect::<Vec<_>>().join(", ")
}

/// Everything that a value follows from, near and far.
fn all_inputs(values: &BTreeMap<String, Written>, formula: &Formula) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    let mut next: Vec<&String> = formula.inputs.iter().collect();
    while let Some(path) = next.pop() {
        if all.insert(path.clone())
            && let Some(formula) = values.get(path).and_then(|written| written.formula.as_ref())
        {
            next.extend(&formula.inputs);
        }
    }
    all
}

/// What a value follows from, near or far, and was written over what the expression stands in: what
/// the user has just changed.
pub(crate) fn changed_above(values: &BTreeMap<String, Written>, formula: &Formula) -> Vec<String> {
    let mut changed: Vec<String> = all_inputs(values, formula).into_iter().collect();
    let below = formula.layer;
    changed.retain(|path| {
        values.get(path).is_some_and(|w| w.formula.is_none() && w.place.layer.is_over(below))
    });
    changed
}

fn value_paths(fields: &[Field], section: &str, paths: &mut Vec<String>) {
    for field in fields {
        let path = join(section, field.name);
        match &field.shape {
            Shape::Section(inner) => value_paths(inner, &path, paths),
            Shape::Value { .. } => paths.push(path),
        }
    }
}
