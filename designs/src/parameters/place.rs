//! Where values stand, what was written there, and what is wrong with it.

use std::sync::Arc;

use super::tree::{Fault, Position};
use super::{Problem, Source, shown};

/// Which text a value comes from; also the order in which problems are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Layer {
    /// The file that was asked for.
    File,
    /// `--set`.
    Override,
    /// The built-in sensor that the file extends.
    Base,
}

/// Where something stands.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub layer: Layer,
    pub file: Arc<str>,
    pub position: Option<Position>,
}

impl Place {
    pub fn at(&self, position: Position) -> Self {
        Self { position: Some(position), ..self.clone() }
    }

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
            },
        }
    }
}

/// A problem and what is needed to put it in order.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub layer: Layer,
    pub problem: Problem,
}

impl Found {
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.problem.hint = Some(hint.into());
        self
    }

    pub fn fault(fault: Fault, place: &Place) -> Self {
        let place = Place { position: fault.position, ..place.clone() };
        let found = place.problem(&fault.path, &fault.written, fault.message);
        Self { problem: Problem { hint: fault.hint, ..found.problem }, ..found }
    }

    /// In the order of the file, then `--set`, then what the file extends.
    pub fn sorted(mut found: Vec<Self>) -> Vec<Problem> {
        found.sort_by_key(|f| (f.layer, f.problem.line, f.problem.column));
        found.into_iter().map(|f| f.problem).collect()
    }
}

/// A value as written.
#[derive(Clone, Debug)]
pub(crate) struct Written {
    pub place: Place,
    pub text: WrittenText,
    pub source: Source,
}

#[derive(Clone, Debug)]
pub(crate) enum WrittenText {
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
