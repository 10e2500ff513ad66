//! Holes, pieces and cavities are those of the design at every tolerance, and what values make
//! otherwise is refused as what cannot be made.

use fabkit_application::exports::{ExportOptions, Format, export};
use fabkit_designs::Design;
use fabkit_tests::{Run, fabkit};
use serde_json::Value;

/// From fine to the coarsest that the command takes, mm.
const TOLERANCES_MM: [f64; 12] = [0.02, 0.03, 0.05, 0.08, 0.1, 0.15, 0.2, 0.25, 0.3, 0.5, 0.7, 1.0];

fn export_at_all(designs: &[Design], most_parts: usize) {
    let mut refused = Vec::new();
    for design in designs {
        let names = design.sensor.parts().map(|part| part.name.clone());
        let parts: Vec<String> = names.take(most_parts).collect();
        for tolerance_mm in TOLERANCES_MM {
            let formats = vec![Format::Stl];
            let parts = parts.clone();
            let options =
                ExportOptions { parts, formats, tolerance_mm, ..ExportOptions::default() };
            if let Err(failure) = export(design, &options, &|_| ()) {
                refused.push(format!("{} at {tolerance_mm} mm: {failure}", design.sensor.name));
            }
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

// At 0.01 mm, every other test exports them.
#[test]
fn sensors_keep_their_topology_at_every_tolerance() {
    export_at_all(&fabkit_tests::builtin_designs(), usize::MAX);
}

/// Of a hundred halves of calibration bodies, a few.
#[test]
fn fixtures_keep_their_topology_at_every_tolerance() {
    export_at_all(&fabkit_tests::builtin_fixtures(), 8);
}

#[test]
fn the_manifest_tells_the_tolerance_that_was_used() {
    let root = tempfile::tempdir().unwrap();
    let options = ["--tolerance=0.3mm", "--format=stl", "-o", "out"];
    fabkit(root.path(), &[&["export", "tactip/body"][..], &options].concat()).ok();
    let text = std::fs::read(root.path().join("out/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_slice(&text).unwrap();
    let used = manifest["parts"][0]["mesh"]["chord_tolerance_mm"].as_f64().unwrap();
    assert!((0.005..0.3).contains(&used), "{used}");
    assert_eq!(manifest["parts"][0]["mesh"]["genus"], 2);
}

#[test]
fn loose_pieces_are_refused() {
    let root = tempfile::tempdir().unwrap();
    // Closed cavities are tested where exports are (`fabkit/application/tests/exporting.rs`).
    let set = "--set=fixtures.pin_dome.numbers.height=7.20531mm";
    let options = ["export", "tactip/pin-dome", set, "--format=stl", "-o", "out"];
    let run: Run = fabkit(root.path(), &options);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("= help: "), "{run:?}");
    assert!(!root.path().join("out").exists());
}
