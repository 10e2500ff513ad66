//! Progress of long operations.

/// Progress report, sent from any thread each time a piece is finished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step<'a> {
    /// Number of finished pieces.
    pub done: usize,
    /// Number of these that existed before the run; they say nothing about the rate.
    pub found: usize,
    /// Total number of pieces.
    pub all: usize,
    /// Name of the last finished piece; empty if pieces have no names.
    pub last: &'a str,
}

/// Callback for progress reports.
pub type OnProgress<'a> = &'a (dyn Fn(Step) + Sync);

/// Ignores progress reports.
pub fn unwatched(_: Step) {}

/// Wraps a progress callback for lower crates, which report two numbers: finished and total.
pub fn counted(progress: OnProgress) -> impl Fn(usize, usize) + Sync {
    move |done, all| progress(Step { done, all, ..Step::default() })
}
