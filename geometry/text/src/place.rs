//! Places of values in files, the values as written, and the problems found there.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::expression::Formula;
use crate::layer::TextLayer;
use crate::tree::{Dialect, Position, YamlFault};
use crate::{Problem, ProblemFacts, Suggestion, ValueSource, to_printable};

/// Place in one of the texts.
///
/// ```
/// use fabkit_text::{Dialect, Position, TextLayer, TextPlace};
///
/// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
/// let place = TextPlace::new(TextLayer::File, "washer.yaml", WASHER);
/// let at = place.at(Position { line: 2, column: 9 });
/// let found = at.problem("radius", "0 mm", "radius is 0 mm".into()).hint("write at least 1 mm");
/// assert_eq!(found.problem.to_string(), "washer.yaml:2:9: radius is 0 mm");
/// assert_eq!(found.problem.hint.as_deref(), Some("write at least 1 mm"));
/// ```
#[derive(Clone, Debug)]
pub struct TextPlace {
    /// Layer of the text.
    pub layer: TextLayer,
    /// Name of the text in messages.
    pub file: Arc<str>,
    /// Kind of file.
    pub dialect: &'static Dialect,
    /// Position in the text; `None` for the whole text.
    pub position: Option<Position>,
}

impl TextPlace {
    /// Creates the place of a whole text.
    pub fn new(layer: TextLayer, file: &str, dialect: &'static Dialect) -> Self {
        Self { layer, file: file.into(), dialect, position: None }
    }

    /// Returns a place in the same text.
    pub fn at(&self, position: Position) -> Self {
        Self { position: Some(position), ..self.clone() }
    }

    /// Creates a problem at this place.
    pub fn problem(&self, path: &str, value: &str, message: String) -> LocatedProblem {
        LocatedProblem {
            layer: self.layer,
            problem: Problem {
                file: self.file.to_string(),
                line: self.position.map(|p| p.line),
                column: self.position.map(|p| p.column),
                path: path.to_owned(),
                value: value.to_owned(),
                message,
                hint: None,
                facts: ProblemFacts::default(),
            },
        }
    }
}

/// Problem with the layer of its text, by which problems are sorted.
#[derive(Clone, Debug)]
pub struct LocatedProblem {
    /// Layer of the text.
    pub layer: TextLayer,
    /// The problem.
    pub problem: Problem,
}

impl LocatedProblem {
    /// Sets the hint.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.problem.hint = Some(hint.into());
        self
    }

    /// Creates a problem from a fault of the text at `place`.
    pub fn from_fault(fault: YamlFault, place: &TextPlace) -> Self {
        Self { layer: place.layer, problem: fault.in_file(&place.file) }
    }

    /// Sorts problems: those of the file in its order, then those of `--set`, then those of extended files.
    ///
    /// ```
    /// use fabkit_text::{Dialect, LocatedProblem, TextLayer, TextPlace};
    ///
    /// const WASHER: &Dialect = &Dialect::new("washer", 1, "");
    /// let problem =
    ///     |layer, file| TextPlace::new(layer, file, WASHER).problem("radius", "0 mm", "too small".into());
    /// let found = vec![problem(TextLayer::Override, "--set"), problem(TextLayer::File, "washer.yaml")];
    /// let files = LocatedProblem::sort(found).into_iter().map(|problem| problem.file);
    /// assert!(files.eq(["washer.yaml", "--set"]));
    /// ```
    pub fn sort(mut found: Vec<Self>) -> Vec<Problem> {
        found.sort_by_key(|f| (f.layer, f.problem.line, f.problem.column));
        found.into_iter().map(|f| f.problem).collect()
    }
}

/// Value as written.
#[derive(Clone, Debug)]
pub struct WrittenValue {
    /// Place of the value.
    pub place: TextPlace,
    /// Text of the value.
    pub text: WrittenText,
    /// Source of the value.
    pub source: ValueSource,
    /// Expression that the text was computed from, if any.
    pub formula: Option<Formula>,
}

/// Written values by path. Copies share the values.
pub type WrittenValues = BTreeMap<String, Arc<WrittenValue>>;

impl WrittenValue {
    /// Creates a value that is not computed.
    pub(crate) fn new(place: TextPlace, text: WrittenText, source: ValueSource) -> Self {
        Self { place, text, source, formula: None }
    }
}

/// Text of a value.
#[derive(Clone, Debug)]
pub enum WrittenText {
    /// Single value.
    Scalar(String),
    /// List items with their places.
    List(Vec<(String, TextPlace)>),
}

impl WrittenText {
    /// Formats the text on one line, for messages.
    pub fn to_printable(&self) -> String {
        match self {
            Self::Scalar(text) => to_printable(text),
            Self::List(items) => {
                let items: Vec<&str> = items.iter().map(|(text, _)| &**text).collect();
                to_printable(&format!("[{}]", items.join(", ")))
            }
        }
    }
}

impl LocatedProblem {
    /// Sets the code: the short name of the kind of problem.
    #[must_use]
    pub fn code(mut self, code: &'static str) -> Self {
        self.problem.facts.code = code;
        self
    }

    /// Sets the replacement that programs may write.
    #[must_use]
    pub fn suggest(mut self, path: &str, value: &str) -> Self {
        self.problem.facts.suggestion = Some(Suggestion { path: path.into(), value: value.into() });
        self
    }
}
