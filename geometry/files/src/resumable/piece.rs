//! Recorded size and hash of one file in a folder, and its verification.

use std::fs;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use blake3::Hash;
use serde_json::{Value, json};

use super::ResumableFolderError;
use crate::reading::{self, ExpectedFile, ReadError};

/// Size and hash of a file.
///
/// ```
/// use fabkit_files::resumable::{Piece, PieceState};
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// let piece = Piece::from_bytes(b"zero");
/// assert_eq!(piece.verify(folder.path(), "0.png")?, PieceState::Missing);
/// folder.write("0.png", b"zero")?;
/// assert_eq!(piece.verify(folder.path(), "0.png")?, PieceState::Intact);
/// folder.write("0.png", b"more than that")?;
/// let changed = PieceState::Changed("it has 14 bytes, and was written with 4".into());
/// assert_eq!(piece.verify(folder.path(), "0.png")?, changed);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    bytes: u64,
    hash: Hash,
}

/// State of a recorded file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PieceState {
    /// File with the recorded content.
    Intact,
    /// No file.
    Missing,
    /// Something else under the name: other bytes, a folder, a link, a pipe. Holds the description.
    Changed(String),
}

impl Piece {
    /// Computes size and hash of the content.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, hash: blake3::hash(bytes) }
    }

    /// Formats a line of the journal.
    pub(super) fn journal_line(&self, name: &str) -> String {
        format!("{} {} {name}\n", self.hash.to_hex(), self.bytes)
    }

    /// Parses a line of the journal.
    pub(super) fn from_line(line: &str) -> Option<(String, Self)> {
        let (hash, rest) = line.split_once(' ')?;
        let (bytes, name) = rest.split_once(' ')?;
        let piece = Self { bytes: bytes.parse().ok()?, hash: Hash::from_hex(hash).ok()? };
        // Names that lead out of the folder come from a damaged journal.
        is_safe_name(name).then(|| (name.to_owned(), piece))
    }

    /// Converts to an entry of a document's list of files.
    pub(super) fn to_json(self) -> Value {
        json!({ "bytes": self.bytes, "blake3": self.hash.to_hex().as_str() })
    }

    /// Parses an entry of a document's list of files.
    pub(super) fn from_json(value: &Value) -> Option<Self> {
        let hash = Hash::from_hex(value["blake3"].as_str()?).ok()?;
        Some(Self { bytes: value["bytes"].as_u64()?, hash })
    }

    /// Creates a piece from another program's list: size, and BLAKE3 in hex; `None` if the hash is malformed.
    ///
    /// ```
    /// use fabkit_files::resumable::Piece;
    ///
    /// // BLAKE3 of no bytes.
    /// let hash = "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262";
    /// assert_eq!(Piece::from_listing(0, hash), Some(Piece::from_bytes(b"")));
    /// assert_eq!(Piece::from_listing(0, "af13"), None);
    /// ```
    pub fn from_listing(bytes: u64, blake3: &str) -> Option<Self> {
        Some(Self { bytes, hash: Hash::from_hex(blake3).ok()? })
    }

    /// Returns the size in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Verifies a file against the recorded size and hash. Only a regular file of the right size is opened, and no link
    /// on the way is followed.
    ///
    /// # Errors
    /// [`ResumableFolderError::Io`].
    pub fn verify(&self, folder: &Path, name: &str) -> Result<PieceState, ResumableFolderError> {
        let other = |what: String| Ok(PieceState::Changed(what));
        if let Some(link) = find_link_on_path(folder, name)? {
            return other(format!("{} is a symbolic link", link.display()));
        }
        let path = folder.join(name);
        match fs::symlink_metadata(&path) {
            Ok(found) if !found.is_file() => other("it is not a file".into()),
            Ok(found) if found.len() != self.bytes => {
                other(format!("it has {} bytes, and was written with {}", found.len(), self.bytes))
            }
            Ok(_) => {
                let mut hasher = blake3::Hasher::new();
                let mut buffer = vec![0; 128 << 10];
                let read = |e| ResumableFolderError::io("read", &path, e);
                // One byte more than recorded is read, so that a file that has grown is noticed.
                let mut file = match reading::open(&path) {
                    Ok((file, _)) => file.take(self.bytes + 1),
                    Err(ReadError::Io { source, .. }) => return Err(read(source)),
                    Err(error) => return other(error.to_string()),
                };
                loop {
                    match file.read(&mut buffer) {
                        Ok(0) => break,
                        Ok(count) => drop(hasher.update(&buffer[..count])),
                        // A signal arrived: try again.
                        Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                        Err(error) => return Err(read(error)),
                    }
                }
                if hasher.finalize() == self.hash {
                    Ok(PieceState::Intact)
                } else {
                    other("its checksum is another".into())
                }
            }
            Err(error) if is_absent(&error) => Ok(PieceState::Missing),
            Err(error) => Err(ResumableFolderError::io("look at", &path, error)),
        }
    }

    /// Reads the content and verifies it.
    ///
    /// # Errors
    /// [`ResumableFolderError::Damaged`] and [`ResumableFolderError::Io`].
    pub fn read(&self, folder: &Path, name: &str) -> Result<Vec<u8>, ResumableFolderError> {
        let path = folder.join(name);
        let damaged =
            |what: &str| ResumableFolderError::Damaged { path: path.clone(), what: what.into() };
        match read_regular(&path, self.bytes) {
            Ok(Some(bytes)) if Self::from_bytes(&bytes) == *self => Ok(bytes),
            Ok(Some(bytes)) if bytes.len() as u64 == self.bytes => {
                Err(damaged("its checksum is another"))
            }
            Ok(Some(_)) => Err(damaged(&format!("it has not its {} bytes", self.bytes))),
            Ok(None) => Err(damaged("it is missing")),
            Err(error) => Err(error),
        }
    }
}

/// Reads a regular file of at most `max_bytes`; `None` if it does not exist.
///
/// # Errors
/// [`ResumableFolderError::Damaged`] for something other than a file, or a file that is too long; [`ResumableFolderError::Io`].
///
/// ```
/// use fabkit_files::resumable::read_regular;
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// folder.write("a", b"12345")?;
/// assert_eq!(read_regular(&folder.path_of_file("a"), 5)?, Some(b"12345".to_vec()));
/// assert_eq!(read_regular(&folder.path_of_file("b"), 5)?, None);
/// let error = read_regular(&folder.path_of_file("a"), 4).unwrap_err();
/// assert!(error.to_string().ends_with("is damaged: it has 5 bytes; it had at most 4"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_regular(path: &Path, max_bytes: u64) -> Result<Option<Vec<u8>>, ResumableFolderError> {
    let damaged = |what| Err(ResumableFolderError::Damaged { path: path.into(), what });
    match reading::read(path, ExpectedFile { what: "it", max_bytes, hint: "" }) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(ReadError::Io { source, .. }) if is_absent(&source) => Ok(None),
        Err(ReadError::Io { source, .. }) => Err(ResumableFolderError::io("read", path, source)),
        Err(ReadError::NotAFile { found, .. }) => damaged(format!("it is {found}, not a file")),
        Err(ReadError::TooLarge { found, .. }) => {
            damaged(format!("it has {found} bytes; it had at most {max_bytes}"))
        }
        Err(error @ ReadError::NotText { .. }) => damaged(error.to_string()),
    }
}

/// Returns whether the error means that there is no such file.
fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// Returns whether a name stays within its folder on every operating system, and on one line.
///
/// ```
/// use fabkit_files::resumable::is_safe_name;
///
/// assert!(is_safe_name("images/0.png"));
/// for outside in ["../0.png", "/etc/passwd", "C:\\x", "a//b", "./a", "a\nb", ""] {
///     assert!(!is_safe_name(outside));
/// }
/// ```
pub fn is_safe_name(name: &str) -> bool {
    let is_normal = |part: Component| matches!(part, Component::Normal(_));
    // `\` and `:` separate paths on Windows.
    let is_clean = |c: char| !c.is_control() && !['\\', ':'].contains(&c);
    !name.is_empty()
        && name.chars().all(is_clean)
        && name.split('/').all(|part| !["", ".", ".."].contains(&part))
        && Path::new(name).components().all(is_normal)
}

/// Returns the first folder on the way to a file that is a symbolic link.
pub(super) fn find_link_on_path(
    folder: &Path,
    name: &str,
) -> Result<Option<PathBuf>, ResumableFolderError> {
    let mut path = folder.to_path_buf();
    let mut parts: Vec<&str> = name.split('/').collect();
    parts.pop();
    for part in parts {
        path.push(part);
        match fs::symlink_metadata(&path) {
            Ok(found) if found.is_symlink() => return Ok(Some(path)),
            Ok(_) => {}
            Err(error) if is_absent(&error) => return Ok(None),
            Err(error) => return Err(ResumableFolderError::io("look at", &path, error)),
        }
    }
    Ok(None)
}
