//! Numeric parameters of a document, for searches that try other values.

use std::collections::BTreeMap;

use crate::document::Document;
use crate::expression::resolve;
use crate::place::{Place, Written, WrittenText};
use crate::{Kind, OVERRIDES, Scalar, Shape, Source, SourceKind, TextLayer};

/// Parameter that is one number.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Dotted path.
    pub path: String,
    /// Kind: length (mm), angle (deg), count or plain number.
    pub kind: Kind,
    /// Smallest and largest allowed value.
    pub range: [f64; 2],
    /// Source of the value.
    pub source: SourceKind,
    /// Text that contains the value.
    pub layer: TextLayer,
    /// True if the value is computed from other values.
    pub is_expression: bool,
    /// The value in its unit; `None` if it cannot be read.
    pub value: Option<f64>,
    /// Stated tolerance of the made part, either way, in the parameter's unit.
    pub tolerance: Option<f64>,
}

impl Number {
    /// Formats a value as it would be written.
    pub fn text(&self, value: f64) -> String {
        // Adding 0 turns `-0` into `0`.
        let value = value + 0.0;
        match self.kind {
            Kind::Length => format!("{value} mm"),
            Kind::Angle => format!("{value} deg"),
            _ => value.to_string(),
        }
    }
}

impl Document {
    /// Replaces expressions by their values.
    pub fn resolve(&mut self) {
        resolve(self);
    }

    /// Lists every parameter that is one number, in order of declaration. Values of expressions are known only after
    /// [`Document::resolve`].
    pub fn numbers(&self) -> Vec<Number> {
        let number = |path: String| {
            let Some(Shape::Value { is_list: false, kind, allowed, .. }) =
                self.field(&path).map(|field| &field.shape)
            else {
                return None;
            };
            // Kinds without a range, such as texts, are no numbers.
            let range = range_of(*kind, allowed)?;
            let written = self.value(&path)?;
            let value = self.number(&path, *kind);
            let (source, layer) = (written.source.kind, written.place.layer);
            let is_expression = written.formula.is_some();
            let stated = written.source.tolerance.as_ref();
            let tolerance = stated.and_then(|text| parsed(*kind, text));
            Some(Number {
                path,
                kind: *kind,
                range,
                source,
                layer,
                is_expression,
                value,
                tolerance,
            })
        };
        self.paths().into_iter().filter_map(number).collect()
    }

    /// Returns the number at a path.
    pub fn number(&self, path: &str, kind: Kind) -> Option<f64> {
        match &self.value(path)?.text {
            WrittenText::Scalar(text) => parsed(kind, text),
            WrittenText::List(_) => None,
        }
    }

    /// Writes values over the present ones, as if they were overrides.
    pub fn write_over(&mut self, values: &BTreeMap<String, String>) {
        let place = Place::new(TextLayer::Override, OVERRIDES, self.root.dialect);
        for (path, text) in values {
            let source = Source::user(OVERRIDES);
            let text = WrittenText::Scalar(text.clone());
            self.set(path, Written::new(place.clone(), text, source));
        }
    }
}

/// Parses a number as a value of this kind, in mm or degrees where it has a unit.
fn parsed(kind: Kind, text: &str) -> Option<f64> {
    match kind {
        Kind::Length => text.parse::<fabkit_geometry::Length>().ok().map(|v| v.mm()),
        Kind::Angle => text.parse::<fabkit_geometry::Angle>().ok().map(|v| v.deg()),
        Kind::Count => <u32 as Scalar>::parse(text).ok().map(f64::from),
        Kind::Number => <f64 as Scalar>::parse(text).ok(),
        Kind::Switch | Kind::Text | Kind::List => None,
    }
}

/// Parses the text of a declared range, such as `4 mm to 60 mm`.
fn range_of(kind: Kind, allowed: &str) -> Option<[f64; 2]> {
    let (low, high) = allowed.split_once(" to ")?;
    Some([parsed(kind, low)?, parsed(kind, high)?])
}
