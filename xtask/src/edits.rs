//! `cargo xtask edits`: how well the built-in sensors tolerate changes of single parameters.

use crate::run::{cargo, check};
use crate::samples::FULL;

/// Runs the test that counts refused changes, for every parameter, and shows its output.
pub fn run() -> Result<(), String> {
    let test =
        ["test", "--release", "--package", "fabkit-designs", "--test", "families", "edits::"];
    check(cargo().args(test).args(["--", "--nocapture", "--test-threads=1"]).env(FULL, "1"))
}
