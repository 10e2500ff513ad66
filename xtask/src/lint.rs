//! `cargo xtask lint`

use std::process::Command;

use crate::run::{cargo, check, exists, root, skip, tool_path};

/// Runs all static checks of the code.
pub fn run() -> Result<(), String> {
    check(cargo().args(["fmt", "--all", "--check"]))?;
    crate::book::compare_python_page()?;
    // In release, because the artefacts of build scripts and macros exist there already, C sources included.
    let clippy = ["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"];
    check(cargo().args(clippy))?;
    let doc = ["doc", "--release", "--workspace", "--no-deps"];
    check(cargo().args(doc).env("RUSTDOCFLAGS", "-D warnings"))?;
    let Some(deny) = ["cargo-deny".into(), tool_path("cargo-deny")].into_iter().find(|p| exists(p))
    else {
        return skip(
            "licences, bans and sources of dependencies",
            "cargo-deny is not here; `cargo install --locked --root .tools cargo-deny` brings it",
        );
    };
    // Advisories need a database from the network and are not part of this check.
    let checks = ["check", "licenses", "bans", "sources"];
    check(Command::new(deny).args(checks).current_dir(root()))
}
