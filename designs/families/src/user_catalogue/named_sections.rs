//! Sections whose keys are names that users choose: materials, processes and articles to buy.
//!
//! A file's statements on a name override the built-in ones, as a sensor's file overrides the one that it extends: it
//! states only the differences. `extends: NAME` starts from another name.

use std::collections::BTreeMap;

use fabkit_text::{
    Dialect, LocatedProblem, ParameterTable, Position, Problem, Reader, Scalar, Section, Setting,
    TextPlace, YamlContent, YamlEntry, YamlNode, find_similar, join, take_word, to_printable,
};

/// Maximum number of names that extend each other; more than this is a cycle.
const LONGEST_CHAIN: usize = 16;

/// Maximum number of suggestions for a misspelt name.
const MOST_SUGGESTED: usize = 3;

/// Maximum length of a name, characters.
const LONGEST_NAME: usize = 80;

/// Kind of a named section.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionKind {
    /// Top-level key in files, for example `materials`.
    pub key: &'static str,
    /// Dialect, which messages take the noun from.
    pub dialect: &'static Dialect,
}

/// Statements of one text on one name.
#[derive(Clone, Debug)]
pub(crate) struct RawSection {
    /// Name as written.
    pub name: String,
    /// Place of the name.
    pub place: TextPlace,
    /// Entries of the section.
    pub entries: Vec<YamlEntry>,
}

impl RawSection {
    /// Returns whether the section extends that name.
    pub fn extends(&self, name: &str) -> bool {
        self.base().is_some_and(|base| base == key_of(name))
    }

    /// Returns the [`key_of`] the name that the section extends.
    pub fn base(&self) -> Option<String> {
        let base = self.entries.iter().find(|entry| entry.key == "extends")?;
        base.value.text().map(key_of)
    }
}

/// Returns the form in which names are compared: lower case, single spaces.
pub(crate) fn key_of(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase()
}

/// Returns the known names most similar to a misspelt one, best first.
pub(crate) fn similar_names<'a>(
    written: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Vec<&'a str> {
    let plain = |name: &str| key_of(name).replace(' ', "_");
    // Compares with whole names and with their tails, since users often omit the maker's name.
    let mut plains: Vec<(String, &str)> = Vec::new();
    for name in known {
        let whole = plain(name);
        let tails = whole.match_indices('_').map(|(at, _)| whole[at + 1..].to_owned());
        plains.extend(tails.chain([whole.clone()]).map(|plain| (plain, name)));
    }
    let found = find_similar(&plain(written), plains.iter().map(|(plain, _)| &**plain));
    let mut names: Vec<&str> = Vec::new();
    for found in found {
        for (_, name) in plains.iter().filter(|(plain, _)| *plain == found) {
            if !names.contains(name) {
                names.push(name);
            }
        }
    }
    names.truncate(MOST_SUGGESTED);
    names
}

/// Validates a name given in a file; returns `None` after reporting why it is invalid.
pub(crate) fn parse_name(
    text: &str,
    place: &TextPlace,
    path: &str,
    found: &mut Vec<LocatedProblem>,
) -> Option<String> {
    let name = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let limits = 1..=LONGEST_NAME;
    let says = match <String as Scalar>::parse(&name) {
        Ok(name) if name.is_within(&limits) => return Some(name),
        Ok(_) => format!("is not between 1 and {LONGEST_NAME} characters long"),
        Err(refusal) => refusal.says,
    };
    let message = format!("`{}` is no name: it {says}", to_printable(text));
    found.push(
        place.problem(path, &to_printable(text), message).hint("write a short name on one line"),
    );
    None
}

/// Reads the value of the key: a map of names to sections, or a list of sections with `name:`.
pub(crate) fn read_sections(
    noun: SectionKind,
    entry: YamlEntry,
    place: &TextPlace,
    found: &mut Vec<LocatedProblem>,
) -> Vec<RawSection> {
    // Messages then speak of materials, processes or articles instead of sensors.
    let place = TextPlace { dialect: noun.dialect, ..place.clone() };
    let mut raws: Vec<RawSection> = Vec::new();
    let sections: Vec<(Option<String>, Position, YamlNode)> = match entry.value.content {
        YamlContent::Map(entries) => {
            entries.into_iter().map(|e| (Some(e.key), e.key_position, e.value)).collect()
        }
        YamlContent::List(items) => items.into_iter().map(|i| (None, i.position, i)).collect(),
        _ => {
            let message = format!("{} must be names with sections", noun.key);
            let hint = format!("write `{}:`, then indented lines `NAME: {{...}}`", noun.key);
            found.push(place.at(entry.key_position).problem(noun.key, "", message).hint(hint));
            return raws;
        }
    };
    for (name, position, node) in sections {
        let mut at = place.at(position);
        let YamlContent::Map(mut entries) = node.content else {
            let name = name.as_deref().map(to_printable).unwrap_or_default();
            let message = format!("`{name}` of {} is no section", noun.key);
            let hint = "write its values as indented lines `KEY: VALUE`";
            found.push(at.problem(&join(noun.key, &name), "", message).hint(hint));
            continue;
        };
        let name = match name {
            Some(name) => name,
            None => match take_word(&mut entries, "name", &place, found) {
                Some((name, name_at)) => {
                    at = name_at;
                    name
                }
                None => {
                    let message = format!("an item of {} has no name", noun.key);
                    found.push(at.problem(noun.key, "", message).hint("write `name: NAME` in it"));
                    continue;
                }
            },
        };
        let Some(name) = parse_name(&name, &at, noun.key, found) else { continue };
        let twice = raws.iter().find(|raw| key_of(&raw.name) == key_of(&name));
        if let Some(first) = twice {
            let line = |at: &TextPlace| at.position.map(|p| p.line).unwrap_or_default();
            let [first, second] = [line(&first.place), line(&at)];
            let message = format!(
                "`{}` is written twice: on line {first} and on line {second}",
                to_printable(&name)
            );
            let path = join(noun.key, &to_printable(&name));
            let hint = "keep one of them; case and doubled spaces do not tell names apart";
            found.push(at.problem(&path, &to_printable(&name), message).hint(hint));
            continue;
        }
        raws.push(RawSection { name, place: at, entries });
    }
    raws
}

/// Statements of all texts by [`key_of`] the name; later texts override earlier ones.
#[derive(Debug, Default)]
pub(crate) struct LayeredSections<'a> {
    by_key: BTreeMap<String, Vec<&'a RawSection>>,
}

/// Sections of one name and of all names that it extends, lowest layer first.
type Stack = Vec<(TextPlace, Vec<YamlEntry>)>;

impl<'a> LayeredSections<'a> {
    /// Groups the statements of all texts, given in order.
    pub fn new(raws: impl IntoIterator<Item = &'a RawSection>) -> Self {
        let mut by_key: BTreeMap<String, Vec<&RawSection>> = BTreeMap::new();
        for raw in raws {
            by_key.entry(key_of(&raw.name)).or_default().push(raw);
        }
        Self { by_key }
    }

    /// Iterates over all names with their statements.
    pub fn iter(&self) -> impl Iterator<Item = (&String, &[&'a RawSection])> {
        self.by_key.iter().map(|(key, raws)| (key, &raws[..]))
    }

    fn names(&self) -> Vec<&'a str> {
        self.by_key.values().filter_map(|raws| raws.first()).map(|raw| &*raw.name).collect()
    }

    /// Returns all sections of a name and of those that it extends; `None` after reporting why they cannot be read.
    pub fn stack(
        &self,
        noun: SectionKind,
        key: &str,
        found: &mut Vec<LocatedProblem>,
    ) -> Option<Stack> {
        let mut parts: Vec<Stack> = Vec::new();
        let mut seen: Vec<String> = Vec::new();
        let mut next = Some(key.to_owned());
        while let Some(key) = next.take() {
            let raws = self.by_key.get(&key)?;
            seen.push(key);
            let (mut stack, mut base) = (Stack::new(), None);
            for raw in raws {
                let mut entries = raw.entries.clone();
                // Noted before the entry is taken, to tell a missing key from an unreadable value.
                let extends_something = entries.iter().any(|entry| entry.key == "extends");
                let extends = take_word(&mut entries, "extends", &raw.place, found);
                if extends_something {
                    // The last text that states a base decides.
                    base = Some((raw, extends?));
                }
                stack.push((raw.place.clone(), entries));
            }
            parts.push(stack);
            let Some((raw, (name, at))) = base else { continue };
            let path = join(&join(noun.key, &to_printable(&raw.name)), "extends");
            let base = key_of(&name);
            if seen.contains(&base) || seen.len() > LONGEST_CHAIN {
                let message = format!("{} extends itself", to_printable(&raw.name));
                let hint = "extend another name; what a file says of a known name lies over it \
                            without `extends`";
                found.push(at.problem(&path, &to_printable(&name), message).hint(hint));
                return None;
            }
            if !self.by_key.contains_key(&base) {
                let message = format!(
                    "{} extends `{}`, which is not known",
                    to_printable(&raw.name),
                    to_printable(&name)
                );
                let hint = unknown_hint(&name, &self.names());
                found.push(at.problem(&path, &to_printable(&name), message).hint(hint));
                return None;
            }
            next = Some(base);
        }
        // The farthest base is the lowest layer.
        Some(parts.into_iter().rev().flatten().collect())
    }
}

/// Removes a key from entries and returns its value.
pub(crate) fn take_entry(entries: &mut Vec<YamlEntry>, key: &str) -> Option<YamlNode> {
    let at = entries.iter().position(|entry| entry.key == key)?;
    Some(entries.remove(at).value)
}

/// Returns a hint for an unknown name.
pub(crate) fn unknown_hint(written: &str, names: &[&str]) -> String {
    let near = similar_names(written, names.iter().copied());
    if near.is_empty() {
        format!("known are {}", fabkit_text::list_names(names))
    } else {
        fabkit_text::did_you_mean(&near)
    }
}

/// Reads the declared keys of a section; returns `None` after reporting the problems, each message prefixed by the
/// name.
pub(crate) fn read<S: Section>(
    noun: SectionKind,
    name: &str,
    place: &TextPlace,
    stack: Stack,
    found: &mut Vec<LocatedProblem>,
) -> Option<(S, Vec<Setting>)> {
    let mut document = ParameterTable::new(S::fields(), place.clone());
    for (place, entries) in stack {
        document.merge(entries, &place);
    }
    let mut reader = Reader::new(document);
    let section = S::read(&mut reader, "", "", &());
    let mut settings = reader.take_settings();
    let report = reader.finish(None);
    let section_path = join(noun.key, &to_printable(name));
    for setting in &mut settings {
        setting.path = join(&section_path, &setting.path);
    }
    if report.is_clean() {
        return section.map(|section| (section, settings));
    }
    let about = |problem: Problem| {
        // The declared keys are read as a file of their own; the message has to speak of the section instead.
        let message = match problem.message.strip_prefix("the file lacks") {
            Some(rest) => format!("{} lacks{rest}", to_printable(name)),
            None => format!("{}: {}", to_printable(name), problem.message),
        };
        let path = join(&section_path, &problem.path);
        let path = path.trim_end_matches('.').to_owned();
        LocatedProblem { layer: place.layer, problem: Problem { path, message, ..problem } }
    };
    found.extend(report.into_invalid().problems.into_iter().map(about));
    None
}
