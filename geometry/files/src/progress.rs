//! Progress of long operations.

/// Progress report, sent from any thread each time a piece is finished.
///
/// ```
/// use std::sync::Mutex;
///
/// use fabkit_files::progress::{ProgressCallback, ProgressStep};
///
/// let seen = Mutex::new(Vec::new());
/// let progress: ProgressCallback = &|step: ProgressStep| {
///     seen.lock().unwrap().push(format!("{}: {} of {}", step.last_name, step.done, step.total));
/// };
/// for (done, name) in (1..).zip(["base", "shell"]) {
///     progress(ProgressStep { done, total: 2, last_name: name, ..ProgressStep::default() });
/// }
/// assert_eq!(seen.into_inner()?, ["base: 1 of 2", "shell: 2 of 2"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
///
/// ```
/// use fabkit_files::progress::{ProgressStep, report_counts};
///
/// let check = |step: ProgressStep| assert_eq!((step.done, step.total, step.last_name), (3, 8, ""));
/// let report = report_counts(&check);
/// report(3, 8);
/// ```
pub fn report_counts(progress: ProgressCallback) -> impl Fn(usize, usize) + Sync {
    move |done, all| progress(ProgressStep { done, total: all, ..ProgressStep::default() })
}
