//! `cargo xtask lint`

use std::process::Command;

use crate::run::{cargo, check, exists, root, skip, tool};

/// Everything that can be said about the code without running it.
pub fn run() -> Result<(), String> {
    check(cargo().args(["fmt", "--all", "--check"]))?;
    crate::book::compare_python_page()?;
    check(cargo().args(["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    check(cargo().args(["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))?;
    let Some(deny) = ["cargo-deny".into(), tool("cargo-deny")].into_iter().find(|p| exists(p))
    else {
        return skip(
            "licences, bans and sources of dependencies",
            "cargo-deny is not here; `cargo install --locked --root .tools cargo-deny` brings it",
        );
    };
    // Advisories need a database that must be fetched; they are not part of this check.
    let checks = ["check", "licenses", "bans", "sources"];
    check(Command::new(deny).args(checks).current_dir(root()))
}
