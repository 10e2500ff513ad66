//! Resolved sensor file: all values as used, from whatever files and options.

use std::fmt::Write as _;

use fabkit_designs::{Design, design_hash};
use fabkit_files::diagnostics::SourceText;
use fabkit_text::Setting;
use serde_json::json;

use super::is_fixture_key;
use crate::source::{NamedDesigns, Source};

/// Writes one text that represents a sensor and its fixtures. Returns `None` if reading the text again would give
/// another design: for example, names that contain dots are read as sections. Defaults of the family are not written.
///
/// ```
/// use fabkit_application::designs::design_hash;
/// use fabkit_application::diagnostics::SourceText;
/// use fabkit_application::packaging::resolved_yaml;
/// use fabkit_application::source::{Source, Target};
///
/// let design = Target::new("rtac0").design(&["coat.thickness=0.1 mm".into()])?;
/// let text = resolved_yaml(&design, &Vec::new()).ok_or("one text cannot say it")?;
/// // The text alone gives the same design, with the override.
/// let again = Source::from_text(SourceText { file: "rtac0.yaml".into(), text }).load(&[])?;
/// assert_eq!(design_hash(&again.design), design_hash(&design));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn resolved_yaml(design: &Design, fixtures: &NamedDesigns) -> Option<String> {
    let sensor = &design.sensor;
    let mut text = String::from(
        "# Every value as it is used; comments and sources are in the files it comes from.\n",
    );
    let quoted = |text: &str| json!(text).to_string();
    let _ = write!(
        text,
        "format: 1\nfamily: {}\nname: {}\ntitle: {}\nreference: {}\n",
        design.family,
        sensor.name,
        quoted(&sensor.title),
        quoted(&sensor.reference)
    );
    let said = |setting: &&Setting| !setting.is_default;
    let of_fixtures = fixtures.iter().flat_map(|(_, fixture)| &fixture.parameters);
    let of_fixtures = of_fixtures.filter(|setting| is_fixture_key(&setting.path));
    let settings: Vec<&Setting> =
        design.parameters.iter().chain(of_fixtures).filter(said).collect();
    let mut tree = Section::default();
    for setting in settings {
        tree.put(&setting.path, &setting.value);
    }
    tree.write(&mut text, 0);

    // The text is loaded again and its hashes compared, because not every set of values can be expressed.
    let main = SourceText { file: format!("{}.yaml", sensor.name), text: text.clone() };
    let project = Source::from_text(main).load(&[]).ok()?;
    let is_same = |name: &str, was: &Design| {
        project.fixture(name).is_ok_and(|now| design_hash(&now) == design_hash(was))
    };
    let same = design_hash(&project.design) == design_hash(design)
        && fixtures.iter().all(|(name, was)| is_same(name, was));
    same.then_some(text)
}

/// Keys in their order, with values or nested sections.
#[derive(Default)]
struct Section(Vec<(String, Content)>);

enum Content {
    Value(String),
    Section(Section),
}

impl Section {
    /// Inserts a value at a path; if the path exists, the first value stays.
    fn put(&mut self, path: &str, value: &str) {
        let (key, rest) = match path.split_once('.') {
            Some((key, rest)) => (key, Some(rest)),
            None => (path, None),
        };
        let at = self.0.iter().position(|(there, _)| there == key);
        match (rest, at) {
            (None, None) => self.0.push((key.to_owned(), Content::Value(value.to_owned()))),
            (Some(rest), None) => {
                let mut section = Self::default();
                section.put(rest, value);
                self.0.push((key.to_owned(), Content::Section(section)));
            }
            (Some(rest), Some(at)) => {
                if let Content::Section(section) = &mut self.0[at].1 {
                    section.put(rest, value);
                }
            }
            (None, Some(_)) => {}
        }
    }

    fn write(&self, text: &mut String, depth: usize) {
        let indent = "  ".repeat(depth);
        for (key, content) in &self.0 {
            let is_plain = key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
            let key = if is_plain { key.clone() } else { json!(key).to_string() };
            match content {
                Content::Value(value) if value.starts_with('[') => {
                    let _ = writeln!(text, "{indent}{key}: {value}");
                }
                Content::Value(value) => {
                    let _ = writeln!(text, "{indent}{key}: {}", json!(value));
                }
                Content::Section(section) => {
                    let _ = writeln!(text, "{indent}{key}:");
                    section.write(text, depth + 1);
                }
            }
        }
    }
}
