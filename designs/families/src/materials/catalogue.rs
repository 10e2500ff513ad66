//! Catalogue of materials by name: the built-in ones, and those that files add or change.

use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

use fabkit_text::{
    Dialect, LocatedProblem, NodeReader, Setting, SourceKind, TextLayer, TextPlace, ValueKind,
    ValueSource, YamlContent, YamlEntry, YamlNode, join, read_mapping, take_format, to_printable,
};

use super::{Bond, BondMethod, Castable, Figures, Material, MaterialOrigin};
use crate::user_catalogue::named_sections::{
    LayeredSections, RawSection, SectionKind, key_of, parse_name, read, read_sections, take_entry,
};

/// Materials in files: key and dialect.
pub(crate) const MATERIALS: SectionKind = SectionKind {
    key: "materials",
    dialect: &Dialect::new("material", 1, ", then `materials:` and names with sections"),
};

const BUILTIN_FILE: &str = "materials.yaml (built-in)";
const BUILTIN_YAML: &str = include_str!("../../materials.yaml");

/// Maximum number of components of a mix, and of materials that one bonds to.
const MOST_ITEMS: usize = 32;

/// Maximum length of a source text that is copied to each value as its note, bytes.
const LONGEST_NOTE: usize = 500;

/// Allowed range of a component's share in a mix.
const SHARES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Materials of the built-in file.
static BUILTIN: LazyLock<Catalogue> = LazyLock::new(|| {
    let place = TextPlace::new(TextLayer::Base, BUILTIN_FILE, MATERIALS.dialect);
    let mut found = Vec::new();
    let mut own = Vec::new();
    for entry in builtin_entries(&place, &mut found) {
        own.extend(read_sections(MATERIALS, entry, &place, &mut found));
    }
    let catalogue = Catalogue::from_sections(own, &mut found);
    debug_assert!(found.is_empty(), "{found:#?}");
    catalogue
});

fn builtin_entries(place: &TextPlace, found: &mut Vec<LocatedProblem>) -> Vec<YamlEntry> {
    let mut entries = read_mapping(BUILTIN_YAML, place, found).unwrap_or_default();
    take_format(&mut entries, place, found);
    entries
}

/// All materials that a sensor's file may name.
#[derive(Clone, Debug)]
pub(crate) struct Catalogue {
    raws: Arc<Vec<RawSection>>,
    by_key: Arc<BTreeMap<String, Castable>>,
}

impl Catalogue {
    /// Returns the materials that fabkit comes with.
    pub fn builtin() -> &'static Self {
        &BUILTIN
    }

    /// Returns the materials with the entries of files added; later entries override earlier ones.
    pub fn with(&self, own: Vec<RawSection>, found: &mut Vec<LocatedProblem>) -> Self {
        if own.is_empty() {
            return self.clone();
        }
        Self::from_sections(self.raws.iter().cloned().chain(own).collect(), found)
    }

    /// Creates the catalogue from sections in the order of their layers.
    fn from_sections(raws: Vec<RawSection>, found: &mut Vec<LocatedProblem>) -> Self {
        let layered = LayeredSections::new(&raws);
        let material = |(key, said): (&String, &[&RawSection])| {
            let material = material(&layered, key, said, found)?;
            Some((key.clone(), Castable(Arc::new(material))))
        };
        let by_key = layered.iter().filter_map(material).collect();
        Self { by_key: Arc::new(by_key), raws: Arc::new(raws) }
    }

    /// Finds a material by name, regardless of case and doubled spaces.
    pub fn find(&self, name: &str) -> Option<&Castable> {
        self.by_key.get(&key_of(name))
    }

    /// Returns the components of all mixes and the primers of all bonds.
    pub fn components(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.by_key.values().flat_map(ordered_names).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// Returns all names.
    pub fn names(&self) -> Vec<&str> {
        self.by_key.values().map(|castable| &**castable).collect()
    }
}

/// Returns the components of a material's mix and the primers of its bonds.
fn ordered_names(castable: &Castable) -> impl Iterator<Item = &str> {
    let material = castable.material();
    let mixed = material.by_mass.iter().map(|(name, _)| name.as_str());
    let primers = material.bonds.iter().filter_map(|bond| match &bond.hold {
        BondMethod::Primer(primer) => Some(primer.as_str()),
        _ => None,
    });
    mixed.chain(primers)
}

fn is_builtin(raw: &RawSection) -> bool {
    &*raw.place.file == BUILTIN_FILE
}

/// Reads one material; returns `None` after reporting its problems.
fn material(
    layered: &LayeredSections,
    key: &str,
    said: &[&RawSection],
    found: &mut Vec<LocatedProblem>,
) -> Option<Material> {
    // The name as it was first written, so that built-in materials keep theirs.
    let (first, last) = (said.first()?, said.last()?);
    let name = first.name.clone();
    let origin = match (is_builtin(first), is_builtin(last)) {
        (true, true) => MaterialOrigin::BuiltIn,
        (true, false) => MaterialOrigin::Changed(last.place.file.to_string()),
        (false, _) => MaterialOrigin::UserDefined(last.place.file.to_string()),
    };
    let before = found.len();
    let mut stack = layered.stack(MATERIALS, key, found)?;
    let (mut mix, mut bonds) = (None, None);
    // `mix` and `bonds` are free-form maps: they are taken out before the declared keys are read.
    for (place, entries) in &mut stack {
        with_sources(place, entries);
        mix = take_entry(entries, "mix").map(|node| (place.clone(), node)).or(mix);
        bonds = take_entry(entries, "bonds").map(|node| (place.clone(), node)).or(bonds);
    }
    let path = join(MATERIALS.key, &to_printable(&name));
    let mut own = Vec::new();
    let by_mass = match mix {
        Some((place, node)) => by_mass(&place, &join(&path, "mix"), node, &mut own, found),
        // Without a mix, the product comes ready to use.
        None => vec![(name.clone(), 1.0)],
    };
    let bonds = match bonds {
        Some((place, node)) => bonds_of(&place, &join(&path, "bonds"), node, &mut own, found),
        None => Vec::new(),
    };
    let figures = read::<Figures>(MATERIALS, &name, &last.place, stack, found);
    let (figures, mut settings) = figures.filter(|_| found.len() == before)?;
    settings.extend(own);
    // Sources and notes describe other values and are no parameters themselves.
    let is_text = |path: &str| path.ends_with(".source") || path.ends_with(".note");
    settings.retain(|setting| !is_text(&setting.path));
    Some(Material { name, origin, figures, by_mass, bonds, settings })
}

/// Copies the source of a section to each of its values that states none, so that the source stays with the value when
/// other layers override the rest.
fn with_sources(place: &TextPlace, entries: &mut [YamlEntry]) {
    let kind = if &*place.file == BUILTIN_FILE { SourceKind::Maker } else { SourceKind::User };
    let text = entries.iter().find(|entry| entry.key == "source").and_then(|e| e.value.text());
    // A text that is too long for a note is reported where `source` itself is read.
    let Some(text) = text.filter(|text| text.len() <= LONGEST_NOTE).map(str::to_owned) else {
        return;
    };
    for entry in entries {
        match (&*entry.key, &mut entry.value.content) {
            ("source" | "note" | "extends", _) => {}
            // The section `cure` passes the source on to its own values.
            ("cure", YamlContent::Map(inner)) if inner.iter().all(|e| e.key != "value") => {
                inner.iter_mut().for_each(|entry| wrap(&mut entry.value, kind, &text));
            }
            _ => wrap(&mut entry.value, kind, &text),
        }
    }
}

/// Replaces a plain value by a map of the value with its source.
fn wrap(node: &mut YamlNode, kind: SourceKind, note: &str) {
    if matches!(node.content, YamlContent::Nothing) || node.get("value").is_some() {
        return;
    }
    let position = node.position;
    let entry = |key: &str, content| YamlEntry {
        key: key.to_owned(),
        key_position: position,
        value: YamlNode { position, content },
    };
    let plain = std::mem::replace(&mut node.content, YamlContent::Nothing);
    node.content = YamlContent::Map(vec![
        entry("value", plain),
        entry("source", YamlContent::Scalar(kind.word().to_owned())),
        entry("note", YamlContent::Scalar(note.to_owned())),
    ]);
}

/// Returns the map behind a key, and its source if it is written with one.
fn with_source<'n>(
    reading: &mut NodeReader,
    path: &str,
    node: &'n YamlNode,
) -> Option<(&'n [YamlEntry], ValueSource)> {
    let mut source = ValueSource::user("");
    let Some(inner @ YamlNode { content: YamlContent::Map(_), .. }) = node.get("value") else {
        return Some((reading.read_map(path, node), source));
    };
    for entry in node.entries() {
        let text = entry.value.text().unwrap_or_default().trim();
        match &*entry.key {
            "value" => {}
            "note" => source.note = to_printable(text),
            "source" => match SourceKind::ALL.into_iter().find(|kind| kind.word() == text) {
                Some(kind) => source.kind = kind,
                None => {
                    let words = SourceKind::ALL.map(SourceKind::word).join(", ");
                    let message = format!("the source of {path} is `{}`", to_printable(text));
                    let hint = format!("write one of {words}");
                    reading.report_problem(entry.value.position, path, text, message, hint);
                }
            },
            key => {
                let message = format!("`{}` is not known beside `value`", to_printable(key));
                reading.report_problem(entry.key_position, path, key, message, "remove the line");
            }
        }
    }
    Some((inner.entries(), source))
}

/// Returns a textual setting.
fn setting(path: &str, value: String, summary: &str, limits: &str, source: ValueSource) -> Setting {
    Setting {
        path: path.to_owned(),
        value,
        kind: ValueKind::Text,
        source,
        summary: summary.to_owned(),
        limits: limits.to_owned(),
        expression: None,
        is_default: false,
        bounds: None,
        choices: Vec::new(),
    }
}

/// Reports a map with no item or too many; returns whether the number is wrong.
fn too_many(reading: &mut NodeReader, path: &str, node: &YamlNode, count: usize) -> bool {
    // An empty or unreadable map may already be reported.
    let is_wrong = count == 0 || count > MOST_ITEMS;
    if is_wrong && reading.found.is_empty() {
        let message = format!("{path} has {count} items; it must have between 1 and {MOST_ITEMS}");
        reading.report_problem(
            node.position,
            path,
            "",
            message,
            "write `{NAME: VALUE, NAME: VALUE}`",
        );
    }
    is_wrong
}

/// Reads the components of a mix with their shares by mass.
fn by_mass(
    place: &TextPlace,
    path: &str,
    node: YamlNode,
    settings: &mut Vec<Setting>,
    found: &mut Vec<LocatedProblem>,
) -> Vec<(String, f64)> {
    let mut reading = NodeReader::new(place.clone());
    let mut mix = Vec::new();
    if let Some((entries, source)) = with_source(&mut reading, path, &node)
        && !too_many(&mut reading, path, &node, entries.len())
    {
        for entry in entries {
            let at = place.at(entry.key_position);
            let name = parse_name(&entry.key, &at, path, &mut reading.found);
            let path = join(path, &to_printable(&entry.key));
            let share = reading.read_scalar(&path, &entry.value);
            let share = share.and_then(|text| {
                reading.read_value::<f64>(entry.value.position, &path, text, &SHARES)
            });
            mix.extend(name.zip(share));
        }
        let shown: Vec<String> =
            mix.iter().map(|(name, share)| format!("{share} {name}")).collect();
        let limits = "shares by mass, each more than 0";
        let summary = "Components and their shares by mass.";
        settings.push(setting(path, shown.join(" : "), summary, limits, source));
    }
    found.extend(reading.found);
    mix
}

/// Reads the bonds of a material.
fn bonds_of(
    place: &TextPlace,
    path: &str,
    node: YamlNode,
    settings: &mut Vec<Setting>,
    found: &mut Vec<LocatedProblem>,
) -> Vec<Bond> {
    let mut reading = NodeReader::new(place.clone());
    let mut bonds = Vec::new();
    if let Some((entries, source)) = with_source(&mut reading, path, &node)
        && !too_many(&mut reading, path, &node, entries.len())
    {
        for entry in entries {
            let at = place.at(entry.key_position);
            let to = parse_name(&entry.key, &at, path, &mut reading.found);
            let path = join(path, &to_printable(&entry.key));
            let primer = reading.read_scalar(&path, &entry.value);
            let at = place.at(entry.value.position);
            let primer = primer.and_then(|text| parse_name(text, &at, &path, &mut reading.found));
            let (Some(to), Some(primer)) = (to, primer) else { continue };
            let hold = match &*primer {
                "none" => BondMethod::NoBond,
                "itself" => BondMethod::SelfBonding,
                _ => BondMethod::Primer(primer),
            };
            bonds.push(Bond { to, hold });
        }
        let shown = |bond: &Bond| match &bond.hold {
            BondMethod::Primer(primer) => format!("{} with {primer}", bond.to),
            BondMethod::SelfBonding => format!("{} by itself", bond.to),
            BondMethod::NoBond => format!("not to {}", bond.to),
        };
        let shown: Vec<String> = bonds.iter().map(shown).collect();
        let summary = "Materials to which it bonds, with their primers, and to which it does not.";
        settings.push(setting(
            path,
            shown.join("; "),
            summary,
            "a primer, `itself` or `none`, by material",
            source,
        ));
    }
    found.extend(reading.found);
    bonds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_figure_is_read_and_says_where_it_comes_from() {
        let place = TextPlace::new(TextLayer::Base, BUILTIN_FILE, MATERIALS.dialect);
        let mut found = Vec::new();
        let own: Vec<RawSection> = builtin_entries(&place, &mut found)
            .into_iter()
            .flat_map(|entry| read_sections(MATERIALS, entry, &place, &mut found))
            .collect();
        let written = own.len();
        let catalogue = Catalogue::from_sections(own, &mut found);
        assert!(found.is_empty(), "{found:#?}");
        assert_eq!(catalogue.by_key.len(), written);
        for castable in catalogue.by_key.values() {
            let material = castable.material();
            assert!(material.settings.len() >= 4, "{}", material.name);
            for setting in &material.settings {
                let ValueSource { kind, note, .. } = &setting.source;
                assert!(*kind != SourceKind::User && !note.is_empty(), "{setting:?}");
            }
        }
    }
}
