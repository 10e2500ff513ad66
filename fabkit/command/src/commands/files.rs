//! Output files of a command, at any place.

use std::path::Path;
use std::path::PathBuf;

use fabkit_application::staging::write_each;
use serde_json::{Value, json};

use super::Failure;
use crate::interrupt;
use crate::table::format_size;

/// Files with their contents, written together.
#[derive(Default)]
pub(super) struct Files(Vec<(PathBuf, Vec<u8>)>);

impl Files {
    pub(super) fn add(&mut self, path: &Path, bytes: Vec<u8>) {
        self.0.push((path.to_owned(), bytes));
    }

    /// Writes all files or none.
    pub(super) fn write(&self) -> Result<(), Failure> {
        interrupt::begin_writing()?;
        let files = self.0.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
        Ok(write_each(files, &interrupt::is_requested)?)
    }

    /// Lists the files, one line for each.
    pub(super) fn text(&self) -> String {
        let lines = self.0.iter().map(|(path, bytes)| {
            format!("{}: {}\n", path.display(), format_size(bytes.len() as u64))
        });
        lines.collect()
    }

    /// Lists the files with their sizes.
    pub(super) fn json(&self) -> Value {
        let files = self.0.iter().map(
            |(path, bytes)| json!({ "file": path.display().to_string(), "bytes": bytes.len() }),
        );
        files.collect()
    }
}
