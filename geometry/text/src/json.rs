//! Documents that programs write: JSON that says its format and version.

use serde::de::DeserializeOwned;

use crate::Json;

/// Why a text is not such a document: everything that is wrong with it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("not a {what}: {}", .problems.join("; "))]
pub struct InvalidDocument {
    /// What it should be, for example `calibration board`.
    pub what: &'static str,
    /// At least one; each names the place, the value and the limit.
    pub problems: Vec<String>,
}

/// A kind of document.
#[derive(Clone, Copy, Debug)]
pub struct JsonFormat {
    /// What it is, for messages.
    pub what: &'static str,
    /// What stands behind `format`.
    pub format: &'static str,
    /// What stands behind `version`.
    pub version: u32,
    /// Longest text, bytes.
    pub max_bytes: usize,
}

impl JsonFormat {
    /// Something is wrong.
    pub fn refuse(&self, problem: impl Into<String>) -> InvalidDocument {
        InvalidDocument { what: self.what, problems: vec![problem.into()] }
    }

    /// Accepts what nothing is wrong with.
    ///
    /// # Errors
    /// The problems, if there are any.
    pub fn accept(&self, problems: Vec<String>) -> Result<(), InvalidDocument> {
        match problems.is_empty() {
            true => Ok(()),
            false => Err(InvalidDocument { what: self.what, problems }),
        }
    }

    /// Reads a text as JSON of any form.
    ///
    /// # Errors
    /// Text that is too long or no JSON, with line and column.
    pub fn parse(&self, text: &str) -> Result<Json, InvalidDocument> {
        if text.len() > self.max_bytes {
            let (found, most) = (text.len(), self.max_bytes);
            return Err(self.refuse(format!("{found} bytes; at most {most} are read")));
        }
        serde_json::from_str(text).map_err(|error| self.refuse(error.to_string()))
    }

    /// Reads a document of this format; `parsed` is what the text holds.
    ///
    /// # Errors
    /// Other formats and versions; what does not fit the type, with line and column.
    pub fn read<T: DeserializeOwned>(
        &self,
        text: &str,
        parsed: &Json,
    ) -> Result<T, InvalidDocument> {
        let of = |key| parsed.get(key).unwrap_or(&Json::Null);
        if of("format") != self.format || of("version") != self.version {
            return Err(self.refuse(format!(
                "format {} version {}; this fabkit reads \"{}\" version {}",
                of("format"),
                of("version"),
                self.format,
                self.version
            )));
        }
        // From the text again: only then do messages name a line.
        serde_json::from_str(text).map_err(|error| self.refuse(error.to_string()))
    }
}
