//! `fabkit completions SHELL`

use clap::CommandFactory;
use serde_json::json;

use super::Outcome;
use crate::cli::Cli;
use crate::failure::Failure;

pub(super) fn run(shell: clap_complete::Shell) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "fabkit", &mut script);
    let text = String::from_utf8(script).map_err(Failure::bug)?;
    let json = json!({
        "format": "fabkit-completions",
        "version": 1,
        "shell": shell.to_string(),
        "script": text,
    });
    Ok(Outcome { text, json, failed: false })
}
