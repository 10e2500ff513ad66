//! Assignment of processes and materials to parts: the keys `processes:` and `parts:` of files.

use fabkit_text::{
    Dialect, LocatedProblem, NodeReader, Setting, TextPlace, ValueSource, YamlEntry, join,
    to_printable,
};

use super::part_processes::{PartAssignment, matches_pattern};
use super::{NamedProcess, ProcessAssignments, ProcessFigures, ProcessKind};
use crate::user_catalogue::named_sections::{
    LayeredSections, RawSection, SectionKind, key_of, parse_name, read, similar_names, take_entry,
};

/// Processes in files: key and dialect.
pub(crate) const PROCESSES: SectionKind = SectionKind {
    key: "processes",
    dialect: &Dialect::new("process", 1, ", then `processes:` and names with sections"),
};

/// Key of the assignments to parts.
pub(crate) const PARTS: &str = "parts";

/// Maximum number of materials of one process.
const MOST_MATERIALS: usize = 32;

/// Processes and assignments stated by files.
#[derive(Clone, Debug, Default)]
pub(crate) struct Processes {
    recipes: Vec<(NamedProcess, Vec<Setting>)>,
    given: Vec<PartAssignment>,
}

impl Processes {
    /// Reads processes and assignments; later texts override earlier ones.
    pub fn read(
        raws: Vec<RawSection>,
        parts: Vec<(TextPlace, YamlEntry)>,
        found: &mut Vec<LocatedProblem>,
    ) -> Self {
        let layered = LayeredSections::new(&raws);
        let recipe = |(key, said): (&String, &[&RawSection])| recipe(&layered, key, said, found);
        let recipes = layered.iter().filter_map(recipe).collect();
        let mut all = Self { recipes, given: Vec::new() };
        for (place, entry) in parts {
            let mut reading = NodeReader::new(place.clone());
            for part in reading.read_map(PARTS, &entry.value).to_vec() {
                all.part(&mut reading, part);
            }
            found.extend(reading.found);
        }
        all
    }

    /// Reads an override `parts.PATTERN.process=WORD` of the command line. Returns whether the text was one.
    pub fn take_override(
        &mut self,
        text: &str,
        place: &TextPlace,
        found: &mut Vec<LocatedProblem>,
    ) -> bool {
        let Some((path, value)) = text.split_once('=') else { return false };
        let Some(rest) = path.trim().strip_prefix("parts.") else { return false };
        let Some((pattern, key)) = rest.rsplit_once('.') else { return false };
        let mut reading = NodeReader::new(place.clone());
        let mut given = PartAssignment {
            pattern: pattern.into(),
            place: place.clone(),
            recipe: None,
            material: None,
        };
        self.key(&mut reading, &mut given, key, path.trim(), value.trim(), place);
        found.extend(reading.found);
        self.given.push(given);
        true
    }

    /// Reads the assignment to one pattern.
    fn part(&mut self, reading: &mut NodeReader, entry: YamlEntry) {
        let path = join(PARTS, &to_printable(&entry.key));
        let place = reading.place.at(entry.key_position);
        let mut given = PartAssignment {
            pattern: entry.key.trim().into(),
            place,
            recipe: None,
            material: None,
        };
        for inner in reading.read_map(&path, &entry.value).to_vec() {
            let path = join(&path, &to_printable(&inner.key));
            let Some(text) = reading.read_scalar(&path, &inner.value) else { continue };
            let key_place = reading.place.at(inner.key_position);
            // A wrong value is reported at the value, an unknown key at the key.
            let at = if matches!(&*inner.key, "process" | "material") {
                reading.place.at(inner.value.position)
            } else {
                key_place
            };
            self.key(reading, &mut given, &inner.key, &path, text, &at);
        }
        self.given.push(given);
    }

    /// Reads the key `process` or `material` of an assignment.
    fn key(
        &self,
        reading: &mut NodeReader,
        given: &mut PartAssignment,
        key: &str,
        path: &str,
        text: &str,
        at: &TextPlace,
    ) {
        match key {
            "process" => match self.recipe(text) {
                Some(recipe) => given.recipe = Some(recipe),
                None => {
                    let names = self.names();
                    let message =
                        format!("{path} is `{}`, which is no known process", to_printable(text));
                    let did = match &similar_names(text, names.iter().map(String::as_str))[..] {
                        [] => String::new(),
                        near => format!("{} ", fabkit_text::did_you_mean(near)),
                    };
                    let hint = format!(
                        "{did}known are {}; or declare your own: `processes: {{{}: {{kind: fdm}}}}`",
                        names.join(", "),
                        to_printable(text)
                    );
                    reading.found.push(at.problem(path, &to_printable(text), message).hint(hint));
                }
            },
            "material" => {
                let value = parse_name(text, at, path, &mut reading.found);
                given.material = value;
            }
            _ => {
                let message = format!("`{}` is not a key of a part", to_printable(key));
                let hint = fabkit_text::suggestion(key, ["process", "material"], "the keys are");
                reading.found.push(at.problem(path, &to_printable(key), message).hint(hint));
            }
        }
    }

    /// Returns the names of all processes: the user's own, then the kinds.
    fn names(&self) -> Vec<String> {
        let own = self.recipes.iter().map(|(recipe, _)| recipe.name.clone());
        let kinds = ProcessKind::WORDS.iter().map(|word| (*word).to_owned());
        let mut names: Vec<String> = own.chain(kinds).collect();
        let mut seen = std::collections::BTreeSet::new();
        // A user's process may have the name of a kind.
        names.retain(|name| seen.insert(key_of(name)));
        names
    }

    /// Finds a process by name: a user's own, otherwise a kind.
    fn recipe(&self, name: &str) -> Option<NamedProcess> {
        let key = key_of(name);
        let own = self.recipes.iter().find(|(recipe, _)| key_of(&recipe.name) == key);
        if let Some((recipe, _)) = own {
            return Some(recipe.clone());
        }
        let kind = ProcessKind::ALL.into_iter().find(|kind| kind.word() == key)?;
        let name = kind.word().to_owned();
        Some(NamedProcess { name, kind, figures: None, materials: Vec::new() })
    }

    /// Returns the assignments in the form in which families ask for them.
    pub fn to_assignments(&self) -> ProcessAssignments {
        // A recipe named like its kind, such as `fdm`, changes that kind for all parts.
        let is_of_kind = |recipe: &&NamedProcess| recipe.kind.word() == key_of(&recipe.name);
        let recipes = self.recipes.iter().map(|(recipe, _)| recipe);
        let of_kind = recipes.filter(is_of_kind).cloned().collect();
        ProcessAssignments::new(of_kind, self.given.clone())
    }

    /// Returns the settings that parts of these names depend on.
    pub fn settings(&self, names: &[String]) -> Vec<Setting> {
        let is_meant = |given: &&PartAssignment| {
            names.iter().any(|name| matches_pattern(&given.pattern, name))
        };
        // A machine on which no part is made does not count.
        let is_used = |recipe: &NamedProcess| {
            let given = self.given.iter().filter(is_meant);
            recipe.kind.word() == key_of(&recipe.name)
                || given.into_iter().any(|given| given.recipe.as_ref() == Some(recipe))
        };
        let used = self.recipes.iter().filter(|(recipe, _)| is_used(recipe));
        let own = used.flat_map(|(_, settings)| settings.iter().cloned());
        let given = self.given.iter().filter(is_meant).flat_map(|given| {
            let path = join(PARTS, &given.pattern);
            let of = |key: &str, value: Option<String>, summary: &str| {
                Some(Setting {
                    path: join(&path, key),
                    value: value?,
                    kind: fabkit_text::ValueKind::Text,
                    source: ValueSource::user(""),
                    summary: summary.into(),
                    limits: String::new(),
                    expression: None,
                    is_default: false,
                    bounds: None,
                    choices: Vec::new(),
                })
            };
            let process = given.recipe.as_ref().map(|recipe| recipe.name.clone());
            [
                of("process", process, "Process by which these parts are made."),
                of("material", given.material.clone(), "Material of these parts."),
            ]
        });
        own.chain(given.flatten()).collect()
    }
}

/// Reads one process; returns `None` after reporting its problems.
fn recipe(
    layered: &LayeredSections,
    key: &str,
    said: &[&RawSection],
    found: &mut Vec<LocatedProblem>,
) -> Option<(NamedProcess, Vec<Setting>)> {
    let (first, last) = (said.first()?, said.last()?);
    let name = first.name.clone();
    let before = found.len();
    let mut stack = layered.stack(PROCESSES, key, found)?;
    let path = join(PROCESSES.key, &to_printable(&name));
    let mut materials = Vec::new();
    for (place, entries) in &mut stack {
        let Some(node) = take_entry(entries, "materials") else { continue };
        let mut reading = NodeReader::new(place.clone());
        let path = join(&path, "materials");
        let items = reading.read_list(&path, &node);
        materials = items
            .iter()
            .take(MOST_MATERIALS)
            .filter_map(|item| Some(reading.read_scalar(&path, item)?.to_owned()))
            .collect();
        found.extend(reading.found);
    }
    let figures = read::<ProcessFigures>(PROCESSES, &name, &last.place, stack, found);
    let (figures, settings) = figures.filter(|_| found.len() == before)?;
    let named = ProcessKind::ALL.into_iter().find(|kind| kind.word() == key);
    let Some(kind) = figures.kind.or(named) else {
        let message = format!("{} lacks `kind`", to_printable(&name));
        let hint = format!("write `kind: ` and one of {}", ProcessKind::WORDS.join(", "));
        found.push(last.place.problem(&join(&path, "kind"), "", message).hint(hint));
        return None;
    };
    Some((NamedProcess { name, kind, figures: Some(figures), materials }, settings))
}
