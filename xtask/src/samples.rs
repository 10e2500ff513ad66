//! How much of what takes minutes `cargo xtask test` looks at: chosen before it begins, by how quick the machine is, and
//! never by a clock that runs out.

use std::env;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Set to 1, tests, oracles and the Python package's tests look at everything; the tests themselves read it, too.
pub const FULL: &str = "FABKIT_FULL";

/// What [`work`] takes on the gate's quick machine, in the debug build that `cargo xtask` runs; in release it is 85 ms.
const QUICK: Duration = Duration::from_millis(150);

/// Sizes of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// Everything.
    Full,
    /// The usual sample, or on a slow machine a half or a quarter of it.
    Part { slowness: usize },
}

impl Samples {
    /// Looks at the environment and measures the machine, which should have nothing else to do.
    pub fn choose() -> Self {
        if env::var_os(FULL).is_some_and(|value| value == "1") {
            return Self::Full;
        }
        // On a machine with other work, the quickest of several says how long it takes.
        let took = (0..5).map(|_| work()).min().unwrap_or(QUICK);
        let times = took.as_secs_f64() / QUICK.as_secs_f64();
        println!("xtask: this machine takes {times:.1} times as long as a quick one");
        Self::Part { slowness: slowness(times) }
    }

    /// Every so many-th of many, for outside programs; the usual step is for a quick machine.
    pub fn step(self, usual: usize) -> usize {
        match self {
            Self::Full => 1,
            Self::Part { slowness } => usual * slowness,
        }
    }

    /// So many of as many as one likes.
    pub fn count(self, full: usize, usual: usize) -> usize {
        match self {
            Self::Full => full,
            Self::Part { slowness } => usual.div_ceil(slowness),
        }
    }

    /// The names that are looked at in part; none, which stands for all, in full.
    pub fn names<'a>(self, usual: &'a [&'a str]) -> &'a [&'a str] {
        if self == Self::Full { &[] } else { usual }
    }
}

/// Two sizes of steps are enough, and a machine that is as quick as before gets the samples that it had.
fn slowness(times: f64) -> usize {
    match times {
        ..1.7 => 1,
        ..3.0 => 2,
        _ => 4,
    }
}

/// Sorts the same four million numbers: what it takes depends on the core alone.
fn work() -> Duration {
    let start = Instant::now();
    let mut state = 1u64;
    let mut numbers: Vec<u64> = std::iter::repeat_with(|| {
        // Knuth's constants.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 11
    })
    .take(1 << 22)
    .collect();
    numbers.sort_unstable();
    black_box(numbers);
    start.elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_machines_look_at_less_and_never_at_nothing() {
        let sizes = |samples: Samples| (samples.step(5), samples.count(200, 6));
        assert_eq!(sizes(Samples::Full), (1, 200));
        let part = |times: f64| sizes(Samples::Part { slowness: slowness(times) });
        assert_eq!([0.8, 1.5, 2.0, 3.5].map(part), [(5, 6), (5, 6), (10, 3), (20, 2)]);
        assert_eq!(Samples::Part { slowness: 4 }.count(9, 1), 1);
    }
}
