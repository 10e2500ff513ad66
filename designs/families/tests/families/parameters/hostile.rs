//! Broken, huge and malicious text: refused where it goes wrong, quickly, and never a panic.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use super::bulb::{GLOW, REGISTRY, glow_with, problem, problems};
use fabkit_designs::parameters::{MAX_BYTES, MAX_DEPTH, MAX_NODES};
use proptest::prelude::*;

#[test]
fn syntax_errors_have_a_line_and_a_column() {
    for (yaml, line, says) in [
        (glow_with("  radius", "\tradius"), 7, "a tab is used for indentation"),
        (glow_with("  wall_height", "    wall_height"), 8, "not YAML"),
        (glow_with("15.0 mm", "\"15.0 mm"), 7, "not YAML"),
        (glow_with("note: published mesh}", "note: published mesh"), 7, "not YAML"),
        (format!("%YAML 1.2\n---\n{GLOW}"), 1, "directives"),
        (format!("{GLOW}---\n{GLOW}"), 20, "a second document"),
        (glow_with("15.0 mm", "!!str 15.0 mm"), 7, "tags"),
        (glow_with("15.0 mm", "&r 15.0 mm"), 7, "anchors"),
        (glow_with("15.0 mm", "*r"), 7, "aliases"),
        (glow_with("  radius:", "  <<: {}\n  radius:"), 7, "merge keys"),
        (glow_with("  radius:", "  [1, 2]: 3\n  radius:"), 7, "not a key"),
        (glow_with("  radius:", "  ? {a: b}\n  : 3\n  radius:"), 7, "not a key"),
    ] {
        let found = problem(&yaml, &[]);
        assert!(found.message.contains(says), "{yaml}\n{found:#?}");
        assert!(found.hint.is_some(), "{found:#?}");
        // An unclosed quote or brace is noticed where the next thing makes no sense.
        let noticed = found.line.unwrap();
        assert!((line..=line + 1).contains(&noticed), "{found:#?}");
        assert!(found.column.is_some(), "{found:#?}");
    }
}

#[test]
fn duplicate_keys_name_both_lines() {
    let found = problem(&format!("{GLOW}  leds: 9\n"), &[]);
    assert_eq!(found.message, "`optics.leds` is written twice: on line 15 and on line 20");
    assert_eq!((found.line, found.column), (Some(20), Some(3)));
    assert_eq!(found.path, "optics.leds");
}

#[test]
fn a_bomb_is_refused_at_its_first_anchor() {
    let mut bomb = String::from("a0: &a0 [lol, lol, lol, lol, lol, lol, lol, lol, lol]\n");
    for i in 1..30 {
        let items = vec![format!("*a{}", i - 1); 9].join(", ");
        writeln!(bomb, "a{i}: &a{i} [{items}]").unwrap();
    }
    let start = Instant::now();
    let found = problem(&bomb, &[]);
    assert_eq!(found.line, Some(1));
    assert!(found.message.contains("anchors"));
    // Expanded it would be 9^30 nodes; the seconds are for slow machines with other work.
    assert!(start.elapsed() < Duration::from_secs(10));
}

#[test]
fn limits_on_bytes_nodes_and_depth() {
    let huge = "a: 1\n".repeat(2_000_000);
    // On a machine with other work, the quickest of several says how long it takes.
    let refuse = || {
        let start = Instant::now();
        let found = problem(&huge, &[]);
        assert!(found.message.contains("10000000 bytes"), "{}", found.message);
        assert!(found.message.contains(&MAX_BYTES.to_string()));
        start.elapsed()
    };
    let quickest = (0..5).map(|_| refuse()).min().unwrap();
    assert!(quickest < Duration::from_millis(100), "not even looked at: {quickest:?}");

    // A list in a mapping: 3 nodes besides its items.
    let list = |items: usize| format!("a: [{}]", vec!["1"; items].join(","));
    let found = problem(&list(MAX_NODES - 2), &[]);
    assert!(found.message.contains("more than 20000 keys and values"), "{}", found.message);
    let found = problems(&list(MAX_NODES - 3), &[]);
    assert_eq!(found[0].message, "the format is missing");

    let nested = |depth: usize| format!("{}{}", "[".repeat(depth), "]".repeat(depth));
    for depth in [MAX_DEPTH + 1, 1_000, 100_000] {
        let found = problem(&nested(depth), &[]);
        assert!(found.message.contains("nested more than 64 deep"), "{}", found.message);
    }
    assert!(problem(&nested(MAX_DEPTH), &[]).message.contains("keys and values"));
}

#[test]
fn long_or_odd_text_is_not_echoed_as_it_is() {
    let long = glow_with("15.0 mm", &format!("\"\\e[31m{}\"", "x".repeat(1000)));
    let found = problem(&long, &[]);
    assert!(found.value.len() < 100 && found.message.len() < 300, "{found:#?}");
    assert!(!found.message.contains('\u{1b}'));
    let key = problem(&format!("{GLOW}\"a\\e\\u202e\": 1\n"), &[]);
    assert!(!key.message.contains(['\u{1b}', '\u{202e}']), "{key:#?}");
}

/// Text that looks enough like a sensor file to get past the first check.
fn yaml_like() -> impl Strategy<Value = String> {
    let word = prop::sample::select(vec![
        "format: 1\n",
        "family: bulb\n",
        "extends: glow\n",
        "name: x\n",
        "surface:\n",
        "  radius:",
        " 9 mm",
        "layers:\n",
        "  gel:\n",
        "    thickness: ",
        "optics:\n",
        "  rings: ",
        "[1 mm, ",
        "]",
        "{value: ",
        ", source: paper",
        "}",
        "\n",
        "  ",
        " ",
        ":",
        "- ",
        "\"",
        "'",
        "|\n",
        ">\n",
        "#",
        "&a",
        "*a",
        "!t ",
        "? ",
        "---\n",
        "...\n",
        "\t",
        "\r\n",
        ".nan",
        "1e999",
        "-",
        "%",
        "\u{feff}",
        "\u{0}",
        "é",
        "<<: ",
    ]);
    prop::collection::vec(word, 0..40).prop_map(|words| words.concat())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 512,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Whatever is read: a design, or problems with a message each.
    #[test]
    fn no_text_makes_reading_panic(yaml in yaml_like(), bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        for text in [yaml, String::from_utf8_lossy(&bytes).into_owned()] {
            for (yaml, set) in [(text.as_str(), None), (GLOW, Some(text.clone()))] {
                let overrides: Vec<String> = set.into_iter().collect();
                if let Err(invalid) = REGISTRY.load("x", yaml, &overrides, &[]) {
                    prop_assert!(!invalid.problems.is_empty());
                    prop_assert!(invalid.problems.iter().all(|p| !p.message.is_empty()));
                }
            }
        }
    }

    /// A file with a part replaced: what the reader says stays within the file.
    #[test]
    fn places_lie_within_the_file(start in 0..GLOW.len(), len in 0_usize..30, put in yaml_like()) {
        let end = (start + len).min(GLOW.len());
        let yaml = format!("{}{put}{}", &GLOW[..start], &GLOW[end..]);
        if let Err(invalid) = REGISTRY.load("x", &yaml, &[], &[]) {
            let lines = yaml.lines().count() + 1;
            for found in invalid.problems.iter().filter(|p| p.file == "x") {
                prop_assert!(found.line.is_none_or(|line| (1..=lines).contains(&line)), "{found:#?}");
            }
        }
    }
}
