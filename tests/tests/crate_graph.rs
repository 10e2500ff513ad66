//! Which crate may know which: the table of ARCHITECTURE.md, compared with what cargo sees.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Each crate of the workspace with the crates of the workspace that it may use.
const MAY_USE: &[(&str, &[&str])] = &[
    ("fabkit-geometry", &[]),
    ("fabkit-mesh", &["fabkit-geometry"]),
    ("fabkit-camera", &[]),
    ("fabkit-depth", &["fabkit-geometry", "fabkit-camera"]),
    ("fabkit-checks", &["fabkit-geometry"]),
    ("fabkit-designs", &["fabkit-geometry"]),
    ("fabkit-report", &[]),
    ("fabkit-calibration", &["fabkit-geometry", "fabkit-camera", "fabkit-report"]),
    (
        "fabkit-fixtures",
        &[
            "fabkit-geometry",
            "fabkit-camera",
            "fabkit-calibration",
            "fabkit-checks",
            "fabkit-designs",
            "fabkit-mesh",
            "fabkit-export",
        ],
    ),
    ("fabkit-export", &["fabkit-geometry", "fabkit-mesh"]),
    (
        "fabkit-sweep",
        &[
            "fabkit-geometry",
            "fabkit-mesh",
            "fabkit-camera",
            "fabkit-checks",
            "fabkit-designs",
            "fabkit-calibration",
            "fabkit-fixtures",
            "fabkit-export",
            "fabkit-report",
        ],
    ),
    (
        "fabkit",
        &[
            "fabkit-geometry",
            "fabkit-mesh",
            "fabkit-camera",
            "fabkit-depth",
            "fabkit-checks",
            "fabkit-designs",
            "fabkit-calibration",
            "fabkit-fixtures",
            "fabkit-export",
            "fabkit-sweep",
        ],
    ),
    (
        "fabkit-tests",
        &[
            "fabkit",
            "fabkit-geometry",
            "fabkit-mesh",
            "fabkit-camera",
            "fabkit-depth",
            "fabkit-checks",
            "fabkit-designs",
            "fabkit-calibration",
            "fabkit-fixtures",
            "fabkit-export",
        ],
    ),
    ("fabkit-fuzz-targets", &["fabkit"]),
    ("fabkit-python", &["fabkit"]),
    ("xtask", &[]),
];

/// Crates from outside that only these crates here may use, tests apart.
const FEW_USERS: &[(&str, &[&str])] = &[
    ("manifold-rust", &["fabkit-mesh"]),
    ("granit-parser", &["fabkit-designs", "fabkit-camera"]),
    ("png", &["fabkit-export", "fabkit-calibration"]),
    ("flate2", &["fabkit-export"]),
    ("parquet", &["fabkit-export"]),
    ("clap", &["fabkit"]),
    ("ctrlc", &["fabkit"]),
];

/// Package name to the names of its dependencies with their kind: empty, `dev` or `build`.
fn graph() -> BTreeMap<String, Vec<(String, String)>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .args(["--manifest-path", concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml")])
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
fn crates_use_only_what_the_table_allows() {
    let graph = graph();
    let table: BTreeMap<&str, BTreeSet<&str>> =
        MAY_USE.iter().map(|(name, uses)| (*name, uses.iter().copied().collect())).collect();
    assert!(graph.keys().map(String::as_str).eq(table.keys().copied()), "{:?}", graph.keys());
    for (name, dependencies) in &graph {
        // A crate's tests may use the crate itself with other features.
        let others = dependencies.iter().filter(|(used, _)| used != name);
        let here = others.map(|(d, _)| d.as_str()).filter(|d| table.contains_key(d));
        for used in here {
            assert!(table[name.as_str()].contains(used), "{name} must not know {used}");
        }
    }
}

#[test]
fn kernels_and_formats_have_few_users() {
    for (name, dependencies) in &graph() {
        for (used, kind) in dependencies {
            let few = FEW_USERS.iter().find(|(outside, _)| outside == used);
            if let Some((outside, users)) = few.filter(|_| kind != "dev") {
                assert!(users.contains(&name.as_str()), "{outside} belongs to {users:?}");
            }
        }
    }
}
