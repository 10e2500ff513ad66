//! The crates as cargo sees them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::modules::Modules;

/// One crate.
#[derive(Clone, Debug, Default)]
pub struct Crate {
    /// Its folder from the root, for example `geometry/solids`.
    pub folder: String,
    /// The packages that it is built with: those of its build script, and of single systems, among them.
    pub uses: BTreeSet<String>,
    /// The packages that its tests use.
    pub tests_use: BTreeSet<String>,
}

/// Every crate by the name of its package.
pub type Crates = BTreeMap<String, Crate>;

/// Where the project lies.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// Asks cargo for all crates of the workspace.
pub fn crates() -> Crates {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1", "--manifest-path"])
        .arg(root().join("Cargo.toml"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    read(&serde_json::from_slice(&output.stdout).unwrap())
}

fn read(metadata: &Value) -> Crates {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let root = text(&metadata["workspace_root"]);
    let packages = metadata["packages"].as_array().unwrap().iter();
    packages
        .map(|package| {
            let manifest = text(&package["manifest_path"]);
            let folder = Path::new(&manifest).strip_prefix(&root).unwrap().parent().unwrap();
            let dependencies = package["dependencies"].as_array().unwrap();
            let of = |is_of: fn(&str) -> bool| {
                let some = dependencies.iter().filter(|used| is_of(&text(&used["kind"])));
                some.map(|used| text(&used["name"])).collect()
            };
            let found = Crate {
                folder: folder.to_string_lossy().replace('\\', "/"),
                uses: of(|kind| kind != "dev"),
                tests_use: of(|kind| kind == "dev"),
            };
            (text(&package["name"]), found)
        })
        .collect()
}

/// What others call a package of this workspace: `fabkit-mesh` is `mesh`.
pub fn short(package: &str) -> &str {
    package.strip_prefix("fabkit-").unwrap_or(package)
}

impl Crate {
    /// The room in which it lies.
    pub fn room(&self) -> &str {
        self.folder.split('/').next().unwrap_or_default()
    }

    /// Its modules, those of its library and of its program, from the project's root.
    pub fn modules(&self) -> Vec<Modules> {
        let source = root().join(&self.folder).join("src");
        let roots: Vec<PathBuf> = ["lib.rs", "main.rs"].map(|name| source.join(name)).into();
        let modules: Vec<_> = roots.iter().filter(|root| root.is_file()).collect();
        assert!(!modules.is_empty(), "{} has its sources elsewhere", self.folder);
        modules.into_iter().map(|root| Modules::read(root)).collect()
    }
}

#[test]
fn what_tests_use_is_told_from_what_a_crate_uses() {
    let dependency = |name: &str, kind: Value| serde_json::json!({"name": name, "kind": kind});
    let metadata = serde_json::json!({"workspace_root": "/w", "packages": [{
        "name": "fabkit-a",
        "manifest_path": "/w/room/a/Cargo.toml",
        "dependencies": [
            dependency("b", Value::Null), dependency("c", "build".into()), dependency("d", "dev".into()),
        ],
    }]});
    let found = &read(&metadata)["fabkit-a"];
    let names = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    assert_eq!((&*found.folder, found.room()), ("room/a", "room"));
    assert_eq!((&found.uses, &found.tests_use), (&names(&["b", "c"]), &names(&["d"])));
}
