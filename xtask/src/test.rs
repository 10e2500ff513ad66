//! `cargo xtask test`

use std::path::Path;
use std::process::Command;

use crate::run::{built, cargo, check, in_ci, root, skip, skipped};

/// The sensor that is verified everywhere; in continuous integration, all are.
const ALWAYS_VERIFIED: &str = "rtac0";

/// Programs that read what fabkit writes, from the system's packages.
const CONSUMERS: [&str; 2] = ["admesh", "prusa-slicer"];

/// Builds, lets the outside oracles read what the command writes, and runs all tests.
pub fn run() -> Result<(), String> {
    // Both profiles: a test compares their bytes.
    check(cargo().args(["build", "--release", "--package", "fabkit"]))?;
    check(cargo().args(["build", "--package", "fabkit"]))?;
    match crate::python::environment() {
        Ok(python) => oracles(&python)?,
        Err(why) => skip("the outside oracles and other kernels", &why)?,
    }
    // Last, so that its summary ends the output. Doc tests are part of it.
    let tests = check(cargo().args(["test", "--workspace", "--release", "--no-fail-fast"]));
    for step in skipped() {
        println!("xtask: SKIPPED {step}");
    }
    tests
}

fn oracles(python: &Path) -> Result<(), String> {
    let fabkit = built("release", "fabkit");
    let script = |path: &str| {
        let mut command = Command::new(python);
        command.arg(root().join(path)).env("FABKIT_PYTHON", python);
        command
    };
    check(script("tests/python/check_files.py").arg(&fabkit))?;
    check(script("tests/python/check_intrinsics.py").arg(&fabkit))?;
    check(script("tests/python/check_dataset.py").arg(&fabkit))?;
    for consumer in CONSUMERS {
        if installed(consumer) {
            check(script("tests/python/consumers.py").args([consumer]).arg(&fabkit))?;
        } else {
            skip(consumer, "it is not installed; the system's packages have it")?;
        }
    }
    check(
        Command::new(python)
            .args(["-m", "unittest", "discover", "--start-directory"])
            .arg(root().join("verify/tests"))
            .env("FABKIT", &fabkit)
            .env("FABKIT_PYTHON", python),
    )?;
    for sensor in if in_ci() { sensors(&fabkit)? } else { vec![ALWAYS_VERIFIED.to_owned()] } {
        check(Command::new(&fabkit).args(["verify", &sensor]).env("FABKIT_PYTHON", python))?;
    }
    if !in_ci() {
        skip("verification of the other sensors", "it is part of continuous integration")?;
    }
    Ok(())
}

/// Whether a program can be started; neither of the consumers exits with 0 for `--version`.
fn installed(program: &str) -> bool {
    Command::new(program).arg("--help").output().is_ok()
}

/// Names of the built-in sensors.
fn sensors(fabkit: &Path) -> Result<Vec<String>, String> {
    let output = Command::new(fabkit)
        .args(["list", "--quiet"])
        .output()
        .map_err(|e| format!("fabkit list: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout);
    // A sensor's line is not indented: `rtac0: R-Tac0, ...`.
    let name = |line: &str| line.split_once(':').map(|(name, _)| name.to_owned());
    Ok(text.lines().filter(|line| !line.starts_with(' ')).filter_map(name).collect())
}
