//! What notes tell people and what 3MF files tell slicers is the same.

use fabkit_checks::print_settings;
use fabkit_designs::Design;
use fabkit_geometry::{Body, Process};
use fabkit_tests::{build_design, builtin_designs, builtin_fixtures, sample_bodies};

/// The number before the words, for example `0.12` of `parting face up, 0.12 mm layers`.
fn before<'a>(note: &'a str, words: &str) -> Option<&'a str> {
    let head = &note[..note.find(words)?];
    head.rsplit(' ').next()
}

/// What a part's notes say of supports.
fn supports(part: &Body) -> Option<bool> {
    let notes = part.notes.join("; ").to_lowercase();
    let denied = ["no supports", "without support"];
    if denied.iter().any(|words| notes.contains(words)) {
        Some(false)
    } else {
        notes.contains("support").then_some(true)
    }
}

fn layers(part: &Body) -> Option<f64> {
    let said = |note: &String| {
        let number = before(note, " mm layers")
            .or_else(|| note.split_once("in layers of ")?.1.split(' ').next())?;
        number.parse().ok()
    };
    part.notes.iter().find_map(said)
}

fn every_design() -> Vec<Design> {
    let mut all = builtin_designs();
    all.extend(builtin_fixtures());
    all
}

#[test]
fn notes_say_what_slicers_are_told() {
    let mut said = [0; 3];
    for design in every_design() {
        let fdm = sample_bodies(&design).filter(|body| body.process() == Some(Process::Fdm));
        for part in fdm {
            let place = format!("{}/{}: {:?}", design.sensor.name, part.name, part.notes);
            assert_eq!(part.slicing.supports, supports(part), "{place}");
            assert_eq!(part.slicing.layer_mm, layers(part), "{place}");
            let brim = part.notes.iter().any(|note| note.contains("on a brim"));
            assert_eq!(part.slicing.brim_mm.is_some_and(|mm| mm > 0.0), brim, "{place}");
            let wide = part
                .notes
                .iter()
                .find_map(|note| note.split_once("on a brim ")?.1.split(' ').next());
            if let Some(width_mm) = wide.and_then(|word| word.parse::<f64>().ok()) {
                assert_eq!(part.slicing.brim_mm, Some(width_mm), "{place}");
            }
            let told = print_settings(&design.sensor, part).unwrap().unwrap();
            assert_eq!(part.slicing.supports.unwrap_or(told.supports.value), told.supports.value);
            assert_eq!(part.slicing.layer_mm.unwrap_or(told.layer_mm.value), told.layer_mm.value);
            assert!(told.layer_mm.value * 1.5 < told.line_mm, "{place}: flat lines hold");
            said[0] += usize::from(part.slicing.supports.is_some());
            said[1] += usize::from(part.slicing.layer_mm.is_some());
            said[2] += usize::from(brim);
        }
    }
    assert!(said.iter().all(|count| *count > 0), "{said:?}");
}

/// A file's processes go before notes and rules.
#[test]
fn owners_say_how_their_printers_are_told() {
    let yaml = "format: 1\nextends: rtac0\nname: mine\ntitle: Mine\nprocesses:\n  strong:\n    kind: fdm\n    \
                layer_height: 0.16 mm\n    perimeters: 6\n    infill: 0.4\n    supports: true\n    brim: 3 mm\n\
                parts:\n  shell: {process: strong}\n";
    let design = fabkit_designs::load("mine.yaml", yaml, &[], &["fixtures"]).unwrap();
    let told = |name: &str| {
        let part = design.sensor.body(name).unwrap();
        print_settings(&design.sensor, part).unwrap().unwrap()
    };
    let shell = told("shell");
    assert_eq!(
        (shell.layer_mm.value, shell.perimeters.value, shell.solid_layers.value),
        (0.16, 6, 5)
    );
    assert_eq!(
        (shell.infill_percent.value, shell.supports.value, shell.brim_mm.value),
        (40.0, true, 3.0)
    );
    assert_eq!(shell.infill_percent.reason, "as the process strong says");
    assert_eq!(told("base").perimeters.value, 3);
    // What is told to slicers is part of the design.
    let plain = build_design("rtac0", &[]);
    let paths = |design: &Design| -> Vec<String> {
        design.parameters.iter().map(|setting| setting.path.clone()).collect()
    };
    assert!(paths(&design).contains(&"processes.strong.infill".to_owned()), "{:?}", paths(&design));
    assert!(!paths(&plain).iter().any(|path| path.starts_with("processes.")));
}
