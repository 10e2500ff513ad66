//! `fabkit completions SHELL`

use clap_complete::env::Shells;
use serde_json::json;

use super::Outcome;
use crate::failure::Failure;

pub(super) fn run(shell: clap_complete::Shell) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    // The script calls the command for each completion, so that it knows the current files, sensors and parts.
    let name = shell.to_string();
    let shells = Shells::builtins();
    let completer =
        shells.completer(&name).ok_or_else(|| Failure::bug("a shell without script"))?;
    let written =
        completer.write_registration("COMPLETE", "fabkit", "fabkit", "fabkit", &mut script);
    written.map_err(Failure::bug)?;
    let text = String::from_utf8(script).map_err(Failure::bug)?;
    let json = json!({
        "format": "fabkit-completions",
        "version": 1,
        "shell": name,
        "script": text,
    });
    Ok(Outcome { text, json, failed: false })
}
