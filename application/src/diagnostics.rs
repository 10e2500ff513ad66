//! Problems of a design, each with the line it is about, in the layout that rustc made familiar.

use std::fmt::Write as _;

use fabkit_text::{InvalidDesign, Problem};

use crate::{ErrorKind, Explained};

/// Longer lines are cut around the place in question.
const MAX_LINE_CHARS: usize = 96;

/// The text that problems of one file point into.
#[derive(Clone, Debug)]
pub struct SourceText {
    /// As problems name it.
    pub file: String,
    /// What it says.
    pub text: String,
}

/// Texts with problems, and what they say.
#[derive(Debug, thiserror::Error)]
#[error("{invalid}")]
pub struct Diagnosed {
    /// What is wrong.
    pub invalid: InvalidDesign,
    /// The texts that problems may lie in.
    pub texts: Vec<SourceText>,
}

impl Diagnosed {
    /// What is wrong with one text, or with those that it refers to.
    pub fn new(invalid: InvalidDesign, texts: impl IntoIterator<Item = SourceText>) -> Self {
        Self { invalid, texts: texts.into_iter().collect() }
    }
}

impl Explained for Diagnosed {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }
}

/// All problems and their number, with a final newline. `sources` are the files they may be in.
pub fn list(problems: &[Problem], sources: &[SourceText]) -> String {
    let mut out = String::new();
    for problem in problems {
        one(&mut out, problem, sources);
        out.push('\n');
    }
    let count = problems.len();
    let _ = writeln!(out, "{count} problem{}", if count == 1 { "" } else { "s" });
    out
}

/// Writing to a `String` cannot fail, so results are dropped.
fn one(out: &mut String, problem: &Problem, sources: &[SourceText]) {
    let _ = writeln!(out, "error: {}", printable(&problem.message));
    let mut gutter = 2;
    match (problem.line, problem.column) {
        (Some(line), column) => {
            gutter = line.to_string().len() + 1;
            let column_text = column.map(|c| format!(":{c}")).unwrap_or_default();
            let arrow = format!("{:>gutter$}", "-->", gutter = gutter + 2);
            let _ = writeln!(out, "{arrow} {}:{line}{column_text}", printable(&problem.file));
            let source = sources.iter().find(|source| source.file == problem.file);
            if let Some(text) = source.and_then(|s| s.text.lines().nth(line.saturating_sub(1))) {
                let (excerpt, caret_at) = excerpt(text, column.unwrap_or(1).saturating_sub(1));
                let carets = "^".repeat(caret_width(text, column, &problem.value));
                let _ = writeln!(out, "{:gutter$}|", "");
                let _ = writeln!(out, "{line} | {excerpt}");
                let _ = writeln!(out, "{:gutter$}| {:caret_at$}{carets}", "", "");
            }
        }
        (None, _) if !problem.file.is_empty() => {
            let _ = writeln!(out, "  --> {}", printable(&problem.file));
        }
        _ => {}
    }
    if let Some(hint) = &problem.hint {
        let _ = writeln!(out, "{:gutter$}= help: {}", "", printable(hint));
    }
}

/// The whole value if that is what stands there, else one character.
fn caret_width(line: &str, column: Option<usize>, value: &str) -> usize {
    let from: String = line.chars().skip(column.unwrap_or(1).saturating_sub(1)).collect();
    let stands_there = !value.is_empty() && from.starts_with(value);
    if stands_there { value.chars().count().min(MAX_LINE_CHARS / 2) } else { 1 }
}

/// The line, cut to a readable length around a character, and where in it that character is.
fn excerpt(line: &str, at: usize) -> (String, usize) {
    let chars: Vec<char> = line.chars().collect();
    let start =
        if chars.len() <= MAX_LINE_CHARS { 0 } else { at.saturating_sub(MAX_LINE_CHARS / 2) };
    let end = chars.len().min(start + MAX_LINE_CHARS);
    let start = start.min(end);
    (printable(&chars[start..end].iter().collect::<String>()), at.saturating_sub(start))
}

/// Files are other people's: what would steer a terminal is not passed on to it.
fn printable(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '\t' => ' ',
            '\n' => '\n',
            c if c.is_control() => char::REPLACEMENT_CHARACTER,
            c => c,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(line: Option<usize>, column: Option<usize>, value: &str) -> Problem {
        Problem {
            file: "my.yaml".into(),
            line,
            column,
            path: "surface.radius".into(),
            value: value.into(),
            message: "surface.radius is 900 mm; it must be between 4 mm and 60 mm".into(),
            hint: Some("60 mm is the largest".into()),
        }
    }

    fn source(text: &str) -> [SourceText; 1] {
        [SourceText { file: "my.yaml".into(), text: text.into() }]
    }

    #[test]
    fn a_problem_points_at_its_value() {
        let text = source("surface:\n  radius: 900 mm\n");
        let expected = "\
error: surface.radius is 900 mm; it must be between 4 mm and 60 mm
 --> my.yaml:2:11
  |
2 |   radius: 900 mm
  |           ^^^^^^
  = help: 60 mm is the largest

1 problem
";
        assert_eq!(list(&[problem(Some(2), Some(11), "900 mm")], &text), expected);
    }

    #[test]
    fn places_that_are_not_there_are_left_out() {
        let text = source("a: 1\n");
        let shown = list(&[problem(None, None, ""), problem(Some(99), Some(99), "x")], &text);
        assert!(shown.contains("  --> my.yaml\n"));
        assert!(shown.contains("--> my.yaml:99:99\n"));
        assert!(shown.ends_with("\n2 problems\n"));
        assert!(!shown.contains('^'));
    }

    #[test]
    fn a_long_line_is_cut_and_control_characters_do_not_reach_the_terminal() {
        let long = format!("{}\u{1b}[31m900 mm{}", " ".repeat(1000), "x".repeat(100_000));
        let shown = list(&[problem(Some(1), Some(1006), "900 mm")], &source(&long));
        assert!(shown.len() < 600 && !shown.contains('\u{1b}'), "{shown}");
        let lines: Vec<&str> = shown.lines().collect();
        // `900 mm` stands right above its carets.
        let at = lines[4].find('^').unwrap();
        let above: String = lines[3].chars().skip(at).take(6).collect();
        assert_eq!(above, "900 mm");
    }
}
