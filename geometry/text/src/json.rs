//! JSON documents that programs write, with a format name and a version.

use serde::de::DeserializeOwned;

use crate::Json;

/// Error of a text that is not such a document: all its problems.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("not a {what}: {}", crate::list_problems(.problems, "; "))]
pub struct InvalidDocument {
    /// Name of the expected document, for example `calibration board`.
    pub what: &'static str,
    /// Problems, at least one; each names the place, the value and the limit.
    pub problems: Vec<String>,
}

/// Kind of JSON document.
///
/// ```
/// use fabkit_text::{Json, JsonFormat};
///
/// const BOARD: JsonFormat =
///     JsonFormat { what: "board", format: "board", version: 1, max_bytes: 1000 };
/// let text = r#"{"format": "board", "version": 1, "squares": 8}"#;
/// let board: Json = BOARD.read(text, &BOARD.parse(text)?)?;
/// assert_eq!(board["squares"], 8);
/// let newer = r#"{"format": "board", "version": 2}"#;
/// let error = BOARD.read::<Json>(newer, &BOARD.parse(newer)?).unwrap_err();
/// assert!(error.to_string().starts_with("not a board: format \"board\" version 2;"));
/// # Ok::<(), fabkit_text::InvalidDocument>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct JsonFormat {
    /// Name of the kind, for messages.
    pub what: &'static str,
    /// Value of the key `format`.
    pub format: &'static str,
    /// Value of the key `version`.
    pub version: u32,
    /// Maximum length of the text, bytes.
    pub max_bytes: usize,
}

impl JsonFormat {
    /// Creates an error with one problem.
    pub fn refuse(&self, problem: impl Into<String>) -> InvalidDocument {
        InvalidDocument { what: self.what, problems: vec![problem.into()] }
    }

    /// Returns an error unless `problems` is empty.
    ///
    /// # Errors
    /// The problems, if there are any.
    ///
    /// ```
    /// let board = fabkit_text::JsonFormat { what: "board", format: "board", version: 1, max_bytes: 1000 };
    /// assert!(board.accept(Vec::new()).is_ok());
    /// let problems = vec!["rows is 0; at least 2".to_owned(), "there is no pitch".to_owned()];
    /// let error = board.accept(problems).unwrap_err();
    /// assert_eq!(error.to_string(), "not a board: rows is 0; at least 2; there is no pitch");
    /// ```
    pub fn accept(&self, problems: Vec<String>) -> Result<(), InvalidDocument> {
        if problems.is_empty() {
            Ok(())
        } else {
            Err(InvalidDocument { what: self.what, problems })
        }
    }

    /// Reads a text as JSON of any form.
    ///
    /// # Errors
    /// If the text is too long or is not JSON (with line and column).
    pub fn parse(&self, text: &str) -> Result<Json, InvalidDocument> {
        if text.len() > self.max_bytes {
            let (found, most) = (text.len(), self.max_bytes);
            return Err(self.refuse(format!("{found} bytes; at most {most} are read")));
        }
        serde_json::from_str(text).map_err(|error| self.refuse(error.to_string()))
    }

    /// Reads a document of this format; `parsed` is the same text as a JSON value.
    ///
    /// # Errors
    /// If format or version differ, or the document does not fit the type (with line and column).
    pub fn read<T: DeserializeOwned>(
        &self,
        text: &str,
        parsed: &Json,
    ) -> Result<T, InvalidDocument> {
        // Checked before the content, because other versions may have other fields.
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
        // Parsed from the text again, because only then messages contain a line number.
        serde_json::from_str(text).map_err(|error| self.refuse(error.to_string()))
    }
}
