//! `cargo xtask fuzz`

use std::process::Command;

use crate::run::{build_program, check, fabkit, root};

/// Time in the gate, s; together with starting all processes, it stays well below a minute.
const SECONDS: &str = "20";
/// More runs than that time allows.
const MAX_RUNS: &str = "1000000";
/// Default seed: the gate uses the same inputs each time; other seeds give other inputs.
const SEED: &str = "1";

/// Feeds nearly valid files to everything that reads files, and to the command.
///
/// Options: `--seconds S`, `--runs N`, `--seed K`, then names of targets: for example `camera`, or `command` for the
/// command itself.
pub fn run(arguments: impl Iterator<Item = String>) -> Result<(), String> {
    let (mut seconds, mut runs, mut seed) =
        (SECONDS.to_owned(), MAX_RUNS.to_owned(), SEED.to_owned());
    let mut names = Vec::new();
    let mut arguments = arguments.peekable();
    while let Some(word) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{word} needs a number"));
        match word.as_str() {
            // The number of runs alone decides, however long they take.
            "--runs" => (runs, seconds) = (value()?, "86400".into()),
            "--seconds" => seconds = value()?,
            "--seed" => seed = value()?,
            _ => names.push(word),
        }
    }
    if !cfg!(target_os = "linux") {
        return crate::run::skip("fuzzing", "memory is limited by what Linux has for it");
    }
    let mut fuzz = Command::new(build_program("fabkit-fuzz-targets", "fabkit-fuzz")?);
    fuzz.arg(root().join("tests/fuzz/corpus")).arg(root().join("target/fuzz")).arg(fabkit()?);
    check(fuzz.args([runs, seconds, seed]).args(names))
}
