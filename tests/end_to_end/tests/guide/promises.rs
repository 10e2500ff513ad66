//! What a guide promises to whoever opens its files: a design that does not pass `check` is said first, cells are no
//! formulas, lengths have the digits that somebody can measure, and no pin is asked for that the camera cannot see.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use fabkit_tests::{fabkit, sampled_sensors};

/// What a reader sees of a page: no tags, scripts or drawings.
fn text_of(html: &str) -> String {
    let mut text = String::new();
    let mut rest = html;
    while let Some(at) = rest.find('<') {
        text.push_str(&rest[..at]);
        text.push(' ');
        let skipped = ["script", "style", "svg"].into_iter().find_map(|name| {
            let is_it = rest[at + 1..].starts_with(name);
            is_it.then(|| format!("</{name}>"))
        });
        let end = skipped.unwrap_or_else(|| ">".into());
        let length = rest[at..].find(&end).map_or(rest.len() - at, |length| length + end.len());
        rest = &rest[at + length..];
    }
    text + rest
}

#[test]
fn a_design_that_does_not_pass_check_is_said_first() {
    let root = tempfile::tempdir().unwrap();
    let set = ["--set", "shell.wall=9mm"];
    let check = fabkit(root.path(), &[&["check", "rtac0", "--json"], &set[..]].concat());
    assert_eq!(check.code, Some(1), "{check:?}");
    let check = check.json();
    let findings = check["findings"].as_array().unwrap().iter();
    let errors: Vec<&str> = findings
        .filter(|finding| finding["severity"] == "error")
        .map(|finding| finding["message"].as_str().unwrap())
        .collect();
    let guide = fabkit(root.path(), &[&["guide", "rtac0", "-o", "guide"], &set[..]].concat()).ok();
    let first = guide.stdout.lines().next().unwrap();
    let says = format!("warning: rtac0 does not pass `fabkit check` ({} error", errors.len());
    assert!(first.starts_with(&says) && first.contains(errors[0]), "{first}");
    let page = fs::read_to_string(root.path().join("guide/index.html")).unwrap();
    let text = text_of(&page);
    let said = text.find("does not pass").unwrap();
    assert!(said < text.find("Parts to make").unwrap(), "it stands before everything else");
    let facts = fs::read_to_string(root.path().join("guide/guide.json")).unwrap();
    let facts: serde_json::Value = serde_json::from_str(&facts).unwrap();
    let listed = facts["check_errors"].as_array().unwrap().iter();
    assert!(listed.map(|error| error.as_str().unwrap()).eq(errors), "{facts}");
    // A design that passes has nothing of it.
    let quiet = fabkit(root.path(), &["guide", "9dtact/coupon", "-o", "other"]).ok();
    assert!(!quiet.stdout.contains("warning"), "{quiet:?}");
    let page = fs::read_to_string(root.path().join("other/index.html")).unwrap();
    assert!(!page.contains("does not pass"));
}

/// Splits a table of comma-separated values (RFC 4180).
fn cells(csv: &str) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    let mut letters = csv.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if is_quoted && letters.peek() == Some(&'"') => {
                letters.next();
                cell.push('"');
            }
            '"' => is_quoted = !is_quoted,
            ',' | '\n' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            letter => cell.push(letter),
        }
    }
    cells
}

#[test]
fn no_cell_of_a_table_is_a_formula() {
    let root = tempfile::tempdir().unwrap();
    // As a material's name, a maker, a number and a note.
    let text = r#"format: 1
extends: rtac0
name: sums
materials:
  "=1+1 gel":
    kind: gel
    mix: {"+part A": 3, "-2+3 part B": 1}
    density: 1.02 g/cm3
    cure: {time: 90 min, temperature: 40 C}
    pot_life: 20 min
    shrinkage: 0.5 %
    hardness: Shore 00-20
    clarity: translucent
    degas: true
    source: "@SUM(A1)"
translucent_gel: {material: "=1+1 gel"}
leds: {model: {value: "+cmd|' /C calc'!A0", source: measured, note: "=2"}}
camera: {model: "-cmd|' /C calc'!A0"}
buy:
  camera: {maker: "@maker", number: "=HYPERLINK(\"x\")", price: 30 EUR, source: "=3", what: "+4"}
"#;
    fs::write(root.path().join("sums.yaml"), text).unwrap();
    fabkit(root.path(), &["guide", "sums.yaml", "-o", "guide", "-q"]).ok();
    let mut hostile = 0;
    for name in ["bom.csv", "parts.csv"] {
        let csv = fs::read_to_string(root.path().join("guide").join(name)).unwrap();
        for cell in cells(&csv) {
            let is_number = cell.parse::<f64>().is_ok();
            assert!(is_number || !cell.starts_with(['=', '+', '-', '@']), "{name}: {cell}");
            hostile += usize::from(cell.starts_with('\''));
        }
    }
    assert!(hostile >= 5, "{hostile} cells");
}

/// Numbers with more than four decimals, with the words around them. Names of articles, such as `arXiv 2308.14277`, are
/// none.
fn long_numbers(text: &str) -> Vec<&str> {
    let letters: Vec<(usize, char)> = text.char_indices().collect();
    let mut found = Vec::new();
    for (i, &(at, letter)) in letters.iter().enumerate() {
        let digits = letters[i + 1..].iter().take_while(|(_, c)| c.is_ascii_digit()).count();
        let begins = i > 0 && letters[i - 1].1.is_ascii_digit();
        if letter == '.' && begins && digits > 4 {
            let from = text[..at].char_indices().rev().nth(24).map_or(0, |(from, _)| from);
            let around = &text[from..letters[i + digits].0 + 1];
            if !["arXiv", "doi", "10."].iter().any(|word| around.contains(word)) {
                found.push(around);
            }
        }
    }
    found
}

#[test]
fn lengths_have_digits_that_can_be_measured() {
    assert_eq!(long_numbers("600 × 300 × 0.10000000000000009 mm").len(), 1);
    assert!(long_numbers("0.125 mm, arXiv 2308.14277").is_empty());
    let root = tempfile::tempdir().unwrap();
    for sensor in sampled_sensors() {
        fabkit(root.path(), &["guide", sensor, "-o", sensor, "-q"]).ok();
        let page = fs::read_to_string(root.path().join(sensor).join("index.html")).unwrap();
        let text = text_of(&page);
        let long = long_numbers(&text);
        assert!(long.is_empty(), "{sensor}: {long:?}");
    }
}

/// Numbers of the holes whose pins the camera does not see, as `check` says.
fn unseen_holes(root: &Path, words: &[&str]) -> BTreeSet<u64> {
    let check = fabkit(root, &[&["check", "--json"], words].concat()).json();
    let findings = check["findings"].as_array().unwrap().iter();
    let messages = findings.filter_map(|finding| finding["message"].as_str());
    let holes = messages
        .filter_map(|message| message.strip_prefix("the camera does not see the pins in holes "));
    let holes = holes.flat_map(|holes| holes.split(", "));
    holes.map(|hole| hole.parse().unwrap()).collect()
}

#[test]
fn no_pin_is_asked_for_that_the_camera_does_not_see() {
    let root = tempfile::tempdir().unwrap();
    let mut unseen_anywhere = 0;
    // The second looks at half of the dome.
    for words in
        [&["rtac0/pin-dome"][..], &["rtac0/pin-dome", "--set", "camera.field_of_view=120deg"]]
    {
        let unseen = unseen_holes(root.path(), words);
        unseen_anywhere += unseen.len();
        let guide = [&["guide", "--json", "-o", "guide"], words].concat();
        let guide = fabkit(root.path(), &guide).ok().json();
        let captures = guide["calibration"]["captures"].as_array().unwrap();
        let asked = captures.iter().flat_map(|one| one["holes"].as_array().unwrap());
        let asked: BTreeSet<u64> = asked.map(|hole| hole.as_u64().unwrap()).collect();
        assert!(!asked.is_empty(), "{words:?}");
        assert!(asked.is_disjoint(&unseen), "{words:?}: {asked:?}, unseen {unseen:?}");
    }
    assert!(unseen_anywhere > 0);
}
