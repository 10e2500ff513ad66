//! Fault injection library that is loaded before the C library (`xtask/faults/shim.c`).

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::root;

/// Injected fault.
#[derive(Clone, Debug)]
pub struct Fault {
    pub call: &'static str,
    /// Ordinal of the failing call, from 1.
    pub ordinal: usize,
    /// Error number of the system; 0 kills the process.
    pub error: i32,
    /// True if all later calls fail as well.
    pub is_persistent: bool,
}

/// Kinds of calls with their possible errors (EACCES 13, EDQUOT 122, EINTR 4, EIO 5, EMFILE 24, ENOSPC 28, EPERM 1,
/// EXDEV 18), and 0 for being killed.
pub const KINDS: [(&str, &[i32]); 5] = [
    ("open", &[13, 5, 24, 28, 0]),
    ("write", &[28, 122, 5, 4, 0]),
    ("rename", &[5, 13, 28, 18, 0]),
    ("link", &[1, 28, 0]),
    ("fsync", &[5, 28, 4, 0]),
];

impl Fault {
    pub fn kills(&self) -> bool {
        self.error == 0
    }

    /// Injects the fault into a command that runs in `folder`.
    pub fn inject(&self, command: &mut Command, shim: &Path, folder: &Path) {
        command
            .env("LD_PRELOAD", shim)
            .env("FAULT_DIR", folder)
            .env("FAULT_CALL", self.call)
            .env("FAULT_K", self.ordinal.to_string())
            .env("FAULT_ERRNO", self.error.to_string())
            .env("FAULT_ON", if self.is_persistent { "1" } else { "" });
    }
}

/// Compiles the library.
pub fn build(folder: &Path) -> Result<PathBuf, String> {
    if !cfg!(all(target_os = "linux", target_env = "gnu")) {
        return Err("it is for Linux with the GNU C library".into());
    }
    let library = folder.join("shim.so");
    let output = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .arg(&library)
        .arg(root().join("xtask/faults/shim.c"))
        .arg("-ldl")
        .output()
        .map_err(|e| format!("no C compiler: {e}"))?;
    if output.status.success() {
        Ok(library)
    } else {
        Err(String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

/// Counts the calls of each kind in `folder` during an undisturbed run.
pub fn count(command: &mut Command, shim: &Path, folder: &Path) -> Result<Vec<usize>, String> {
    let counts = folder.with_extension("counts");
    command.env("LD_PRELOAD", shim).env("FAULT_DIR", folder).env("FAULT_COUNT", &counts);
    let output = command.output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let text = std::fs::read_to_string(&counts)
        .map_err(|e| format!("the library was not loaded before the others: {e}"))?;
    let count = |line: &str| line.split_once(' ').and_then(|(_, n)| n.trim().parse().ok());
    Ok(text.lines().filter_map(count).collect())
}
