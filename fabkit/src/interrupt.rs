//! Ctrl-C.
//!
//! While nothing is on disk, an interrupt ends the process at once. Once temporary files are being
//! written, it only asks for a stop: the writer sees that between two files, removes what it
//! wrote, and the process leaves with the same code. A second interrupt does not wait.

use std::sync::atomic::{AtomicU8, Ordering};

use crate::failure::Exit;

const COMPUTING: u8 = 0;
const WRITING: u8 = 1;
const STOPPING: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(COMPUTING);

/// Listens for interrupts. Without it they end the process with the system's own code.
pub fn listen() {
    // Fails only if somebody else listens already.
    let _ = ctrlc::set_handler(|| {
        // The one transition that may go on: from writing to stopping.
        let writing =
            STATE.compare_exchange(WRITING, STOPPING, Ordering::SeqCst, Ordering::SeqCst).is_ok();
        if !writing {
            eprintln!("error: interrupted");
            std::process::exit(Exit::Interrupted as i32);
        }
    });
}

/// From here on there may be temporary files to clean up.
pub fn begin_writing() {
    STATE.store(WRITING, Ordering::SeqCst);
}

/// Whether an interrupt asked the writer to stop.
pub fn requested() -> bool {
    STATE.load(Ordering::SeqCst) == STOPPING
}
