//! Hardly any files of one folder name each other in a loop, beside a module and its own children.

use super::crates::{crates, root};
use super::modules::Circle;

/// Crates with such circles, and how many at most: a list that only gets shorter.
const INSIDE_ONE: [(&str, usize); 12] = [
    ("designs/families", 1),
    ("fabkit/application", 1),
    ("fixtures", 4),
    ("geometry/files", 2),
    ("geometry/solids", 1),
    ("geometry/text", 1),
    ("physics/depth", 1),
    ("physics/elastic", 1),
    ("physics/optics", 2),
    ("physics/tetra", 1),
    ("simulation/dataset", 2),
    ("simulation/scene", 1),
];

/// What is wrong with a crate's circles, beside as many as are listed.
fn breach(name: &str, circles: &[Circle], most: usize) -> Option<String> {
    let inside: Vec<&Circle> = circles.iter().filter(|circle| !circle.spans_folders).collect();
    let ties = inside.iter().map(|circle| format!("\n  {}", circle.ties.join("\n  ")));
    let ties = ties.collect::<String>().replace(&format!("{}/", root().display()), "");
    let message = format!("{name}: {} circles inside a folder{ties}", inside.len());
    (inside.len() > most).then_some(message)
}

#[test]
fn files_of_one_folder_name_each_other_in_few_loops() {
    let crates = crates();
    let found = crates.values().filter_map(|own| {
        let listed = INSIDE_ONE.iter().find(|(listed, _)| *listed == own.folder);
        let circles: Vec<Circle> =
            own.modules().iter().flat_map(|modules| modules.circles()).collect();
        breach(&own.folder, &circles, listed.map_or(0, |(_, most)| *most))
    });
    let found: Vec<String> = found.collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_circle_too_many_is_told_with_what_ties_it() {
    let circle = |spans_folders| Circle { spans_folders, ties: vec!["a.rs -> b.rs: B".to_owned()] };
    let told = breach("a/crate", &[circle(false)], 0).unwrap();
    assert!(told.contains("a.rs -> b.rs: B"), "{told}");
    assert_eq!(breach("a/crate", &[circle(true), circle(false)], 1), None);
}
