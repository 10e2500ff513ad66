//! A parameter as it stands.

use crate::source::Source;
use crate::value::Kind;

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
