//! Values of a design that its user set.

use fabkit_text::{FieldDeclaration, InvalidDesign, Section, TextLayer, ValueKind};

use super::layers::OtherSections;
use super::{Extension, LayeredDocument, Registry, SensorText};

/// Value that the user set, in a file or by an override.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UserValue {
    /// Dotted path of the parameter.
    pub path: String,
    /// Value as written.
    pub text: String,
    /// Kind of the value; [`ValueKind::Text`] for values of the user's own sections.
    pub kind: ValueKind,
}

impl Registry {
    /// Lists the values that the user set, overrides first, then those of files in the order of their paths. Name, title and
    /// reference are no parameters.
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
                text: value.into(),
                kind: kind(path),
            })
            .collect();
        let of_files = written.iter().filter(|(_, written)| {
            written.place.layer != TextLayer::Override && self.is_users(&written.place, text.yaml)
        });
        values.extend(of_files.map(|(path, written)| UserValue {
            path: path.clone(),
            text: written.text.to_printable(),
            kind: kind(path),
        }));
        values.retain(|value| !header.contains(&&*value.path));
        Ok(values)
    }
}
