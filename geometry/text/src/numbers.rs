//! Numeric parameters of a document, for searches that try other values.

use std::collections::BTreeMap;

use crate::expression::resolve;
use crate::parameter_table::ParameterTable;
use crate::place::{TextPlace, WrittenText, WrittenValue};
use crate::{
    FieldShape, OVERRIDE_FILE_NAME, Scalar, SourceKind, TextLayer, ValueKind, ValueSource,
};

/// Parameter that is one number.
#[derive(Clone, Debug, PartialEq)]
pub struct NumericParameter {
    /// Dotted path.
    pub path: String,
    /// Kind: length (mm), angle (deg), count or plain number.
    pub kind: ValueKind,
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

impl NumericParameter {
    /// Formats a value as it would be written.
    ///
    /// ```
    /// use fabkit_text::{NumericParameter, SourceKind, TextLayer, ValueKind};
    ///
    /// let radius = NumericParameter {
    ///     path: "surface.radius".into(),
    ///     kind: ValueKind::Length,
    ///     range: [4.0, 60.0],
    ///     source: SourceKind::Paper,
    ///     layer: TextLayer::File,
    ///     is_expression: false,
    ///     value: Some(15.0),
    ///     tolerance: None,
    /// };
    /// assert_eq!(radius.format_value(15.5), "15.5 mm");
    /// assert_eq!(radius.format_value(-0.0), "0 mm");
    /// ```
    pub fn format_value(&self, value: f64) -> String {
        // Adding 0 turns `-0` into `0`.
        let value = value + 0.0;
        match self.kind {
            ValueKind::Length => format!("{value} mm"),
            ValueKind::Angle => format!("{value} deg"),
            _ => value.to_string(),
        }
    }
}

impl ParameterTable {
    /// Replaces expressions by their values.
    ///
    /// ```
    /// use fabkit_geometry::Length;
    /// use fabkit_text::{
    ///     Dialect, FieldDeclaration, Parameter, ParameterTable, TextLayer, TextPlace, apply_overrides,
    /// };
    ///
    /// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
    /// let shape = Length::shape(&(0.1..=20.0));
    /// let length = |name| FieldDeclaration { name, summary: String::new(), shape: shape.clone() };
    /// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
    /// let mut table = ParameterTable::new(vec![length("radius"), length("wall"), length("lip")], place);
    /// let set = ["radius=6 mm", "wall== radius / 4 + 0.5 mm", "lip== radius + 1"].map(String::from);
    /// apply_overrides(&mut table, &set);
    /// table.resolve();
    /// assert_eq!(table.numbers()[1].value, Some(2.0));
    /// // A length plus a plain number is nothing.
    /// assert_eq!(table.found[0].problem.path, "lip");
    /// ```
    pub fn resolve(&mut self) {
        resolve(self);
    }

    /// Lists every parameter that is one number, in order of declaration. Values of expressions are known only after
    /// [`ParameterTable::resolve`].
    pub fn numbers(&self) -> Vec<NumericParameter> {
        let number = |path: String| {
            let Some(FieldShape::Value { is_list: false, kind, allowed, .. }) =
                self.field(&path).map(|field| &field.shape)
            else {
                return None;
            };
            // Kinds without a range, such as texts, are no numbers.
            let range = parse_range(*kind, allowed)?;
            let written = self.value(&path)?;
            let value = self.number(&path, *kind);
            let (source, layer) = (written.source.kind, written.place.layer);
            let is_expression = written.formula.is_some();
            let stated = written.source.tolerance.as_ref();
            let tolerance = stated.and_then(|text| parse_number(*kind, text));
            Some(NumericParameter {
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
    pub fn number(&self, path: &str, kind: ValueKind) -> Option<f64> {
        match &self.value(path)?.text {
            WrittenText::Scalar(text) => parse_number(kind, text),
            WrittenText::List(_) => None,
        }
    }

    /// Writes values over the present ones, as if they were overrides.
    ///
    /// ```
    /// use std::collections::BTreeMap;
    ///
    /// use fabkit_geometry::Length;
    /// use fabkit_text::{
    ///     Dialect, FieldDeclaration, Parameter, ParameterTable, TextLayer, TextPlace, ValueKind,
    /// };
    ///
    /// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
    /// let shape = Length::shape(&(1.0..=20.0));
    /// let radius = FieldDeclaration { name: "radius", summary: "Radius.".into(), shape };
    /// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
    /// let mut table = ParameterTable::new(vec![radius], place);
    /// table.override_values(&BTreeMap::from([("radius".to_owned(), "0.8 cm".to_owned())]));
    /// assert_eq!(table.number("radius", ValueKind::Length), Some(8.0));
    /// assert_eq!(table.numbers()[0].layer, TextLayer::Override);
    /// ```
    pub fn override_values(&mut self, values: &BTreeMap<String, String>) {
        let place = TextPlace::new(TextLayer::Override, OVERRIDE_FILE_NAME, self.root.dialect);
        for (path, text) in values {
            let source = ValueSource::user(OVERRIDE_FILE_NAME);
            let text = WrittenText::Scalar(text.clone());
            self.set(path, WrittenValue::new(place.clone(), text, source));
        }
    }
}

/// Parses a number as a value of this kind, in mm or degrees where it has a unit.
fn parse_number(kind: ValueKind, text: &str) -> Option<f64> {
    match kind {
        ValueKind::Length => text.parse::<fabkit_geometry::Length>().ok().map(|v| v.mm()),
        ValueKind::Angle => text.parse::<fabkit_geometry::Angle>().ok().map(|v| v.deg()),
        ValueKind::Count => <u32 as Scalar>::parse(text).ok().map(f64::from),
        ValueKind::Number => <f64 as Scalar>::parse(text).ok(),
        ValueKind::Switch | ValueKind::Text | ValueKind::List => None,
    }
}

/// Parses the text of a declared range, such as `4 mm to 60 mm`.
fn parse_range(kind: ValueKind, allowed: &str) -> Option<[f64; 2]> {
    let (low, high) = allowed.split_once(" to ")?;
    Some([parse_number(kind, low)?, parse_number(kind, high)?])
}
