//! `cargo xtask lint`

use std::process::Command;

use crate::run::{cargo, check, exists, root, skip, tool};

/// Everything that can be said about the code without running it.
pub fn run() -> Result<(), String> {
    check(cargo().args(["fmt", "--all", "--check"]))?;
    crate::book::compare_python_page()?;
    // In release: what build scripts and macros are made of is there already, C sources included.
    let clippy = ["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"];
    check(cargo().args(clippy))?;
    let doc = ["doc", "--release", "--workspace", "--no-deps"];
    check(cargo().args(doc).env("RUSTDOCFLAGS", "-D warnings"))?;
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
