//! `cargo xtask style [FOLDER...]`: counts of habits that make code hard to read for newcomers, of this repository or of
//! others to compare with.
//!
//! The counts come from the text alone, line by line, so that they mean the same for any Rust code. They are aids for
//! reviewers, not limits.

use std::fs;
use std::path::{Path, PathBuf};

use crate::run::root;

/// Bad first words of doc comments: they state a relation instead of naming the item.
const RIDDLES: [&str; 7] = ["What", "How", "Where", "Of", "As", "By", "Which"];

/// Skipped folders, with foreign or generated code.
const SKIPPED: [&str; 4] = ["target", "node_modules", ".git", ".venv"];

#[derive(Debug, Default, PartialEq, Eq)]
struct Counts {
    lines: usize,
    comments: usize,
    docs: usize,
    riddles: usize,
    bool_matches: usize,
    closures: usize,
    called_once: usize,
    named_of: usize,
    examples: usize,
}

/// Prints one line for each folder, or for this repository.
pub fn run(folders: &[String]) -> Result<(), String> {
    let folders: Vec<PathBuf> = match folders {
        [] => vec![root().to_owned()],
        _ => folders.iter().map(PathBuf::from).collect(),
    };
    println!(
        "{:>7} {:>9} {:>8} {:>10} {:>9} {:>11} {:>5} {:>8}  folder",
        "lines", "comments", "riddles", "bool match", "closures", "called once", "`of`", "examples"
    );
    for folder in folders {
        let mut counts = Counts::default();
        for file in rust_files(&folder)? {
            let text = fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
            add(&mut counts, &text);
        }
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole.max(1) as f64;
        println!(
            "{:>7} {:>7.1} % {:>6.1} % {:>10} {:>9} {:>11} {:>5} {:>8}  {}",
            counts.lines,
            share(counts.comments, counts.lines),
            share(counts.riddles, counts.docs),
            counts.bool_matches,
            counts.closures,
            counts.called_once,
            counts.named_of,
            counts.examples,
            folder.display(),
        );
    }
    Ok(())
}

/// Lists the Rust files below a folder, sorted.
fn rust_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && !SKIPPED.contains(&name.as_str()) {
            found.extend(rust_files(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn add(counts: &mut Counts, text: &str) {
    let (mut is_doc_before, mut is_in_block) = (false, false);
    // Names of closures in the current function, which ends at a closing brace with little indentation.
    let mut bound: Vec<(String, usize)> = Vec::new();
    for line in text.lines() {
        let line_text = line.trim();
        if let Some(doc) = line_text.strip_prefix("///").or_else(|| line_text.strip_prefix("//!")) {
            let doc = doc.trim();
            if !is_doc_before {
                counts.docs += 1;
                let first = doc.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
                counts.riddles += usize::from(RIDDLES.contains(&first));
            }
            if doc.starts_with("```") {
                counts.examples += usize::from(!is_in_block && is_example(doc));
                is_in_block = !is_in_block;
            }
            is_doc_before = true;
            continue;
        }
        is_doc_before = false;
        if line_text.is_empty() {
            continue;
        }
        if line_text.starts_with("//") {
            counts.comments += 1;
            continue;
        }
        counts.lines += 1;
        counts.bool_matches += usize::from(line_text.starts_with("true =>"));
        counts.named_of += usize::from(line_text.contains("fn of("));
        for (name, calls) in &mut bound {
            *calls += line_text.matches(&format!("{name}(")).count();
        }
        if let Some(name) = bound_closure(line_text) {
            counts.closures += 1;
            bound.push((name, 0));
        }
        let indentation = line.len() - line.trim_start().len();
        if line_text == "}" && indentation <= 4 {
            counts.called_once += bound.iter().filter(|(_, calls)| *calls == 1).count();
            bound.clear();
        }
    }
}

/// Returns whether a line of a doc comment opens a code block that is compiled as a test.
fn is_example(doc: &str) -> bool {
    ["```", "```rust", "```no_run", "```should_panic"].contains(&doc)
}

/// Returns the name in `let name = |..|` or `let name = move |..|`.
fn bound_closure(line: &str) -> Option<String> {
    let (name, value) = line.strip_prefix("let ")?.split_once(" = ")?;
    let value = value.strip_prefix("move ").unwrap_or(value);
    let is_plain = name.chars().all(|c| c.is_alphanumeric() || c == '_');
    (value.starts_with('|') && is_plain).then(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn habits_are_counted() {
        let text = "\
/// What it does.
/// More of it.
fn of(is_big: bool) -> u32 {
    // Why.
    let twice = |x: u32| 2 * x;
    match is_big {
        true => twice(4),
        false => 0,
    }
}

/// Returns nothing.
///
/// ```
/// nothing();
/// ```
fn nothing() {}
";
        let mut counts = Counts::default();
        add(&mut counts, text);
        let expected = Counts {
            lines: 8,
            comments: 1,
            docs: 2,
            riddles: 1,
            bool_matches: 1,
            closures: 1,
            called_once: 1,
            named_of: 1,
            examples: 1,
        };
        assert_eq!(counts, expected);
    }
}
