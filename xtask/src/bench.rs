//! `cargo xtask bench`

use crate::run::{cargo, check};

/// Times fabkit beside manifold3d on the same scenes at the same tolerance, and beside OpenCV on the
/// same pixels.
pub fn run() -> Result<(), String> {
    let python = crate::python::environment()?;
    for package in ["fabkit-mesh", "fabkit-calibration"] {
        check(cargo().args(["bench", "--package", package]).env("FABKIT_PYTHON", &python))?;
    }
    Ok(())
}
