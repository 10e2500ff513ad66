//! Problems of a file.

use std::fmt;

use crate::facts::ProblemFacts;

/// One problem of a design.
///
/// ```
/// use fabkit_text::{Problem, ProblemFacts};
///
/// let problem = Problem {
///     file: "washer.yaml".into(),
///     line: Some(2),
///     column: Some(9),
///     path: "radius".into(),
///     value: "90 mm".into(),
///     message: "radius is 90 mm; it must be between 1 mm and 20 mm".into(),
///     hint: None,
///     facts: ProblemFacts::new("out_of_range"),
/// };
/// assert_eq!(problem.to_string(), format!("washer.yaml:2:9: {}", problem.message));
/// let nowhere = Problem { file: "--set".into(), line: None, column: None, ..problem };
/// assert_eq!(nowhere.to_string(), format!("--set: {}", nowhere.message));
/// ```
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
