//! Handling of Ctrl-C.
//!
//! While nothing is on disk, an interrupt ends the process at once. Once temporary files are being written, it only
//! requests a stop: the writer notices it between two files, removes what it wrote, and the process ends with the same
//! exit code. A second interrupt ends the process at once.

#[cfg(unix)]
use std::sync::Arc;
#[cfg(unix)]
use std::sync::atomic::AtomicBool;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::failure::{ErrorKind, Failure, FailureCode};
use crate::terminal;

const COMPUTING: u8 = 0;
const WRITING: u8 = 1;
const STOPPING: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(COMPUTING);

/// Installs the handler for interrupts. Without it they end the process with the system's own code.
pub fn install_handler() {
    fail_beyond_file_limits();
    // Fails only if a handler is installed already.
    let _ = ctrlc::set_handler(|| {
        if STATE.swap(STOPPING, Ordering::SeqCst) != WRITING {
            terminal::tell("error: interrupted\n");
            std::process::exit(FailureCode::Interrupted as i32);
        }
    });
}

/// Turns exceeding `ulimit -f` into a write error. By default the signal ends the process; with a handler, the write
/// fails like any other.
#[cfg(unix)]
fn fail_beyond_file_limits() {
    let heard = Arc::new(AtomicBool::new(false));
    // If the signal cannot be handled, temporary files stay until the next run.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, heard);
}

#[cfg(not(unix))]
fn fail_beyond_file_limits() {}

/// Marks the beginning of writing: from now on there may be temporary files to clean up.
///
/// # Errors
/// An interrupt that came just before.
pub fn begin_writing() -> Result<(), Failure> {
    STATE
        .compare_exchange(COMPUTING, WRITING, Ordering::SeqCst, Ordering::SeqCst)
        .map(drop)
        .map_err(|_| Failure::plain(ErrorKind::Interrupted, "interrupted"))
}

/// Returns [`is_requested`], and delays interrupts from the first call on until the caller polls again: for work with its
/// own processes and temporary files. Ends with [`finish_watching`].
pub fn poll_interrupt() -> bool {
    let _ = STATE.compare_exchange(COMPUTING, WRITING, Ordering::SeqCst, Ordering::SeqCst);
    is_requested()
}

/// Ends the delay: an interrupt ends the process at once again.
///
/// # Errors
/// An interrupt that came too late for the work to notice it.
pub fn finish_watching() -> Result<(), Failure> {
    let before = STATE.compare_exchange(WRITING, COMPUTING, Ordering::SeqCst, Ordering::SeqCst);
    match before {
        Err(STOPPING) => Err(Failure::plain(ErrorKind::Interrupted, "interrupted")),
        _ => Ok(()),
    }
}

/// Returns whether an interrupt requested a stop.
pub fn is_requested() -> bool {
    STATE.load(Ordering::SeqCst) == STOPPING
}
