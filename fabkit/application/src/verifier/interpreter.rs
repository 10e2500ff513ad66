//! Selection and isolation of the Python interpreter.
//!
//! One rule finds it: [`PYTHON_VARIABLE`] names it by an absolute path, or else it is that of `.venv` in fabkit's
//! checkout, for a program that cargo built there. The working folder, the search path and the folders above them are
//! never searched, because they may hold anything.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::VerifierError;
pub use crate::programs::PYTHON_VARIABLE;
use crate::programs::{Program, RelativeProgram};

/// Python interpreter with the package.
#[derive(Clone, Debug)]
pub(super) struct Interpreter {
    program: Program,
}

impl Interpreter {
    /// Finds the interpreter by the rule above.
    pub(super) fn find(folder: &Path) -> Result<Self, VerifierError> {
        let relative = |RelativeProgram(path)| VerifierError::RelativePython(path);
        let Some(program) = Program::from_variable(PYTHON_VARIABLE).map_err(relative)? else {
            let own = env::current_exe().ok();
            let checkout = own.as_deref().and_then(find_checkout);
            let path = checkout.ok_or(VerifierError::NoEnvironment)?.join(interpreter_path());
            let found = Self { program: Program::new(path).map_err(relative)? };
            return if found.has_package(folder) {
                Ok(found)
            } else {
                Err(VerifierError::NoEnvironment)
            };
        };
        let named = Self { program };
        if named.has_package(folder) {
            Ok(named)
        } else {
            Err(VerifierError::NoPackage(named.path().to_owned()))
        }
    }

    /// Returns its path.
    pub(super) fn path(&self) -> &Path {
        self.program.path()
    }

    /// Makes a command of the interpreter that runs in `folder`. It is isolated (`-I`): neither the folder nor a
    /// script's folder nor the user's packages are searched, and `PYTHON` variables are ignored. They are also removed,
    /// because child processes would read them.
    pub(super) fn command(&self, folder: &Path) -> Command {
        let mut command = self.program.command();
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

fn interpreter_path() -> PathBuf {
    Path::new(".venv").join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" })
}

/// Finds the checkout whose `target` folder holds the program. Trusting it is safe: whoever can write there could also
/// have replaced the program.
fn find_checkout(program: &Path) -> Option<&Path> {
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
        assert_eq!(find_checkout(&program), None, "no package there yet");
        fs::write(package.join("__main__.py"), "").unwrap();
        assert_eq!(find_checkout(&program), Some(checkout.as_path()));
        let cross = checkout.join("target/some-triple/release/deps/fabkit-0");
        assert_eq!(find_checkout(&cross), Some(checkout.as_path()));
        for elsewhere in ["fabkit", "bin/fabkit", "export/verify/fabkit"] {
            assert_eq!(find_checkout(&checkout.join(elsewhere)), None, "{elsewhere}");
        }
    }
}
