//! `cargo xtask variants`

use std::path::Path;
use std::process::Command;

use crate::run::{check, fabkit, root};

const USAGE: &str = "usage: cargo xtask variants N [--seed S], with N at least 1";

/// Makes random variants of every sensor and fixture, and lets trimesh check every file.
pub fn run(arguments: &[String]) -> Result<(), String> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (count, seed) = match *words {
        [count] => (count, "1"),
        [count, "--seed", seed] | ["--seed", seed, count] => (count, seed),
        _ => return Err(USAGE.into()),
    };
    let count: usize = count.parse().ok().filter(|count| *count > 0).ok_or(USAGE)?;
    let seed: u64 = seed.parse().map_err(|_| USAGE)?;
    let python = crate::python::environment()?;
    check(&mut judge(&python, &fabkit()?, count, seed))
}

/// Makes the command that checks variants, with an existing environment and binary.
pub fn judge(python: &Path, fabkit: &Path, count: usize, seed: u64) -> Command {
    let mut command = Command::new(python);
    command.arg(root().join("xtask/variants/run.py")).arg(fabkit);
    command.args([count.to_string(), seed.to_string()]);
    command
}
