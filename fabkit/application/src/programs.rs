//! Programs of other people that fabkit starts: interpreters of Python and the slicer. This is the only place that does.
//!
//! A program is named by an absolute path, or found in an absolute folder of the search path. A relative one would be
//! another program in every folder, also in one that somebody else filled.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Environment variable with the path of the Python interpreter.
pub const PYTHON_VARIABLE: &str = "FABKIT_PYTHON";

/// Path of a program that is not absolute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RelativeProgram(pub(crate) PathBuf);

/// Program by its absolute path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Program {
    path: PathBuf,
}

impl Program {
    /// Creates a program from its path, which must be absolute.
    pub(crate) fn new(path: PathBuf) -> Result<Self, RelativeProgram> {
        if path.is_absolute() { Ok(Self { path }) } else { Err(RelativeProgram(path)) }
    }

    /// Returns the program that an environment variable names, if it names one.
    pub(crate) fn from_variable(variable: &str) -> Result<Option<Self>, RelativeProgram> {
        let named = env::var_os(variable).filter(|name| !name.is_empty());
        named.map(|name| Self::new(name.into())).transpose()
    }

    /// Finds a program in the absolute folders of the search path.
    pub(crate) fn find(name: &str) -> Option<Self> {
        let path = env::var_os("PATH").unwrap_or_default();
        let folders = env::split_paths(&path).filter(|folder| folder.is_absolute());
        let file = format!("{name}{}", env::consts::EXE_SUFFIX);
        let mut places = folders.map(|folder| folder.join(&file));
        places.find(|place| place.is_file()).map(|path| Self { path })
    }

    /// Returns its path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Makes a command of it.
    pub(crate) fn command(&self) -> Command {
        Command::new(&self.path)
    }
}

/// Finds the Python interpreter with the user's packages: the one that `FABKIT_PYTHON` names, or `python3`; `None` if there
/// is none.
pub(crate) fn find_python() -> Result<Option<Program>, RelativeProgram> {
    Ok(Program::from_variable(PYTHON_VARIABLE)?.or_else(|| Program::find("python3")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_absolute_paths_are_programs() {
        for path in ["python3", "./python3", "../bin/python3"] {
            assert_eq!(Program::new(path.into()), Err(RelativeProgram(path.into())));
        }
        let path = env::temp_dir().join("python3");
        assert_eq!(Program::new(path.clone()).map(|program| program.path), Ok(path));
    }
}
