//! What is wrong with a file.

use std::fmt;

use crate::facts::Facts;

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
