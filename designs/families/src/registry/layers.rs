//! Layering of a sensor's file, the files it extends and defaults into one document.

use fabkit_text::{
    FieldDeclaration, InvalidDesign, LocatedProblem, ParameterTable, Problem, ProblemFacts,
    TextLayer, TextPlace, WrittenValues, YamlContent, YamlEntry,
};
use fabkit_text::{apply_overrides, join, read_mapping, take_format};
use fabkit_text::{find_similar, suggestion, take_word, to_printable};

use super::{BaseFile, Extension, FamilyEntry, Registry, SENSOR, SensorText, camera_modules};
use crate::blocks;
use crate::user_catalogue::UserCatalogue;

/// Sections of sensor files besides the parameters of their family.
pub(super) struct OtherSections<'a> {
    /// Keys that are skipped.
    pub(super) others: &'a [&'a str],
    /// Section of another crate that is read.
    pub(super) section: Option<(&'a Extension, FieldDeclaration)>,
}

/// Layered texts of a design, and the family that reads them.
pub(super) struct LayeredDocument {
    pub(super) document: ParameterTable,
    pub(super) family: FamilyEntry,
    pub(super) own: UserCatalogue,
}

/// Entries of a file and of the files it extends, nearest first.
pub(super) struct Layers {
    pub(super) family: FamilyEntry,
    pub(super) entries: Vec<(TextPlace, Vec<YamlEntry>)>,
}

/// Lays default files, each with name and text, into a document.
pub(super) fn lay_defaults(
    document: &mut ParameterTable,
    files: &[(&str, &str)],
    layer: TextLayer,
) {
    for (name, yaml) in files {
        let place = TextPlace::new(layer, name, &SENSOR);
        let mut entries = read_mapping(yaml, &place, &mut document.found).unwrap_or_default();
        take_format(&mut entries, &place, &mut document.found);
        document.merge(entries, &place);
    }
}

/// Lays the shared defaults of the blocks into a document, restricted to the parameters that its family has.
pub(super) fn lay_shared_defaults(document: &mut ParameterTable) {
    let (name, yaml) = blocks::DEFAULTS;
    let place = TextPlace::new(TextLayer::Default, name, &SENSOR);
    // Restricted to parameters of this family: others would be reported as unknown keys.
    let known = document.paths();
    let mut entries = read_mapping(yaml, &place, &mut document.found).unwrap_or_default();
    take_format(&mut entries, &place, &mut document.found);
    for section in &mut entries {
        if let YamlContent::Map(values) = &mut section.value.content {
            values.retain(|value| known.contains(&join(&section.key, &value.key)));
        }
    }
    entries.retain(
        |section| matches!(&section.value.content, YamlContent::Map(values) if !values.is_empty()),
    );
    document.merge(entries, &place);
}

/// Returns whether the override `text` sets the value at `path`.
fn sets(text: &str, path: &str) -> bool {
    text.split_once('=').is_some_and(|(set, _)| set.trim() == path)
}

/// Removes the value at a dotted path.
fn remove_value(entries: &mut Vec<YamlEntry>, path: &str) {
    let Some((key, rest)) = path.split_once('.') else {
        entries.retain(|entry| entry.key != path);
        return;
    };
    for entry in entries.iter_mut().filter(|entry| entry.key == key) {
        if let YamlContent::Map(inner) = &mut entry.value.content {
            remove_value(inner, rest);
        }
    }
    // A section that held nothing else is removed too: an empty one is a fault of its own.
    entries.retain(|entry| {
        entry.key != key
            || !matches!(&entry.value.content, YamlContent::Map(inner) if inner.is_empty())
    });
}

/// Returns an error that only a mistake in fabkit itself can cause.
pub(super) fn internal_error(file: &str, message: String) -> InvalidDesign {
    InvalidDesign::new(vec![Problem {
        file: file.to_owned(),
        line: None,
        column: None,
        path: String::new(),
        value: String::new(),
        message,
        hint: Some("this is a bug in fabkit; please report it with the file".into()),
        facts: ProblemFacts::new("bug"),
    }])
}

impl Registry {
    /// Lays the texts over each other and finds the family that reads them.
    pub(super) fn layer_texts(
        &self,
        SensorText { file, yaml, bases, user, omitted }: SensorText,
        overrides: &[String],
        extra: OtherSections,
    ) -> Result<LayeredDocument, InvalidDesign> {
        let place = TextPlace::new(TextLayer::File, file, &SENSOR);
        let mut found = Vec::new();
        let Some(mut layers) = self.layers(yaml, place.clone(), bases, &mut found) else {
            return Err(InvalidDesign::new(LocatedProblem::sort(found)));
        };
        let family = layers.family;
        if let Some(path) = omitted {
            for (_, entries) in
                layers.entries.iter_mut().filter(|(place, _)| self.is_users(place, yaml))
            {
                remove_value(entries, path);
            }
        }
        // The user's own sections are taken out first: the document does not know their keys.
        let mut own = UserCatalogue::take_from_layers(&mut layers.entries, user, &mut found);
        let mut document = ParameterTable::new(family.all_fields(), place);
        document.found = found;
        family.lay_defaults(&mut document);
        if let Some((extension, field)) = extra.section {
            document.add_field(field);
            lay_defaults(&mut document, extension.defaults, TextLayer::Base);
        }
        // Extended files come first, so that the file overrides them.
        for (place, mut entries) in layers.entries.into_iter().rev() {
            entries.retain(|entry| !extra.others.contains(&&*entry.key));
            document.merge(entries, &place);
        }
        let overrides: Vec<String> = overrides
            .iter()
            .filter(|text| omitted.is_none_or(|path| !sets(text, path)))
            .cloned()
            .collect();
        let overrides = own.take_overrides(&overrides, &mut document.found);
        apply_overrides(&mut document, &overrides);
        // Last, because an override may name another camera module.
        camera_modules::lay_module(&mut document);
        Ok(LayeredDocument { document, family, own })
    }

    /// Returns whether the user wrote the text at `place`, where `yaml` is the text of the layer [`TextLayer::File`].
    pub(super) fn is_users(&self, place: &TextPlace, yaml: &str) -> bool {
        match place.layer {
            // A built-in sensor that is named directly is in the layer of the user's file.
            TextLayer::File => self.sensors.iter().all(|(_, builtin)| *builtin != yaml),
            TextLayer::Override | TextLayer::Extended(_) => true,
            TextLayer::Base | TextLayer::Default => false,
        }
    }

    /// Returns the family of a built-in sensor and the values, by path, of its file and the files it extends.
    pub(super) fn builtin_values(&self, sensor: &str) -> Option<(FamilyEntry, WrittenValues)> {
        let place = TextPlace::new(TextLayer::Base, sensor, &SENSOR);
        let yaml = self.builtin_yaml(sensor)?;
        let layers = self.layers(yaml, place.clone(), &[], &mut Vec::new())?;
        let mut document = ParameterTable::new(layers.family.all_fields(), place);
        layers.family.lay_defaults(&mut document);
        // Sections of other crates are unknown here; the problems they cause are dropped with the document.
        for (place, entries) in layers.entries.into_iter().rev() {
            document.merge(entries, &place);
        }
        Some((layers.family, document.into_values()))
    }

    /// Reads a file and the files it extends, nearest first, and finds the family. Returns `None` after reporting why
    /// the rest cannot be read.
    pub(super) fn layers(
        &self,
        yaml: &str,
        place: TextPlace,
        bases: &[BaseFile],
        found: &mut Vec<LocatedProblem>,
    ) -> Option<Layers> {
        let mut entries: Vec<(TextPlace, Vec<YamlEntry>)> = Vec::new();
        let mut family: Option<(&FamilyEntry, TextPlace)> = None;
        let mut next = Some((yaml, place.clone()));
        while let Some((yaml, place)) = next.take() {
            let mut own = read_mapping(yaml, &place, found)?;
            take_format(&mut own, &place, found);
            if let Some((word, at)) = take_word(&mut own, "family", &place, found) {
                let known = self.family(&word, &at, found)?;
                match &family {
                    // All files of a chain have to name the same family.
                    Some((first, at)) if first.name != known.name => {
                        let message = format!(
                            "family is {}, but {} is a sensor of the family {}",
                            first.name, place.file, known.name
                        );
                        found.push(
                            at.problem("family", first.name, message)
                                .hint("remove the line, or extend another sensor"),
                        );
                        return None;
                    }
                    _ => family = Some((known, at)),
                }
            }
            // Noted before the entry is taken, to tell a missing key from an unreadable value.
            let extends_something = own.iter().any(|entry| entry.key == "extends");
            let extends = take_word(&mut own, "extends", &place, found);
            entries.push((place, own));
            if !extends_something {
                continue;
            }
            // The name behind `extends:` is unreadable. Stop here: otherwise everything that the base provides would be
            // reported as missing.
            let (name, at) = extends?;
            let above: Vec<&TextPlace> = entries.iter().map(|(place, _)| place).collect();
            next = Some(self.resolve_base(&name, &at, &above, bases, found)?);
        }
        let Some((family, _)) = family else {
            let names: Vec<&str> = self.families.iter().map(|f| f.name).collect();
            let found_here = place.problem("family", "", "the family is missing".into());
            found.push(found_here.hint(format!(
                "add `family: NAME` with one of {}, or `extends: NAME` with one of {}",
                names.join(", "),
                self.builtin_names().join(", ")
            )));
            return None;
        };
        Some(Layers { family: *family, entries })
    }

    /// Finds a family by its word; returns `None` after reporting an unknown one.
    fn family(
        &self,
        word: &str,
        at: &TextPlace,
        found: &mut Vec<LocatedProblem>,
    ) -> Option<&FamilyEntry> {
        let family = self.families.iter().find(|family| family.name == word);
        if family.is_none() {
            let names: Vec<&str> = self.families.iter().map(|f| f.name).collect();
            let message = format!("`{}` is not a family of sensors", to_printable(word));
            let near = find_similar(word, names.iter().copied()).first().copied();
            let hint = suggestion(word, names, "the families are");
            let unknown = at
                .problem("family", &to_printable(word), message)
                .hint(hint)
                .code("unknown_family");
            found.push(match near {
                Some(near) => unknown.suggest("family", near),
                None => unknown,
            });
        }
        family
    }
}
