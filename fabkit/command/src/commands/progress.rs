//! Progress display: one line on a terminal with the current work and its progress.
//!
//! Nothing is shown if standard error is not a terminal, or with `--json` or `--quiet`.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use fabkit_application::progress::ProgressStep;
use fabkit_application::text::escape_steering;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::Global;

/// Interval of the spinner, which moves even while nothing is finished.
const SPINNER_INTERVAL: Duration = Duration::from_millis(200);

/// Largest refresh rate, Hz: no faster than the eye.
const REFRESH_HZ: u8 = 10;

const UNCOUNTED: &str = "{spinner} {prefix} {elapsed} {msg}";
const COUNTED: &str = "{spinner} {prefix} [{bar:24}] {pos} of {len}, {elapsed}, {eta} left {msg}";

/// Progress line, removed when dropped.
pub(super) struct Progress {
    bar: ProgressBar,
    /// One more than the number of pieces that existed before; 0 until that is known.
    found: AtomicUsize,
}

impl Progress {
    /// Starts a progress line. `doing` describes the work, for example `checking rtac0`.
    pub(super) fn new(global: &Global, doing: impl Into<String>) -> Self {
        let target = if global.quiet || global.json {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr_with_hz(REFRESH_HZ)
        };
        Self::with_target(target, doing.into())
    }

    fn with_target(target: ProgressDrawTarget, doing: String) -> Self {
        let bar = ProgressBar::with_draw_target(None, target)
            .with_prefix(escape_steering(&doing).into_owned());
        bar.set_style(style(UNCOUNTED));
        if !bar.is_hidden() {
            bar.enable_steady_tick(SPINNER_INTERVAL);
        }
        Self { bar, found: AtomicUsize::new(0) }
    }

    pub(super) fn show(&self, step: ProgressStep) {
        // Once, at the first step: pieces that existed before took no time, so they must not enter the estimate.
        if self.found.swap(step.resumed + 1, Ordering::Relaxed) == 0 {
            self.bar.set_length(step.total as u64);
            self.bar.set_style(style(COUNTED));
            self.bar.set_position(step.resumed as u64);
            self.bar.reset_eta();
        }
        self.bar.set_position(step.done as u64);
        if !step.last_name.is_empty() {
            self.bar.set_message(escape_steering(step.last_name).into_owned());
        }
    }

    /// Counts one more finished piece of an unknown total.
    pub(super) fn count_piece(&self, name: &str) {
        self.bar.inc(1);
        let name = escape_steering(name);
        self.bar.set_message(format!("{}, {name}", self.bar.position()));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Makes a style. The templates are constants, and a test checks them.
fn style(template: &str) -> ProgressStyle {
    let style = ProgressStyle::with_template(template);
    style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("#..")
}

#[cfg(test)]
mod tests {
    use super::*;
    use indicatif::TermLike;
    use std::io;
    use std::sync::{Arc, Mutex};

    /// Terminal that records what was written since its line was last cleared.
    #[derive(Clone, Debug, Default)]
    struct Screen(Arc<Mutex<String>>);

    impl Screen {
        fn shown(&self) -> String {
            self.0.lock().unwrap().clone()
        }
    }

    impl TermLike for Screen {
        fn width(&self) -> u16 {
            100
        }

        fn move_cursor_up(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_down(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_right(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn move_cursor_left(&self, _: usize) -> io::Result<()> {
            Ok(())
        }

        fn write_line(&self, text: &str) -> io::Result<()> {
            self.write_str(text)
        }

        fn write_str(&self, text: &str) -> io::Result<()> {
            self.0.lock().unwrap().push_str(text);
            Ok(())
        }

        fn clear_line(&self) -> io::Result<()> {
            self.0.lock().unwrap().clear();
            Ok(())
        }

        fn flush(&self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_line_says_what_is_under_way_and_how_far_and_is_gone_at_the_end() {
        let screen = Screen::default();
        let target = ProgressDrawTarget::term_like(Box::new(screen.clone()));
        let progress = Progress::with_target(target, "making files".into());
        progress.bar.force_draw();
        assert!(screen.shown().contains("making files"), "{}", screen.shown());
        for done in 5..=6 {
            progress.show(ProgressStep { done, resumed: 4, total: 12, last_name: "a.npz" });
        }
        progress.bar.force_draw();
        let shown = screen.shown();
        assert!(shown.contains("a.npz"), "{shown}");
        assert!(shown.contains("[############............] 6 of 12, "), "{shown}");
        drop(progress);
        assert_eq!(screen.shown().trim(), "");
    }

    #[test]
    fn templates_are_valid() {
        for template in [UNCOUNTED, COUNTED] {
            assert!(ProgressStyle::with_template(template).is_ok(), "{template}");
        }
    }
}
