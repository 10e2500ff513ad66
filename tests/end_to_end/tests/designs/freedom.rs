//! What families can do besides what the built-in sensors ask of them, built, checked and exported.

use fabkit_tests::fabkit;

#[test]
fn mounts_labels_boards_and_dots_can_be_built() {
    let root = tempfile::tempdir().unwrap();
    let insert = ["mount.hold=insert", "mount.thread=M2", "mount.pattern=rectangle"];
    let narrow = ["surface.radius=11mm", "shell.shoulder=2.5mm", "shell.edge_fillet=1mm"];
    let turned = ["shell.cable_side=left", "mount.pattern=rectangle", "mount.thread=M4"];
    let stepped =
        ["holder.outer_diameter=26mm", "holder.edge_fillet=2mm", "base.cable_angle=90 deg"];
    let passed = ["mount.hold=through", "mount.pattern=list", "labels.style=raised"];
    for (sensor, sets) in [
        ("rtac0", [&insert[..], &["labels.style=sunken"]].concat()),
        ("rtac0", narrow.to_vec()),
        ("digit-like", [&turned[..], &["labels.style=sunken"]].concat()),
        ("shadowtac", passed.to_vec()),
        ("shadowtac", vec!["holder.edge_fillet=0.8mm", "base.cable_side=left"]),
        ("gelsight-like", vec!["shell.edge_fillet=1.5mm", "labels.style=raised"]),
        ("tactip", vec!["body.edge_fillet=0.8mm", "body.cable_angle=90 deg"]),
        ("uvdtact", stepped.to_vec()),
        ("fluidic", vec!["housing.cable_side=back"]),
    ] {
        let sets: Vec<String> = sets.iter().map(|set| format!("--set={set}")).collect();
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let checked = fabkit(root.path(), &[&["check", sensor][..], &sets].concat());
        assert_eq!(checked.code, Some(0), "{sensor} {sets:?}: {checked:?}");
        // An export counts pieces and holes of each mesh.
        let export = ["export", sensor, "--format=stl", "--tolerance=0.05mm", "--force", "--clean"];
        fabkit(root.path(), &[&export[..], &sets].concat()).ok();
    }
}

#[test]
fn what_is_asked_of_a_family_counts_for_the_design() {
    let root = tempfile::tempdir().unwrap();
    let hash = |sets: &[&str]| {
        let shown = fabkit(root.path(), &[&["show", "9dtact", "--json"], sets].concat()).ok();
        shown.json()["design_hash"].as_str().unwrap().to_owned()
    };
    let plain = hash(&[]);
    assert_ne!(plain, hash(&["--set=labels.style=none"]));
    assert_ne!(plain, hash(&["--set=mount.thread=M2"]));
}
