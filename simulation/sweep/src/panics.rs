//! Isolation of panics. A variant that makes fabkit panic is a bug, but no reason to lose all other variants: it
//! becomes a row that names the place.
//!
//! A hook records the place of a panic on the thread that panics. If work is spread over threads, this may be any of
//! them, and which of several panics propagates depends on timing. So work that panicked is repeated on a single
//! thread, whose first panic is always the same.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::fmt;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Message and place of a panic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaughtPanic {
    text: String,
    place: Option<String>,
}

impl fmt::Display for CaughtPanic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fabkit panicked: {}", self.text)?;
        self.place.iter().try_for_each(|place| write!(f, " at {place}"))
    }
}

/// Number of threads that run work whose panics are caught.
static CATCHING: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Nesting depth of such work on this thread.
    static DEPTH: Cell<usize> = const { Cell::new(0) };
    /// Place of the last panic on this thread.
    static PLACE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Returns whether a panic becomes a row, so that a panic hook must not report it.
///
/// Idle threads of the pool help with the variants of others. Other work that panics there meanwhile still propagates
/// its panic, but the hook does not report it.
pub fn is_caught(info: &PanicHookInfo) -> bool {
    let is_helper =
        || CATCHING.load(Ordering::Relaxed) > 0 && rayon::current_thread_index().is_some();
    if DEPTH.get() == 0 && !is_helper() {
        return false;
    }
    let place = info.location().map(|l| format!("{}:{}", portable_path(l.file()), l.line()));
    PLACE.with_borrow_mut(|last| *last = place);
    true
}

/// Shortens a source path so that it is the same on all machines, wherever packages are stored.
fn portable_path(file: &str) -> String {
    let file = file.replace('\\', "/");
    // Sources of packages lie in a folder that differs between machines.
    let of_package = file.split_once("/registry/src/").and_then(|(_, rest)| rest.split_once('/'));
    of_package.map_or(file.as_str(), |(_, rest)| rest).to_owned()
}

/// Runs work. If it panics, runs it again on a single thread and returns that panic.
pub(crate) fn catch_panics<T: Send>(work: impl Fn() -> T + Sync) -> Result<T, CaughtPanic> {
    static HOOK: Once = Once::new();
    // Hooks are global: ours is installed once and passes on all other panics.
    HOOK.call_once(|| {
        let others = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !is_caught(info) {
                others(info);
            }
        }));
    });
    attempt(&work).or_else(|panic| run_single_threaded(&work).unwrap_or(Err(panic)))
}

/// Runs work on a pool of one thread; `None` if no thread can be created.
fn run_single_threaded<T: Send>(work: &(impl Fn() -> T + Sync)) -> Option<Result<T, CaughtPanic>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().ok()?;
    // A new thread waits for the result: a waiting thread of the pool would take up other work meanwhile.
    thread::scope(|scope| scope.spawn(|| pool.install(|| attempt(work))).join().ok())
}

/// Runs work and returns its panic with the recorded place.
fn attempt<T>(work: &impl Fn() -> T) -> Result<T, CaughtPanic> {
    CATCHING.fetch_add(1, Ordering::Relaxed);
    DEPTH.set(DEPTH.get() + 1);
    PLACE.take();
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    DEPTH.set(DEPTH.get() - 1);
    CATCHING.fetch_sub(1, Ordering::Relaxed);
    result.map_err(|payload| CaughtPanic { text: text(&*payload), place: PLACE.take() })
}

fn text(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    text.unwrap_or("without a word").to_owned()
}

#[cfg(test)]
pub(crate) mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::row::{PANIC, Status};
    use crate::{Plan, PlanSource, Row, Table, report};

    /// Stands for a bug in a family: panics for some variants of the plans below.
    pub(crate) fn misbehave(overrides: &[String]) {
        let is = |set: &str| overrides.iter().any(|one| one == set);
        assert!(!is("camera.depth=6.1 mm"), "a wall of {} mm", 0.25);
        if is("camera.depth=6.3 mm") {
            // On other threads, several at once, with texts of their own.
            (0..64).into_par_iter().for_each(|i| assert!(i % 8 != 3, "layer {i} is gone"));
        }
    }

    const PLAN: &str = "
format: 1
sensor: rtac0
axes:
  camera.depth: [6 mm, 6.1 mm, 6.2 mm, 6.3 mm, 6.4 mm]
metrics: [coverage]
";

    #[test]
    fn a_panic_is_a_row_and_the_others_are_there() {
        let yaml = fabkit_designs::builtin_yaml("rtac0").unwrap();
        let plan = Plan::new(PlanSource::new("sweep.yaml", PLAN, "rtac0.yaml", yaml)).unwrap();
        let rows = || -> Vec<Row> {
            (0..plan.len()).into_par_iter().map(|number| plan.evaluate(number)).collect()
        };
        let first = rows();
        let reason = |row: usize| first[row].reason.clone().unwrap();
        for panicked in [1, 3] {
            let row = &first[panicked];
            assert_eq!((row.status, row.error_code.as_deref()), (Status::Failed, Some(PANIC)));
            assert!(
                row.metrics.is_empty()
                    && reason(panicked).contains(" at simulation/sweep/src/panics.rs:")
            );
        }
        assert!(reason(1).starts_with("fabkit panicked: a wall of 0.25 mm at "), "{}", reason(1));
        assert!(reason(3).contains("layer 3 is gone"), "{}", reason(3));
        assert!([0, 2, 4].iter().all(|row| first[*row].status == Status::Ok));
        // The same whatever threads do it.
        for threads in [1, 2, 4, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(rows), first, "{threads} threads");
        }
        let table = Table::new(&plan, first.clone());
        assert!(table.to_csv().contains("1,failed,panic,fabkit panicked: a wall of 0.25 mm at "));
        assert!(report(&plan, &table).contains("a wall of 0.25 mm"));
        assert!(table.to_parquet().is_ok());
    }

    #[test]
    fn places_are_the_same_on_all_machines() {
        let crates = "/home/me/.cargo/registry/src/index-1234/rayon-1.12.0/src/lib.rs";
        assert_eq!(portable_path(crates), "rayon-1.12.0/src/lib.rs");
        assert_eq!(portable_path("geometry\\src\\lib.rs"), "geometry/src/lib.rs");
    }
}
