//! Files of one command that people go on editing: cameras, poses, profiles.
//!
//! The rule of an export's folder holds for them too: what somebody changed since fabkit wrote it, or
//! what fabkit did not write, is only replaced by force. There is no manifest beside them, so
//! that each says itself what it was: its last line is a comment with the hash of all before it.

use std::path::{Path, PathBuf};

use fabkit_files::reading::{self, Expected, ReadError};
use fabkit_files::{ErrorKind, ErrorSubject, Explained, joined};

use crate::source::MAX_YAML_BYTES;

/// Before and after the hash.
const BEFORE: &str = "# blake3 of all above: ";
const AFTER: &str = "\n";

/// Files that may not be replaced; at least one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", joined(.0))]
pub struct NotReplaced(pub Vec<Authored>);

/// A file that stands in the way.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Authored {
    /// It is not as fabkit wrote it.
    #[error("{} was changed since fabkit wrote it", .0.display())]
    Changed(PathBuf),
    /// It is not fabkit's.
    #[error("{} is there, and fabkit did not write it", .0.display())]
    Foreign(PathBuf),
}

impl Explained for NotReplaced {
    fn kind(&self) -> ErrorKind {
        ErrorKind::BadInput
    }

    fn hint(&self) -> Option<String> {
        Some("choose another file, or have it replaced by force".into())
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("edited_by_hand")
    }
}

/// A text with its last line.
pub fn signed(text: &str) -> String {
    format!("{text}{BEFORE}{}{AFTER}", blake3::hash(text.as_bytes()).to_hex())
}

/// Whether that is what fabkit wrote; nothing if nothing says that fabkit wrote it at all.
fn is_unchanged(bytes: &[u8]) -> Option<bool> {
    let text = String::from_utf8_lossy(bytes);
    let at = text.rfind(BEFORE)?;
    Some(signed(&text[..at]).as_bytes() == bytes)
}

/// Refuses to replace what is not as fabkit wrote it, all at once, unless it is `forced`. What is
/// replaced by its own content is not replaced.
///
/// # Errors
/// [`NotReplaced`] with all of them.
pub fn may_replace(files: &[(PathBuf, Vec<u8>)], forced: bool) -> Result<(), NotReplaced> {
    let mut refused = Vec::new();
    for (place, new) in files.iter().filter(|(place, _)| !forced && is_edited(place)) {
        match found(place) {
            Found::Nothing => {}
            Found::File(bytes) if bytes == *new => {}
            Found::File(bytes) => match is_unchanged(&bytes) {
                Some(true) => {}
                Some(false) => refused.push(Authored::Changed(place.clone())),
                None => refused.push(Authored::Foreign(place.clone())),
            },
            Found::Other => refused.push(Authored::Foreign(place.clone())),
        }
    }
    if refused.is_empty() { Ok(()) } else { Err(NotReplaced(refused)) }
}

/// Reports and pictures are for looking at.
fn is_edited(place: &Path) -> bool {
    reading::has_ending(place, "yaml") || reading::has_ending(place, "yml")
}

enum Found {
    Nothing,
    File(Vec<u8>),
    /// A folder and the like is refused when it is written.
    Other,
}

fn found(place: &Path) -> Found {
    let expected = Expected { what: "a file of fabkit's", max_bytes: MAX_YAML_BYTES, hint: "" };
    match reading::read(place, expected) {
        Ok(bytes) => Found::File(bytes),
        Err(ReadError::TooLarge { .. }) => Found::Other,
        Err(_) => Found::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_of_a_signed_text_is_noticed() {
        let text = signed("fx_px: 43\n# mine\n");
        assert_eq!(is_unchanged(text.as_bytes()), Some(true));
        assert_eq!(is_unchanged(b"fx_px: 43\n"), None);
        for bit in 0..8 * text.len() {
            let mut bytes = text.clone().into_bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(is_unchanged(&bytes), Some(true), "bit {bit}");
        }
        assert_eq!(is_unchanged(format!("{text}more: 1\n").as_bytes()), Some(false));
    }
}
