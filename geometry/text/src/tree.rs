//! What a YAML text holds, with where everything stands.

use std::fmt;

/// A kind of file: what messages call it, and what of YAML it may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// What one file describes, for example `sensor`.
    pub noun: &'static str,
    /// The version behind `format:`.
    pub format: u32,
    /// What follows ``begin with `format: 1` ``, for example `` and `name: NAME` ``.
    pub begin: &'static str,
    /// What `extends: NAME` may name, for example `a built-in sensor`; empty where there is none.
    pub base: &'static str,
    /// The tags that mappings may have, without exclamation marks; they mean nothing.
    pub tags: &'static [&'static str],
    /// Last words, or whole paths, of what people look for in such files and there is not; and why.
    pub absent: &'static [(&'static str, &'static str)],
}

impl Dialect {
    /// Without tags, and without files to start from.
    pub const fn new(noun: &'static str, format: u32, begin: &'static str) -> Self {
        Self { noun, format, begin, base: "", tags: &[], absent: &[] }
    }
}

/// A place in a text; both counts start at 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Of the file.
    pub line: usize,
    /// In characters.
    pub column: usize,
}

/// One YAML value.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Where it begins.
    pub position: Position,
    /// What it is.
    pub content: Content,
}

impl Node {
    /// The value of a key, if this is a mapping that has it.
    pub fn get(&self, key: &str) -> Option<&Self> {
        self.entries().iter().find(|entry| entry.key == key).map(|entry| &entry.value)
    }

    /// All keys with their values; none if this is no mapping.
    pub fn entries(&self) -> &[Entry] {
        match &self.content {
            Content::Map(entries) => entries,
            _ => &[],
        }
    }

    /// The items of a list; none if this is no list.
    pub fn items(&self) -> &[Self] {
        match &self.content {
            Content::List(items) => items,
            _ => &[],
        }
    }

    /// Whether this is a list, empty or not.
    pub fn is_list(&self) -> bool {
        matches!(self.content, Content::List(_))
    }

    /// The text of a single value, which may be nothing.
    pub fn text(&self) -> Option<&str> {
        match &self.content {
            Content::Scalar(text) => Some(text),
            Content::Nothing => Some(""),
            _ => None,
        }
    }
}

/// What a YAML value is.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Nothing was written, as in `radius:` or `radius: null`.
    Nothing,
    /// One value, as text.
    Scalar(String),
    /// `[a, b]`, or lines that begin with `-`.
    List(Vec<Node>),
    /// `key: value`, in the order of the file.
    Map(Vec<Entry>),
}

/// One `key: value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its name.
    pub key: String,
    /// Where the name stands.
    pub key_position: Position,
    /// What stands behind it.
    pub value: Node,
}

/// Why a text cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Where, if it is one place.
    pub position: Option<Position>,
    /// Dotted path of the key at fault, where there is one.
    pub path: String,
    /// What stands there.
    pub written: String,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
}

impl Fault {
    /// Something wrong, at one place if that is known.
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

    /// The same with what to do about it.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The same as a problem of a file.
    pub fn in_file(self, file: &str) -> crate::Problem {
        crate::Problem {
            file: file.into(),
            line: self.position.map(|at| at.line),
            column: self.position.map(|at| at.column),
            path: self.path,
            value: self.written,
            message: self.message,
            hint: self.hint,
            facts: crate::Facts::of("bad_yaml"),
        }
    }

    pub(crate) fn at(
        position: Position,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) -> Self {
        Self::new(position, "", message).hint(hint)
    }
}

impl fmt::Display for Fault {
    /// `line 3: lens.k1: what is wrong (what to do)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(Position { line, .. }) = self.position {
            write!(f, "line {line}: ")?;
        }
        // Some messages begin with the path themselves.
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
