//! Tree of a YAML text, with the position of every node.

use std::fmt;

/// Kind of file: its name in messages, and the YAML features it may use.
///
/// ```
/// use fabkit_text::{Dialect, ParameterTable, TextLayer, TextPlace, read_mapping};
///
/// const PAD: &Dialect = &Dialect {
///     absent: &[("weight", "it follows from the materials")],
///     ..Dialect::new("pad", 1, "")
/// };
/// let place = TextPlace::new(TextLayer::File, "pad.yaml", PAD);
/// let mut table = ParameterTable::new(Vec::new(), place.clone());
/// let entries = read_mapping("weight: 3\n", &place, &mut table.found).unwrap_or_default();
/// table.merge(entries, &place);
/// assert_eq!(table.found[0].problem.message, "`weight` is not a key of a pad");
/// let hint = table.found[0].problem.hint.as_deref().unwrap_or_default();
/// assert!(hint.starts_with("fabkit has none: it follows from the materials;"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// Noun for one file's subject, for example `sensor`.
    pub noun: &'static str,
    /// Number behind `format:`.
    pub format: u32,
    /// Text that follows ``begin with `format: 1` ``, for example `` and `name: NAME` ``.
    pub begin: &'static str,
    /// Description of what `extends: NAME` may name, for example `a built-in sensor`; empty if files cannot extend
    /// others.
    pub base: &'static str,
    /// Tags that mappings may carry, without exclamation marks. They are ignored.
    pub tags: &'static [&'static str],
    /// Names that people look for in such files but do not exist (last words or whole paths), each with the reason.
    pub absent: &'static [(&'static str, &'static str)],
}

impl Dialect {
    /// Creates a dialect without tags and without `extends`.
    pub const fn new(noun: &'static str, format: u32, begin: &'static str) -> Self {
        Self { noun, format, begin, base: "", tags: &[], absent: &[] }
    }
}

/// Position in a text; line and column start at 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Line.
    pub line: usize,
    /// Column, in characters.
    pub column: usize,
}

/// One YAML value.
///
/// ```
/// use fabkit_text::{Dialect, Position, parse};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let (tree, _) = parse("name: fine\nheights: [1 mm, 2 mm]\n", PINS)?;
/// assert_eq!(tree.get("name").and_then(|name| name.text()), Some("fine"));
/// let heights = tree.get("heights").map(|heights| heights.items()).unwrap_or_default();
/// assert_eq!(heights[1].text(), Some("2 mm"));
/// assert_eq!(heights[1].position, Position { line: 2, column: 17 });
/// # Ok::<(), fabkit_text::YamlFault>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct YamlNode {
    /// Position of its first character.
    pub position: Position,
    /// Content of the node.
    pub content: YamlContent,
}

impl YamlNode {
    /// Returns the value of a key, if this is a mapping that has it.
    pub fn get(&self, key: &str) -> Option<&Self> {
        self.entries().iter().find(|entry| entry.key == key).map(|entry| &entry.value)
    }

    /// Returns all keys with their values; empty if this is not a mapping.
    pub fn entries(&self) -> &[YamlEntry] {
        match &self.content {
            YamlContent::Map(entries) => entries,
            _ => &[],
        }
    }

    /// Returns the items of a list; empty if this is not a list.
    pub fn items(&self) -> &[Self] {
        match &self.content {
            YamlContent::List(items) => items,
            _ => &[],
        }
    }

    /// Returns whether this is a list, empty or not.
    pub fn is_list(&self) -> bool {
        matches!(self.content, YamlContent::List(_))
    }

    /// Returns the text of a scalar (empty for a missing value); `None` for lists and mappings.
    pub fn text(&self) -> Option<&str> {
        match &self.content {
            YamlContent::Scalar(text) => Some(text),
            // A missing value reads as an empty text.
            YamlContent::Nothing => Some(""),
            _ => None,
        }
    }
}

/// Content of a YAML node.
///
/// ```
/// use fabkit_text::{Dialect, YamlContent, parse};
///
/// const PINS: &Dialect = &Dialect::new("pin field", 1, "");
/// let (tree, _) = parse("empty: null\nword: \"null\"\nnumber: 1.50\n", PINS)?;
/// let contents: Vec<_> = tree.entries().iter().map(|entry| &entry.value.content).collect();
/// assert_eq!(contents[0], &YamlContent::Nothing);
/// assert_eq!(contents[1], &YamlContent::Scalar("null".into()));
/// // Numbers stay as they were written.
/// assert_eq!(contents[2], &YamlContent::Scalar("1.50".into()));
/// # Ok::<(), fabkit_text::YamlFault>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum YamlContent {
    /// Missing value, as in `radius:` or `radius: null`.
    Nothing,
    /// Scalar, as text.
    Scalar(String),
    /// Sequence: `[a, b]`, or lines that begin with `-`.
    List(Vec<YamlNode>),
    /// Mapping `key: value`, in the order of the file.
    Map(Vec<YamlEntry>),
}

/// One `key: value` pair.
#[derive(Clone, Debug, PartialEq)]
pub struct YamlEntry {
    /// Name of the key.
    pub key: String,
    /// Position of the key.
    pub key_position: Position,
    /// Value behind the key.
    pub value: YamlNode,
}

/// Reason why a text cannot be read.
///
/// ```
/// use fabkit_text::{Position, YamlFault};
///
/// let at = Position { line: 3, column: 7 };
/// let fault = YamlFault::new(at, "lens.k1", "not a number").hint("write for example `0.1`");
/// assert_eq!(fault.to_string(), "line 3: lens.k1: not a number (write for example `0.1`)");
/// assert_eq!(fault.in_file("camera.yaml").to_string(), "camera.yaml:3:7: not a number");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct YamlFault {
    /// Position, if it is one place.
    pub position: Option<Position>,
    /// Dotted path of the key at fault, if there is one.
    pub path: String,
    /// Text at the position.
    pub written: String,
    /// Description of the fault.
    pub message: String,
    /// Suggested correction.
    pub hint: Option<String>,
}

impl YamlFault {
    /// Creates a fault, at one position if that is known.
    pub fn new(
        position: impl Into<Option<Position>>,
        path: &str,
        message: impl Into<String>,
    ) -> Self {
        Self {
            position: position.into(),
            path: path.to_owned(),
            written: String::new(),
            message: message.into(),
            hint: None,
        }
    }

    /// Sets the hint.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Converts the fault to a problem of a file.
    pub fn in_file(self, file: &str) -> crate::Problem {
        crate::Problem {
            file: file.into(),
            line: self.position.map(|at| at.line),
            column: self.position.map(|at| at.column),
            path: self.path,
            value: self.written,
            message: self.message,
            hint: self.hint,
            facts: crate::ProblemFacts::new("bad_yaml"),
        }
    }

    /// Creates a fault at a position, with a hint.
    pub(crate) fn at(
        position: Position,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) -> Self {
        Self::new(position, "", message).hint(hint)
    }
}

impl fmt::Display for YamlFault {
    /// Writes `line 3: lens.k1: what is wrong (what to do)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Position { line, .. }) = self.position {
            write!(f, "line {line}: ")?;
        }
        // Some messages already begin with the path.
        if !self.path.is_empty() && !self.message.starts_with(&format!("`{}`", self.path)) {
            write!(f, "{}: ", self.path)?;
        }
        write!(f, "{}", self.message)?;
        match &self.hint {
            Some(hint) => write!(f, " ({hint})"),
            None => Ok(()),
        }
    }
}
