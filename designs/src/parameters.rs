//! Parameters: names, units, limits and sources, read from YAML with all errors at once.

use std::fmt;

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// Stated in the paper.
    Paper,
    /// Measured from published files.
    Measured,
    /// Chosen by fabkit's authors.
    Chosen,
    /// Given by the user: in their own file without a source, or on the command line.
    User,
}

/// The source of one value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// What kind.
    pub kind: SourceKind,
    /// Section, file or reason.
    pub note: String,
}

/// One parameter as it stands, for `fabkit show`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Dotted path, for example `surface.radius`.
    pub path: String,
    /// Value with unit, as it would be written in YAML.
    pub value: String,
    /// Where it comes from.
    pub source: Source,
    /// One line for people.
    pub summary: String,
    /// Allowed values, for people, for example `2 mm to 60 mm`.
    pub limits: String,
}

/// One thing wrong with a design.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// File name, or `--set`.
    pub file: String,
    /// 1-based line, where there is one.
    pub line: Option<usize>,
    /// 1-based column, where there is one.
    pub column: Option<usize>,
    /// Dotted path of the parameter; empty for the whole document.
    pub path: String,
    /// The value as written; empty where there is none.
    pub value: String,
    /// What is wrong, with the limit.
    pub message: String,
    /// What to do.
    pub hint: Option<String>,
}

/// Everything wrong with a design.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct InvalidDesign {
    /// At least one, in the order of the file.
    pub problems: Vec<Problem>,
}

impl fmt::Display for InvalidDesign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} problem(s) in the design", self.problems.len())
    }
}
