//! What grows unless somebody looks: documents that a newcomer reads first, files of a family, the application.

use std::fs;
use std::path::{Path, PathBuf};

use super::crates::root;

/// Files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found
}

/// Folders directly in a folder, by name.
fn folders(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

fn lines(path: &Path) -> usize {
    fs::read_to_string(path).unwrap().lines().count()
}

#[test]
fn the_front_pages_are_short() {
    for (page, most_bytes) in [("ARCHITECTURE.md", 10_000), ("CONTRIBUTING.md", 8_000)] {
        let bytes = fs::metadata(root().join(page)).unwrap().len();
        assert!(bytes <= most_bytes, "{page}: {bytes} bytes; at most {most_bytes}");
    }
    let architecture = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let rooms = architecture.lines().filter_map(|line| line.strip_prefix("| [`")?.split_once("/`"));
    let rooms: Vec<&str> = rooms.map(|(room, _)| room).collect();
    assert!(rooms.contains(&"geometry") && rooms.len() <= 12, "{rooms:?}");
    for room in rooms {
        let count = lines(&root().join(room).join("README.md"));
        assert!(count <= 40, "{room}/README.md: {count} lines; at most 40");
    }
}

#[test]
fn a_family_has_few_files_and_a_page() {
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let families = folders(&root().join("designs/families/src/families"));
    assert!(families.len() > 3, "{families:?}");
    for family in &families {
        let count = files(family).len();
        assert!(count <= 8, "{}: {count} files; at most 8", family.display());
    }
    for page in files(&root().join("docs/reference")) {
        let name = page.file_name().unwrap().to_str().unwrap();
        assert!(summary.contains(&format!("reference/{name}")), "docs/SUMMARY.md forgets {name}");
    }
}

#[test]
fn the_application_holds_use_cases_alone() {
    let sources = files(&root().join("fabkit/application/src"));
    // Examples in documentation are no use cases, and none has to be left out for this limit.
    let in_examples = |path: &PathBuf| {
        let text = fs::read_to_string(path).unwrap();
        let is_doc = |line: &&str| line.starts_with("//!") || line.trim_start().starts_with("///");
        let (mut count, mut is_inside) = (0, false);
        for line in text.lines().filter(is_doc) {
            let is_fence = line.contains("```");
            count += usize::from(is_inside || is_fence);
            is_inside ^= is_fence;
        }
        count
    };
    let count: usize = sources.iter().map(|path| lines(path) - in_examples(path)).sum();
    assert!(count <= 10_000, "{count} lines; more belongs into the rooms below");
}
