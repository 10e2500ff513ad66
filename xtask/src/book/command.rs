//! Reference of the command, generated from its help.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{GENERATED, Output};

/// Width of the help texts: narrower than a page, so that nothing scrolls.
const COLUMNS: &str = "88";

/// Makes one page with the help of every command.
///
/// # Errors
/// A command that does not print its help.
pub fn page(fabkit: &Path) -> Result<Output, String> {
    let mut text = format!("# The command\n\n{GENERATED}\n");
    describe(fabkit, &[], &mut text)?;
    Ok(Output { path: PathBuf::from("reference/command.md"), text })
}

/// Appends the help of a command, then of its subcommands.
fn describe(fabkit: &Path, words: &[&str], text: &mut String) -> Result<(), String> {
    let name = [&["fabkit"], words].concat().join(" ");
    let help =
        super::run_output(Command::new(fabkit).args(words).arg("--help").env("COLUMNS", COLUMNS))?;
    // Writing to a string cannot fail.
    let _ = write!(text, "\n## {name}\n\n```text\n{}\n```\n", help.trim_end());
    for command in commands(&help) {
        describe(fabkit, &[words, &[command]].concat(), text)?;
    }
    Ok(())
}

/// Lists the names below `Commands:`, without `help`.
fn commands(help: &str) -> impl Iterator<Item = &str> {
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    list.take_while(|line| !line.is_empty())
        // Continued descriptions have a deeper indentation.
        .filter_map(|line| line.strip_prefix("  ").filter(|name| !name.starts_with(' ')))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_listed_without_their_descriptions() {
        let help =
            "Usage\n\nCommands:\n  list  Lists\n        all\n  help  Helps\n\nOptions:\n  -h\n";
        assert_eq!(commands(help).collect::<Vec<_>>(), ["list"]);
        assert_eq!(commands("Usage\n").count(), 0);
    }
}
