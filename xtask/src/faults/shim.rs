//! The library that stands before the C library (`xtask/faults/shim.c`).

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run::root;

/// Which call goes wrong, and how.
#[derive(Clone, Debug)]
pub struct Fault {
    pub call: &'static str,
    /// From 1.
    pub k: usize,
    /// The system's number; 0 kills.
    pub error: i32,
    /// All later ones fail too.
    pub on: bool,
}

/// What each kind of call may fail with: EACCES, EDQUOT, EINTR, EIO, EMFILE, ENOSPC, EPERM, EXDEV; and
/// 0, which kills.
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

    /// Puts it into a command that runs in `folder`.
    pub fn put(&self, command: &mut Command, shim: &Path, folder: &Path) {
        command
            .env("LD_PRELOAD", shim)
            .env("FAULT_DIR", folder)
            .env("FAULT_CALL", self.call)
            .env("FAULT_K", self.k.to_string())
            .env("FAULT_ERRNO", self.error.to_string())
            .env("FAULT_ON", if self.on { "1" } else { "" });
    }
}

/// Compiles it.
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
    match output.status.success() {
        true => Ok(library),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

/// How often a command calls each kind in its folder when nothing goes wrong.
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
