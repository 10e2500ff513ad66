//! Ctrl-C.
//!
//! While nothing is on disk, an interrupt ends the process at once. Once temporary files are being
//! written, it only asks for a stop: the writer sees that between two files, removes what it
//! wrote, and the process leaves with the same code. A second interrupt does not wait.

use std::io::{self, Write};
use std::sync::atomic::{AtomicU8, Ordering};

use crate::failure::{Exit, Failure};

const COMPUTING: u8 = 0;
const WRITING: u8 = 1;
const STOPPING: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(COMPUTING);

/// Listens for interrupts. Without it they end the process with the system's own code.
pub fn listen() {
    // Fails only if somebody else listens already.
    let _ = ctrlc::set_handler(|| {
        if STATE.swap(STOPPING, Ordering::SeqCst) != WRITING {
            // If nobody can be told, the exit code still says it.
            let _ = writeln!(io::stderr(), "error: interrupted");
            std::process::exit(Exit::Interrupted as i32);
        }
    });
}

/// From here on there may be temporary files to clean up.
///
/// # Errors
/// An interrupt that came just before.
pub fn begin_writing() -> Result<(), Failure> {
    STATE
        .compare_exchange(COMPUTING, WRITING, Ordering::SeqCst, Ordering::SeqCst)
        .map(drop)
        .map_err(|_| Failure::plain(Exit::Interrupted, "interrupted"))
}

/// Whether an interrupt asked the writer to stop.
pub fn requested() -> bool {
    STATE.load(Ordering::SeqCst) == STOPPING
}
