//! What fabkit suggests is true: hints lead to designs that can be built, and `fix` finds what gives way.

use fabkit_designs::fixing::{advise, fix};
use fabkit_designs::parameters::Problem;
use fabkit_designs::{SensorText, builtin_yaml, load};

const OTHERS: [&str; 1] = ["fixtures"];

/// What people ask of the sensors, one edit each.
const EDITS: [(&str, &str); 60] = [
    ("rtac0", "surface.radius=12mm"),
    ("rtac0", "surface.radius=8mm"),
    ("rtac0", "surface.radius=20mm"),
    ("rtac0", "surface.radius=30mm"),
    ("rtac0", "surface.wall_height=2mm"),
    ("rtac0", "surface.wall_height=12mm"),
    ("rtac0", "translucent_gel.thickness=3mm"),
    ("rtac0", "translucent_gel.thickness=0.5mm"),
    ("rtac0", "leds.count=12"),
    ("rtac0", "leds.count=6"),
    ("rtac0", "leds.circle_radius=10mm"),
    ("rtac0", "leds.length=5mm"),
    ("rtac0", "camera.barrel_diameter=14mm"),
    ("rtac0", "camera.field_of_view=90deg"),
    ("rtac0", "camera.depth=3mm"),
    ("rtac0", "camera.board_size=25mm"),
    ("rtac0", "camera.screw_spacing=20mm"),
    ("rtac0", "shell.outer_diameter=40mm"),
    ("rtac0", "shell.wall=3mm"),
    ("rtac0", "shell.screws=4"),
    ("rtac0", "base.mount_holes=4"),
    ("rtac0", "base.height=6mm"),
    ("rtac0", "diffuser.thickness=3mm"),
    ("rtac0", "mold.wall=1mm"),
    ("rtac0", "mold.dowel_diameter=4mm"),
    ("rtac0", "connector.o_ring_cord=1.5mm"),
    ("shadowtac", "skin.base_diameter=30mm"),
    ("shadowtac", "skin.height=8mm"),
    ("shadowtac", "dimples.width=1.5mm"),
    ("shadowtac", "dimples.spacing=1mm"),
    ("shadowtac", "dimples.rings=12"),
    ("shadowtac", "plate.thickness=5mm"),
    ("shadowtac", "leds.count=9"),
    ("shadowtac", "camera.depth=25mm"),
    ("shadowtac", "holder.height=15mm"),
    ("shadowtac", "base.mount_radius=10mm"),
    ("tactip", "tip.diameter=20mm"),
    ("tactip", "tip.diameter=40mm"),
    ("tactip", "skin.thickness=2mm"),
    ("tactip", "pins.length=3mm"),
    ("tactip", "lens.thickness=4mm"),
    ("tactip", "bayonet.turn=30deg"),
    ("tactip", "camera.depth=30mm"),
    ("tactip", "seal.cord=2mm"),
    ("uvdtact", "surface.diameter=20mm"),
    ("uvdtact", "surface.height=20mm"),
    ("uvdtact", "markers.count=120"),
    ("uvdtact", "markers.radius=1mm"),
    ("uvdtact", "leds.pairs=4"),
    ("uvdtact", "base.bolts=6"),
    ("fluidic", "channels.width=1.5mm"),
    ("fluidic", "channels.per_side=8"),
    ("fluidic", "tubes.outer_diameter=2mm"),
    ("fluidic", "plate.side=40mm"),
    ("fluidic", "markers.pitch=1mm"),
    ("9dtact", "pad.thickness=2mm"),
    ("9dtact", "pad.length=40mm"),
    ("9dtact", "shell.wall=1mm"),
    ("digit-like", "pad.width=10mm"),
    ("gelsight-like", "camera.field_of_view=60deg"),
];

/// What following the hints comes to.
#[derive(Debug, PartialEq)]
enum Followed {
    Converged(usize),
    /// No hint says what to write.
    Stuck(String),
    /// Values come back that were there before.
    Looped,
    TooLong,
}

/// The problems of a design with hints as they are printed.
fn problems(sensor: &str, overrides: &[String]) -> Vec<Problem> {
    let yaml = builtin_yaml(sensor).unwrap();
    let Err(mut invalid) = load(sensor, yaml, overrides, &OTHERS) else { return Vec::new() };
    advise(SensorText::without_bases(sensor, yaml), overrides, &OTHERS, &mut invalid);
    invalid.problems
}

/// What a hint says to write first: paths and values.
fn suggested(problem: &Problem) -> Vec<(String, String)> {
    let Some(hint) = &problem.hint else { return Vec::new() };
    if let Some(value) = hint.strip_prefix("the nearest allowed value is ") {
        return vec![(problem.path.clone(), value.split(';').next().unwrap().to_owned())];
    }
    let Some(first) = hint.strip_prefix("write ") else { return Vec::new() };
    let first = first.split(", or ").next().unwrap();
    let mut pairs = Vec::new();
    for part in first.split(" and ") {
        let part = part.trim_start_matches("at most ").trim_start_matches("at least ");
        match part.split_once(" for `") {
            Some((value, path)) => pairs.push((path.trim_end_matches('`').into(), value.into())),
            None => pairs.push((problem.path.clone(), part.to_owned())),
        }
    }
    pairs
}

/// Does what the hints say, all of one message together, up to five times.
fn follow(sensor: &str, edit: &str) -> Followed {
    let mut overrides = vec![edit.to_owned()];
    let mut seen = Vec::new();
    for round in 0..=5 {
        let problems = problems(sensor, &overrides);
        if problems.is_empty() {
            return Followed::Converged(round);
        }
        if seen.contains(&overrides) {
            return Followed::Looped;
        }
        seen.push(overrides.clone());
        let mut said: Vec<(String, String)> = problems.iter().flat_map(suggested).collect();
        said.sort();
        said.dedup();
        if said.is_empty() {
            let first = &problems[0];
            return Followed::Stuck(format!("{}; {:?}", first.message, first.hint));
        }
        for (path, value) in said {
            overrides.retain(|text| text.split('=').next() != Some(&path));
            overrides.push(format!("{path}={value}"));
        }
    }
    Followed::TooLong
}

#[test]
fn who_follows_the_hints_arrives() {
    let mut refused = 0;
    let mut lost = Vec::new();
    for (sensor, edit) in EDITS {
        let followed = follow(sensor, edit);
        println!("{sensor} {edit}: {followed:?}");
        refused += usize::from(followed != Followed::Converged(0));
        assert_ne!(followed, Followed::Looped, "{sensor} {edit}");
        if !matches!(followed, Followed::Converged(_)) {
            lost.push(format!("{sensor} {edit}: {followed:?}"));
        }
    }
    println!("{refused} are refused at first, {} are lost", lost.len());
    assert!(refused >= 15, "the edits are too tame: {refused} are refused");
    assert!(lost.len() <= 5, "{lost:#?}");
}

fn fixed(sensor: &str, overrides: &[&str]) -> Result<Vec<String>, String> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let changes =
        fix(SensorText::without_bases(sensor, builtin_yaml(sensor).unwrap()), &overrides, &OTHERS);
    match changes {
        Ok(changes) => Ok(changes.iter().map(ToString::to_string).collect()),
        Err(invalid) => {
            let messages: Vec<String> = invalid.problems.into_iter().map(|p| p.message).collect();
            Err(messages.join("\n"))
        }
    }
}

/// Once upon a time hints sent people from "at most 2" to "at least 4.2" and back for ever.
#[test]
fn a_plug_that_is_too_short_and_too_long_is_a_contradiction() {
    let why = fixed("rtac0", &["surface.wall_height=2mm"]).unwrap_err();
    assert_eq!(
        why,
        "a contradiction: connector.plug_length must be at least 3.55 mm, because the O-ring's groove \
         needs walls on both sides; and connector.plug_length must be at most 2 mm, because the plug \
         must end in the tube's straight part; these cannot be kept together with \
         `surface.wall_height` as set, whatever the chosen values are"
    );
    let edit = ["surface.wall_height=2mm".to_owned()];
    let hint = problems("rtac0", &edit)[0].hint.clone().unwrap();
    assert!(hint.starts_with("write at least 3.55 mm for `surface.wall_height`"), "{hint}");
}

#[test]
fn what_can_be_built_is_left_alone() {
    assert_eq!(fixed("rtac0", &[]), Ok(Vec::new()));
    assert_eq!(fixed("rtac0", &["camera.field_of_view=150deg"]), Ok(Vec::new()));
}

#[test]
fn what_cannot_be_read_is_told_as_ever() {
    let unknown = fixed("rtac0", &["surface.raduis=9mm", "surface.wall_height=2mm"]).unwrap_err();
    assert!(unknown.contains("`surface.raduis` is not a parameter"), "{unknown}");
    let unit = fixed("rtac0", &["surface.radius=9"]).unwrap_err();
    assert!(unit.contains("no unit"), "{unit}");
}

/// Hints name what was just changed, and nothing that is bought.
#[test]
fn hints_do_not_suggest_another_camera() {
    for (sensor, edit) in EDITS {
        for problem in problems(sensor, &[edit.to_owned()]) {
            let hint = problem.hint.unwrap_or_default();
            let mine = edit.split('=').next().unwrap();
            for word in hint.split('`').filter(|word| word.contains('.') && !word.contains(' ')) {
                let is_bought = fabkit_designs::fixing::is_bought(word);
                assert!(!is_bought || word == mine, "{sensor} {edit}: {hint}");
            }
        }
    }
}

#[test]
fn what_fabkit_does_not_have_is_no_slip_of_the_pen() {
    for (sensor, path, why) in [
        ("rtac0", "base.flange", "mounting holes"),
        ("rtac0", "camera.focal_length", "field of view"),
        ("rtac0", "shell.infill", "slicer"),
    ] {
        let problem = &problems(sensor, &[format!("{path}=4 mm")])[0];
        let hint = problem.hint.as_ref().unwrap();
        assert!(hint.starts_with("fabkit has no such parameter: "), "{hint}");
        assert!(hint.contains(why) && !hint.contains("did you mean"), "{hint}");
        let section = path.split('.').next().unwrap();
        assert!(hint.contains(&format!("those of {section} are ")), "{hint}");
    }
}
