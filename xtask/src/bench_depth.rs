//! `cargo xtask bench-depth`

use std::path::PathBuf;
use std::process::Command;

use crate::run::{built_path, cargo, check, root};

/// Ray casters for triangle meshes, in a separate environment: nothing else needs them.
const PEERS: [&str; 3] = ["numpy==2.4.6", "trimesh==5.2.0", "embreex==4.4.0.post1"];
/// Large, and not available for every Python version. It is left out, with a message, where it cannot be installed.
const OPEN3D: &str = "open3d-cpu==0.20.0";

/// Casts the same scene exactly, and as meshes with trimesh, Embree and Open3D. Prints rates, errors and their ratios,
/// and writes them into `docs/benchmarks_depth.md`.
pub fn run() -> Result<(), String> {
    let python = environment()?;
    let release = ["build", "--release", "--package"];
    check(cargo().args(release).arg("fabkit"))?;
    check(cargo().args(release).args(["fabkit-application", "--example", "depth_throughput"]))?;
    check(
        Command::new(python)
            .arg(root().join("xtask/depth/run.py"))
            .arg(built_path("release", "fabkit"))
            .arg(built_path("release", "examples/depth_throughput"))
            .arg(root().join("docs/benchmarks_depth.md")),
    )
}

/// Returns the interpreter of `.tools/bench-depth`, which is created if it is missing.
fn environment() -> Result<PathBuf, String> {
    let folder = root().join(".tools/bench-depth");
    let python = crate::python::interpreter(&folder);
    if !crate::run::exists(&python) {
        check(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    }
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    check(Command::new(&python).args(install).args(PEERS))?;
    // A separate installation, so that its failure does not affect the others.
    if let Err(why) = check(Command::new(&python).args(install).arg(OPEN3D)) {
        println!("xtask: bench-depth goes on WITHOUT Open3D: {why}");
    }
    Ok(python)
}
