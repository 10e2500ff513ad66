//! Problems of a file.

use std::fmt;

use crate::facts::ProblemFacts;

/// One problem of a design.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// File name, or `--set`.
    pub file: String,
    /// Line, from 1, if known.
    pub line: Option<usize>,
    /// Column, from 1, if known.
    pub column: Option<usize>,
    /// Dotted path of the parameter; empty for the whole document.
    pub path: String,
    /// Value as written; empty if there is none.
    pub value: String,
    /// Description of the problem, with the limit.
    pub message: String,
    /// Suggested correction.
    pub hint: Option<String>,
    /// Machine-readable part.
    pub facts: ProblemFacts,
}

impl fmt::Display for Problem {
    /// Writes `file:line:column: message`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        for count in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{count}")?;
        }
        write!(f, ": {}", self.message)
    }
}

/// All problems of a design.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct InvalidDesign {
    /// Problems, at least one, in the order of the file.
    pub problems: Vec<Problem>,
}

impl fmt::Display for InvalidDesign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} problem(s) in the design", self.problems.len())
    }
}
