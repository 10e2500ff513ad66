//! Whoever computes from captures decides about what is implausible.

use std::fs;
use std::path::{Path, PathBuf};

/// Files that take values out with findings. Each hands the findings on or reports them; the next command that reads
/// captures is added here by somebody who has looked.
const DECIDES: [&str; 9] = [
    "fabkit/command/src/commands/fit_light/domes.rs",
    "fabkit/command/src/commands/fit_light/pads.rs",
    "fabkit/command/src/commands/reconstruct.rs",
    "fabkit/python/src/scene.rs",
    "simulation/capture/src/light_fit/mod.rs",
    "simulation/capture/src/light_fit/pads.rs",
    "simulation/capture/src/plausibility/mod.rs",
    "simulation/reconstruct/src/image_reader.rs",
    "simulation/reconstruct/src/lib.rs",
];

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "target") {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

#[test]
fn findings_about_captures_are_dropped_nowhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = Vec::new();
    for room in ["fabkit", "simulation", "calibration", "physics"] {
        collect(&root.join(room), &mut files);
    }
    let mut found = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        if text.contains("accept_anyway(") {
            let name = file.strip_prefix(&root).unwrap().display().to_string();
            let hands_on = ["merge(", "finish_outcome(", "Judged::new(", "judged.accept()"];
            assert!(hands_on.iter().any(|call| text.contains(call)), "{name} drops findings");
            found.push(name);
        }
    }
    found.sort();
    assert_eq!(found, DECIDES);
}
