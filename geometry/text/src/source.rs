//! Sources of numbers.

use std::fmt;

/// Kind of source of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// Stated in the paper.
    Paper,
    /// Stated by the maker of a bought part, in a data sheet.
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

    /// Returns the word used in YAML.
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

/// Source of one value.
///
/// ```
/// use fabkit_geometry::Length;
/// use fabkit_text::{
///     Dialect, FieldDeclaration, Parameter, ParameterTable, SourceKind, TextLayer, TextPlace,
///     read_mapping,
/// };
///
/// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
/// let shape = Length::shape(&(1.0..=20.0));
/// let radius = FieldDeclaration { name: "radius", summary: "Radius.".into(), shape };
/// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
/// let yaml = "radius: {value: 7 mm, source: paper, note: Table 1, tolerance: 0.1 mm}";
/// let mut table = ParameterTable::new(vec![radius], place.clone());
/// table.merge(read_mapping(yaml, &place, &mut Vec::new()).unwrap_or_default(), &place);
/// let source = &table.written("radius").expect("it is written").source;
/// assert_eq!((source.kind, source.note.as_str()), (SourceKind::Paper, "Table 1"));
/// assert_eq!(table.numbers()[0].tolerance, Some(0.1));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ValueSource {
    /// Kind of the source.
    pub kind: SourceKind,
    /// Section, file or reason.
    pub note: String,
    /// Tolerance of the made part, either way, as written; for lengths and angles.
    pub tolerance: Option<String>,
}

impl ValueSource {
    /// Creates the source of a value that the user gave, of which nothing more is known.
    pub fn user(note: impl Into<String>) -> Self {
        Self { kind: SourceKind::User, note: note.into(), tolerance: None }
    }
}
