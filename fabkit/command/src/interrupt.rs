//! Ctrl-C.
//!
//! While nothing is on disk, an interrupt ends the process at once. Once temporary files are being
//! written, it only asks for a stop: the writer sees that between two files, removes what it
//! wrote, and the process leaves with the same code. A second interrupt does not wait.

use std::io::{self, Write};
#[cfg(unix)]
use std::sync::Arc;
#[cfg(unix)]
use std::sync::atomic::AtomicBool;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::failure::{ErrorKind, Exit, Failure};

const COMPUTING: u8 = 0;
const WRITING: u8 = 1;
const STOPPING: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(COMPUTING);

/// Listens for interrupts. Without it they end the process with the system's own code.
pub fn listen() {
    fail_beyond_file_limits();
    // Fails only if somebody else listens already.
    let _ = ctrlc::set_handler(|| {
        if STATE.swap(STOPPING, Ordering::SeqCst) != WRITING {
            // If nobody can be told, the exit code still says it.
            let _ = writeln!(io::stderr(), "error: interrupted");
            std::process::exit(Exit::Interrupted as i32);
        }
    });
}

/// A file that outgrows `ulimit -f` ends the process, unless somebody listens to the signal: then the
/// write fails, like any other.
#[cfg(unix)]
fn fail_beyond_file_limits() {
    let heard = Arc::new(AtomicBool::new(false));
    // Where it cannot be listened to, temporary files stay until the next run.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, heard);
}

#[cfg(not(unix))]
fn fail_beyond_file_limits() {}

/// From here on there may be temporary files to clean up.
///
/// # Errors
/// An interrupt that came just before.
pub fn begin_writing() -> Result<(), Failure> {
    STATE
        .compare_exchange(COMPUTING, WRITING, Ordering::SeqCst, Ordering::SeqCst)
        .map(drop)
        .map_err(|_| Failure::plain(ErrorKind::Interrupted, "interrupted"))
}

/// As [`requested`], and from the first time on that it is asked, an interrupt waits until it is asked again: for
/// work that has processes and temporary files of its own, until [`finish_watching`].
pub fn watched() -> bool {
    let _ = STATE.compare_exchange(COMPUTING, WRITING, Ordering::SeqCst, Ordering::SeqCst);
    requested()
}

/// An interrupt ends the process at once again.
///
/// # Errors
/// An interrupt that came too late for the work to see it.
pub fn finish_watching() -> Result<(), Failure> {
    let before = STATE.compare_exchange(WRITING, COMPUTING, Ordering::SeqCst, Ordering::SeqCst);
    match before {
        Err(STOPPING) => Err(Failure::plain(ErrorKind::Interrupted, "interrupted")),
        _ => Ok(()),
    }
}

/// Whether an interrupt asked the writer to stop.
pub fn requested() -> bool {
    STATE.load(Ordering::SeqCst) == STOPPING
}
