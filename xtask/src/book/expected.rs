//! Commands with the output shown below them on a page.

/// Command of a `console` block.
#[derive(Debug, PartialEq)]
pub struct Step {
    /// Line in the block, from 0.
    pub line: usize,
    /// Command for the shell.
    pub command: String,
    /// Lines of output shown; empty if none is shown.
    pub shown: Vec<String>,
}

/// Parses a `console` block: commands after `$ `, continued after a backslash, and their output.
///
/// # Errors
/// Output before the first command.
pub fn steps(text: &str) -> Result<Vec<Step>, String> {
    let mut steps: Vec<Step> = Vec::new();
    let mut continues = false;
    for (line, content) in text.lines().enumerate() {
        match (content.strip_prefix("$ "), steps.last_mut()) {
            (Some(command), _) => {
                steps.push(Step { line, command: command.to_owned(), shown: Vec::new() });
            }
            (None, Some(step)) if continues => step.command += &format!("\n{content}"),
            (None, Some(step)) => step.shown.push(content.trim_end().to_owned()),
            (None, None) => return Err(format!("`{content}` is the output of no command")),
        }
        continues = content.ends_with('\\') && steps.last().is_some_and(|s| s.shown.is_empty());
    }
    Ok(steps)
}

/// Compares output with the lines shown, where a line `...` stands for any lines, and `...` within a line for any text.
/// The error names the first line that the output lacks.
pub fn compare(shown: &[String], output: &str) -> Result<(), String> {
    let output: Vec<&str> = output.trim_end().lines().map(str::trim_end).collect();
    match find_unmatched(shown, &output) {
        None => Ok(()),
        Some("") => Err("there is more output than is shown".into()),
        Some(line) => Err(format!("the output lacks `{line}`")),
    }
}

/// Returns `None` if all lines match; otherwise the first line that cannot be matched in any way, or an empty text for
/// surplus output.
fn find_unmatched<'a>(shown: &'a [String], output: &[&str]) -> Option<&'a str> {
    // All positions in the output that the lines so far may reach, as in a simulation of a nondeterministic automaton.
    let mut reached = vec![0];
    for line in shown {
        let next: Vec<usize> = if line == "..." {
            (reached.first().copied().unwrap_or_default()..=output.len()).collect()
        } else {
            let matching =
                |&&at: &&usize| output.get(at).is_some_and(|have| matches_line(line, have));
            reached.iter().filter(matching).map(|at| at + 1).collect()
        };
        if next.is_empty() {
            return Some(line);
        }
        reached = next;
    }
    (!reached.contains(&output.len())).then_some("")
}

/// Returns whether a line matches a shown one, in which `...` stands for any text.
fn matches_line(shown: &str, have: &str) -> bool {
    let mut parts = shown.split("...");
    let Some(mut rest) = parts.next().and_then(|first| have.strip_prefix(first)) else {
        return false;
    };
    // Parts in the middle are matched greedily from the left; only the last one must reach the end.
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_told_from_output() {
        let steps = steps("$ a\n1\n\n2\n$ b \\\n  c\n3\n").unwrap();
        assert_eq!(steps[0].shown, ["1", "", "2"]);
        assert_eq!((steps[1].line, steps[1].command.as_str()), (4, "b \\\n  c"));
        assert_eq!(steps[1].shown, ["3"]);
        assert!(super::steps("1\n").is_err());
    }

    #[test]
    fn gaps_match_anything_and_nothing_else_does() {
        let matches = |shown: &str, output: &str| {
            let shown: Vec<String> = shown.lines().map(str::to_owned).collect();
            compare(&shown, output)
        };
        assert_eq!(matches("a\n...\nc", "a\nb\nb\nc\n"), Ok(()));
        assert_eq!(matches("a\n...\nc", "a\nc\n"), Ok(()));
        assert_eq!(matches("...\nc\nd", "c\nx\nc\nd\n"), Ok(()));
        assert_eq!(matches("took ... s (...)", "took 0.1 s (ok)"), Ok(()));
        assert_eq!(matches("...", ""), Ok(()));
        assert_eq!(matches("a\nb", "a"), Err("the output lacks `b`".into()));
        assert_eq!(matches("a", "a\nb"), Err("there is more output than is shown".into()));
        assert!(matches("took ... s", "took 0.1 ms").is_err());
        assert!(matches("ab...ba", "aba").is_err());
    }
}
