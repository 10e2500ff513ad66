//! What cannot be made is refused, and what a refusal recommends can be made.

use std::path::Path;

use fabkit_tests::{Run, fabkit, sample_cases};

/// How often advice is followed.
const ROUNDS: u32 = 3;

/// Exports coarsely: export itself compares holes and handles with those that the design counts.
fn export(folder: &Path, design: &str, parts: &[&str], settings: &[String]) -> Run {
    let mut arguments = vec!["export", design, "-o", "out", "--format", "stl", "--tolerance"];
    arguments.push("0.05mm");
    arguments.extend(parts.iter().flat_map(|part| ["--part", part]));
    arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
    fabkit(folder, &arguments)
}

/// What a refusal recommends, `error: PATH is 3 mm; it must be at most 2.85 mm, because ...`, as
/// settings.
fn recommended(run: &Run) -> Vec<[String; 2]> {
    let advice = |line: &str| {
        let (path, rest) = line.strip_prefix("error: ")?.split_once(" is ")?;
        let (value, _) = rest.split_once("it must be at ")?.1.split_once(", because")?;
        let (_, value) = value.split_once(' ')?;
        Some([path.to_owned(), value.replace(' ', "")])
    };
    run.stderr.lines().filter_map(advice).collect()
}

/// Exports with settings; where that is refused, with what the refusal recommends instead.
fn made_or_mended(design: &str, parts: &[&str], settings: &[[&str; 2]]) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let written = |[path, value]: &[&str; 2]| format!("{path}={value}");
    let mut all: Vec<String> = settings.iter().map(written).collect();
    let mut run = export(folder.path(), design, parts, &all);
    if run.code == Some(0) {
        return true;
    }
    // What one piece of advice makes room for, the next one may be about.
    for _ in 0..ROUNDS {
        assert_eq!(run.code, Some(2), "{design} {all:?}: {run:?}");
        let better = recommended(&run);
        assert!(!better.is_empty(), "no advice: {run:?}");
        let is_better =
            |setting: &str| better.iter().any(|[path, _]| setting.starts_with(&format!("{path}=")));
        all.retain(|setting| !is_better(setting));
        all.extend(better.iter().map(|[path, value]| format!("{path}={value}")));
        run = export(folder.path(), design, parts, &all);
        if run.code == Some(0) {
            return false;
        }
    }
    panic!("{design} {all:?} after {ROUNDS} pieces of advice: {run:?}");
}

#[test]
fn a_dome_has_room_for_its_numbers_or_says_how_large_they_may_be() {
    let height = "fixtures.pin_dome.numbers.height";
    let mut made = 0;
    for (sensor, values) in [
        ("rtac0", &["1.5mm", "2.5mm", "3.2mm", "8mm"][..]),
        ("shadowtac", &["8mm"]),
        ("tactip", &["3.2mm"]),
        ("uvdtact", &["2.5mm", "8mm"]),
    ] {
        let design = format!("{sensor}/pin-dome");
        for value in values {
            made += u32::from(made_or_mended(&design, &["dome"], &[[height, value]]));
        }
        // As deep as may be.
        let deep = ["fixtures.pin_dome.numbers.depth", "2mm"];
        made_or_mended(&design, &["dome"], &[[height, "4mm"], deep]);
    }
    // What is made by default, and what is smaller.
    println!("{made} made as asked");
    assert!((3..7).contains(&made), "{made}");
}

#[test]
fn a_lens_that_is_recommended_covers_the_chip() {
    for size in ["7.9mm", "10mm", "13.7mm"] {
        let chip = ["camera.array_size", size];
        made_or_mended("tactip", &["lens"], &[chip, ["camera.lens_view", "60deg"]]);
    }
}

/// Near the surface, only the crests of ring-shaped protrusions stand out of a half dome.
#[test]
fn halves_close_to_the_surface_are_made() {
    let close =
        [("rtac0", "0.1mm"), ("tactip", "0.1mm"), ("uvdtact", "0.1mm"), ("uvdtact", "0.4mm")];
    for (sensor, clearance) in sample_cases(&close) {
        let near = [format!("fixtures.semi_domes.clearance={clearance}")];
        let folder = tempfile::tempdir().unwrap();
        let design = format!("{sensor}/semi-domes");
        export(folder.path(), &design, &["holder", "semi-dome-012"], &near).ok();
    }
}

/// What a lamp needs, its supply must have; and neither it nor its resistor burns. `--fix` takes another supply
/// where it was chosen, and never makes a lamp bear more than it is said to.
#[test]
fn lamps_shine_on_their_supply_and_do_not_burn() {
    let drop = "the resistor needs 0.2 V of the supply's";
    for (design, settings, said, fixed) in [
        (
            "rtac0",
            &["leds.forward_volts=6"][..],
            &*format!("leds.forward_volts is 6; it must be at most 4.8, because {drop} 5 V"),
            Some("leds.supply_volts 5 -> 6.2"),
        ),
        ("uvdtact", &["leds.uv_forward_volts=3.3", "leds.supply_volts=3.3"], "at most 3.1", None),
        // (5 V - 3 V)^2 / 0.1 W
        (
            "rtac0",
            &["leds.resistor_ohms=20", "leds.rated_ma=200"],
            "at least 40, because a resistor 0603 bears 0.1 W",
            Some("leds.supply_volts 5 -> "),
        ),
        // (5 V - 3 V) / 20 mA
        (
            "rtac0",
            &["leds.resistor_ohms=47"],
            "at least 100, because an LED bears 20 mA",
            Some("leds.supply_volts 5 -> "),
        ),
        ("tactip", &["leds.current_ma=25"], "at most 20, because an LED bears no more", None),
        // Four behind one resistor of 0.1 W that takes 2 V.
        (
            "uvdtact",
            &["leds.current_ma=15"],
            "at most 12.5, because a resistor 0603 bears 0.1 W",
            None,
        ),
        ("9dtact", &["leds.supply_ma=12"], "because the supply gives 12 mA for", Some("leds.")),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let run = |settings: &[&str], more: &[&str]| {
            let set = settings.iter().flat_map(|setting| ["--set", setting]);
            let words = ["show", design].into_iter().chain(set).chain(more.iter().copied());
            fabkit(folder.path(), &words.collect::<Vec<_>>())
        };
        let refused = run(settings, &[]);
        assert_eq!(refused.code, Some(2), "{design} {settings:?}: {refused:?}");
        assert!(refused.stderr.contains(said), "{design} {settings:?}: {refused:?}");
        // The hint works: `write at most 4.8`, `write at least 25.55 for `leds.supply_ma``.
        let mut lines = refused.stderr.lines();
        let hint = lines.find_map(|line| line.split_once("= help: write at ")).unwrap().1;
        let is_digit = |c: &char| c.is_ascii_digit() || *c == '.';
        let value: String =
            hint.chars().skip_while(|c| !is_digit(c)).take_while(is_digit).collect();
        let own = settings[0].split_once('=').unwrap().0;
        let path =
            hint.split_once(" for `").map_or(own, |(_, rest)| rest.split_once('`').unwrap().0);
        let better = format!("{path}={value}");
        let kept = settings.iter().filter(|setting| !setting.starts_with(&format!("{path}=")));
        run(&kept.copied().chain([&*better]).collect::<Vec<_>>(), &[]).ok();
        // What was set stays, and what was chosen follows, if that is no rating.
        let run = run(settings, &["--fix"]);
        assert_eq!(
            run.code,
            Some(if fixed.is_some() { 0 } else { 2 }),
            "{design} {settings:?}: {run:?}"
        );
        let told = run.stderr + &run.stdout;
        assert!(fixed.is_none_or(|fixed| told.contains(&format!("fixed: {fixed}"))), "{told}");
    }
}
