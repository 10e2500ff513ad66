//! How much memory a command may take, and who may not begin because of it.
//!
//! Whoever is about to do something whose memory grows with what was asked for says beforehand how
//! much that is, from figures that were measured, and is refused above the limit. Nothing here counts
//! what is really taken: a test compares both. The command sets the limit, once; a program that uses
//! fabkit as a library has none unless it sets one.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::{ErrorKind, ErrorSubject, Explained};

/// Of the command, unless it is told otherwise, bytes.
pub const DEFAULT_LIMIT: u64 = 2 * GB;
/// Least and most that can be asked for, bytes.
pub const LIMITS: [u64; 2] = [100 * MB, 1024 * GB];

/// A million bytes.
pub const MB: u64 = 1_000_000;
/// A thousand million bytes.
pub const GB: u64 = 1000 * MB;

/// What the process itself takes, with a sensor and its fixtures, bytes.
const PROCESS: u64 = 50 * MB;

static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);

/// Allows this many bytes from now on, for all threads.
pub fn set_limit(bytes: u64) {
    LIMIT.store(bytes, Ordering::Relaxed);
}

/// What there is besides the process itself, bytes.
pub fn room() -> u64 {
    LIMIT.load(Ordering::Relaxed).saturating_sub(PROCESS)
}

/// What there could be less of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Less {
    /// Rays for each pixel, and files made of them.
    Rays,
    /// Pixels of a picture that is drawn.
    Pixels,
    /// Pixels of the camera.
    Camera,
    /// Pixels of pictures that are read.
    Pictures,
    /// How many pictures at once.
    Files,
    /// Variants of a sweep.
    Variants,
    /// Channels of a network.
    Network,
    /// Nothing: the data set is as it is.
    Nothing,
}

impl Less {
    fn hint(self) -> &'static str {
        match self {
            Self::Rays => "ask for fewer samples or files",
            Self::Pixels => "ask for a smaller picture",
            Self::Files => "give fewer pictures at once",
            Self::Camera => "take a smaller camera",
            Self::Pictures => "take smaller pictures",
            Self::Variants => "plan fewer variants",
            Self::Network => "take a network of fewer channels, or fewer threads",
            Self::Nothing => "read the data set on a machine with more",
        }
    }
}

/// Who may not begin.
#[derive(Debug, thiserror::Error)]
pub enum MemoryError {
    /// It would take too much.
    #[error("{what} takes {} of memory; the limit is {}", rounded_up(*.bytes), shown(*.limit))]
    TooMuch {
        /// What is to be done.
        what: String,
        /// What it takes with the process itself, bytes.
        bytes: u64,
        /// What is allowed, bytes.
        limit: u64,
        /// What there could be less of.
        less: Less,
    },
    /// The system has no threads.
    #[error("{count} threads: {source}")]
    Threads {
        /// How many were to work.
        count: usize,
        /// What the system said.
        source: rayon::ThreadPoolBuildError,
    },
}

impl MemoryError {
    /// The limit that would do, as [`parse`] reads it.
    pub fn enough(&self) -> Option<String> {
        match self {
            Self::TooMuch { bytes, .. } => Some(rounded_up(*bytes)),
            Self::Threads { .. } => None,
        }
    }
}

impl Explained for MemoryError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Limit
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::TooMuch { less, .. } => Some(less.hint().into()),
            Self::Threads { .. } => None,
        }
    }

    fn subject(&self) -> ErrorSubject {
        ErrorSubject::new("memory_limit")
    }
}

/// Refuses what would take too much: `what` is done with `bytes` besides the process itself.
///
/// # Errors
/// [`MemoryError::TooMuch`] with the figure and the limit.
pub fn admit(what: &str, bytes: u64, less: Less) -> Result<(), MemoryError> {
    workers(what, bytes, 0, usize::MAX, less).map(drop)
}

/// How many of `most` workers may work side by side, if all of them share `shared` bytes and each
/// needs `each` besides.
///
/// # Errors
/// [`MemoryError::TooMuch`] if there is no room for one.
pub fn workers(
    what: &str,
    shared: u64,
    each: u64,
    most: usize,
    less: Less,
) -> Result<usize, MemoryError> {
    let limit = LIMIT.load(Ordering::Relaxed);
    let bytes = shared.saturating_add(each).saturating_add(PROCESS);
    let Some(room) = limit.checked_sub(bytes) else {
        return Err(MemoryError::TooMuch { what: what.into(), bytes, limit, less });
    };
    let others = room.checked_div(each).map_or(usize::MAX, |n| n.try_into().unwrap_or(usize::MAX));
    Ok(others.saturating_add(1).min(most))
}

/// Works on as many threads as [`workers`] allows.
///
/// # Errors
/// As [`workers`]; those of `work`; no threads.
pub fn on_workers<R: Send, E: From<MemoryError> + Send>(
    what: &str,
    shared: u64,
    each: u64,
    less: Less,
    work: impl FnOnce() -> Result<R, E> + Send,
) -> Result<R, E> {
    let most = rayon::current_num_threads();
    let count = workers(what, shared, each, most, less)?;
    if count == most {
        return work();
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    pool.map_err(|source| MemoryError::Threads { count, source })?.install(work)
}

/// Reads `2GB`, `500 MB`, `1.5GiB`.
///
/// # Errors
/// No number, no unit, a value outside [`LIMITS`].
pub fn parse(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let at = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = (text[..at].trim(), text[at..].to_ascii_lowercase());
    let per_unit: u64 = match unit.as_str() {
        "mb" => MB,
        "gb" => GB,
        "mib" => 1 << 20,
        "gib" => 1 << 30,
        "" => return Err("has no unit; write for example 4GB".into()),
        other => return Err(format!("`{other}` is no unit of memory; write MB, GB, MiB or GiB")),
    };
    let number: f64 = number.parse().map_err(|_| format!("`{number}` is not a number"))?;
    let bytes = number * per_unit as f64;
    let [least, most] = LIMITS;
    if (least as f64..=most as f64).contains(&bytes) {
        return Ok(bytes as u64);
    }
    Err(format!("{text} is not between {} and {}", shown(least), shown(most)))
}

fn shown(bytes: u64) -> String {
    match bytes {
        0..GB => format!("{}MB", bytes / MB),
        _ => format!("{}GB", (bytes / (GB / 10)) as f64 / 10.0),
    }
}

/// To a number that [`parse`] reads and that is enough.
fn rounded_up(bytes: u64) -> String {
    match bytes {
        0..GB => format!("{}MB", bytes.div_ceil(MB)),
        _ => format!("{}GB", bytes.div_ceil(GB / 10) as f64 / 10.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_a_unit_and_limits() {
        assert_eq!(parse("2GB"), Ok(DEFAULT_LIMIT));
        assert_eq!(parse(" 1.5 GiB"), Ok(3 << 29));
        assert_eq!(parse("500mb"), Ok(500 * MB));
        for wrong in ["", "2", "GB", "-2GB", "nanGB", "1e30GB", "2TB", "0.05GB", "2G B", "\u{b5}GB"]
        {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn hints_are_enough() {
        for bytes in [100 * MB, 100 * MB + 1, 999_999_999, GB, 2 * GB + 1, 123_456_789_012] {
            assert!(parse(&rounded_up(bytes)).unwrap() >= bytes, "{bytes}");
        }
    }

    /// One test, because the limit is the process's.
    #[test]
    fn what_does_not_fit_is_refused_with_both_figures() {
        let less = Less::Camera;
        assert!(admit("everything", u64::MAX / 2, less).is_ok(), "a library has no limit");
        set_limit(DEFAULT_LIMIT);
        assert_eq!(workers("casting", 450 * MB, 500 * MB, 16, less).unwrap(), 3);
        assert_eq!(workers("casting", 0, 10 * MB, 16, less).unwrap(), 16);
        assert!(admit("a cast", DEFAULT_LIMIT - PROCESS, less).is_ok());
        let refused = admit("a cast", DEFAULT_LIMIT, less).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::Limit);
        assert_eq!(refused.to_string(), "a cast takes 2.1GB of memory; the limit is 2GB");
        assert_eq!(refused.enough().as_deref(), Some("2.1GB"));
        set_limit(u64::MAX);
    }
}
