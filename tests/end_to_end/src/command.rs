//! Finding and running the real binary.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use crate::contract::faults;

/// How one run ended.
#[derive(Clone, Debug)]
pub struct Run {
    /// Exit code; none if a signal ended it.
    pub code: Option<i32>,
    /// What it said.
    pub stdout: String,
    /// What it complained about.
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("fabkit writes UTF-8");
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        Self { code: output.status.code(), stdout, stderr }
    }
}

impl Run {
    /// The one JSON document on standard output, which is as its schema says.
    ///
    /// # Panics
    /// If there is none, or another one.
    pub fn json(&self) -> serde_json::Value {
        let document: serde_json::Value =
            serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        let faults = if document.get("$schema").is_some() { vec![] } else { faults(&document) };
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        document
    }

    /// The run itself, if it succeeded.
    ///
    /// # Panics
    /// If it did not.
    pub fn ok(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }
}

/// The command: what `FABKIT` names, or the binary in the profile of the tests, built if it is out of
/// date.
pub fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| match env::var_os("FABKIT") {
        Some(fabkit) => fabkit.into(),
        None => build(!cfg!(debug_assertions)),
    })
}

/// Asks cargo, because only cargo knows where the binary is and whether it is up to date.
fn build(release: bool) -> PathBuf {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args(["build", "--package", "fabkit", "--bin", "fabkit"])
        .args(["--message-format", "json", "--manifest-path", manifest])
        .args(release.then_some("--release"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
        .expect("cargo names the binary it built")
}

/// The command, not yet run, in a folder.
pub fn command(folder: &Path) -> Command {
    let mut command = Command::new(binary());
    // Nothing of whoever runs the tests.
    command.current_dir(folder).env_remove("FABKIT_MATERIALS");
    command
}

/// Runs the command in a folder.
///
/// # Panics
/// If it cannot be started.
pub fn fabkit(folder: &Path, arguments: &[&str]) -> Run {
    command(folder).args(arguments).output().expect("fabkit starts").into()
}

/// All files directly in a folder, hidden ones too, with their content; empty if it is not there.
///
/// # Panics
/// If one cannot be read.
pub fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = fs::read_dir(folder) else { return BTreeMap::new() };
    entries
        .map(|entry| {
            let entry = entry.expect("the folder can be read");
            let name = entry.file_name().into_string().expect("names are UTF-8");
            (name, fs::read(entry.path()).expect("the file can be read"))
        })
        .collect()
}
