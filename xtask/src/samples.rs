//! Sample sizes of the slow checks of `cargo xtask test`. They are chosen before the tests begin, by the machine's
//! speed, and never by a time limit.

use std::env;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Environment variable: with 1, tests, oracles and the Python package's tests cover everything. The tests read it
/// themselves.
pub const FULL: &str = "FABKIT_FULL";

/// Environment variable of the tests: divisor of their sample sizes.
pub const SLOWNESS: &str = "FABKIT_SLOWNESS";

/// Duration of [`measure_speed`] on the gate's fast machine, in the debug build that `cargo xtask` runs; in release it is 85 ms.
const FAST_DURATION: Duration = Duration::from_millis(150);

/// Sample sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// Everything.
    Full,
    /// The usual sample, or a half or a quarter of it on a slow machine.
    Part { slowness: usize },
}

impl Samples {
    /// Reads the environment variable, or measures the machine, which should be idle.
    pub fn choose() -> Self {
        if env::var_os(FULL).is_some_and(|value| value == "1") {
            return Self::Full;
        }
        // Other work may slow single measurements down, so the shortest counts.
        let took = (0..5).map(|_| measure_speed()).min().unwrap_or(FAST_DURATION);
        let times = took.as_secs_f64() / FAST_DURATION.as_secs_f64();
        println!("xtask: this machine takes {times:.1} times as long as a quick one");
        Self::Part { slowness: slowness(times) }
    }

    /// Returns the step between sampled items for external programs; `usual` is the step on a fast machine.
    pub fn step(self, usual: usize) -> usize {
        match self {
            Self::Full => 1,
            Self::Part { slowness } => usual * slowness,
        }
    }

    /// Returns the number of samples where any number is possible.
    pub fn count(self, full: usize, usual: usize) -> usize {
        match self {
            Self::Full => full,
            Self::Part { slowness } => usual.div_ceil(slowness),
        }
    }

    /// Returns the divisor of sample sizes.
    pub fn slowness(self) -> usize {
        match self {
            Self::Full => 1,
            Self::Part { slowness } => slowness,
        }
    }

    /// Returns the names of the sample; an empty list, which stands for all, in full.
    pub fn names<'a>(self, usual: &'a [&'a str]) -> &'a [&'a str] {
        if self == Self::Full { &[] } else { usual }
    }
}

/// Returns the divisor of the sample sizes. Two reduced sizes suffice, and a machine of unchanged speed keeps its
/// samples.
fn slowness(times: f64) -> usize {
    match times {
        ..1.7 => 1,
        ..3.0 => 2,
        _ => 4,
    }
}

/// Measures the time to sort the same four million numbers, which depends on the core alone.
fn measure_speed() -> Duration {
    let start = Instant::now();
    let mut state = 1u64;
    let mut numbers: Vec<u64> = std::iter::repeat_with(|| {
        // Constants of Knuth's linear congruential generator.
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
