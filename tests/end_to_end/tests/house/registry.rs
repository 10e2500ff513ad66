//! Nothing is forgotten: every file of a family is a module, every sensor's file is a sensor, every
//! body has an image, every parameter a source; every file of tests is part of a program, and programs are few.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use fabkit_application::images::{ImageView, draw_body};
use fabkit_application::progress::ignore_progress;
use fabkit_application::text::SourceKind;

fn designs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../designs/families")
}

/// Rust files and folders in a folder, as names of modules, sorted.
fn modules_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut names: Vec<String> = entries
        .filter(|path| path.is_dir() || path.extension().is_some_and(|e| e == "rs"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .filter(|name| name != "mod" && name != "main")
        .collect();
    names.sort();
    names.dedup();
    names
}

/// Modules in a folder that the file above them does not declare, the folder's own first.
fn undeclared(parent: &Path, folder: &Path) -> Vec<PathBuf> {
    let text = fs::read_to_string(parent).unwrap();
    let mut missing = Vec::new();
    for name in modules_in(folder) {
        let declared = text.lines().any(|line| {
            let line = line.trim_start_matches("pub(crate) ").trim_start_matches("pub ");
            line == format!("mod {name};")
        });
        if !declared {
            missing.push(folder.join(&name));
        }
        let (below, file) = (folder.join(&name), folder.join(format!("{name}.rs")));
        if below.is_dir() {
            let parent = if file.exists() { file } else { below.join("mod.rs") };
            missing.extend(undeclared(&parent, &below));
        }
    }
    missing
}

#[test]
fn every_file_of_a_family_is_part_of_it() {
    let families = designs().join("src/families");
    let missing = undeclared(&designs().join("src/families.rs"), &families);
    assert!(missing.is_empty(), "no module declares {missing:?}");
    assert!(!modules_in(&families).is_empty());
}

/// Each program links everything that it tests once more: half a minute of the gate for every ten of them.
#[test]
fn the_tests_of_a_crate_are_one_program_with_all_its_files() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .args(["--manifest-path", concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml")])
        .output()
        .unwrap();
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut found = 0;
    for package in metadata["packages"].as_array().unwrap() {
        let targets = package["targets"].as_array().unwrap().iter();
        let programs: Vec<PathBuf> = targets
            .filter(|target| target["kind"][0] == "test")
            .map(|target| target["src_path"].as_str().unwrap().into())
            .collect();
        let most = if package["name"] == "fabkit-tests" { 9 } else { 1 };
        assert!(programs.len() <= most, "{}: make one program of {programs:#?}", package["name"]);
        for program in programs.iter().filter(|program| program.ends_with("main.rs")) {
            let missing = undeclared(program, program.parent().unwrap());
            assert!(missing.is_empty(), "{} does not declare {missing:?}", program.display());
            found += 1;
        }
    }
    assert!(found > 10, "{found}");
}

#[test]
fn a_forgotten_file_is_found() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("families");
    fs::create_dir_all(folder.join("ball")).unwrap();
    fs::write(root.path().join("families.rs"), "mod ball;\n").unwrap();
    fs::write(folder.join("ball/mod.rs"), "pub mod shell;\n// mod lid;\n").unwrap();
    fs::write(folder.join("ball/shell.rs"), "").unwrap();
    fs::write(folder.join("ball/lid.rs"), "").unwrap();
    let missing = undeclared(&root.path().join("families.rs"), &folder);
    assert_eq!(missing, [folder.join("ball/lid")]);
}

#[test]
fn every_sensor_file_is_registered() {
    let files = fs::read_dir(designs().join("sensors")).unwrap();
    let mut names: Vec<String> = files
        .map(|f| f.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    names.sort();
    assert_eq!(names, fabkit_designs::builtin_names());
}

#[test]
fn every_body_has_an_image_that_shows_it() {
    let shot = ImageView { size_px: [64, 48], is_section: false, from: None };
    for design in fabkit_tests::builtin_designs() {
        for body in &design.sensor.bodies {
            let png = draw_body(body, shot, &ignore_progress)
                .unwrap_or_else(|e| panic!("{}: {e}", body.name));
            // An empty image of this size is smaller than that.
            assert!(png.len() > 300, "{}: {} bytes", body.name, png.len());
        }
    }
}

#[test]
fn every_parameter_says_where_it_comes_from() {
    for design in fabkit_tests::builtin_designs() {
        for setting in &design.parameters {
            let told = !setting.source.note.trim().is_empty();
            assert!(
                told || setting.source.kind == SourceKind::Paper,
                "{}: {} has no source",
                design.sensor.name,
                setting.path
            );
        }
    }
}

#[test]
fn the_page_on_sensor_files_names_every_family() {
    let root = super::crates::root();
    let page = std::fs::read_to_string(root.join("docs/reference/yaml.md")).unwrap();
    for family in fabkit_designs::REGISTRY.families() {
        let name = family.name();
        assert!(page.contains(&format!("[{name}](yaml-{name}.md)")), "{name}");
        assert!(root.join(format!("docs/reference/yaml-{name}.md")).is_file(), "{name}");
    }
}
