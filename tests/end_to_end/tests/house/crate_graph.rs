//! Which crate may know which: the tables of ARCHITECTURE.md, compared with what cargo sees.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

const ARCHITECTURE: &str = include_str!("../../../../ARCHITECTURE.md");

/// The first two cells of each row below a table's head, which begins with `head`.
fn rows<'a>(text: &'a str, head: &str) -> Vec<[&'a str; 2]> {
    let below = text.lines().skip_while(|line| !line.starts_with(head)).skip(2);
    below
        .map_while(|line| line.strip_prefix('|'))
        .map(|row| {
            let mut cells = row.split('|').map(str::trim);
            [cells.next(), cells.next()].map(|cell| cell.expect("a row has two cells"))
        })
        .collect()
}

/// `a, b` to its words; a dash stands for none.
fn words(cell: &str) -> impl Iterator<Item = &str> {
    cell.split(", ").filter(|word| *word != "—")
}

/// Each crate with the crates that it may use, by package, in the order of the table.
fn table(text: &str) -> Vec<(String, BTreeSet<String>)> {
    let mut found: Vec<(&str, String, BTreeSet<String>)> = Vec::new();
    for [name, uses] in rows(text, "| folder (package) | uses |") {
        let (folder, package) = name.split_once("/`").expect("a folder in backticks");
        let package = package.trim().trim_start_matches('(').trim_end_matches(')');
        let package = if package.is_empty() { folder.trim_start_matches('`') } else { package };
        // Other rows name it without what all crates begin with.
        let folder = package.strip_prefix("fabkit-").unwrap_or(package);
        let above = |used: &str| {
            let row = found.iter().find(|(folder, ..)| *folder == used);
            row.unwrap_or_else(|| panic!("{folder} uses {used}, which is not above it")).1.clone()
        };
        let uses = words(uses).map(above).collect();
        found.push((folder, package.to_owned(), uses));
    }
    found.into_iter().map(|(_, package, uses)| (package, uses)).collect()
}

/// Package name to the names of its dependencies with their kind: empty, `dev` or `build`.
fn graph() -> BTreeMap<String, Vec<(String, String)>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .args(["--manifest-path", concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml")])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let packages = metadata["packages"].as_array().unwrap().iter();
    packages
        .map(|package| {
            let dependencies = package["dependencies"].as_array().unwrap().iter();
            (
                text(&package["name"]),
                dependencies.map(|d| (text(&d["name"]), text(&d["kind"]))).collect(),
            )
        })
        .collect()
}

#[test]
fn crates_use_exactly_what_the_table_says() {
    let graph = graph();
    let table: BTreeMap<_, _> = table(ARCHITECTURE).into_iter().collect();
    assert_eq!(graph.keys().collect::<Vec<_>>(), table.keys().collect::<Vec<_>>());
    for (name, dependencies) in &graph {
        // What tests alone use may itself use the crate that is tested.
        let is_for_tests = |used: &str, kind: &str| kind == "dev" && used.ends_with("-testing");
        let others = dependencies.iter().filter(|(used, kind)| !is_for_tests(used, kind));
        let others = others.map(|(used, _)| used).filter(|used| *used != name);
        let here: BTreeSet<String> =
            others.filter(|used| table.contains_key(*used)).cloned().collect();
        assert_eq!(here, table[name], "what {name} uses, and what ARCHITECTURE.md says");
    }
}

#[test]
#[should_panic(expected = "mesh uses text, which is not above it")]
fn a_crate_cannot_use_one_that_stands_below_it() {
    table(
        "| folder (package) | uses | holds |\n|---|---|---|\n| `geometry/solids/` (fabkit-geometry) | — | |\n\
         | `geometry/mesh/` (fabkit-mesh) | geometry, text | |\n| `geometry/text/` (fabkit-text) | — | |\n",
    );
}

#[test]
fn kernels_and_formats_have_few_users() {
    let few = rows(ARCHITECTURE, "| package | users |");
    assert!(few.iter().any(|[package, _]| *package == "manifold-rust"), "{few:?}");
    let mut found: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for (name, dependencies) in &graph() {
        for (used, _) in dependencies.iter().filter(|(_, kind)| kind != "dev") {
            if let Some([package, _]) = few.iter().find(|[package, _]| package == used) {
                let name = name.strip_prefix("fabkit-").unwrap_or(name);
                found.entry(package).or_default().insert(name.to_owned());
            }
        }
    }
    for [package, users] in few {
        let users: BTreeSet<String> = words(users).map(str::to_owned).collect();
        assert_eq!(found.get(package), Some(&users), "users of {package}");
    }
}

/// The sources in a folder and below, each line of code with its file's name.
fn code(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            code(&path, found);
        } else {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let text = fs::read_to_string(&path).unwrap();
            let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
            found.extend(lines.map(|line| (name.clone(), line.to_owned())));
        }
    }
}

#[test]
fn only_the_command_speaks_of_its_options() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let names_one = |line: &str| {
        let after = line.split("--").skip(1);
        after.into_iter().any(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
    };
    // Those name the options of other programs.
    let others = ["verifier.rs", "slicing.rs"];
    for (folder, other_programs) in
        [("fabkit/application/src", &others[..]), ("fabkit/python/src", &[])]
    {
        let mut lines = Vec::new();
        code(&root.join(folder), &mut lines);
        assert!(lines.len() > 1000, "{folder} has its sources elsewhere");
        for (file, line) in
            lines.iter().filter(|(file, _)| !other_programs.contains(&file.as_str()))
        {
            assert!(!names_one(line), "{folder}, {file}: {line}");
            let imports = line.contains("fabkit::") && !line.contains("fabkit::run(");
            assert!(!imports && !line.contains("commands::"), "{folder}, {file}: {line}");
        }
    }
}
