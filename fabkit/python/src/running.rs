//! Long work: on a thread of its own, without the interpreter's lock, with an eye on Ctrl-C.
//!
//! The thread never touches Python. The caller's thread waits for it, and between short waits lets
//! Python handle signals and tells the caller's `progress(done, all)` how far the work is.

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::errors::{Failure, exception};

/// Often enough for people, rarely enough to cost nothing.
const POLL: Duration = Duration::from_millis(25);

/// What the thread that works and the one that waits tell each other.
#[derive(Debug, Default)]
pub struct Link {
    cancelled: AtomicBool,
    done: AtomicUsize,
    all: AtomicUsize,
}

impl Link {
    /// Whether the work should stop where it can.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// `done` of `all` pieces.
    pub fn show(&self, done: usize, all: usize) {
        self.all.store(all, Ordering::Relaxed);
        self.done.store(done, Ordering::Relaxed);
    }

    /// One more piece.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

/// Short work, without the interpreter's lock.
///
/// # Errors
/// What panics, as an exception: Python's users know no panics.
pub fn short<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let result = py.detach(|| panic::catch_unwind(AssertUnwindSafe(work)));
    result.map_err(|_| exception(py, Failure::bug("fabkit stopped")))
}

/// Panics on purpose, so that tests see what becomes of it.
#[pyfunction]
pub fn fall(py: Python<'_>) -> PyResult<()> {
    short(py, || panic!("on purpose"))
}

/// Short work that may use Python.
///
/// # Errors
/// Its own, and what panics as [`short`] has it.
pub fn guarded<T>(py: Python<'_>, work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    panic::catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|_| Err(exception(py, Failure::bug("fabkit stopped"))))
}

/// What to do with work that is interrupted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interrupted {
    /// Leave it: it stops where it looks at the link, and its result is dropped.
    Leave,
    /// Wait until it has stopped: it writes files, and cleans up after itself.
    Wait,
}

/// Does the work, and gives its result.
///
/// # Errors
/// What the work fails with, as an exception; `KeyboardInterrupt`, or whatever else a signal's
/// handler or `progress` raises.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    interrupted: Interrupted,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Link) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let link = Arc::new(Link::default());
    let (sender, mut receiver) = mpsc::channel();
    let shared = Arc::clone(&link);
    thread::spawn(move || {
        let result = panic::catch_unwind(AssertUnwindSafe(|| work(&shared)));
        // Nobody listens any more if the caller was interrupted.
        let _ = sender.send(result.unwrap_or_else(|_| Err(Failure::bug("fabkit stopped"))));
    });
    let mut raised = None;
    let mut shown = (0, 0);
    loop {
        let received;
        // A receiver cannot be shared between threads, but handed over.
        (received, receiver) = py.detach(move || (receiver.recv_timeout(POLL), receiver));
        match received {
            Ok(result) => {
                return match raised {
                    Some(error) => Err(error),
                    None => {
                        report(progress, &link, &mut shown)?;
                        result.map_err(|failure| exception(py, failure))
                    }
                };
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(exception(py, Failure::bug("fabkit stopped")));
            }
            Err(RecvTimeoutError::Timeout) if raised.is_some() => {}
            Err(RecvTimeoutError::Timeout) => {
                let fine = report(progress, &link, &mut shown).and_then(|()| py.check_signals());
                if let Err(error) = fine {
                    link.cancelled.store(true, Ordering::Relaxed);
                    if interrupted == Interrupted::Leave {
                        return Err(error);
                    }
                    raised = Some(error);
                }
            }
        }
    }
}

fn report(
    progress: Option<&Bound<'_, PyAny>>,
    link: &Link,
    shown: &mut (usize, usize),
) -> PyResult<()> {
    let now = (link.done.load(Ordering::Relaxed), link.all.load(Ordering::Relaxed));
    if let Some(progress) = progress.filter(|_| now != *shown) {
        progress.call1(now)?;
        *shown = now;
    }
    Ok(())
}
