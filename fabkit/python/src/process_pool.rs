//! Thread pool of the present process.
//!
//! Rayon's global pool does not survive a fork: its threads stay in the parent, and a child that asks it for work waits for
//! ever. Every process therefore has a pool of its own, also the first one, so that the global pool is never started, and
//! works in a child even where it is used by mistake.

use std::process;
use std::sync::OnceLock;

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Pools of the first process and of the forks between it and this one. Only the last has threads.
///
/// A list, because reading it takes no lock: a lock that another thread holds during a fork stays locked in the child.
static POOLS: OnceLock<ProcessPool> = OnceLock::new();

/// Pool of one process.
struct ProcessPool {
    process: u32,
    pool: Option<ThreadPool>,
    /// Pool of a process that was forked from this one.
    child: OnceLock<Box<ProcessPool>>,
}

impl ProcessPool {
    fn new() -> Self {
        // `None` if the system starts no threads: rayon's own pool then says so.
        let pool = ThreadPoolBuilder::new().build().ok();
        Self { process: process::id(), pool, child: OnceLock::new() }
    }

    /// Returns the pool of the present process, which is started by its first use.
    fn current() -> &'static Self {
        let mut pool = POOLS.get_or_init(Self::new);
        let process = process::id();
        while pool.process != process {
            pool = pool.child.get_or_init(|| Box::new(Self::new()));
        }
        pool
    }
}

/// Starts the pool of this process. Called when the package is imported, before any other thread can fork meanwhile.
pub fn start_pool() {
    ProcessPool::current();
}

/// Runs work in the pool of this process.
pub fn run_in_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    match &ProcessPool::current().pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}
