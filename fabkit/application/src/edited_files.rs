//! Hand-editable files written by a command: cameras, poses and profiles.
//!
//! The same rule as for export folders applies: a file that somebody changed since fabkit wrote it, or that fabkit did
//! not write, is replaced only by force. These files have no manifest beside them, so each carries its own signature:
//! its last line is a comment with the BLAKE3 hash of everything above it.

use std::path::{Path, PathBuf};

use fabkit_files::reading::{self, ExpectedFile, ReadError};
use fabkit_files::{ErrorKind, ErrorSubject, Explained, join_messages};

use crate::source::MAX_YAML_BYTES;

/// Text before and after the hash in a signature line.
const SIGNATURE_PREFIX: &str = "# blake3 of all above: ";
const SIGNATURE_SUFFIX: &str = "\n";

/// Error for files that may not be replaced; it holds at least one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", join_messages(.0))]
pub struct NotReplaced(pub Vec<ReplacementRefusal>);

/// Existing file that blocks the write, with the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplacementRefusal {
    /// The file was changed since fabkit wrote it.
    #[error("{} was changed since fabkit wrote it", .0.display())]
    Changed(PathBuf),
    /// The file was not written by fabkit.
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

/// Returns the text with its signature line appended.
///
/// ```
/// use fabkit_application::edited_files::sign_text;
/// let signed = sign_text("fx_px: 43\n");
/// // The text stays as it is; a comment with its hash follows.
/// let (text, signature) = signed.split_at(10);
/// assert_eq!(text, "fx_px: 43\n");
/// assert!(signature.starts_with("# blake3 of all above: "));
/// ```
pub fn sign_text(text: &str) -> String {
    format!("{text}{SIGNATURE_PREFIX}{}{SIGNATURE_SUFFIX}", blake3::hash(text.as_bytes()).to_hex())
}

/// Returns whether the bytes match their signature line; `None` if they have no signature line.
fn is_unchanged(bytes: &[u8]) -> Option<bool> {
    let text = String::from_utf8_lossy(bytes);
    // The last occurrence counts: the text itself may quote a signature line.
    let at = text.rfind(SIGNATURE_PREFIX)?;
    Some(sign_text(&text[..at]).as_bytes() == bytes)
}

/// Refuses to replace edited or foreign files, all at once, unless `forced`. A file whose content stays the same is
/// never refused.
///
/// # Errors
/// [`NotReplaced`] with all refused files.
///
/// ```
/// use fabkit_application::edited_files::{check_replaceable, sign_text};
/// let file = std::env::temp_dir().join(format!("fabkit-edited-{}.yaml", std::process::id()));
/// let new = [(file.clone(), sign_text("fx_px: 44\n").into_bytes())];
/// std::fs::write(&file, sign_text("fx_px: 43\n"))?;
/// assert!(check_replaceable(&new, false).is_ok());
/// // Somebody edits the file.
/// std::fs::write(&file, sign_text("fx_px: 43\n").replace("43", "45"))?;
/// assert!(check_replaceable(&new, false).is_err() && check_replaceable(&new, true).is_ok());
/// std::fs::remove_file(&file)?;
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn check_replaceable(files: &[(PathBuf, Vec<u8>)], forced: bool) -> Result<(), NotReplaced> {
    let mut refused = Vec::new();
    for (place, new) in files.iter().filter(|(place, _)| !forced && is_hand_editable(place)) {
        match read_existing(place) {
            ExistingFile::Nothing => {}
            ExistingFile::File(bytes) if bytes == *new => {}
            ExistingFile::File(bytes) => match is_unchanged(&bytes) {
                Some(true) => {}
                Some(false) => refused.push(ReplacementRefusal::Changed(place.clone())),
                None => refused.push(ReplacementRefusal::Foreign(place.clone())),
            },
            ExistingFile::Other => refused.push(ReplacementRefusal::Foreign(place.clone())),
        }
    }
    if refused.is_empty() { Ok(()) } else { Err(NotReplaced(refused)) }
}

/// Returns whether people edit this kind of file: YAML only. Reports and images are replaced freely.
fn is_hand_editable(place: &Path) -> bool {
    reading::has_extension(place, "yaml") || reading::has_extension(place, "yml")
}

enum ExistingFile {
    Nothing,
    File(Vec<u8>),
    /// File larger than any that fabkit writes here.
    Other,
}

fn read_existing(place: &Path) -> ExistingFile {
    let expected = ExpectedFile { what: "a file of fabkit's", max_bytes: MAX_YAML_BYTES, hint: "" };
    match reading::read(place, expected) {
        Ok(bytes) => ExistingFile::File(bytes),
        Err(ReadError::TooLarge { .. }) => ExistingFile::Other,
        // A missing file is no obstacle. Other errors, such as a folder in its place, are reported by the write itself.
        Err(_) => ExistingFile::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_of_a_signed_text_is_noticed() {
        let text = sign_text("fx_px: 43\n# mine\n");
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
