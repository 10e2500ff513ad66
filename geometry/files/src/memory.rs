//! Memory limit of a process, and admission of work by its estimated memory.
//!
//! Code whose memory grows with the request states its need beforehand, from measured figures, and is refused above the
//! limit. Nothing here counts actual allocations: a test compares both. The command sets the limit once; a program that
//! uses fabkit as a library has no limit unless it sets one.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::{ErrorKind, ErrorSubject, Explained};

/// Default limit of the command, bytes.
pub const DEFAULT_LIMIT: u64 = 2 * GB;
/// Smallest and largest limit that can be requested, bytes.
pub const LIMITS: [u64; 2] = [100 * MB, 1024 * GB];

/// One megabyte (10^6 bytes).
pub const MB: u64 = 1_000_000;
/// One gigabyte (10^9 bytes).
pub const GB: u64 = 1000 * MB;

/// Memory of the process itself, with a sensor and its fixtures loaded, bytes.
const PROCESS_BYTES: u64 = 50 * MB;

static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);

/// Sets the limit for all threads, bytes.
///
/// ```
/// use fabkit_files::memory::{
///     DEFAULT_LIMIT, GB, MemoryHint, available_bytes, check_memory, set_limit,
/// };
///
/// // Without a limit, everything is allowed.
/// assert!(check_memory("a cast", 1000 * GB, MemoryHint::Rays).is_ok());
/// set_limit(DEFAULT_LIMIT);
/// assert_eq!(available_bytes(), 1_950_000_000);
/// let refused = check_memory("a cast", 3 * GB, MemoryHint::Rays).unwrap_err();
/// assert_eq!(refused.to_string(), "a cast takes 3.1GB of memory; the limit is 2GB");
/// ```
pub fn set_limit(bytes: u64) {
    LIMIT.store(bytes, Ordering::Relaxed);
}

/// Returns the limit minus the memory of the process itself, bytes.
pub fn available_bytes() -> u64 {
    LIMIT.load(Ordering::Relaxed).saturating_sub(PROCESS_BYTES)
}

/// Quantity to reduce when memory is short; selects the hint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryHint {
    /// Rays per pixel, and the files made of them.
    Rays,
    /// Pixels of a drawn image.
    Pixels,
    /// Pixels of the camera.
    Camera,
    /// Pixels of images that are read.
    Images,
    /// Number of images at once.
    Files,
    /// Variants of a sweep.
    Variants,
    /// Channels of a network, or threads.
    Network,
    /// Nothing: the data set is fixed.
    Nothing,
}

impl MemoryHint {
    /// Returns what to do.
    fn hint(self) -> &'static str {
        match self {
            Self::Rays => "ask for fewer samples or files",
            Self::Pixels => "ask for a smaller image",
            Self::Files => "give fewer images at once",
            Self::Camera => "take a smaller camera",
            Self::Images => "take smaller images",
            Self::Variants => "plan fewer variants",
            Self::Network => "take a network of fewer channels, or fewer threads",
            Self::Nothing => "read the data set on a machine with more",
        }
    }
}

/// Refusal of work that does not fit, or lack of threads.
#[derive(Debug, thiserror::Error)]
pub enum MemoryError {
    /// Work that needs more memory than the limit.
    #[error("{what} takes {} of memory; the limit is {}", format_size_rounded_up(*.bytes), format_size(*.limit))]
    TooMuch {
        /// Description of the work.
        what: String,
        /// Memory needed, the process itself included, bytes.
        bytes: u64,
        /// Present limit, bytes.
        limit: u64,
        /// Quantity to reduce.
        less: MemoryHint,
    },
    /// Failure of the operating system to start threads.
    #[error("{count} threads: {source}")]
    Threads {
        /// Number of requested threads.
        count: usize,
        /// Error of the thread pool.
        source: rayon::ThreadPoolBuildError,
    },
}

impl MemoryError {
    /// Returns a sufficient limit, in the form that [`parse`] reads.
    ///
    /// ```
    /// use fabkit_files::memory::{GB, MemoryHint, check_memory, parse, set_limit};
    ///
    /// set_limit(GB);
    /// let refused = check_memory("an image", GB, MemoryHint::Pixels).unwrap_err();
    /// let limit = refused.sufficient_limit().unwrap_or_default();
    /// assert_eq!(limit, "1.1GB");
    /// set_limit(parse(&limit)?);
    /// assert!(check_memory("an image", GB, MemoryHint::Pixels).is_ok());
    /// # Ok::<(), String>(())
    /// ```
    pub fn sufficient_limit(&self) -> Option<String> {
        match self {
            Self::TooMuch { bytes, .. } => Some(format_size_rounded_up(*bytes)),
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

/// Permission to use memory, which only [`MemoryGrant::request`] gives.
///
/// What takes memory by the size of a request asks for one, so that no caller can forget to ask for the limit.
///
/// ```
/// use fabkit_files::memory::{GB, MemoryGrant, MemoryHint, set_limit};
///
/// /// A table that grows with what is asked for.
/// fn table(size: usize, grant: &MemoryGrant) -> Vec<u8> {
///     assert!(grant.bytes() >= size as u64);
///     vec![0; size]
/// }
/// set_limit(2 * GB);
/// let grant = MemoryGrant::request("a table", 1000, MemoryHint::Rays)?;
/// assert_eq!(table(1000, &grant).len(), 1000);
/// assert!(MemoryGrant::request("a table", 3 * GB, MemoryHint::Rays).is_err());
/// # Ok::<(), fabkit_files::memory::MemoryError>(())
/// ```
#[derive(Debug)]
#[must_use]
pub struct MemoryGrant {
    bytes: u64,
}

impl MemoryGrant {
    /// Requests memory for work that needs `bytes` besides the process itself.
    ///
    /// # Errors
    /// [`MemoryError::TooMuch`] with need and limit.
    pub fn request(what: &str, bytes: u64, less: MemoryHint) -> Result<Self, MemoryError> {
        check_memory(what, bytes, less).map(|()| Self { bytes })
    }

    /// Returns the permitted memory, bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

/// Refuses work that needs too much memory: `bytes` is its need besides the process itself.
///
/// # Errors
/// [`MemoryError::TooMuch`] with need and limit.
pub fn check_memory(what: &str, bytes: u64, less: MemoryHint) -> Result<(), MemoryError> {
    count_workers(what, bytes, 0, usize::MAX, less).map(drop)
}

/// Returns how many of at most `most` workers may run in parallel, if they share `shared` bytes and each needs `each`
/// bytes more.
///
/// # Errors
/// [`MemoryError::TooMuch`] if there is no room for one.
///
/// ```
/// use fabkit_files::memory::{GB, MB, MemoryHint, count_workers, set_limit};
///
/// set_limit(2 * GB);
/// // 50 MB for the process and 450 MB for all leave 1.5 GB.
/// assert_eq!(count_workers("casting", 450 * MB, 500 * MB, 16, MemoryHint::Rays)?, 3);
/// assert_eq!(count_workers("casting", 450 * MB, MB, 16, MemoryHint::Rays)?, 16);
/// assert!(count_workers("casting", 450 * MB, 2 * GB, 16, MemoryHint::Rays).is_err());
/// # Ok::<(), fabkit_files::memory::MemoryError>(())
/// ```
pub fn count_workers(
    what: &str,
    shared: u64,
    each: u64,
    most: usize,
    less: MemoryHint,
) -> Result<usize, MemoryError> {
    let limit = LIMIT.load(Ordering::Relaxed);
    let bytes = shared.saturating_add(each).saturating_add(PROCESS_BYTES);
    let Some(room) = limit.checked_sub(bytes) else {
        return Err(MemoryError::TooMuch { what: what.into(), bytes, limit, less });
    };
    // If workers need nothing of their own, any number of them fits.
    let others = room.checked_div(each).map_or(usize::MAX, |n| n.try_into().unwrap_or(usize::MAX));
    Ok(others.saturating_add(1).min(most))
}

/// Runs `work` on as many threads as [`count_workers`] allows.
///
/// # Errors
/// As [`count_workers`]; those of `work`; [`MemoryError::Threads`].
///
/// ```
/// use fabkit_files::memory::{GB, MB, MemoryError, MemoryHint, run_on_workers, set_limit};
///
/// set_limit(GB);
/// let work = || Ok::<_, MemoryError>((1..=4).sum::<u32>());
/// assert_eq!(run_on_workers("a sum", 0, MB, MemoryHint::Network, work)?, 10);
/// assert!(run_on_workers("a sum", 0, GB, MemoryHint::Network, work).is_err());
/// # Ok::<(), MemoryError>(())
/// ```
pub fn run_on_workers<R: Send, E: From<MemoryError> + Send>(
    what: &str,
    shared: u64,
    each: u64,
    less: MemoryHint,
    work: impl FnOnce() -> Result<R, E> + Send,
) -> Result<R, E> {
    let most = rayon::current_num_threads();
    let count = count_workers(what, shared, each, most, less)?;
    // The present thread pool has exactly that many threads.
    if count == most {
        return work();
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
    pool.map_err(|source| MemoryError::Threads { count, source })?.install(work)
}

/// Parses a memory size such as `2GB`, `500 MB`, `1.5GiB`.
///
/// # Errors
/// If there is no number, no known unit, or the size is outside [`LIMITS`].
///
/// ```
/// use fabkit_files::memory::{GB, MB, parse};
///
/// assert_eq!(parse("500 MB"), Ok(500 * MB));
/// assert_eq!(parse("1.5gb"), Ok(3 * GB / 2));
/// assert_eq!(parse("2GiB"), Ok(1 << 31));
/// assert_eq!(parse("2"), Err("has no unit; write for example 4GB".into()));
/// assert_eq!(parse("1MB"), Err("1MB is not between 100MB and 1024GB".into()));
/// ```
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
    // Refuses NaN too, which no range contains.
    if (least as f64..=most as f64).contains(&bytes) {
        return Ok(bytes as u64);
    }
    Err(format!("{text} is not between {} and {}", format_size(least), format_size(most)))
}

/// Formats a size, rounded down.
fn format_size(bytes: u64) -> String {
    match bytes {
        0..GB => format!("{}MB", bytes / MB),
        _ => format!("{}GB", (bytes / (GB / 10)) as f64 / 10.0),
    }
}

/// Formats a size, rounded up so that [`parse`] returns at least `bytes`.
fn format_size_rounded_up(bytes: u64) -> String {
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
    fn suggested_limits_are_sufficient() {
        for bytes in [100 * MB, 100 * MB + 1, 999_999_999, GB, 2 * GB + 1, 123_456_789_012] {
            assert!(parse(&format_size_rounded_up(bytes)).unwrap() >= bytes, "{bytes}");
        }
    }

    /// One test, because the limit is the process's.
    #[test]
    fn work_above_the_limit_is_refused_with_need_and_limit() {
        let less = MemoryHint::Camera;
        assert!(check_memory("everything", u64::MAX / 2, less).is_ok(), "a library has no limit");
        set_limit(DEFAULT_LIMIT);
        assert_eq!(count_workers("casting", 450 * MB, 500 * MB, 16, less).unwrap(), 3);
        assert_eq!(count_workers("casting", 0, 10 * MB, 16, less).unwrap(), 16);
        assert!(check_memory("a cast", DEFAULT_LIMIT - PROCESS_BYTES, less).is_ok());
        let refused = check_memory("a cast", DEFAULT_LIMIT, less).unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::Limit);
        assert_eq!(refused.to_string(), "a cast takes 2.1GB of memory; the limit is 2GB");
        assert_eq!(refused.sufficient_limit().as_deref(), Some("2.1GB"));
        set_limit(u64::MAX);
    }
}
