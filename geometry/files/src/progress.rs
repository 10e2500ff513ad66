//! Progress of long operations.

/// Progress report, sent from any thread each time a piece is finished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProgressStep<'a> {
    /// Number of finished pieces.
    pub done: usize,
    /// Number of these that existed before the run; they say nothing about the rate.
    pub resumed: usize,
    /// Total number of pieces.
    pub total: usize,
    /// Name of the last finished piece; empty if pieces have no names.
    pub last_name: &'a str,
}

/// Callback for progress reports.
pub type ProgressCallback<'a> = &'a (dyn Fn(ProgressStep) + Sync);

/// Ignores progress reports.
pub fn ignore_progress(_: ProgressStep) {}

/// Wraps a progress callback for lower crates, which report two numbers: finished and total.
pub fn report_counts(progress: ProgressCallback) -> impl Fn(usize, usize) + Sync {
    move |done, all| progress(ProgressStep { done, total: all, ..ProgressStep::default() })
}
