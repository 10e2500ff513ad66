//! Files that people write: read with every error at once, each with place, value, limit and hint.
//!
//! [`parse()`] reads YAML to values that know where they stand, for all kinds of file ([`Dialect`]).
//! Above it are two ways to read. What is declared with [`parameters!`] needs no more: from that one
//! declaration come the typed struct that code reads, the limits that are checked, the JSON Schema,
//! the rows of `fabkit show`, and the paths that `--set` knows. Other files are read key by key, with
//! a [`Reading`] that collects what is wrong. What programs write, as JSON, says what it is
//! ([`JsonFormat`]).
//!
//! Reading goes on after an error. For parameters the steps are: text to a tree, trees to one table
//! of values by path ([`Document`]: what a file `extends`, the file itself, then `--set`), table to
//! typed values within their limits ([`Reader`]), and last what is required of several values
//! together ([`Report`]).
//!
//! Why not serde: it stops at the first error, and forgets where values stood.

use std::fmt;

mod declare;
mod document;
mod expression;
mod facts;
mod json;
mod numbers;
mod overrides;
mod parse;
mod place;
mod reader;
mod reading;
mod report;
mod schema;
mod suggest;
mod tree;
mod unknown;
mod value;

pub use declare::{Field, Inline, Look, Parameter, Section, Shape, join, summary};
pub use document::Document;
pub use expression::Formula;
pub use facts::{Facts, Suggestion, number_and_unit};
pub use json::{InvalidDocument, JsonFormat};
pub use numbers::Number;
pub use overrides::{OVERRIDES, apply_overrides};
pub use parse::{MAX_BYTES, MAX_DEPTH, MAX_NODES, Parsed, parse};
pub use place::{Found, Place, TextLayer, Written, WrittenText};
pub use reader::{Example, Reader};
pub use reading::{Reading, check_format, mapping_of, read_section, take_word};
pub use report::{Broken, Quantity, Report, Rule};
pub use schema::{FamilySchema, root_schema, section_schema};
pub use serde_json::Value as Json;
pub use suggest::{did_you_mean, hint as suggestion, similar};
pub use tree::{Content, Dialect, Entry, Fault, Node, Position};
pub use value::{Kind, Name, Refusal, Scalar};

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// Stated in the paper.
    Paper,
    /// Stated by the maker of what is bought: in a data sheet.
    Maker,
    /// Measured from published files.
    Measured,
    /// Chosen by fabkit's authors.
    Chosen,
    /// Given by the user: in their own file without a source, or on the command line.
    User,
}

impl SourceKind {
    /// Every kind, in the order in which messages name them.
    pub const ALL: [Self; 5] = [Self::Paper, Self::Maker, Self::Measured, Self::Chosen, Self::User];

    /// As written in YAML.
    pub fn word(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Maker => "maker",
            Self::Measured => "measured",
            Self::Chosen => "chosen",
            Self::User => "user",
        }
    }
}

impl fmt::Display for SourceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// The source of one value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// What kind.
    pub kind: SourceKind,
    /// Section, file or reason.
    pub note: String,
    /// How far what is made may be from it, either way, as written; of lengths and angles.
    pub tolerance: Option<String>,
}

impl Source {
    /// Of a value that the user gave; nothing more is known of it.
    pub fn user(note: impl Into<String>) -> Self {
        Self { kind: SourceKind::User, note: note.into(), tolerance: None }
    }
}

/// One parameter as it stands, for `fabkit show`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Dotted path, for example `surface.radius`.
    pub path: String,
    /// Value with unit, as it would be written in YAML.
    pub value: String,
    /// What kind of value it is.
    pub kind: Kind,
    /// Where it comes from.
    pub source: Source,
    /// One line for people.
    pub summary: String,
    /// Allowed values, for people, for example `2 mm to 60 mm`.
    pub limits: String,
    /// The smallest and the largest value that are allowed, of a list those of its items, as they
    /// would be written; nothing where a value is no number.
    pub bounds: Option<[String; 2]>,
    /// The words that are allowed, where it is one of a few.
    pub choices: Vec<String>,
    /// The expression that the value follows from, beginning with `= `, where there is one.
    pub expression: Option<String>,
    /// Whether no file and no override says it: the family does so by default.
    pub is_default: bool,
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
    /// The same for programs.
    pub facts: Facts,
}

impl fmt::Display for Problem {
    /// `file:line:column: message`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        for count in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{count}")?;
        }
        write!(f, ": {}", self.message)
    }
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

/// Text from a file as it may be shown on a terminal: one line, no control characters, not long.
pub fn shown(text: &str) -> String {
    const LONGEST: usize = 60;
    let mut safe = String::new();
    for (i, c) in text.chars().enumerate() {
        if i == LONGEST {
            safe.push('…');
            break;
        }
        match c {
            // Direction marks could make a terminal show another text than the one refused.
            '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
                safe.extend(c.escape_unicode());
            }
            c if c.is_control() => safe.extend(c.escape_default()),
            c => safe.push(c),
        }
    }
    safe
}
