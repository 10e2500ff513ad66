//! Files that others wrote: read whole, or refused with what is wrong.
//!
//! Everything that fabkit reads comes through here: a pipe that nobody writes to must not stop it, a
//! device must not feed it for ever, and nothing is read that is larger than its kind can be.

use std::cmp::Ordering;
pub use std::fs::File;
use std::fs::OpenOptions;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use fabkit_text::{did_you_mean, similar};

use crate::{ErrorKind, ErrorSubject, Explained};

/// What a file is expected to be.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    /// For messages: `a sensor's file`.
    pub what: &'static str,
    /// Its largest size.
    pub max_bytes: u64,
    /// What to do if it is larger.
    pub hint: &'static str,
}

/// Largest size of files that people write by hand: sensors, plans, cameras, lists.
pub const MAX_YAML_BYTES: u64 = 1 << 20;

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system said no.
    #[error("cannot read {}: {source}", .path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A folder, a device or a pipe.
    #[error("{} is {found}, not a file", .path.display())]
    NotAFile {
        /// Where.
        path: PathBuf,
        /// What is there.
        found: &'static str,
    },
    /// More than its kind can have.
    #[error("{} has {found} bytes; {} has at most {}", .path.display(), .expected.what, .expected.max_bytes)]
    TooLarge {
        /// Which file.
        path: PathBuf,
        /// How many, or `too many` if it grew while it was read.
        found: String,
        /// What it was taken for.
        expected: Expected,
    },
    /// Text that is none.
    #[error("{}:{line}: not UTF-8 text (byte {byte})", .path.display())]
    NotText {
        /// Which file.
        path: PathBuf,
        /// Of the first byte that is wrong, counted from 1.
        line: usize,
        /// The same.
        byte: usize,
    },
}

impl Explained for ReadError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Io { .. } => ErrorKind::Io,
            Self::TooLarge { .. } => ErrorKind::Limit,
            Self::NotAFile { .. } | Self::NotText { .. } => ErrorKind::BadInput,
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Io { path, source } if source.kind() == io::ErrorKind::NotFound => {
                neighbour_named_like(path)
            }
            Self::Io { .. } | Self::NotAFile { .. } => None,
            Self::TooLarge { expected, .. } => Some(expected.hint.into()),
            Self::NotText { .. } => Some("save the file as UTF-8".into()),
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Io { path, source } => ErrorSubject::of_io(path, source, "file_unreadable"),
            Self::NotAFile { path, .. } => ErrorSubject::at("not_a_file", path),
            Self::TooLarge { path, .. } => ErrorSubject::at("file_too_large", path),
            Self::NotText { path, .. } => ErrorSubject::at("not_utf8", path),
        }
    }
}

/// What is there under a similar name, where nothing is under this one.
fn neighbour_named_like(path: &Path) -> Option<String> {
    /// More names in a folder take longer to read than a slip is worth.
    const MOST: usize = 2000;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let names = entries.take(MOST).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.collect();
    names.sort();
    let similar = similar(path.file_name()?.to_str()?, names.iter().map(String::as_str));
    (!similar.is_empty()).then(|| did_you_mean(&similar))
}

/// Opens a regular file, and says how long it is. Nothing else is opened: not even for a moment, as
/// far as that can be known before, and never with waiting.
///
/// # Errors
/// [`ReadError::Io`], [`ReadError::NotAFile`].
pub fn open(path: &Path) -> Result<(File, u64), ReadError> {
    let failed = |source| ReadError::Io { path: path.into(), source };
    let check = |found: &std::fs::Metadata| {
        let what = if found.is_dir() { "a folder" } else { "a device or a pipe" };
        match found.is_file() {
            true => Ok(found.len()),
            false => Err(ReadError::NotAFile { path: path.into(), found: what }),
        }
    };
    check(&std::fs::metadata(path).map_err(failed)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    // Something else may have taken the name since.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        libc::O_NONBLOCK | libc::O_NOCTTY,
    );
    let file = options.open(path).map_err(failed)?;
    let length = check(&file.metadata().map_err(failed)?)?;
    Ok((file, length))
}

/// Reads a file. Refuses what is too large or no file before reading it.
///
/// # Errors
/// No such file, a folder or a device, too many bytes, or the system's own reasons.
pub fn read(path: &Path, expected: Expected) -> Result<Vec<u8>, ReadError> {
    let too_large = |found: String| ReadError::TooLarge { path: path.into(), found, expected };
    let (file, length) = open(path)?;
    if length > expected.max_bytes {
        return Err(too_large(length.to_string()));
    }
    // At most `max_bytes`, which was just checked.
    let mut bytes = Vec::with_capacity(length as usize);
    // It may have grown since.
    let read = file.take(expected.max_bytes + 1).read_to_end(&mut bytes);
    read.map_err(|source| ReadError::Io { path: path.into(), source })?;
    if bytes.len() as u64 > expected.max_bytes {
        return Err(too_large("too many".into()));
    }
    Ok(bytes)
}

/// Reads a text file.
///
/// # Errors
/// As [`read`]; text that is not UTF-8, with its line.
pub fn read_text(path: &Path, expected: Expected) -> Result<String, ReadError> {
    String::from_utf8(read(path, expected)?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|b| **b == b'\n').count();
        ReadError::NotText { path: path.into(), line, byte: valid + 1 }
    })
}

/// The order in which people look for names: runs of digits count as numbers.
///
/// ```
/// use fabkit_files::reading::natural_order;
/// let mut names = ["7_12.png", "7_2.png", "10.png", "9.png", "07_2.png"];
/// names.sort_by(|a, b| natural_order(a, b));
/// assert_eq!(names, ["07_2.png", "7_2.png", "7_12.png", "9.png", "10.png"]);
/// ```
pub fn natural_order(a: &str, b: &str) -> Ordering {
    // Texts and numbers by turns, a text first; as many digits as there are.
    let pieces = |name: &str| {
        let mut pieces: Vec<(String, String)> = vec![Default::default()];
        for c in name.chars() {
            match pieces.last_mut() {
                Some((_, number)) if c.is_ascii_digit() => number.push(c),
                Some((text, number)) if number.is_empty() => text.push(c),
                _ => pieces.push((c.into(), String::new())),
            }
        }
        let valued = |(text, number): (String, String)| {
            let value = number.trim_start_matches('0').to_owned();
            (text, value.len(), value)
        };
        pieces.into_iter().map(valued).collect::<Vec<_>>()
    };
    // `07` and `7` are the same number, not the same name.
    pieces(a).cmp(&pieces(b)).then_with(|| a.cmp(b))
}

/// Whether a name ends as files of a kind do: `has_ending(path, "png")`.
pub fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Expected = Expected { what: "a note", max_bytes: 4, hint: "shorten it" };

    #[test]
    fn only_small_files_of_text_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        };
        assert_eq!(read(&write("4", b"1234"), SMALL).unwrap(), b"1234");
        let long = read(&write("5", b"12345"), SMALL).unwrap_err();
        assert!(long.to_string().ends_with("has 5 bytes; a note has at most 4"), "{long}");
        let wrong = read_text(&write("utf", b"a\n\xff"), SMALL).unwrap_err();
        assert!(matches!(wrong, ReadError::NotText { line: 2, byte: 3, .. }), "{wrong}");
        assert!(matches!(open(folder.path()), Err(ReadError::NotAFile { .. })));
        assert!(matches!(open(&folder.path().join("none")), Err(ReadError::Io { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_what_they_pretend_to_be_are_refused() {
        for device in ["/dev/zero", "/dev/null", "/dev/tty"] {
            if !Path::new(device).exists() {
                continue;
            }
            let link = tempfile::tempdir().unwrap();
            let link = link.path().join("link.csv");
            let _ = std::os::unix::fs::symlink(device, &link);
            for path in [Path::new(device), &link] {
                let refused = open(path);
                assert!(refused.is_err(), "{}", path.display());
            }
        }
    }
}
