//! Values of a design that its user set.

use std::sync::Arc;

use fabkit_text::{
    FieldDeclaration, InvalidDesign, ParameterTable, Section, TextLayer, TextPlace, ValueKind,
    WrittenValue, WrittenValues, to_printable,
};

use super::layers::{LayeredDocument, OtherSections, lay_defaults};
use super::{Extension, Registry, SENSOR, SensorText};

/// Value that the user set, in a file or by an override.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UserValue {
    /// Dotted path of the parameter.
    pub path: String,
    /// Value as written.
    pub text: String,
    /// Kind of the value; [`ValueKind::Text`] for values of the user's own sections.
    pub kind: ValueKind,
    /// True if it stands in place of a value that somebody stated: that of a file which is extended, or of the user's own
    /// file. False for a file that extends none, whose values are its own from the start.
    pub replaces_value: bool,
}

impl Registry {
    /// Lists the values that the user set, overrides first, then those of files in the order of their paths. Values of files
    /// are left out that have no other value without the files: they are the same, or there is none. Name, title and reference
    /// are no parameters.
    ///
    /// # Errors
    /// Texts that cannot be read at all.
    ///
    /// ```
    /// use fabkit_designs::{Extension, REGISTRY, SensorText};
    /// use fabkit_designs::parameters::parameters;
    ///
    /// parameters! {
    ///     /// Nothing.
    ///     pub struct Nothing {
    ///         /// A switch.
    ///         switch: bool,
    ///     }
    /// }
    /// let extension = Extension { key: "fixtures", summary: "none", defaults: &[] };
    /// let yaml = "format: 1\nextends: rtac0\nname: mine\nshell: {wall: 1.6 mm}\n";
    /// let text = SensorText::without_bases("mine.yaml", yaml);
    /// let set = ["coat.thickness=0.1 mm".to_owned()];
    /// let values = REGISTRY.user_values::<Nothing>(text, &set, &extension)?;
    /// let paths: Vec<&str> = values.iter().map(|value| &*value.path).collect();
    /// assert_eq!(paths, ["coat.thickness", "shell.wall"]);
    /// # Ok::<(), fabkit_designs::parameters::InvalidDesign>(())
    /// ```
    pub fn user_values<P: Section>(
        &self,
        text: SensorText,
        overrides: &[String],
        extension: &Extension,
    ) -> Result<Vec<UserValue>, InvalidDesign> {
        let field = FieldDeclaration {
            name: extension.key,
            summary: extension.summary.into(),
            shape: P::shape(&()),
        };
        let base = self.base_values(text, extension, field.clone());
        let extra = OtherSections { others: &[], section: Some((extension, field)) };
        let LayeredDocument { document, family, .. } = self.layer_texts(text, overrides, extra)?;
        let header: Vec<&str> = family
            .all_fields()
            .iter()
            .take(super::Header::fields().len())
            .map(|f| f.name)
            .collect();
        let kinds = document.numbers();
        let kind = |path: &str| {
            let number = kinds.iter().find(|number| number.path == path);
            number.map_or(ValueKind::Text, |number| number.kind)
        };
        let written = document.into_values();
        let set = overrides.iter().filter_map(|text| text.split_once('='));
        let mut values: Vec<UserValue> = set
            .map(|(path, value)| (path.trim(), value.trim()))
            .map(|(path, value)| UserValue {
                path: path.into(),
                text: to_printable(value),
                kind: kind(path),
                replaces_value: true,
            })
            .collect();
        // Built-in sensors have a name. A file that extends none has values that the design cannot be without.
        let extends_builtin = base.contains_key("name");
        let is_other = |(path, written): &(&String, &Arc<WrittenValue>)| match base.get(*path) {
            Some(base) => base.text.to_printable() != written.text.to_printable(),
            None => extends_builtin,
        };
        let of_files = written.iter().filter(|(_, written)| {
            written.place.layer != TextLayer::Override && self.is_users(&written.place, text.yaml)
        });
        let of_files = of_files.filter(is_other);
        values.extend(of_files.map(|(path, written)| UserValue {
            path: path.clone(),
            text: written.text.to_printable(),
            kind: kind(path),
            replaces_value: extends_builtin,
        }));
        values.retain(|value| !header.contains(&&*value.path));
        Ok(values)
    }

    /// Returns the values that a design would have without the user's files: those of the built-in sensor that they extend,
    /// and the defaults.
    fn base_values(
        &self,
        text: SensorText,
        extension: &Extension,
        field: FieldDeclaration,
    ) -> WrittenValues {
        let place = TextPlace::new(TextLayer::File, text.file, &SENSOR);
        let layers = self.layers(text.yaml, place.clone(), text.bases, &mut Vec::new());
        // What is wrong with the texts is reported where they are read.
        let Some(layers) = layers else { return WrittenValues::new() };
        let mut document = ParameterTable::new(layers.family.all_fields(), place);
        layers.family.lay_defaults(&mut document);
        document.add_field(field);
        lay_defaults(&mut document, extension.defaults, TextLayer::Base);
        let builtin = layers.entries.into_iter().rev();
        for (place, entries) in builtin.filter(|(place, _)| !self.is_users(place, text.yaml)) {
            document.merge(entries, &place);
        }
        document.into_values()
    }
}
