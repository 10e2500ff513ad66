//! `cargo xtask test`

use std::process::Command;

use crate::run::{built, cargo, check, root, skip};

/// Builds, lets the outside oracles read what the command writes, and runs all tests.
pub fn run() -> Result<(), String> {
    // Both profiles: a test compares their bytes.
    check(cargo().args(["build", "--release", "--package", "fabkit"]))?;
    check(cargo().args(["build", "--package", "fabkit"]))?;
    match crate::python::environment() {
        Ok(python) => {
            for script in ["check_files.py", "check_dataset.py"] {
                check(
                    Command::new(&python)
                        .arg(root().join("tests/python").join(script))
                        .arg(built("release", "fabkit")),
                )?;
            }
        }
        Err(why) => skip("the outside oracles lib3mf, manifold3d, ezdxf and zarr", &why)?,
    }
    // Last, so that its summary ends the output. Doc tests are part of it.
    check(cargo().args(["test", "--workspace", "--release", "--no-fail-fast"]))
}
