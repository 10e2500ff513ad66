//! Parameter with its present value.

use crate::source::ValueSource;
use crate::value::ValueKind;

/// Parameter with its present value, for `fabkit show`.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// Dotted path, for example `surface.radius`.
    pub path: String,
    /// Value with unit, as it would be written in YAML.
    pub value: String,
    /// Kind of the value.
    pub kind: ValueKind,
    /// Source of the value.
    pub source: ValueSource,
    /// Description in one line.
    pub summary: String,
    /// Allowed values, for people, for example `2 mm to 60 mm`.
    pub limits: String,
    /// Smallest and largest allowed value as they would be written (of a list: of its items); `None` if the value is
    /// not a number.
    pub bounds: Option<[String; 2]>,
    /// Allowed words, if the value is one of a few.
    pub choices: Vec<String>,
    /// Expression that the value is computed from, beginning with `= `, if any.
    pub expression: Option<String>,
    /// True if no file and no override sets it: it is the family's default.
    pub is_default: bool,
}
