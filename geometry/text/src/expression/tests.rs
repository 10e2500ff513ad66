use std::time::{Duration, Instant};

use fabkit_geometry::{Angle, Length};

use super::{MAX_CHARACTERS, MAX_DEPTH};
use crate::{
    Dialect, Parameter, ParameterTable, Problem, Reader, Section, Setting, TextLayer, TextPlace,
    apply_overrides, read_mapping,
};

const BASE: Dialect = Dialect::new("box", 1, "");

crate::parameters! {
    /// Test.
    pub struct Lid {
        /// Width.
        width: Length = 0.0..=500.0,
        /// Slope.
        slope: Angle = 0.0..=180.0,
        /// Screws.
        screws: u32 = 1..=99,
        /// Share.
        share: f64 = 0.0..=9.0,
        /// Steps.
        steps: Vec<Length> = (1..=3, 0.0..=50.0),
        /// Label.
        label: String = 0..=90,
    }
}
crate::parameters! {
    /// Test.
    pub struct Crate {
        /// Lid.
        lid: Lid,
        /// Wall.
        wall: Length = 0.0..=50.0,
    }
}

const PLAIN: [(&str, &str); 7] = [
    ("wall", "2 mm"),
    ("lid.width", "30 mm"),
    ("lid.slope", "161 deg"),
    ("lid.screws", "4"),
    ("lid.share", "0.1"),
    ("lid.steps", "[1 mm, 2 mm]"),
    ("lid.label", "= none"),
];

/// Reads a crate in which these values are others.
fn read(changes: &[(&str, &str)], overrides: &[&str]) -> (Vec<Setting>, Vec<Problem>) {
    let place = TextPlace::new(TextLayer::File, "box.yaml", &BASE);
    let mut yaml = String::new();
    let value = |path: &str, plain: &str| {
        let change = changes.iter().find(|(changed, _)| *changed == path);
        change.map_or(plain, |(_, value)| *value).to_owned()
    };
    for (path, plain) in PLAIN {
        match path.strip_prefix("lid.") {
            None => yaml += &format!("{path}: {}\nlid:\n", value(path, plain)),
            Some(key) => yaml += &format!("  {key}: {}\n", value(path, plain)),
        }
    }
    let mut found = Vec::new();
    let entries = read_mapping(&yaml, &place, &mut found).unwrap_or_else(|| panic!("{found:?}"));
    let mut document = ParameterTable::new(Crate::fields(), place.clone());
    document.merge(entries, &place);
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    apply_overrides(&mut document, &overrides);
    let mut reader = Reader::new(document);
    Crate::read(&mut reader, "", "", &());
    let settings = reader.take_settings();
    let report = reader.finish(None);
    let problems = if report.is_clean() { Vec::new() } else { report.into_invalid().problems };
    (settings, problems)
}

fn value(path: &str, expression: &str) -> String {
    let (settings, problems) = read(&[(path, expression)], &[]);
    assert!(problems.is_empty(), "{expression}: {problems:?}");
    settings.into_iter().find(|setting| setting.path == path).unwrap().value
}

#[test]
fn expressions_are_computed_to_the_digits_people_write() {
    for (path, expression, comes_out) in [
        ("wall", "= lid.width - 2 * (lid.width - 16 mm)", "2 mm"),
        ("wall", "=3*0.1mm", "0.3 mm"),
        ("wall", "= 1 cm + 1_000 um + 0.5 in", "23.7 mm"),
        ("wall", "= sqrt(3 mm * 3 mm + 4 mm * 4 mm)", "5 mm"),
        ("wall", "\"= max(1 mm, min(lid.width, 7 mm), abs(-3 mm))\"", "7 mm"),
        ("wall", "= lid.width / (lid.screws + 1) * lid.share * 1e1", "6 mm"),
        ("wall", "= -(-lid.width) - -1 mm", "31 mm"),
        ("wall", "= 10 mm * sin(30 deg) + 10 mm * tan(pi / 4 * 1 rad) / cos(0 deg)", "15 mm"),
        ("lid.slope", "= 2 * asin(0.5) + acos(1) + atan(1)", "105 deg"),
        ("lid.screws", "= round(lid.width / 7 mm) + floor(1.9) + ceil(0.1)", "6"),
        ("lid.share", "= wall / lid.width * 3", "0.2"),
        ("lid.steps", "[= wall, 3 mm, \"= min(wall, lid.width) / 4\"]", "[2 mm, 3 mm, 0.5 mm]"),
        ("lid.width", "= wall * lid.slope / 1 deg", "322 mm"),
    ] {
        assert_eq!(value(path, expression), comes_out, "{expression}");
    }
    // The digits of an angle are not lost on the way through radians.
    assert_eq!(value("wall", "= lid.slope / 2 deg * 0.1 mm"), "8.05 mm");
    // A text that begins with `=` is not an expression.
    assert_eq!(value("lid.label", "= wall"), "= wall");
}

#[test]
fn written_values_stay_and_dependent_values_change() {
    let formulas = [("lid.width", "= 10 * wall"), ("lid.share", "= lid.width / 100 mm")];
    let values = |overrides: &[&str]| {
        let (settings, problems) = read(&formulas, overrides);
        assert!(problems.is_empty(), "{problems:?}");
        let of = |path: &str| settings.iter().find(|s| s.path == path).unwrap().clone();
        let (width, share) = (of("lid.width"), of("lid.share"));
        (width.value, width.expression, share.value)
    };
    let formula = Some("= 10 * wall".to_owned());
    assert_eq!(values(&[]), ("20 mm".into(), formula.clone(), "0.2".into()));
    assert_eq!(values(&["wall=3mm"]), ("30 mm".into(), formula, "0.3".into()));
    assert_eq!(values(&["wall=3mm", "lid.width=50 mm"]), ("50 mm".into(), None, "0.5".into()));
    let own = Some("= 2 * wall".to_owned());
    assert_eq!(values(&["lid.width== 2 * wall"]), ("4 mm".into(), own, "0.04".into()));
}

#[test]
fn errors_are_reported_quickly_with_line_and_hint() {
    let begun = Instant::now();
    let deep = format!("= {}1 mm{}", "(".repeat(MAX_DEPTH + 1), ")".repeat(MAX_DEPTH + 1));
    let signs = format!("= {}1 mm", "-".repeat(900));
    let calls = format!("= {}1", "abs(".repeat(200));
    let long = format!("= 1 mm{}", " + 1 mm".repeat(MAX_CHARACTERS / 7 + 1));
    let (wall, width) = ("wall", "lid.width");
    for (path, expression, says, hint) in [
        (width, "= wal + 1 mm", "`wal`, which is not a parameter", "did you mean `wall`?"),
        (wall, "= width", "`width`, which is not a parameter", "did you mean `lid.width`?"),
        (wall, "= lid", "which is a section", "`lid.width`, `lid.slope`"),
        (wall, "= lid.label", "which is not a number", "lengths, angles and numbers"),
        (wall, "= lid.steps", "which is a list", "a single value"),
        (wall, "= lid.width + 3", "`3` is a plain number", "write `3 mm`"),
        (width, "= wall * wall", "comes out as an area; it must be a length", "multiplied"),
        (wall, "= 3", "comes out as a plain number", "give its numbers units"),
        (wall, "= lid.width / (lid.screws - 4)", "by `(lid.screws - 4)`, which is 0", "cannot"),
        (wall, "= 1e308 mm * 10", "is not finite at `1e308 mm * 10`", "smaller"),
        (wall, "= 1e999 mm", "no finite number", "the units are"),
        (wall, "= sqrt(0 mm * 1 mm - 1 mm * 1 mm)", "an area", "takes 0 or more"),
        (wall, "= sqrt(lid.width)", "30 mm, a length", "takes a plain number or an area"),
        (wall, "= sin(1) * 1 mm", "a plain number", "takes an angle"),
        (wall, "= 3 furlong", "`3 furlong`", "the units are um, mm"),
        (wall, "= 3 lid.width", "goes on with `lid.width`", "write + - * or /"),
        (wall, "= (1 mm", "lacks a `)`", "stands in quotes"),
        (wall, "= 1 mm)", "a `)` without a `(`", "remove it"),
        (wall, "= 1 mm +", "ends too early", "an expression has"),
        (wall, "=", "ends too early", "an expression has"),
        (width, "= wall ^ 2", "has a `^`", "`a.b * a.b`"),
        (width, "= sqr(wall * wall)", "`sqr`, which is no function", "did you mean `sqrt`?"),
        (width, "= max(wall)", "gives 1 values to `max`", "`max(a, b)`"),
        ("lid.screws", "= lid.share + 1", "comes out as 1.1; it must be a whole", "`round(...)`"),
        (wall, &deep, "nested more than 64 deep", "several parameters"),
        (wall, &signs, "nested more than 64 deep", "several parameters"),
        (wall, &calls, "nested more than 64 deep", "several parameters"),
        (wall, &long, "at most 1000 are read", "several parameters"),
    ] {
        let (_, problems) = read(&[(path, &format!("\"{expression}\""))], &[]);
        let [Problem { line: Some(line), message, hint: Some(found), .. }] = &problems[..] else {
            panic!("{expression}: {problems:?}");
        };
        let place = PLAIN.iter().position(|(known, _)| *known == path).unwrap();
        // `lid:` has a line of its own.
        assert_eq!(*line, if path == wall { 1 } else { place + 2 }, "{expression}");
        assert!(message.contains(says) && found.contains(hint), "{message}; {found}");
    }
    // 28 files, each far below the 50 ms that the command may take for one; the rest is for slow machines with other work.
    assert!(begun.elapsed() < Duration::from_secs(5), "{:?}", begun.elapsed());
}

#[test]
fn all_errors_are_reported_at_once_at_their_own_place() {
    // A cycle of three is reported once; values that depend on it are not reported.
    let circle = [
        ("wall", "= lid.width"),
        ("lid.width", "= lid.share * 1 mm"),
        ("lid.share", "= wall / 1 mm"),
    ];
    let (_, problems) =
        read(&[&circle[..], &[("lid.screws", "= round(wall / 1 mm)")]].concat(), &[]);
    let [Problem { message, .. }] = &problems[..] else { panic!("{problems:?}") };
    assert!(message.ends_with("follows from itself: lid.share -> wall -> lid.width -> lid.share"));
    // Reported where the cycle was closed, not where evaluation entered it.
    let (_, problems) = read(
        &[("lid.width", "= wall"), ("lid.share", "= wall / lid.width")],
        &["wall== lid.width"],
    );
    let [Problem { file, message, .. }] = &problems[..] else { panic!("{problems:?}") };
    assert_eq!(file, "--set");
    assert!(message.ends_with("follows from itself: wall -> lid.width -> wall"), "{message}");
    let (_, problems) = read(&[("wall", "= wall")], &["lid.width=wide"]);
    let [own, other] = &problems[..] else { panic!("{problems:?}") };
    assert!(own.message.ends_with("follows from itself: wall -> wall"), "{own}");
    assert!(other.message.contains("is not a number with a unit"), "{other}");

    // Out of its limits because of another value: that value is named, the last one written first.
    let follows = [("lid.width", "= 200 * wall * lid.share / lid.share")];
    let (_, problems) = read(&follows, &["wall=9mm"]);
    let [Problem { message, hint: Some(hint), file, .. }] = &problems[..] else {
        panic!("{problems:?}");
    };
    assert_eq!(file, "box.yaml");
    assert!(message.starts_with("lid.width is 1800 mm; it must be between 0 mm and 500 mm"));
    assert!(message.ends_with("(it is `= 200 * wall * lid.share / lid.share`)"), "{message}");
    assert_eq!(hint, "the nearest allowed value is 500 mm; or change `wall` or `lid.share`");
    // Reported once.
    let (_, problems) = read(&follows, &["wall=60mm"]);
    let [Problem { path, .. }] = &problems[..] else { panic!("{problems:?}") };
    assert_eq!(path, "wall");
}

#[test]
fn given_uses_a_value_only_if_it_is_written() {
    let drag = [
        ("wall", "\"= min(2 mm, given(lid.width, 1 m) / 10)\""),
        ("lid.width", "\"= max(15 mm, 10 * wall)\""),
    ];
    let values = |changes: &[(&str, &str)], overrides: &[&str]| {
        let (settings, problems) = read(changes, overrides);
        assert!(problems.is_empty(), "{problems:?}");
        let of = |path: &str| settings.iter().find(|s| s.path == path).unwrap().value.clone();
        (of("wall"), of("lid.width"))
    };
    let are = |wall: &str, width: &str| (wall.to_owned(), width.to_owned());
    // Each depends on the other through `given`, and neither is a cycle.
    assert_eq!(values(&drag, &[]), are("2 mm", "20 mm"));
    assert_eq!(values(&drag, &["lid.width=12 mm"]), are("1.2 mm", "12 mm"));
    assert_eq!(values(&drag, &["wall=1.6 mm"]), are("1.6 mm", "16 mm"));
    assert_eq!(values(&drag, &["wall=1 mm", "lid.width=40 mm"]), are("1 mm", "40 mm"));
    // Another expression is no plain value, whoever wrote it.
    assert_eq!(values(&drag, &["lid.width== wall * 3"]), are("2 mm", "6 mm"));
    // Within each other, and within other functions.
    let nested = [
        ("wall", "\"= 2 * given(lid.width, given(lid.share, 7) * 1 mm) + 1 mm\""),
        ("lid.width", "= 3 * wall"),
    ];
    assert_eq!(values(&nested, &[]), are("1.2 mm", "3.6 mm"));
    assert_eq!(values(&nested, &["lid.share== 1 + 1"]), are("15 mm", "45 mm"));
    // An argument that is not needed is not computed: neither a cycle nor a division by zero in it matters.
    let unneeded = [("wall", "\"= given(lid.width, wall / (lid.screws - 4))\"")];
    assert_eq!(values(&unneeded, &["lid.width=3 mm"]), are("3 mm", "3 mm"));
    assert_eq!(value("wall", "\"= given(lid.width, 1 mm)\""), "30 mm");
    assert_eq!(value("wall", "\"= given((lid.width), 1 mm)\""), "30 mm");
}

#[test]
fn errors_in_given_are_reported_even_if_unused() {
    for (expression, says, hint) in [
        ("= given(lid.width, 3)", "`lid.width` is a length and `3` is a plain", "write `3 mm`"),
        ("= given(lid.width, wall * wall)", "`wall * wall` is an area", "make both of one unit"),
        ("= given(lid.width, sqrt(wall))", "`wall` is a length", "takes a plain number"),
        ("= given(lid.width, lid.slope + 1)", "`1` is a plain number", "write `1 deg`"),
        ("= given(lid.widht, 3 mm)", "`lid.widht`, which is not a", "did you mean `lid.width`?"),
        ("= given(lid.width, wal)", "`wal`, which is not a parameter", "did you mean `wall`?"),
        ("= given(lid.label, 3 mm)", "which is not a number", "lengths, angles"),
        ("= given(lid.steps, 3 mm)", "which is a list", "a single value"),
        ("= given(3 mm, 3 mm)", "`3 mm`, which is no name", "`given(section.name, b)`"),
        ("= given(lid.width)", "gives 1 values to `given`", "`given(section.name, b)`"),
        ("= givn(lid.width, 3 mm)", "which is no function", "did you mean `given`?"),
    ] {
        let (_, problems) = read(&[("wall", &format!("\"{expression}\""))], &[]);
        let [Problem { message, hint: Some(found), .. }] = &problems[..] else {
            panic!("{expression}: {problems:?}");
        };
        assert!(message.contains(says) && found.contains(hint), "{message}; {found}");
    }
    // A cycle through the second argument.
    let circle =
        [("wall", "\"= given(lid.width, lid.share * 1 mm)\""), ("lid.width", "= 2 * wall")];
    let (_, problems) = read(&circle, &["lid.share== wall / 1 mm"]);
    let [Problem { message, .. }] = &problems[..] else { panic!("{problems:?}") };
    assert!(message.ends_with("follows from itself: lid.share -> wall -> lid.share"), "{message}");
    // A plain value out of its limits is reported at its own place, and named by values that depend on it.
    let follows = [("wall", "\"= given(lid.width, 1 mm) * 2\"")];
    let (_, problems) = read(&follows, &["lid.width=40 mm"]);
    let [Problem { hint: Some(hint), .. }] = &problems[..] else { panic!("{problems:?}") };
    assert_eq!(hint, "the nearest allowed value is 50 mm; or change `lid.width`");
}
