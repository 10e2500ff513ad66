//! Files that others wrote: read whole, or refused with what is wrong.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use crate::failure::{Exit, Failure};

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

/// Reads a file. Refuses what is too large or no file before reading it: a pipe may never end.
///
/// # Errors
/// No such file, a folder or a device, too many bytes, or the system's own reasons.
pub fn bytes(path: &Path, expected: Expected) -> Result<Vec<u8>, Failure> {
    let shown = path.display();
    let unreadable = |error: io::Error| {
        let exit = match error.kind() {
            io::ErrorKind::NotFound => Exit::BadInput,
            _ => Exit::Io,
        };
        Failure::plain(exit, format!("cannot read {shown}: {error}"))
    };
    let Expected { what, max_bytes, hint } = expected;
    let too_large = |found: &str| {
        let message = format!("{shown} has {found} bytes; {what} has at most {max_bytes}");
        Failure::new(Exit::Limit, message, hint)
    };
    let found = fs::metadata(path).map_err(unreadable)?;
    if !found.is_file() {
        let what = if found.is_dir() { "a folder" } else { "a device or a pipe" };
        return Err(Failure::plain(Exit::BadInput, format!("{shown} is {what}, not a file")));
    }
    if found.len() > max_bytes {
        return Err(too_large(&found.len().to_string()));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    // It may have grown since.
    file.take(max_bytes + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > max_bytes {
        return Err(too_large("too many"));
    }
    Ok(bytes)
}

/// Reads a text file.
///
/// # Errors
/// As [`bytes`]; text that is not UTF-8, with its line.
pub fn text(path: &Path, expected: Expected) -> Result<String, Failure> {
    String::from_utf8(bytes(path, expected)?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|b| **b == b'\n').count();
        let message = format!("{}:{line}: not UTF-8 text (byte {})", path.display(), valid + 1);
        Failure::new(Exit::BadInput, message, "save the file as UTF-8")
    })
}
