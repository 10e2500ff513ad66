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

/// Maximum number of problems that are listed: two screens of text. Whoever has more has the wrong file, or made one
/// mistake many times.
pub const MAX_PROBLEMS: usize = 20;

/// The problems of a design: the first [`MAX_PROBLEMS`], and the number of the others.
///
/// Only [`InvalidDesign::new`] makes one, so that no text can make fabkit print, or keep, problems without end.
///
/// ```
/// use fabkit_text::{InvalidDesign, YamlFault};
///
/// let fault = YamlFault::new(None, "", "the file is empty").in_file("my.yaml");
/// let mut invalid = InvalidDesign::new(vec![fault.clone(); 25]);
/// assert_eq!((invalid.problems.len(), invalid.unlisted()), (20, 5));
/// invalid.extend([fault]);
/// assert_eq!(invalid.to_string(), "26 problem(s) in the design");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct InvalidDesign {
    /// The first problems, at least one, in the order of the file.
    pub problems: Vec<Problem>,
    /// Number of the others.
    unlisted: usize,
}

impl InvalidDesign {
    /// Keeps the first problems and counts the others.
    pub fn new(problems: Vec<Problem>) -> Self {
        let mut invalid = Self { problems: Vec::new(), unlisted: 0 };
        invalid.extend(problems);
        invalid
    }

    /// Adds problems behind the present ones, or counts them.
    pub fn extend(&mut self, problems: impl IntoIterator<Item = Problem>) {
        for problem in problems {
            if self.problems.len() < MAX_PROBLEMS {
                self.problems.push(problem);
            } else {
                self.unlisted += 1;
            }
        }
    }

    /// Returns the number of problems that are not listed.
    pub fn unlisted(&self) -> usize {
        self.unlisted
    }
}

impl fmt::Display for InvalidDesign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} problem(s) in the design", self.problems.len() + self.unlisted)
    }
}

/// Joins the problems of a document that has no lines to show: the first [`MAX_PROBLEMS`], and the number of the others.
///
/// ```
/// use fabkit_text::list_problems;
///
/// assert_eq!(list_problems(&["no rows".into(), "no pitch".into()], "; "), "no rows; no pitch");
/// assert!(list_problems(&vec!["no rows".into(); 23], "; ").ends_with("; no rows; and 3 more"));
/// ```
pub fn list_problems(problems: &[String], separator: &str) -> String {
    let shown = &problems[..problems.len().min(MAX_PROBLEMS)];
    match problems.len() - shown.len() {
        0 => shown.join(separator),
        more => format!("{}{separator}and {more} more", shown.join(separator)),
    }
}
