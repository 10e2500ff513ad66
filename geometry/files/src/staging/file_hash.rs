//! Hashes of files on disk.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use super::StagingError;

/// Computes the BLAKE3 hash of a file's content, in hex; `None` if there is no regular file.
///
/// # Errors
/// [`StagingError::Io`] for errors of the operating system.
///
/// ```
/// use fabkit_files::staging::hash_file;
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// folder.write("empty", b"")?;
/// let hash = hash_file(&folder.path_of_file("empty"))?;
/// // BLAKE3 of no bytes.
/// assert!(hash.is_some_and(|hex| hex.len() == 64 && hex.starts_with("af1349b9")));
/// assert_eq!(hash_file(folder.path())?, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn hash_file(path: &Path) -> Result<Option<String>, StagingError> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => {}
        Ok(_) => return Ok(None),
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(source) => {
            return Err(StagingError::Io { action: "look at", path: path.into(), source });
        }
    }
    let mut hasher = blake3::Hasher::new();
    File::open(path)
        // Read in pieces: the file may be larger than the memory.
        .and_then(|file| hasher.update_reader(file).map(drop))
        .map_err(|source| StagingError::Io { action: "read", path: path.into(), source })?;
    Ok(Some(hasher.finalize().to_hex().to_string()))
}
