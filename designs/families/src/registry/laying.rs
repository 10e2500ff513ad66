//! Layering of a sensor's file, the files it extends and defaults into one document.

use std::collections::BTreeMap;

use fabkit_text::{
    Content, Document, Entry, Facts, Field, Found, InvalidDesign, Place, Problem, TextLayer,
    Written,
};
use fabkit_text::{apply_overrides, check_format, join, mapping_of};
use fabkit_text::{shown, similar, suggestion, take_word};

use super::{BaseFile, Extension, FamilyEntry, Registry, SENSOR, SensorText, modules};
use crate::blocks;
use crate::own::Own;

/// Sections of sensor files besides the parameters of their family.
pub(super) struct Extra<'a> {
    /// Keys that are skipped.
    pub(super) others: &'a [&'a str],
    /// Section of another crate that is read.
    pub(super) section: Option<(&'a Extension, Field)>,
}

/// Layered texts of a design, and the family that reads them.
pub(super) struct Laid {
    pub(super) document: Document,
    pub(super) family: FamilyEntry,
    pub(super) own: Own,
}

/// Entries of a file and of the files it extends, nearest first.
pub(super) struct Layers {
    pub(super) family: FamilyEntry,
    pub(super) entries: Vec<(Place, Vec<Entry>)>,
}

/// Lays default files, each with name and text, into a document.
pub(super) fn lay_defaults(document: &mut Document, files: &[(&str, &str)], layer: TextLayer) {
    for (name, yaml) in files {
        let place = Place::new(layer, name, &SENSOR);
        let mut entries = mapping_of(yaml, &place, &mut document.found).unwrap_or_default();
        check_format(&mut entries, &place, &mut document.found);
        document.lay(entries, &place);
    }
}

/// Lays the shared defaults of the blocks into a document, restricted to the parameters that its family has.
pub(super) fn lay_shared_defaults(document: &mut Document) {
    let (name, yaml) = blocks::DEFAULTS;
    let place = Place::new(TextLayer::Default, name, &SENSOR);
    // Restricted to parameters of this family: others would be reported as unknown keys.
    let known = document.paths();
    let mut entries = mapping_of(yaml, &place, &mut document.found).unwrap_or_default();
    check_format(&mut entries, &place, &mut document.found);
    for section in &mut entries {
        if let Content::Map(values) = &mut section.value.content {
            values.retain(|value| known.contains(&join(&section.key, &value.key)));
        }
    }
    entries.retain(
        |section| matches!(&section.value.content, Content::Map(values) if !values.is_empty()),
    );
    document.lay(entries, &place);
}

/// Returns an error that only a mistake in fabkit itself can cause.
pub(super) fn bug(file: &str, message: String) -> InvalidDesign {
    InvalidDesign {
        problems: vec![Problem {
            file: file.to_owned(),
            line: None,
            column: None,
            path: String::new(),
            value: String::new(),
            message,
            hint: Some("this is a bug in fabkit; please report it with the file".into()),
            facts: Facts::of("bug"),
        }],
    }
}

impl Registry {
    /// Lays the texts over each other and finds the family that reads them.
    pub(super) fn laid(
        &self,
        SensorText { file, yaml, bases, user }: SensorText,
        overrides: &[String],
        extra: Extra,
    ) -> Result<Laid, InvalidDesign> {
        let place = Place::new(TextLayer::File, file, &SENSOR);
        let mut found = Vec::new();
        let Some(mut layers) = self.layers(yaml, place.clone(), bases, &mut found) else {
            return Err(InvalidDesign { problems: Found::sorted(found) });
        };
        let family = layers.family;
        // The user's own sections are taken out first: the document does not know their keys.
        let mut own = Own::take(&mut layers.entries, user, &mut found);
        let mut document = Document::new(family.all_fields(), place);
        document.found = found;
        family.lay_defaults(&mut document);
        if let Some((extension, field)) = extra.section {
            document.add_field(field);
            lay_defaults(&mut document, extension.defaults, TextLayer::Base);
        }
        // Extended files come first, so that the file overrides them.
        for (place, mut entries) in layers.entries.into_iter().rev() {
            entries.retain(|entry| !extra.others.contains(&&*entry.key));
            document.lay(entries, &place);
        }
        let overrides = own.take_overrides(overrides, &mut document.found);
        apply_overrides(&mut document, &overrides);
        // Last, because an override may name another camera module.
        modules::lay_module(&mut document);
        Ok(Laid { document, family, own })
    }

    /// Returns the family of a built-in sensor and the values, by path, of its file and the files it extends.
    pub(super) fn values_of(
        &self,
        sensor: &str,
    ) -> Option<(FamilyEntry, BTreeMap<String, Written>)> {
        let place = Place::new(TextLayer::Base, sensor, &SENSOR);
        let yaml = self.builtin_yaml(sensor)?;
        let layers = self.layers(yaml, place.clone(), &[], &mut Vec::new())?;
        let mut document = Document::new(layers.family.all_fields(), place);
        layers.family.lay_defaults(&mut document);
        // Sections of other crates are unknown here; the problems they cause are dropped with the document.
        for (place, entries) in layers.entries.into_iter().rev() {
            document.lay(entries, &place);
        }
        Some((layers.family, document.into_values()))
    }

    /// Reads a file and the files it extends, nearest first, and finds the family. Returns `None` after reporting why
    /// the rest cannot be read.
    pub(super) fn layers(
        &self,
        yaml: &str,
        place: Place,
        bases: &[BaseFile],
        found: &mut Vec<Found>,
    ) -> Option<Layers> {
        let mut entries: Vec<(Place, Vec<Entry>)> = Vec::new();
        let mut family: Option<(&FamilyEntry, Place)> = None;
        let mut next = Some((yaml, place.clone()));
        while let Some((yaml, place)) = next.take() {
            let mut own = mapping_of(yaml, &place, found)?;
            check_format(&mut own, &place, found);
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
            let above: Vec<&Place> = entries.iter().map(|(place, _)| place).collect();
            next = Some(self.extended(&name, &at, &above, bases, found)?);
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
    fn family(&self, word: &str, at: &Place, found: &mut Vec<Found>) -> Option<&FamilyEntry> {
        let family = self.families.iter().find(|family| family.name == word);
        if family.is_none() {
            let names: Vec<&str> = self.families.iter().map(|f| f.name).collect();
            let message = format!("`{}` is not a family of sensors", shown(word));
            let near = similar(word, names.iter().copied()).first().copied();
            let hint = suggestion(word, names, "the families are");
            let unknown =
                at.problem("family", &shown(word), message).hint(hint).code("unknown_family");
            found.push(match near {
                Some(near) => unknown.suggest("family", near),
                None => unknown,
            });
        }
        family
    }
}
