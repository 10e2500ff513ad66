//! `cargo xtask real-captures DIR`

use std::path::PathBuf;

use crate::run::{cargo, check};

/// Calibrates captures of a real sensor, prints the results, and checks them against their limits.
pub fn run(folder: Option<PathBuf>) -> Result<(), String> {
    let folder = folder.ok_or("name the folder: images, ref.png and holes.json")?;
    let folder = folder.canonicalize().map_err(|e| format!("{}: {e}", folder.display()))?;
    check(
        cargo()
            .args(["test", "--release", "--package", "fabkit-tests", "--test", "real_captures"])
            .args(["--", "--nocapture", "--test-threads", "1"])
            .env("FABKIT_REAL_CAPTURES", folder),
    )
}
