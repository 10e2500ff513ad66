//! Development tasks: `cargo xtask test`, `cargo xtask lint`, `cargo xtask bench-peers`.

mod bench_peers;
mod lint;
mod python;
mod run;
mod test;

use std::env;
use std::process::ExitCode;

const HELP: &str = "\
Usage: cargo xtask TASK

Tasks:
  test   Set up what tests need and run them all: outside oracles, unit, end-to-end and doc tests
  lint   Formatting, clippy and documentation without warnings, licences and sources of dependencies
  bench-peers  Time fabkit beside its peers, print the ratios and write docs/benchmarks.md
";

fn main() -> ExitCode {
    let task = env::args().nth(1).unwrap_or_default();
    let result = match task.as_str() {
        "test" => test::run(),
        "lint" => lint::run(),
        "bench-peers" => bench_peers::run(),
        "" | "-h" | "--help" | "help" => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        other => Err(format!("there is no task `{other}`\n\n{HELP}")),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}
