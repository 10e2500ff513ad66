//! The Python environment of the outside oracles: lib3mf, manifold3d and ezdxf read what fabkit writes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::{check, exists, root};

const REQUIREMENTS: &str = "tests/python/requirements.txt";

/// The interpreter of `.venv`, which is made or brought up to date first.
pub fn environment() -> Result<PathBuf, String> {
    let venv = root().join(".venv");
    let bin = if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" };
    let python = venv.join(bin);
    let wanted = fs::read_to_string(root().join(REQUIREMENTS))
        .map_err(|e| format!("{REQUIREMENTS}: {e}"))?;
    // Written last: an environment without it is incomplete.
    let stamp = venv.join("fabkit-requirements.txt");
    if exists(&python) && fs::read_to_string(&stamp).is_ok_and(|have| have == wanted) {
        return Ok(python);
    }
    if !exists(Path::new("python3")) {
        return Err("there is no python3".into());
    }
    check(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&venv))?;
    check(
        Command::new(&python)
            .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"])
            .arg(root().join(REQUIREMENTS)),
    )?;
    fs::write(&stamp, wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    Ok(python)
}
