//! The book's table of what papers say is what the sensors' files hold, and holds all of it.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use fabkit_designs::builtin_yaml;

const SENSORS: [&str; 5] = ["rtac0", "shadowtac", "tactip", "uvdtact", "fluidic"];

/// One line of a sensor's table.
#[derive(Debug)]
struct Row {
    sensor: String,
    statement: String,
    paper: String,
    fabkit: String,
    /// Of the parameter, where there is one.
    path: Option<String>,
    why: String,
}

fn rows() -> Vec<Row> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/papers.md");
    let page = fs::read_to_string(page).unwrap();
    let mut sensor = String::new();
    let mut rows = Vec::new();
    for line in page.lines() {
        if let Some((_, name)) = line.strip_prefix("## ").and_then(|title| title.split_once('`')) {
            sensor = name.trim_end_matches("`)").to_owned();
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, statement, _, paper, fabkit, parameter, why, _] = cells[..] else { continue };
        if statement == "statement" || statement.starts_with("---") {
            continue;
        }
        let path = (!parameter.is_empty()).then(|| parameter.trim_matches('`').to_owned());
        let [statement, paper, fabkit, why] = [statement, paper, fabkit, why].map(str::to_owned);
        rows.push(Row { sensor: sensor.clone(), statement, paper, fabkit, path, why });
    }
    rows
}

/// Every parameter of a sensor that comes from its paper, with its value.
fn from_paper(sensor: &str) -> Vec<(String, String)> {
    let yaml = builtin_yaml(sensor).unwrap();
    let design = fabkit_designs::load(sensor, yaml, &[], &["fixtures"]).unwrap();
    let settings = design.parameters.iter();
    settings
        .filter(|setting| setting.source.kind.word() == "paper")
        .map(|setting| (setting.path.clone(), setting.value.clone()))
        .collect()
}

#[test]
fn every_value_of_a_paper_stands_in_the_table() {
    let rows = rows();
    for sensor in SENSORS {
        let of_sensor: Vec<&Row> = rows.iter().filter(|row| row.sensor == sensor).collect();
        assert!(!of_sensor.is_empty(), "{sensor}");
        let told: BTreeSet<&str> = of_sensor.iter().filter_map(|row| row.path.as_deref()).collect();
        let known = from_paper(sensor);
        for (path, value) in &known {
            assert!(told.contains(path.as_str()), "{sensor}: {path} = {value} is not in the table");
        }
        for row in of_sensor {
            let Some(path) = &row.path else { continue };
            let value = known.iter().find(|(known, _)| known == path).map(|(_, value)| value);
            assert_eq!(Some(&row.fabkit), value, "{sensor}: {path}");
        }
    }
}

#[test]
fn what_differs_says_why() {
    // `Smooth-On Solaris` is the paper's `Solaris`, `38 mm` is `some 38 mm`.
    let words = |text: &str| -> BTreeSet<String> {
        let words = text.split([' ', ',']);
        words.filter(|word| !word.is_empty()).map(str::to_lowercase).collect()
    };
    for row in rows() {
        let [paper, ours] = [&row.paper, &row.fabkit].map(|text| words(text));
        let is_said = paper.is_subset(&ours) || ours.is_subset(&paper);
        assert!(is_said || !row.why.is_empty(), "{}: {row:?}", row.statement);
    }
}
