//! Long work on a separate thread, without the interpreter's lock, interruptible by Ctrl-C.
//!
//! The worker thread never touches Python. The caller's thread waits for it; between short waits it lets Python handle
//! signals and calls `progress(done, all)`.

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::errors::{Failure, exception};
use crate::process_pool::run_in_pool;

/// Polling interval: short enough for people, long enough to cost nothing.
const POLL: Duration = Duration::from_millis(25);

/// State shared by the worker and the waiting thread.
#[derive(Debug, Default)]
pub struct WorkerLink {
    cancelled: AtomicBool,
    done: AtomicUsize,
    all: AtomicUsize,
}

impl WorkerLink {
    /// Returns whether the work should stop as soon as it can.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Reports `done` of `all` pieces.
    pub fn show(&self, done: usize, all: usize) {
        self.all.store(all, Ordering::Relaxed);
        self.done.store(done, Ordering::Relaxed);
    }

    /// Reports one more piece.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }
}

/// Runs short work without the interpreter's lock, in the pool of this process.
///
/// # Errors
/// A panic, as an exception: it must not unwind into Python.
pub fn run_short<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let result = py.detach(|| panic::catch_unwind(AssertUnwindSafe(|| run_in_pool(work))));
    result.map_err(|_| exception(py, Failure::bug("fabkit stopped")))
}

/// Panics on purpose, for tests of its conversion.
#[pyfunction]
pub fn fall(py: Python<'_>) -> PyResult<()> {
    run_short(py, || panic!("on purpose"))
}

/// Runs short work that may use Python.
///
/// # Errors
/// Errors of the work, and panics as in [`run_short`].
pub fn run_guarded<T>(py: Python<'_>, work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    panic::catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|_| Err(exception(py, Failure::bug("fabkit stopped"))))
}

/// Treatment of interrupted work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterruptPolicy {
    /// Abandon it: it stops where it checks the link, and its result is dropped.
    Abandon,
    /// Wait until it has stopped, because it writes files and cleans up after itself.
    Wait,
}

/// Runs the work on a separate thread and returns its result.
///
/// # Errors
/// The failure of the work as an exception; `KeyboardInterrupt`, or any exception raised by a signal handler or by
/// `progress`.
pub fn run_on_thread<T: Send + 'static>(
    py: Python<'_>,
    interrupted: InterruptPolicy,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&WorkerLink) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let link = Arc::new(WorkerLink::default());
    let (sender, mut receiver) = mpsc::channel();
    let shared = Arc::clone(&link);
    thread::spawn(move || {
        let result = panic::catch_unwind(AssertUnwindSafe(|| run_in_pool(|| work(&shared))));
        // After an interruption, nobody receives the result.
        let _ = sender.send(result.unwrap_or_else(|_| Err(Failure::bug("fabkit stopped"))));
    });
    let mut raised = None;
    let mut shown = (0, 0);
    loop {
        let received;
        // A receiver cannot be shared with the detached closure, so it is moved in and out.
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
            // Already interrupted: only the end of the work is awaited.
            Err(RecvTimeoutError::Timeout) if raised.is_some() => {}
            Err(RecvTimeoutError::Timeout) => {
                let fine = report(progress, &link, &mut shown).and_then(|()| py.check_signals());
                if let Err(error) = fine {
                    link.cancelled.store(true, Ordering::Relaxed);
                    if interrupted == InterruptPolicy::Abandon {
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
    link: &WorkerLink,
    shown: &mut (usize, usize),
) -> PyResult<()> {
    let now = (link.done.load(Ordering::Relaxed), link.all.load(Ordering::Relaxed));
    if let Some(progress) = progress.filter(|_| now != *shown) {
        progress.call1(now)?;
        *shown = now;
    }
    Ok(())
}
