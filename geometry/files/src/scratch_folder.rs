//! Temporary folders for other programs to work in.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// Temporary folder that is removed with its content when this is dropped.
///
/// ```
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// folder.write("in.txt", b"asked")?;
/// // Another program would write its answer here.
/// assert_eq!(folder.read("in.txt"), b"asked");
/// assert!(folder.read("out.txt").is_empty());
/// let path = folder.path().to_owned();
/// drop(folder);
/// assert!(!path.exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ScratchFolder(TempDir);

impl ScratchFolder {
    /// Creates a temporary folder.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn new() -> io::Result<Self> {
        tempfile::tempdir().map(Self)
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Returns the path of a name inside the folder.
    pub fn path_of_file(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Writes a file.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        fs::write(self.path_of_file(name), bytes)
    }

    /// Creates a subfolder.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn make_folder(&self, name: &str) -> io::Result<()> {
        fs::create_dir(self.path_of_file(name))
    }

    /// Creates an empty file and opens it, for another program to write to.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn create(&self, name: &str) -> io::Result<File> {
        File::create(self.path_of_file(name))
    }

    /// Reads a file that another program wrote; empty if it wrote none.
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path_of_file(name)).unwrap_or_default()
    }
}
