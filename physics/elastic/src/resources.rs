//! Threads and memory of a solver.

/// Threads and memory that a solver may use. Neither changes a result; a solver that needs more memory is refused.
///
/// ```
/// use fabkit_elastic::SolverResources;
///
/// // A number alone is one of threads; the memory is then that of the largest solver.
/// assert_eq!(SolverResources::from(4), SolverResources { threads: 4, memory_bytes: u64::MAX });
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SolverResources {
    /// Largest number of threads.
    pub threads: usize,
    /// Largest memory of the matrices, bytes.
    pub memory_bytes: u64,
}

impl From<usize> for SolverResources {
    fn from(threads: usize) -> Self {
        Self { threads, memory_bytes: u64::MAX }
    }
}
