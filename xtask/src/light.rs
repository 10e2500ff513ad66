//! `cargo xtask light`: independent ray tracing through the drawn bodies, for comparison.

use std::path::Path;
use std::process::Command;

use crate::python::{environment, interpreter, uv};
use crate::run::{build_workspace, built_path, check, exists, fabkit, root};
use crate::samples::Samples;

/// Pixels of each sensor in `cargo xtask test`: half a minute in all, most of it for depth maps.
const SAMPLE: usize = 500;
/// Pixels of each sensor in full.
const ALL: usize = 50_000;

const REQUIREMENTS: &str = "tests/oracles/requirements-mitsuba.txt";

/// Compares all pixels, of all sensors or of the named ones; with `--mitsuba`, Mitsuba's part of them.
pub fn run(args: &[String]) -> Result<(), String> {
    build_workspace()?;
    let fabkit = fabkit()?;
    if args.first().is_some_and(|arg| arg == "--mitsuba") {
        return check(
            Command::new(mitsuba()?)
                .arg(root().join("tests/oracles/check_mitsuba.py"))
                .arg(&fabkit)
                .args(&args[1..]),
        );
    }
    check(script(&environment()?, &fabkit).args(args))
}

/// Makes the command that compares a sample of each sensor's pixels.
pub fn sample(python: &Path, fabkit: &Path, samples: Samples) -> Command {
    let mut script = script(python, fabkit);
    script.args(["--sample", &samples.count(ALL, SAMPLE).to_string()]);
    script
}

fn script(python: &Path, fabkit: &Path) -> Command {
    let mut command = Command::new(python);
    command.arg(root().join("tests/oracles/check_light.py")).arg(fabkit);
    command
}

/// Returns the interpreter of Mitsuba's environment, which is created on first use: few need it.
fn mitsuba() -> Result<std::path::PathBuf, String> {
    let venv = built_path("mitsuba", "");
    let python = interpreter(&venv);
    let uv = uv()?;
    if !exists(&python) {
        check(Command::new(&uv).args(["venv", "--quiet"]).arg(&venv))?;
    }
    check(
        Command::new(&uv)
            .args(["pip", "install", "--quiet", "--python"])
            .arg(&python)
            .arg("--requirements")
            .arg(root().join(REQUIREMENTS)),
    )?;
    Ok(python)
}
