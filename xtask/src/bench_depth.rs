//! `cargo xtask bench-depth`

use std::path::PathBuf;
use std::process::Command;

use crate::run::{built, cargo, check, root};

/// Casters of triangles, in an environment of their own: nothing else needs them.
const PEERS: [&str; 3] = ["numpy==2.4.6", "trimesh==5.2.0", "embreex==4.4.0.post1"];
/// Large, and not made for every Python: left out where it cannot be had, and said to be.
const OPEN3D: &str = "open3d-cpu==0.20.0";

/// Casts the same scene exactly and as meshes beside trimesh, Embree and Open3D, prints rates,
/// errors and their ratios, and writes them into `docs/benchmarks_depth.md`.
pub fn run() -> Result<(), String> {
    let python = environment()?;
    let release = ["build", "--release", "--package"];
    check(cargo().args(release).arg("fabkit"))?;
    check(cargo().args(release).args(["fabkit-application", "--example", "depth_throughput"]))?;
    check(
        Command::new(python)
            .arg(root().join("xtask/depth/run.py"))
            .arg(built("release", "fabkit"))
            .arg(built("release", "examples/depth_throughput"))
            .arg(root().join("docs/benchmarks_depth.md")),
    )
}

/// The interpreter of `.tools/bench-depth`, which is made first where it is missing.
fn environment() -> Result<PathBuf, String> {
    let folder = root().join(".tools/bench-depth");
    let python = crate::python::interpreter(&folder);
    if !crate::run::exists(&python) {
        check(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    }
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    check(Command::new(&python).args(install).args(PEERS))?;
    if let Err(why) = check(Command::new(&python).args(install).arg(OPEN3D)) {
        println!("xtask: bench-depth goes on WITHOUT Open3D: {why}");
    }
    Ok(python)
}
