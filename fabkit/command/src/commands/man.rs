//! `fabkit man`

use std::path::Path;

use clap::{Command, CommandFactory};
use fabkit_application::staging::{OutputFile, write_all};
use serde_json::json;

use super::Outcome;
use crate::cli::Cli;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;

pub(super) fn run(output: Option<&Path>) -> Result<Outcome, Failure> {
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    let mut pages = vec![page(&command)?];
    for subcommand in command.get_subcommands() {
        pages.push(page(subcommand)?);
    }
    let names: Vec<&str> = pages.iter().map(|page| page.name.as_str()).collect();
    let json = json!({ "format": "fabkit-man", "version": 1, "pages": names });
    let text = match output {
        None => String::from_utf8(pages.swap_remove(0).bytes).map_err(Failure::bug)?,
        Some(folder) => {
            interrupt::begin_writing()?;
            write_all(folder, &pages, &interrupt::is_requested)?;
            format!("{} pages in {}\n", pages.len(), folder.display())
        }
    };
    Ok(Outcome { text, json, failed: false })
}

fn page(command: &Command) -> Result<OutputFile, Failure> {
    // Without a date, the page of one version is the same on every day.
    let man = clap_mangen::Man::new(command.clone()).date("");
    let mut bytes = Vec::new();
    man.render(&mut bytes).map_err(|e| Failure::plain(ErrorKind::Bug, e))?;
    // Display name set by `build`, for example `fabkit-export`.
    let name = command.get_display_name().unwrap_or(command.get_name());
    Ok(OutputFile { name: format!("{name}.1"), bytes })
}
