//! Template files for new sensors: every parameter with a working value, its description and its allowed range.

use fabkit_text::{
    FieldDeclaration, FieldShape, FileSafeName, Section, WrittenText, WrittenValue, join,
};

use super::{FORMAT, FamilyEntry, Header, Registry};

/// Longest line of a comment, characters.
const COLUMNS: usize = 100;

/// Starting point of a new sensor's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemplateBase<'a> {
    /// All parameters of a family, with the values of its example.
    Family(&'a str),
    /// Built-in sensor to extend, with no value changed yet.
    Extends(&'a str),
}

impl Registry {
    /// Returns all families, in order.
    pub fn families(&self) -> &'static [FamilyEntry] {
        self.families
    }

    /// Returns the template text of a sensor's file; `None` if there is no such family or sensor.
    ///
    /// The parameters of an extended sensor appear as comments that become valid YAML once the first two characters of
    /// each line are removed. `others` are the keys of sections that other crates keep. If a family's example has such
    /// sections, they are copied, because its values do not work without them.
    ///
    /// ```
    /// use fabkit_designs::parameters::{FileSafeName, Scalar};
    /// use fabkit_designs::{REGISTRY, TemplateBase, load};
    /// let name = FileSafeName::parse("my-tip").map_err(|refusal| refusal.says)?;
    /// let start = TemplateBase::Extends("rtac0");
    /// let yaml = REGISTRY.template_text(&name, start, &[]).ok_or("no such sensor")?;
    /// // As long as every value is a comment, the new sensor is like the one that it extends.
    /// assert!(yaml.contains("#   radius: 15.0 mm"));
    /// assert_eq!(load("my-tip.yaml", &yaml, &[], &["fixtures"])?.sensor.name, "my-tip");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn template_text(
        &self,
        name: &FileSafeName,
        start: TemplateBase,
        others: &[&str],
    ) -> Option<String> {
        let base = match start {
            TemplateBase::Family(word) => self.families.iter().find(|f| f.name == word)?.example,
            TemplateBase::Extends(sensor) => sensor,
        };
        let (base_text, (family, values)) = (self.builtin_yaml(base)?, self.builtin_values(base)?);
        let name = name.as_str();
        let given = |field: &str| match (field, start) {
            ("name" | "title", _) => Some(yaml(name)),
            // A new design has no publication; one that extends a sensor keeps the reference.
            ("reference", TemplateBase::Family(_)) => Some(yaml("")),
            _ => None,
        };
        let value =
            |path: &str| given(path).or_else(|| values.get(path).map(|written| yaml_of(written)));
        let (own, inherited): (Vec<FieldDeclaration>, Vec<FieldDeclaration>) =
            Header::fields().into_iter().partition(|field| given(field.name).is_some());
        let parameters = [inherited, family.parameters()].concat();
        let (header, parameters) = (lines(&own, &value), lines(&parameters, &value));
        let format = format!("format: {FORMAT}\n");
        Some(match start {
            TemplateBase::Family(_) => {
                let (family, summary) = (family.name, family.summary);
                let first = format!("A sensor of the family {family}: {summary}.");
                let values = format!(
                    "Every value is that of {base}; `fabkit show {base}` says where each comes from. \
                     Write your own, and `fabkit check {name}.yaml` says whether it can be built."
                );
                intro(&[&first, &values, SOURCES, FIXTURES])
                    + &format
                    + &format!("family: {family}\n\n{header}\n{parameters}")
                    + &others
                        .iter()
                        .map(|key| copy_section(base, base_text, key))
                        .collect::<String>()
            }
            TemplateBase::Extends(_) => {
                let first = format!(
                    "Like {base}, but for what is written here: remove the `# ` before a value, and \
                     before the section that it stands in. `fabkit check {name}.yaml` says whether it \
                     can be built."
                );
                let commented = parameters.lines().map(|line| match line {
                    "" => "\n".to_owned(),
                    line => format!("# {line}\n"),
                });
                intro(&[&first, SOURCES, FIXTURES])
                    + &format
                    + &format!("extends: {base}\n\n{header}\n")
                    + &commented.collect::<String>()
            }
        })
    }
}

const SOURCES: &str = "A value may say where it comes from: `{value: 15 mm, source: measured, note: \
                       \"with calipers\"}`. Sources are paper, measured, chosen and user.";

const FIXTURES: &str = "What calibration hardware should do otherwise than by default may be added \
                        under `fixtures:`; `fabkit schema` lists its parameters.";

/// Copies a section from the file of a built-in sensor, including its notes, with an empty line before it; returns an
/// empty text if the section is absent.
fn copy_section(sensor: &str, text: &str, key: &str) -> String {
    let mut lines = text.lines().skip_while(|line| *line != format!("{key}:"));
    let Some(first) = lines.next() else { return String::new() };
    let inner = lines.take_while(|line| line.starts_with(' ')).map(|line| format!("{line}\n"));
    let above = comment("", &format!("What suits the shape of {sensor}, whose notes these are."));
    format!("\n{above}{first}\n{}", inner.collect::<String>())
}

/// Formats paragraphs as comments, followed by an empty line.
fn intro(paragraphs: &[&str]) -> String {
    let paragraphs: Vec<String> = paragraphs.iter().map(|text| comment("", text)).collect();
    paragraphs.join("#\n") + "\n"
}

/// Formats fields with their values; an empty line precedes each section.
fn lines(fields: &[FieldDeclaration], value: &impl Fn(&str) -> Option<String>) -> String {
    let mut text = String::new();
    for field in fields {
        if matches!(field.shape, FieldShape::Section(_)) && !text.is_empty() {
            text.push('\n');
        }
        describe(field, "", value, &mut text);
    }
    text
}

/// Appends a key with its description above it.
fn describe(
    field: &FieldDeclaration,
    section: &str,
    value: &impl Fn(&str) -> Option<String>,
    text: &mut String,
) {
    let path = join(section, field.name);
    let indent = "  ".repeat(path.matches('.').count());
    let (name, summary) = (field.name, &field.summary);
    match &field.shape {
        FieldShape::Section(inner) => {
            *text += &comment(&indent, summary);
            *text += &format!("{indent}{name}:\n");
            inner.iter().for_each(|field| describe(field, &path, value, text));
        }
        FieldShape::Value { allowed, .. } => {
            let Some(value) = value(&path) else { return };
            *text += &comment(&indent, &format!("{summary} Allowed: {allowed}."));
            *text += &format!("{indent}{name}: {value}\n");
        }
    }
}

/// Formats a comment in lines of at most [`COLUMNS`] characters, broken between words.
fn comment(indent: &str, text: &str) -> String {
    let mut lines = vec![format!("{indent}#")];
    for word in text.split_whitespace() {
        let last = lines.last().map_or(0, |line| line.chars().count());
        if last + 1 + word.chars().count() > COLUMNS {
            lines.push(format!("{indent}#"));
        }
        if let Some(line) = lines.last_mut() {
            *line += " ";
            *line += word;
        }
    }
    lines.join("\n") + "\n"
}

/// Formats a written value for YAML.
fn yaml_of(written: &WrittenValue) -> String {
    match &written.text {
        WrittenText::Scalar(text) => yaml(text),
        WrittenText::List(items) => {
            let items: Vec<String> = items.iter().map(|(text, _)| yaml(text)).collect();
            format!("[{}]", items.join(", "))
        }
    }
}

/// Formats a scalar for YAML: quoted unless it can only be read as plain text.
fn yaml(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || " ._-+/()".contains(c);
    let begins = text.starts_with(|c: char| c.is_ascii_alphanumeric());
    // YAML reads these words as null or as a boolean.
    let is_word = !["null", "yes", "no", "on", "off"].contains(&&*text.to_ascii_lowercase());
    if begins && is_word && text.trim_end() == text && text.chars().all(is_plain) {
        return text.to_owned();
    }
    fabkit_text::Json::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_keep_their_meaning_in_yaml() {
        for plain in ["15.0 mm", "8", "true", "black PLA", "M2 x 4", "frosted on both sides"] {
            assert_eq!(yaml(plain), plain);
        }
        for (text, quoted) in [
            ("", r#""""#),
            ("a: b", r#""a: b""#),
            ("null", r#""null""#),
            ("3 # of", r#""3 # of""#),
            ("-7 deg", r#""-7 deg""#),
            ("say \"a\"", r#""say \"a\"""#),
            ("0,5", r#""0,5""#),
        ] {
            assert_eq!(yaml(text), quoted);
        }
    }

    #[test]
    fn comments_are_broken_between_words() {
        let text = comment("  ", &"word ".repeat(60));
        assert!(text.lines().all(|line| line.starts_with("  # word") && line.len() <= COLUMNS));
        assert_eq!(text.matches("word").count(), 60);
    }
}
