//! The workspace's Rust tests as separate programs that can run beside other work. `cargo test` runs them one after the
//! other, and the end of each keeps only one core busy.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::run::{WORKSPACE, cargo, fabkit};
use crate::samples::{SLOWNESS, Samples};

/// Test programs started first, the longest before the others.
const LONG_TESTS: [&str; 8] =
    ["truth", "reality", "designs", "calibration", "guide", "export", "datasets", "families"];

/// Test program that measures time and memory, and sends interrupts: it runs without others, one test at a time.
const EXCLUSIVE_TEST: &str = "alone";

/// Test programs.
pub struct Tests {
    /// Programs that can run beside others, the longest first.
    pub beside_others: Vec<Command>,
    /// Programs that must run alone.
    pub exclusive: Vec<Command>,
}

/// Builds all test programs, which look at samples of these sizes.
pub fn build(samples: Samples) -> Result<Tests, String> {
    let mut build = cargo();
    build.args(["test", "--release", "--no-run", "--lib", "--bins", "--tests"]);
    build.arg("--message-format=json").args(WORKSPACE);
    let output = build.stderr(Stdio::inherit()).output();
    let output = output.map_err(|e| format!("cannot build the tests: {e}"))?;
    if !output.status.success() {
        return Err(format!("building the tests: {}", output.status));
    }
    let messages = String::from_utf8_lossy(&output.stdout);
    let mut programs: Vec<Program> = messages.lines().filter_map(Program::of).collect();
    // A stable sort: programs that are not listed keep cargo's order, after the long ones.
    programs.sort_by_key(Program::rank);
    let fabkit = fabkit()?;
    let (mut alone, mut beside_others) = (Vec::new(), Vec::new());
    for program in &programs {
        let mut command = program.command(&fabkit);
        command.env(SLOWNESS, samples.slowness().to_string());
        if program.name == EXCLUSIVE_TEST {
            command.arg("--test-threads=1");
            alone.push(command);
        } else {
            beside_others.push(command);
        }
    }
    Ok(Tests { beside_others, exclusive: alone })
}

/// Makes the command of the documentation examples, which only cargo can run.
pub fn doc_tests() -> Result<Command, String> {
    let mut command = cargo();
    command.args(["test", "--release", "--doc"]).args(WORKSPACE).env("FABKIT", fabkit()?);
    Ok(command)
}

struct Program {
    name: String,
    /// Folder in which cargo would start it.
    folder: PathBuf,
    path: PathBuf,
}

impl Program {
    /// Parses one of cargo's messages; `None` if it is not about a test program.
    fn of(line: &str) -> Option<Self> {
        let message: Value = serde_json::from_str(line).ok()?;
        let is_test = message["profile"]["test"].as_bool()?;
        let path = message["executable"].as_str().filter(|_| is_test)?;
        let manifest = Path::new(message["manifest_path"].as_str()?);
        Some(Self {
            name: message["target"]["name"].as_str()?.to_owned(),
            folder: manifest.parent()?.to_owned(),
            path: path.into(),
        })
    }

    fn rank(&self) -> usize {
        LONG_TESTS.iter().position(|name| *name == self.name).unwrap_or(LONG_TESTS.len())
    }

    fn command(&self, fabkit: &Path) -> Command {
        let mut command = Command::new(&self.path);
        command.current_dir(&self.folder).env("FABKIT", fabkit);
        command
    }
}
