//! What is wrong is said soon, whatever was written.

use std::time::{Duration, Instant};

use fabkit_tests::{Run, fabkit};

/// Each hint is tried with the others, thousands of times over: a family whose limits are slow to look at
/// would keep its user waiting for minutes.
#[test]
fn hints_for_several_problems_do_not_take_long() {
    let root = tempfile::tempdir().unwrap();
    let wide = "camera.screw_spacing=25 mm";
    let low = "surface.wall_height=2mm";
    // The first run may build the binary.
    assert_eq!(fabkit(root.path(), &["--version"]).code, Some(0));
    // What no one value mends.
    for (sensor, set) in [("uvdtact", "mount.thread=M5"), ("rtac0", low), ("gelsight-like", wide)] {
        let start = Instant::now();
        let run = fabkit(root.path(), &["show", sensor, "--set", set]);
        assert_eq!(run.code, Some(2), "{sensor}: {run:?}");
        // Two seconds on a quiet machine.
        assert!(start.elapsed() < Duration::from_secs(30), "{sensor}: {:?}", start.elapsed());
    }
}

/// Shortest time of a command among some runs, each of which `look` sees. On a machine with other work, the quickest of
/// several says how long it takes.
fn quickest(runs: usize, arguments: &[&str], look: impl Fn(&Run)) -> Duration {
    let root = tempfile::tempdir().unwrap();
    let time = |_| {
        let start = Instant::now();
        let run = fabkit(root.path(), arguments);
        let took = start.elapsed();
        look(&run);
        took
    };
    (0..runs).map(time).min().unwrap()
}

/// Time in which the sensor is read and shown on this machine, which other times are compared with.
fn time_of_show() -> Duration {
    quickest(9, &["show", "rtac0", "--json"], |run| assert_eq!(run.code, Some(0), "{run:?}"))
}

/// A search that ends without a way out has tried all that it may: 7000 evaluations. They take 30 times as long as `show`,
/// and took 100 times before each computed only the expressions that a change reaches.
#[test]
fn a_contradiction_is_said_soon() {
    let sets = ["--set", "surface.radius=9mm", "--set", "surface.wall_height=2mm"];
    let took = quickest(3, &[&["check", "rtac0", "--fix"], &sets[..]].concat(), |run| {
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains("a contradiction: "), "{run:?}");
    });
    let most = 60 * time_of_show();
    assert!(took < most || cfg!(debug_assertions), "{took:?} of {most:?}");
}

#[test]
fn what_is_nested_or_long_without_end_is_refused_at_once() {
    let deep = format!("surface.radius== {}1 mm{}", "(".repeat(400), ")".repeat(400));
    let long = format!("surface.radius== 1 mm{}", " + 1 mm".repeat(10_000));
    let wide = format!("surface.radius== {}", "max(".repeat(20_000));
    let signs = format!("surface.radius== {}1 mm", "-".repeat(300));
    // The sensor's other values are read before, and nothing is built.
    let most = time_of_show() + Duration::from_millis(20);
    for set in [deep, long, wide, signs] {
        let took = quickest(9, &["show", "rtac0", "--json", "--set", &set], |run| {
            assert_eq!(run.code, Some(2), "{run:?}");
            assert_eq!(run.json()["problems"][0]["code"], "expression_too_large");
        });
        assert!(took < most, "{took:?} of {most:?}: {}", &set[..40]);
    }
}
