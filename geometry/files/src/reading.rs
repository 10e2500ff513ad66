//! Bounded reading of foreign files.
//!
//! Every file that fabkit reads passes through here: a pipe without a writer must not block it, a device must not feed
//! it for ever, and nothing larger than its kind of file allows is read.

use std::cmp::Ordering;
pub use std::fs::File;
use std::fs::OpenOptions;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use fabkit_text::{did_you_mean, find_similar};

use crate::{ErrorKind, ErrorSubject, Explained};

/// Expected kind of file.
#[derive(Clone, Copy, Debug)]
pub struct ExpectedFile {
    /// Description for messages, such as `a sensor's file`.
    pub what: &'static str,
    /// Maximum size, bytes.
    pub max_bytes: u64,
    /// Hint for larger files.
    pub hint: &'static str,
}

/// Maximum size of files that people write by hand: sensors, plans, cameras, lists; bytes.
pub const MAX_YAML_BYTES: u64 = 1 << 20;

/// Reason why a file cannot be read.
///
/// ```
/// use fabkit_files::Explained;
/// use fabkit_files::reading::{ReadError, open};
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// folder.write("camera.yaml", b"format: 1\n")?;
/// let error = open(&folder.path_of_file("camrea.yaml")).unwrap_err();
/// assert!(matches!(error, ReadError::Io { .. }));
/// assert_eq!(error.hint().as_deref(), Some("did you mean `camera.yaml`?"));
/// assert_eq!(error.subject().code, "file_missing");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Error of the operating system.
    #[error("cannot read {}: {source}", .path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Folder, device or pipe in place of a file.
    #[error("{} is {found}, not a file", .path.display())]
    NotAFile {
        /// Path.
        path: PathBuf,
        /// Description of what is there.
        found: &'static str,
    },
    /// File larger than its kind allows.
    #[error("{} has {found} bytes; {} has at most {}", .path.display(), .expected.what, .expected.max_bytes)]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// Number of bytes, or `too many` if the file grew while it was read.
        found: String,
        /// Expected kind of file.
        expected: ExpectedFile,
    },
    /// Text that is not UTF-8.
    #[error("{}:{line}: not UTF-8 text (byte {byte})", .path.display())]
    NotText {
        /// Path of the file.
        path: PathBuf,
        /// Line of the first wrong byte, from 1.
        line: usize,
        /// Offset of the first wrong byte, from 1.
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
                suggest_similar_file(path)
            }
            Self::Io { .. } | Self::NotAFile { .. } => None,
            Self::TooLarge { expected, .. } => Some(expected.hint.into()),
            Self::NotText { .. } => Some("save the file as UTF-8".into()),
        }
    }

    fn subject(&self) -> ErrorSubject {
        match self {
            Self::Io { path, source } => ErrorSubject::from_io(path, source, "file_unreadable"),
            Self::NotAFile { path, .. } => ErrorSubject::from_path("not_a_file", path),
            Self::TooLarge { path, .. } => ErrorSubject::from_path("file_too_large", path),
            Self::NotText { path, .. } => ErrorSubject::from_path("not_utf8", path),
        }
    }
}

/// Suggests an existing file with a similar name in the same folder.
fn suggest_similar_file(path: &Path) -> Option<String> {
    /// Maximum number of names to look at: listing larger folders would take too long for a hint.
    const MOST: usize = 2000;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = std::fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let names = entries.take(MOST).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.collect();
    names.sort();
    let written = path.file_name()?.to_str()?;
    // A common extension makes short names look alike: what comes before it must be similar, too.
    let stem = |name: &str| Path::new(name).file_stem()?.to_str().map(str::to_owned);
    let is_near = |name: &&str| {
        let stems = stem(written).zip(stem(name));
        stems.is_some_and(|(written, other)| !find_similar(&written, [&*other]).is_empty())
    };
    let mut found = find_similar(written, names.iter().map(String::as_str));
    found.retain(is_near);
    (!found.is_empty()).then(|| did_you_mean(&found))
}

/// Opens a regular file and returns its length. Other kinds are refused before they are opened, as far as that can be
/// known, and opening never blocks.
///
/// # Errors
/// [`ReadError::Io`], [`ReadError::NotAFile`].
///
/// ```
/// use fabkit_files::reading::{ReadError, open};
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let folder = ScratchFolder::new()?;
/// folder.write("a.bin", &[0; 7])?;
/// assert_eq!(open(&folder.path_of_file("a.bin"))?.1, 7);
/// let refused = open(folder.path());
/// assert!(matches!(refused, Err(ReadError::NotAFile { found: "a folder", .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn open(path: &Path) -> Result<(File, u64), ReadError> {
    let failed = |source| ReadError::Io { path: path.into(), source };
    let check = |found: &std::fs::Metadata| {
        let what = if found.is_dir() { "a folder" } else { "a device or a pipe" };
        if found.is_file() {
            Ok(found.len())
        } else {
            Err(ReadError::NotAFile { path: path.into(), found: what })
        }
    };
    check(&std::fs::metadata(path).map_err(failed)?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    // The name may have been taken by something else after the first check: opening must not block then, nor make a
    // terminal the controlling one.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        libc::O_NONBLOCK | libc::O_NOCTTY,
    );
    let file = options.open(path).map_err(failed)?;
    let length = check(&file.metadata().map_err(failed)?)?;
    Ok((file, length))
}

/// Reads a file. Files that are too large or not regular are refused before reading.
///
/// # Errors
/// [`ReadError::Io`], [`ReadError::NotAFile`] and [`ReadError::TooLarge`].
///
/// ```
/// use fabkit_files::reading::{ExpectedFile, read};
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let expected = ExpectedFile { what: "a key", max_bytes: 4, hint: "it has four bytes" };
/// let folder = ScratchFolder::new()?;
/// folder.write("good", b"1234")?;
/// folder.write("long", b"12345")?;
/// assert_eq!(read(&folder.path_of_file("good"), expected)?, b"1234");
/// let error = read(&folder.path_of_file("long"), expected).unwrap_err();
/// assert!(error.to_string().ends_with("has 5 bytes; a key has at most 4"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(path: &Path, expected: ExpectedFile) -> Result<Vec<u8>, ReadError> {
    let too_large = |found: String| ReadError::TooLarge { path: path.into(), found, expected };
    let (file, length) = open(path)?;
    if length > expected.max_bytes {
        return Err(too_large(length.to_string()));
    }
    // At most `max_bytes`, as checked above.
    let mut bytes = Vec::with_capacity(length as usize);
    // The file may have grown since its length was taken.
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
/// As [`read`]; [`ReadError::NotText`] with the line if the text is not UTF-8.
///
/// ```
/// use fabkit_files::reading::{ExpectedFile, MAX_YAML_BYTES, ReadError, read_text};
/// use fabkit_files::scratch_folder::ScratchFolder;
///
/// let expected = ExpectedFile { what: "a list", max_bytes: MAX_YAML_BYTES, hint: "" };
/// let folder = ScratchFolder::new()?;
/// folder.write("latin-1", b"one\nM\xfcnchen\n")?;
/// let error = read_text(&folder.path_of_file("latin-1"), expected).unwrap_err();
/// assert!(matches!(error, ReadError::NotText { line: 2, byte: 6, .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_text(path: &Path, expected: ExpectedFile) -> Result<String, ReadError> {
    String::from_utf8(read(path, expected)?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|b| **b == b'\n').count();
        ReadError::NotText { path: path.into(), line, byte: valid + 1 }
    })
}

/// Compares names in natural order: runs of digits count as numbers.
///
/// ```
/// use fabkit_files::reading::compare_natural;
/// let mut names = ["7_12.png", "7_2.png", "10.png", "9.png", "07_2.png"];
/// names.sort_by(|a, b| compare_natural(a, b));
/// assert_eq!(names, ["07_2.png", "7_2.png", "7_12.png", "9.png", "10.png"]);
/// ```
pub fn compare_natural(a: &str, b: &str) -> Ordering {
    // Alternating texts and numbers, beginning with a text. Numbers without leading zeros compare by length, then by
    // digits, so they may have any length.
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
    // `07` and `7` are the same number but different names.
    pieces(a).cmp(&pieces(b)).then_with(|| a.cmp(b))
}

/// Returns whether a path has the extension, in any case: `has_extension(path, "png")`.
///
/// ```
/// use std::path::Path;
///
/// use fabkit_files::reading::has_extension;
///
/// assert!(has_extension(Path::new("image.PNG"), "png"));
/// assert!(!has_extension(Path::new("image.png.txt"), "png"));
/// assert!(!has_extension(Path::new("png"), "png"));
/// ```
pub fn has_extension(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: ExpectedFile = ExpectedFile { what: "a note", max_bytes: 4, hint: "shorten it" };

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
    fn devices_and_links_to_them_are_refused() {
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
