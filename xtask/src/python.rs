//! `cargo xtask verify-env`: the Python environment of the verifier and of all outside oracles.
//!
//! cadquery's and build123d's wheels of OpenCascade write the same folder; only uv can leave one of
//! them out (`export/verify/pyproject.toml`), so that uv itself comes from PyPI first, into `.tools/uv`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::{check, exists, root};

/// What the environment is made from; a change in any of them remakes it.
const SOURCES: [&str; 3] =
    ["export/verify/pyproject.toml", "export/verify/uv.lock", "tests/oracles/requirements.txt"];
const UV: &str = "uv==0.13.9";

/// Makes the environment and says which kernels it holds.
pub fn run() -> Result<(), String> {
    let python = environment()?;
    check(Command::new(python).args(["-I", "-m", "fabkit_verify", "versions"]))
}

/// The interpreter of `.venv`, which is made or brought up to date first.
pub fn environment() -> Result<PathBuf, String> {
    let venv = root().join(".venv");
    let python = interpreter(&venv);
    // The verifier is installed where it lies: a checkout that was moved needs it anew.
    let mut wanted = format!("{UV}\n{}\n", root().display());
    for source in SOURCES {
        wanted += &fs::read_to_string(root().join(source)).map_err(|e| format!("{source}: {e}"))?;
    }
    // Written last: an environment without it is incomplete.
    let stamp = venv.join("fabkit-sources.txt");
    if exists(&python) && fs::read_to_string(&stamp).is_ok_and(|have| have == wanted) {
        return Ok(python);
    }
    let uv = uv()?;
    check(
        Command::new(&uv)
            .args(["sync", "--quiet", "--frozen", "--project"])
            .arg(root().join("export/verify"))
            .env("UV_PROJECT_ENVIRONMENT", &venv),
    )?;
    check(
        Command::new(&uv)
            .args(["pip", "install", "--quiet", "--python"])
            .arg(&python)
            .arg("--requirements")
            .arg(root().join(SOURCES[2])),
    )?;
    // All kernels side by side, or no environment.
    check(Command::new(&python).args(["-I", "-m", "fabkit_verify", "versions"]))?;
    fs::write(&stamp, wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    Ok(python)
}

/// The `uv` of `.tools`, which is installed first if it is missing.
pub fn uv() -> Result<PathBuf, String> {
    let folder = root().join(".tools/uv");
    let uv = folder.join(if cfg!(windows) { "Scripts/uv.exe" } else { "bin/uv" });
    if exists(&uv) {
        return Ok(uv);
    }
    if !exists(Path::new("python3")) {
        return Err("there is no python3".into());
    }
    check(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    check(Command::new(interpreter(&folder)).args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        UV,
    ]))?;
    Ok(uv)
}

/// Where a virtual environment keeps its interpreter.
pub fn interpreter(venv: &Path) -> PathBuf {
    venv.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}
