//! How far something is that takes long.

/// What is told each time that a piece of it is finished, from any thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step<'a> {
    /// Pieces that are finished.
    pub done: usize,
    /// How many of these were there before, and say nothing about the rate.
    pub found: usize,
    /// All that there will be.
    pub all: usize,
    /// Which one was finished last; empty where pieces have no names.
    pub last: &'a str,
}

/// Whoever wants to know.
pub type OnProgress<'a> = &'a (dyn Fn(Step) + Sync);

/// For those who do not.
pub fn unwatched(_: Step) {}

/// The same for crates below, which know of nothing but numbers.
pub fn counted(progress: OnProgress) -> impl Fn(usize, usize) + Sync {
    move |done, all| progress(Step { done, all, ..Step::default() })
}
