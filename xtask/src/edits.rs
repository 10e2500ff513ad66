//! `cargo xtask edits`: how far the built-in sensors follow their users.

use crate::run::{cargo, check};
use crate::samples::FULL;

/// Runs the test that counts what is refused, for every parameter, and lets it tell.
pub fn run() -> Result<(), String> {
    let test =
        ["test", "--release", "--package", "fabkit-designs", "--test", "families", "edits::"];
    check(cargo().args(test).args(["--", "--nocapture", "--test-threads=1"]).env(FULL, "1"))
}
