//! `cargo xtask python`: tests the Python packages as their users get them, from wheels: fabkit-cad, and fabkit-bench,
//! which its extra `bench` installs.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::python::{interpreter, uv};
use crate::run::{built_path, check, exists, root};

const REQUIREMENTS: &str = "fabkit/python/requirements-dev.txt";
const BENCH: &str = "simulation/bench";

/// Builds the wheels, installs them into a separate environment, runs tests and examples, and checks types and style.
pub fn run() -> Result<(), String> {
    checks()?.iter_mut().try_for_each(check)
}

/// Installs the packages and returns the commands that test them.
pub fn checks() -> Result<Vec<Command>, String> {
    let folder = folder();
    let lock = lock(&folder)?;
    let python = environment(&folder)?;
    let tool = |name: &str| {
        let mut command = Command::new(python.with_file_name(name));
        command.current_dir(root());
        command
    };
    check(tool("ruff").args(["check", "--quiet", "."]))?;
    check(tool("ruff").args(["format", "--check", "--quiet", "."]))?;

    let wheels = wheels(&folder, &python)?;
    check(
        Command::new(uv()?)
            .args(["pip", "install", "--quiet", "--no-deps", "--reinstall", "--no-cache"])
            .arg("--python")
            .arg(&python)
            .args(wheels),
    )?;
    drop(lock);
    let mut pyright = tool("pyright");
    pyright.arg("--pythonpath").arg(&python);
    // Tests, and the examples in the docstrings of the installed packages.
    let mut pytest = Command::new(&python);
    // Modules of tests are named from the root directory on; with the checkout as root, one of them would be called
    // `fabkit`.
    pytest.args(["-m", "pytest", "-q", "-c", "pyproject.toml", "--rootdir", "fabkit/python"]);
    pytest.args(["--pyargs", "fabkit", "fabkit/python/tests"]);
    pytest.args(["fabkit_bench", "simulation/bench/tests"]);
    pytest.current_dir(root());
    Ok(vec![pytest, pyright])
}

/// Installs the packages alone into a folder, for the `PYTHONPATH` of any interpreter.
pub fn unpacked() -> Result<PathBuf, String> {
    let folder = folder();
    let _lock = lock(&folder)?;
    let python = environment(&folder)?;
    let package = folder.join("package");
    check(
        Command::new(uv()?)
            .args(["pip", "install", "--quiet", "--no-deps", "--reinstall", "--no-cache"])
            .arg("--python")
            .arg(&python)
            .arg("--target")
            .arg(&package)
            .args(wheels(&folder, &python)?),
    )?;
    Ok(package)
}

fn folder() -> PathBuf {
    built_path("python", "").components().collect()
}

/// Waits until no other task builds or installs wheels here: the book runs beside the package's tests.
fn lock(folder: &Path) -> Result<File, String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    fs::create_dir_all(folder).map_err(failed)?;
    let file = File::create(folder.join("lock")).map_err(failed)?;
    file.lock().map_err(failed)?;
    Ok(file)
}

/// Builds both wheels into an empty folder.
fn wheels(folder: &Path, python: &Path) -> Result<Vec<PathBuf>, String> {
    let wheels = folder.join("wheels");
    if wheels.is_dir() {
        // Wheels of older versions would be installed as well.
        fs::remove_dir_all(&wheels).map_err(|e| format!("{}: {e}", wheels.display()))?;
    }
    // Wheels are always release builds, so the artefacts of the workspace's release build are reused.
    let mut maturin = Command::new(python.with_file_name("maturin"));
    maturin.args(["build", "--release", "--locked", "--quiet", "--out"]).arg(&wheels);
    check(maturin.current_dir(root()))?;
    // The build backend is in the environment already.
    let mut bench = Command::new(uv()?);
    bench.args(["build", "--quiet", "--wheel", "--no-build-isolation", "--python"]).arg(python);
    check(bench.arg("--out-dir").arg(&wheels).arg(BENCH).current_dir(root()))?;
    wheels_in(&wheels)
}

/// Returns the interpreter of the packages' environment, which is created or updated first.
fn environment(folder: &Path) -> Result<PathBuf, String> {
    let venv = folder.join("venv");
    let python = interpreter(&venv);
    let requirements = root().join(REQUIREMENTS);
    let wanted = fs::read_to_string(&requirements).map_err(|e| format!("{REQUIREMENTS}: {e}"))?;
    let stamp = venv.join("fabkit-requirements.txt");
    if exists(&python) && fs::read_to_string(&stamp).is_ok_and(|have| have == wanted) {
        return Ok(python);
    }
    let uv = uv()?;
    check(Command::new(&uv).args(["venv", "--quiet", "--clear"]).arg(&venv))?;
    let install = ["pip", "install", "--quiet", "--python"];
    check(Command::new(&uv).args(install).arg(&python).arg("--requirements").arg(requirements))?;
    fs::write(&stamp, wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    Ok(python)
}

fn wheels_in(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |e: std::io::Error| format!("{}: {e}", folder.display());
    let entries = fs::read_dir(folder).map_err(failed)?;
    let paths = entries.map(|entry| Ok(entry.map_err(failed)?.path()));
    // Build tools may leave a `.gitignore` beside the wheels.
    paths
        .filter(|path| path.as_ref().map_or(true, |path| path.extension() == Some("whl".as_ref())))
        .collect()
}
