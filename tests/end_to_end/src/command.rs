//! Locating and running the real binary.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use crate::contract::find_faults;

/// Result of one run.
#[derive(Clone, Debug)]
pub struct Run {
    /// Exit code; `None` if a signal ended the run.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
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
    /// Parses the JSON document on standard output and validates it against its schema.
    ///
    /// # Panics
    /// If there is no such document, or it violates the schema.
    pub fn json(&self) -> serde_json::Value {
        let document: serde_json::Value =
            serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {self:?}"));
        let faults =
            if document.get("$schema").is_some() { vec![] } else { find_faults(&document) };
        assert!(faults.is_empty(), "{}", faults.join("\n"));
        document
    }

    /// Returns the run if it succeeded.
    ///
    /// # Panics
    /// If it failed.
    pub fn ok(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:?}");
        self
    }
}

/// Returns the command: the one that `FABKIT` names, or the binary in the tests' build profile, built if it is out of
/// date.
pub fn binary() -> &'static Path {
    static BINARY: OnceLock<PathBuf> = OnceLock::new();
    BINARY.get_or_init(|| match env::var_os("FABKIT") {
        Some(fabkit) => fabkit.into(),
        None => build(!cfg!(debug_assertions)),
    })
}

/// Builds the binary with cargo, which alone knows its location and whether it is up to date.
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

/// Prepares the command in a folder, without running it.
pub fn command(folder: &Path) -> Command {
    let mut command = Command::new(binary());
    // The environment of the person who runs the tests must not matter.
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

/// Reads all files directly in a folder, hidden ones included; empty if the folder does not exist.
///
/// # Panics
/// If one cannot be read.
pub fn read_folder(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let Ok(entries) = fs::read_dir(folder) else { return BTreeMap::new() };
    entries
        .map(|entry| {
            let entry = entry.expect("the folder can be read");
            let name = entry.file_name().into_string().expect("names are UTF-8");
            (name, fs::read(entry.path()).expect("the file can be read"))
        })
        .collect()
}
