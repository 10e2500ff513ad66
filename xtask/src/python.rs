//! `cargo xtask verify-env`: creates the Python environment of the verifier and of all independent oracles.
//!
//! The OpenCascade wheels of cadquery and build123d write the same folder. Only uv can leave one of them out
//! (`export/verify/pyproject.toml`), so uv itself is first installed from PyPI into `.tools/uv`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::{check, exists, root};

/// Inputs of the environment; a change in any of them rebuilds it.
const SOURCES: [&str; 3] =
    ["export/verify/pyproject.toml", "export/verify/uv.lock", "tests/oracles/requirements.txt"];
const UV: &str = "uv==0.13.9";

/// Creates the environment and prints the kernels in it.
pub fn run() -> Result<(), String> {
    let python = environment()?;
    check(Command::new(python).args(["-I", "-m", "fabkit_verify", "versions"]))
}

/// Returns the interpreter of `.venv`, which is created or updated first.
pub fn environment() -> Result<PathBuf, String> {
    let venv = root().join(".venv");
    let python = interpreter(&venv);
    // The verifier is installed in place, so a moved checkout needs a new environment.
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
    // All kernels must work side by side.
    check(Command::new(&python).args(["-I", "-m", "fabkit_verify", "versions"]))?;
    fs::write(&stamp, wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    Ok(python)
}

/// Returns the `uv` in `.tools`, which is installed first if it is missing.
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

/// Returns the path of a virtual environment's interpreter.
pub fn interpreter(venv: &Path) -> PathBuf {
    venv.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}
