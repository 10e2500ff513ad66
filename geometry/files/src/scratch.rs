//! Temporary folders in which other programs work.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A temporary folder that is removed with all that it holds when this is dropped.
#[derive(Debug)]
pub struct Scratch(TempDir);

impl Scratch {
    /// Makes one.
    ///
    /// # Errors
    /// The system's reasons.
    pub fn new() -> io::Result<Self> {
        tempfile::tempdir().map(Self)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Where something of that name lies in it.
    pub fn place(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    /// Writes a file.
    ///
    /// # Errors
    /// The system's reasons.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        fs::write(self.place(name), bytes)
    }

    /// Makes a folder in it.
    ///
    /// # Errors
    /// The system's reasons.
    pub fn make_folder(&self, name: &str) -> io::Result<()> {
        fs::create_dir(self.place(name))
    }

    /// Opens an empty file for another program to write to.
    ///
    /// # Errors
    /// The system's reasons.
    pub fn create(&self, name: &str) -> io::Result<File> {
        File::create(self.place(name))
    }

    /// Reads a file that another program wrote; nothing where it wrote none.
    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.place(name)).unwrap_or_default()
    }
}
