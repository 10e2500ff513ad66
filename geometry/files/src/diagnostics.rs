//! Listing of a design's problems, each with its source line, in the layout of rustc.

use std::fmt::Write as _;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use fabkit_text::{InvalidDesign, Problem};

use crate::{ErrorKind, ErrorSubject, Explained};

/// Width of the output, columns. Longer source lines are cut around the marked place.
const LINE_COLUMNS: usize = 100;

/// Text of one file that problems point into.
#[derive(Clone, Debug)]
pub struct SourceText {
    /// File name as used in the problems.
    pub file: String,
    /// Content of the file.
    pub text: String,
}

/// Problems together with the texts that they point into.
///
/// ```
/// use fabkit_files::diagnostics::{DiagnosedDesign, SourceText};
/// use fabkit_files::{Error, ErrorKind};
/// use fabkit_text::{InvalidDesign, YamlFault};
///
/// let fault = YamlFault::new(None, "", "the file is empty").in_file("my.yaml");
/// let source = SourceText { file: "my.yaml".into(), text: String::new() };
/// let design = DiagnosedDesign::new(InvalidDesign::new(vec![fault]), [source]);
/// let error = Error::from(design);
/// assert_eq!(error.kind(), ErrorKind::BadInput);
/// assert_eq!(error.to_string(), "1 problem(s) in the design");
/// assert!(error.downcast_ref::<DiagnosedDesign>().is_some_and(|design| design.texts.len() == 1));
/// ```
#[derive(Debug, thiserror::Error)]
#[error("{invalid}")]
pub struct DiagnosedDesign {
    /// The problems.
    pub invalid: InvalidDesign,
    /// Texts that the problems may point into.
    pub texts: Vec<SourceText>,
}

impl DiagnosedDesign {
    /// Creates the error of one text, or of several that refer to each other.
    pub fn new(invalid: InvalidDesign, texts: impl IntoIterator<Item = SourceText>) -> Self {
        Self { invalid, texts: texts.into_iter().collect() }
    }
}

impl Explained for DiagnosedDesign {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("invalid")
    }
}

/// Formats the problems and their count, with a final newline. `sources` are the files that they may be in.
/// `unlisted` is the number of further problems, which are only counted.
///
/// ```
/// use fabkit_files::diagnostics::{SourceText, format_problems};
/// use fabkit_text::{Position, YamlFault};
///
/// let at = Position { line: 2, column: 11 };
/// let mut problem =
///     YamlFault::new(at, "surface.radius", "the radius is too large").in_file("my.yaml");
/// problem.value = "900 mm".into();
/// let text = "surface:\n  radius: 900 mm\n".to_owned();
/// let shown = format_problems(&[problem], 0, &[SourceText { file: "my.yaml".into(), text }]);
/// let lines: Vec<&str> = shown.lines().collect();
/// assert_eq!(lines[..2], ["error: the radius is too large", " --> my.yaml:2:11"]);
/// assert_eq!(lines[2..], ["2 |   radius: 900 mm", "  |           ^^^^^^"]);
/// ```
pub fn format_problems(problems: &[Problem], unlisted: usize, sources: &[SourceText]) -> String {
    let mut out = String::new();
    for problem in problems {
        format_problem(&mut out, problem, sources);
        if problems.len() > 1 {
            out.push('\n');
        }
    }
    let all = problems.len() + unlisted;
    if unlisted > 0 {
        let shown = problems.len();
        let _ = writeln!(out, "{all} problems, of which the first {shown} are shown");
    } else if all > 1 {
        let _ = writeln!(out, "{all} problems");
    }
    out
}

/// Formats one problem. Writing to a `String` cannot fail, so results are dropped.
fn format_problem(out: &mut String, problem: &Problem, sources: &[SourceText]) {
    let message = printable(&problem.message);
    let hint = problem.hint.as_deref().map(printable);
    if let Some((text, place)) = excerpt(problem, sources) {
        let annotation = AnnotationKind::Primary.span(place);
        let snippet = Snippet::source(text).path(printable(&problem.file));
        let snippet = snippet.line_start(problem.line.unwrap_or(1)).annotation(annotation);
        let group = Group::with_title(Level::ERROR.primary_title(message)).element(snippet);
        let group = group.elements(hint.map(|hint| Level::HELP.message(hint)));
        let image = Renderer::plain().term_width(LINE_COLUMNS).render(&[group]);
        // Lines with nothing but the gutter's bar only make a single fault fill a screen.
        for line in image.lines().filter(|line| line.trim() != "|") {
            let _ = writeln!(out, "{line}");
        }
        return;
    }
    let _ = writeln!(out, "error: {message}");
    let digits = problem.line.map_or(1, |line| line.to_string().len());
    if !problem.file.is_empty() {
        let file = printable(&problem.file);
        let line = problem.line.map(|line| format!(":{line}")).unwrap_or_default();
        let column = problem.column.map(|column| format!(":{column}")).unwrap_or_default();
        let indent = problem.line.map_or(2, |_| digits);
        let _ = writeln!(out, "{:indent$}--> {file}{line}{column}", "");
    }
    if let Some(hint) = hint {
        let _ = writeln!(out, "{:digits$} = help: {hint}", "");
    }
}

/// Returns the line of a problem and the byte range to mark: the whole value if it stands at the position, otherwise
/// one character.
fn excerpt<'a>(problem: &Problem, sources: &'a [SourceText]) -> Option<(&'a str, Range<usize>)> {
    let source = sources.iter().find(|source| source.file == problem.file)?;
    let line = source.text.lines().nth(problem.line?.saturating_sub(1))?;
    // Columns count characters, spans count bytes.
    let column = problem.column.unwrap_or(1).saturating_sub(1);
    let start = line.char_indices().nth(column).map_or(line.len(), |(byte, _)| byte);
    let rest = &line[start..];
    // The recorded value may have been shortened; then only its first character is marked.
    let stands_there = !problem.value.is_empty() && rest.starts_with(&problem.value);
    let first = rest.chars().next().map_or(0, char::len_utf8);
    Some((line, start..start + if stands_there { problem.value.len() } else { first }))
}

/// Replaces control characters, so that the content of a foreign file cannot steer the terminal.
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
    use fabkit_text::ProblemFacts;

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
            facts: ProblemFacts::default(),
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
2 |   radius: 900 mm
  |           ^^^^^^
  = help: 60 mm is the largest
";
        assert_eq!(format_problems(&[problem(Some(2), Some(11), "900 mm")], 0, &text), expected);
    }

    #[test]
    fn missing_positions_are_omitted() {
        let text = source("a: 1\n");
        let shown =
            format_problems(&[problem(None, None, ""), problem(Some(99), Some(99), "x")], 0, &text);
        assert!(shown.contains("  --> my.yaml\n"));
        assert!(shown.contains("--> my.yaml:99:99\n"));
        assert!(shown.ends_with("\n2 problems\n"));
        assert!(!shown.contains('^'));
    }

    #[test]
    fn a_long_line_is_cut_and_control_characters_do_not_reach_the_terminal() {
        let long = format!("{}\u{1b}[31m900 mm{}", " ".repeat(1000), "x".repeat(100_000));
        let shown = format_problems(&[problem(Some(1), Some(1006), "900 mm")], 0, &source(&long));
        assert!(shown.len() < 600 && !shown.contains('\u{1b}'), "{shown}");
        let lines: Vec<&str> = shown.lines().collect();
        // `900 mm` stands right above its carets.
        let at = lines[3].find('^').unwrap();
        let above: String = lines[2].chars().skip(at).take(6).collect();
        assert_eq!(above, "900 mm");
    }

    #[test]
    fn carets_account_for_wide_characters() {
        let shown =
            format_problems(&[problem(Some(1), Some(7), "900 mm")], 0, &source("注意, x:900 mm\n"));
        let lines: Vec<&str> = shown.lines().collect();
        // Behind the gutter of four columns come four for two characters, and four more.
        assert_eq!(lines[3].find('^'), Some(4 + 4 + 4), "{shown}");
    }
}
