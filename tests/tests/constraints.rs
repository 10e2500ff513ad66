//! What cannot be made is refused, and what a refusal recommends can be made.

use std::path::Path;

use fabkit_tests::{Run, fabkit};

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
    for sensor in ["rtac0", "shadowtac", "tactip", "uvdtact"] {
        let design = format!("{sensor}/pin-dome");
        for value in ["1.5mm", "2.5mm", "3.2mm", "8mm"] {
            made += u32::from(made_or_mended(&design, &["dome"], &[[height, value]]));
        }
        // As deep as may be.
        let deep = ["fixtures.pin_dome.numbers.depth", "2mm"];
        made_or_mended(&design, &["dome"], &[[height, "4mm"], deep]);
    }
    // What is made by default, and what is smaller.
    assert!((9..16).contains(&made), "{made}");
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
    let nearest = ["rtac0", "shadowtac", "tactip", "uvdtact"].map(|sensor| (sensor, "0.1mm"));
    for (sensor, clearance) in nearest.into_iter().chain([("rtac0", "0.2mm"), ("uvdtact", "0.4mm")])
    {
        let near = [format!("fixtures.semi_domes.clearance={clearance}")];
        let folder = tempfile::tempdir().unwrap();
        let design = format!("{sensor}/semi-domes");
        export(folder.path(), &design, &["holder", "semi-dome-012"], &near).ok();
    }
}
