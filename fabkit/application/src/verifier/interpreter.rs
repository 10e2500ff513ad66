//! Which Python is asked, and how it is kept from running what lies about.
//!
//! One rule finds it: [`PYTHON_VARIABLE`] names it by an absolute path, or else it is that of `.venv`
//! in fabkit's checkout, for a program that cargo built there. The working folder, the search path
//! and the folders above them are never looked at: they may hold anything.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::VerifierError;

/// Names the interpreter of the verifier's environment.
pub const PYTHON_VARIABLE: &str = "FABKIT_PYTHON";

/// A Python that has the package.
#[derive(Clone, Debug)]
pub(super) struct Interpreter {
    path: PathBuf,
}

impl Interpreter {
    /// The one that the rule finds.
    pub(super) fn find(folder: &Path) -> Result<Self, VerifierError> {
        let named = env::var_os(PYTHON_VARIABLE).filter(|name| !name.is_empty());
        let Some(path) = named.map(PathBuf::from) else {
            let program = env::current_exe().ok();
            let checkout = program.as_deref().and_then(checkout_of);
            let path = checkout.ok_or(VerifierError::NoEnvironment)?.join(in_environment());
            let found = Self { path };
            return if found.has_package(folder) {
                Ok(found)
            } else {
                Err(VerifierError::NoEnvironment)
            };
        };
        if !path.is_absolute() {
            return Err(VerifierError::RelativePython(path));
        }
        let named = Self { path };
        match named.has_package(folder) {
            true => Ok(named),
            false => Err(VerifierError::NoPackage(named.path)),
        }
    }

    /// Its path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// A command of it in a folder of our own. Isolated (`-I`): neither the folder nor a script's nor
    /// the user's own packages are searched, and no variable tells it otherwise; those are removed
    /// too, because what it starts would read them.
    pub(super) fn command(&self, folder: &Path) -> Command {
        let mut command = Command::new(&self.path);
        command.arg("-I").current_dir(folder).stdin(Stdio::null());
        for (name, _) in env::vars_os() {
            let upper = name.to_string_lossy().to_ascii_uppercase();
            if upper.starts_with("PYTHON") || upper == "__PYVENV_LAUNCHER__" {
                command.env_remove(&name);
            }
        }
        command
    }

    fn has_package(&self, folder: &Path) -> bool {
        let probe =
            "import importlib.util as u, sys; sys.exit(u.find_spec('fabkit_verify') is None)";
        let run = self.command(folder).args(["-c", probe]).stderr(Stdio::null()).status();
        run.is_ok_and(|status| status.success())
    }
}

fn in_environment() -> PathBuf {
    Path::new(".venv").join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// The checkout whose `target` folder holds the program. Whoever can write there could as well have
/// written the program.
fn checkout_of(program: &Path) -> Option<&Path> {
    let target =
        program.ancestors().find(|folder| folder.file_name() == Some("target".as_ref()))?;
    let checkout = target.parent()?;
    checkout.join("export/verify/fabkit_verify/__main__.py").is_file().then_some(checkout)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn only_a_program_in_a_checkouts_target_folder_has_a_checkout() {
        let root = tempfile::tempdir().unwrap();
        let checkout = root.path().join("checkout");
        let package = checkout.join("export/verify/fabkit_verify");
        fs::create_dir_all(&package).unwrap();
        let program = checkout.join("target/release/fabkit");
        assert_eq!(checkout_of(&program), None, "no package there yet");
        fs::write(package.join("__main__.py"), "").unwrap();
        assert_eq!(checkout_of(&program), Some(checkout.as_path()));
        let cross = checkout.join("target/some-triple/release/deps/fabkit-0");
        assert_eq!(checkout_of(&cross), Some(checkout.as_path()));
        for elsewhere in ["fabkit", "bin/fabkit", "export/verify/fabkit"] {
            assert_eq!(checkout_of(&checkout.join(elsewhere)), None, "{elsewhere}");
        }
    }
}
