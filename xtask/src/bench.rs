//! `cargo xtask bench`

use crate::run::{cargo, check};

/// Times fabkit beside manifold3d on the same scenes at the same tolerance.
pub fn run() -> Result<(), String> {
    let python = crate::python::environment()?;
    check(cargo().args(["bench", "--package", "fabkit-mesh"]).env("FABKIT_PYTHON", python))
}
