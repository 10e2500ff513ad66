//! `cargo xtask bench-depth`

use std::process::Command;

use crate::run::{built, cargo, check, root};

const EXAMPLE: &[&str] =
    &["run", "--release", "--package", "fabkit-depth", "--example", "truth_throughput"];

/// Casts the same scene exactly and as meshes beside Embree and Open3D, and prints rates, errors
/// and their ratios. trimesh and embreex are installed into the environment first; Open3D is used
/// where it is there.
pub fn run() -> Result<(), String> {
    let python = crate::python::environment()?;
    let install = ["-m", "pip", "install", "--quiet", "trimesh==5.2.0", "embreex==4.4.0.post1"];
    check(Command::new(&python).args(install))?;
    check(cargo().args(["build", "--release", "--package", "fabkit"]))?;
    let output = cargo().args(EXAMPLE).output().map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    print!("{text}");
    let whole = text.lines().find_map(|line| line.strip_prefix("reference and 20 protrusions"));
    let rate = whole.and_then(|rest| rest.split_whitespace().next()).unwrap_or_default();
    let script = root().join("depth/benches/against_embree.py");
    check(Command::new(python).arg(script).arg(built("release", "fabkit")).arg(rate))
}
