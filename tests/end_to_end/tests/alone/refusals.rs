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

/// A search that ends without a way out has tried all that it may: 7000 evaluations, which took 7 s of computing and now
/// take 2.
#[test]
fn a_contradiction_is_said_soon() {
    let root = tempfile::tempdir().unwrap();
    assert_eq!(fabkit(root.path(), &["--version"]).code, Some(0));
    let sets = ["--set", "surface.radius=9mm", "--set", "surface.wall_height=2mm"];
    let mut quickest = Duration::MAX;
    // On a machine with other work, the quickest of several says how long it takes.
    for _ in 0..3 {
        let start = Instant::now();
        let run = fabkit(root.path(), &[&["check", "rtac0", "--fix"], &sets[..]].concat());
        quickest = quickest.min(start.elapsed());
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains("a contradiction: "), "{run:?}");
    }
    assert!(quickest < Duration::from_secs(4) || cfg!(debug_assertions), "{quickest:?}");
}

#[test]
fn what_is_nested_or_long_without_end_is_refused_at_once() {
    let root = tempfile::tempdir().unwrap();
    let deep = format!("surface.radius== {}1 mm{}", "(".repeat(400), ")".repeat(400));
    let long = format!("surface.radius== 1 mm{}", " + 1 mm".repeat(10_000));
    let wide = format!("surface.radius== {}", "max(".repeat(20_000));
    let signs = format!("surface.radius== {}1 mm", "-".repeat(300));
    for set in [deep, long, wide, signs] {
        let run = || -> (Run, Duration) {
            let start = Instant::now();
            let run = fabkit(root.path(), &["show", "rtac0", "--json", "--set", &set]);
            (run, start.elapsed())
        };
        // On a machine with other work, the quickest of several says how long it takes.
        let mut quickest = Duration::MAX;
        for _ in 0..40 {
            let (run, took) = run();
            assert_eq!(run.code, Some(2), "{run:?}");
            assert_eq!(run.json()["problems"][0]["code"], "expression_too_large");
            quickest = quickest.min(took);
            if quickest < Duration::from_millis(50) {
                break;
            }
        }
        assert!(quickest < Duration::from_millis(50), "{quickest:?}: {}", &set[..40]);
    }
}
