//! Where values stand, what was written there, and what is wrong with it.

use std::sync::Arc;

use crate::expression::Formula;
use crate::layer::TextLayer;
use crate::tree::{Dialect, Fault, Position};
use crate::{Facts, Problem, Source, Suggestion, shown};

/// Where something stands.
#[derive(Clone, Debug)]
pub struct Place {
    /// Of which text.
    pub layer: TextLayer,
    /// Name of the text in messages.
    pub file: Arc<str>,
    /// What kind of file it is.
    pub dialect: &'static Dialect,
    /// Where in it; `None` for all of it.
    pub position: Option<Position>,
}

impl Place {
    /// A whole text.
    pub fn new(layer: TextLayer, file: &str, dialect: &'static Dialect) -> Self {
        Self { layer, file: file.into(), dialect, position: None }
    }

    /// A place in the same text.
    pub fn at(&self, position: Position) -> Self {
        Self { position: Some(position), ..self.clone() }
    }

    /// A problem of what stands here.
    pub fn problem(&self, path: &str, value: &str, message: String) -> Found {
        Found {
            layer: self.layer,
            problem: Problem {
                file: self.file.to_string(),
                line: self.position.map(|p| p.line),
                column: self.position.map(|p| p.column),
                path: path.to_owned(),
                value: value.to_owned(),
                message,
                hint: None,
                facts: Facts::default(),
            },
        }
    }
}

/// A problem and what is needed to put it in order.
#[derive(Clone, Debug)]
pub struct Found {
    /// Of which text.
    pub layer: TextLayer,
    /// What is wrong.
    pub problem: Problem,
}

impl Found {
    /// The same with what to do about it.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.problem.hint = Some(hint.into());
        self
    }

    /// A fault of the text that a place is in.
    pub fn fault(fault: Fault, place: &Place) -> Self {
        Self { layer: place.layer, problem: fault.in_file(&place.file) }
    }

    /// In the order of the file, then `--set`, then what the file extends.
    pub fn sorted(mut found: Vec<Self>) -> Vec<Problem> {
        found.sort_by_key(|f| (f.layer, f.problem.line, f.problem.column));
        found.into_iter().map(|f| f.problem).collect()
    }
}

/// A value as written.
#[derive(Clone, Debug)]
pub struct Written {
    /// Where.
    pub place: Place,
    /// What.
    pub text: WrittenText,
    /// Where it comes from.
    pub source: Source,
    /// The expression whose value the text is, where it follows from other values.
    pub formula: Option<Formula>,
}

impl Written {
    /// What somebody wrote.
    pub(crate) fn new(place: Place, text: WrittenText, source: Source) -> Self {
        Self { place, text, source, formula: None }
    }
}

/// The text of a value.
#[derive(Clone, Debug)]
pub enum WrittenText {
    /// Of a single value.
    Scalar(String),
    /// Items with their places.
    List(Vec<(String, Place)>),
}

impl WrittenText {
    /// On one line, for messages.
    pub fn shown(&self) -> String {
        match self {
            Self::Scalar(text) => shown(text),
            Self::List(items) => {
                let items: Vec<&str> = items.iter().map(|(text, _)| &**text).collect();
                shown(&format!("[{}]", items.join(", ")))
            }
        }
    }
}

impl Found {
    /// The same with the name of its kind.
    #[must_use]
    pub fn code(mut self, code: &'static str) -> Self {
        self.problem.facts.code = code;
        self
    }

    /// The same with what to write instead.
    #[must_use]
    pub fn suggest(mut self, path: &str, value: &str) -> Self {
        self.problem.facts.suggestion = Some(Suggestion { path: path.into(), value: value.into() });
        self
    }
}
