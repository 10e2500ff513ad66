//! `cargo xtask lint`

use std::path::Path;
use std::process::Command;

use crate::run::{cargo, check, exists, root, skip, tool};

/// Everything that can be said about the code without running it.
pub fn run() -> Result<(), String> {
    check(cargo().args(["fmt", "--all", "--check"]))?;
    crate::book::compare_python_page()?;
    // In release: what build scripts and macros are made of is there already, C sources included.
    let clippy = ["clippy", "--release", "--workspace", "--all-targets", "--", "-D", "warnings"];
    check(cargo().args(clippy))?;
    let mut doc = cargo();
    doc.args(["doc", "--release", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings");
    check(as_clippy(&mut doc))?;
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

/// As `cargo clippy` calls cargo: what it has checked a moment ago is then not checked once more. Where it does so in
/// another way, that costs time and changes nothing else.
fn as_clippy(command: &mut Command) -> &mut Command {
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output();
    let sysroot = sysroot.map(|out| String::from_utf8_lossy(&out.stdout).trim().to_owned());
    let driver = sysroot.map(|root| Path::new(&root).join("bin/clippy-driver"));
    let Some(driver) = driver.ok().filter(|driver| driver.is_file()) else { return command };
    command
        .env("RUSTC_WORKSPACE_WRAPPER", driver)
        .env("CLIPPY_ARGS", "-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__")
}
