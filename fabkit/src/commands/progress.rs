//! One line on a terminal that says how far a long run is.

use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::cli::Global;

/// No faster than the eye.
const EVERY: Duration = Duration::from_millis(100);
const BAR: usize = 24;

/// A bar with a rate and the time left.
pub(super) struct Progress {
    shown: bool,
    /// What is counted, in the plural.
    what: &'static str,
    start: Instant,
    last: Mutex<Option<Instant>>,
}

impl Progress {
    pub(super) fn new(global: &Global, what: &'static str) -> Self {
        let shown = !global.quiet && !global.json && io::stderr().is_terminal();
        Self { shown, what, start: Instant::now(), last: Mutex::new(None) }
    }

    /// `done` of `all`; `found` of these were there before and say nothing about the rate.
    pub(super) fn show(&self, done: usize, found: usize, all: usize) {
        let Ok(mut last) = self.last.lock() else { return };
        if !self.shown || (done < all && last.is_some_and(|at| at.elapsed() < EVERY)) {
            return;
        }
        *last = Some(Instant::now());
        let line = line(self.what, done, found, all, self.start.elapsed().as_secs_f64());
        // Progress that cannot be shown is no reason to stop.
        let _ = write!(io::stderr(), "\r\x1b[K{line}");
    }

    pub(super) fn clear(&self) {
        if self.shown {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}

fn line(what: &str, done: usize, found: usize, all: usize, seconds: f64) -> String {
    let filled = BAR * done / all.max(1);
    let bar = "#".repeat(filled) + &".".repeat(BAR - filled);
    let rate = done.saturating_sub(found) as f64 / seconds.max(1e-3);
    let left = match rate > 0.0 {
        true => format!("{:.0} s left", (all - done) as f64 / rate),
        false => String::new(),
    };
    format!("[{bar}] {done} of {all} {what}, {rate:.1} {what}/s, {left}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_counts_only_what_was_made_now() {
        assert_eq!(
            line("files", 8, 4, 12, 2.0),
            "[################........] 8 of 12 files, 2.0 files/s, 2 s left"
        );
        assert_eq!(
            line("files", 4, 4, 12, 2.0),
            "[########................] 4 of 12 files, 0.0 files/s, "
        );
    }
}
