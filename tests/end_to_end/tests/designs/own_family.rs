//! The family that the book teaches with: it is built, checked and exported as those in the box are.

use fabkit_tests::read_folder;

#[path = "../../../../fabkit/application/examples/own_family.rs"]
#[allow(dead_code)]
mod teaching;

#[test]
fn the_teaching_family_passes_its_checks_and_is_exported() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(teaching::run(folder.path()).unwrap(), 0);
    let files = read_folder(folder.path());
    for name in ["base.stl", "housing.3mf", "mold-ring.stl", "window.dxf", "manifest.json"] {
        assert!(files.keys().any(|file| file.ends_with(name)), "{name}: {:?}", files.keys());
    }
}

#[test]
fn its_limits_find_what_they_follow_from() {
    let yaml = teaching::REGISTRY.builtin_yaml("puck").unwrap();
    let wide = teaching::REGISTRY.load("puck.yaml", yaml, &["gel_diameter=30mm".into()], &[]);
    let hints: Vec<_> = wide.unwrap_err().problems.into_iter().filter_map(|p| p.hint).collect();
    let expected = [
        "write at least 48 mm, or change `gel_diameter`",
        "write at least 25.981 mm, or change `gel_diameter` or `field_of_view`",
    ];
    assert_eq!(hints, expected);
}

#[test]
fn fits_that_a_family_does_not_ask_for_are_said_to_stay() {
    let yaml = teaching::REGISTRY.builtin_yaml("puck").unwrap();
    let set = ["parts.housing.process=sla".into()];
    let puck = teaching::REGISTRY.load("puck.yaml", yaml, &set, &[]).unwrap();
    let note = &puck.sensor.body("housing").unwrap().notes[0];
    assert!(note.ends_with("in place of black PLA; its fits are those of fdm"), "{note}");
}

#[test]
fn it_stays_of_a_teaching_size() {
    let lines =
        include_str!("../../../../fabkit/application/examples/own_family.rs").lines().count();
    // It grew by a twentieth when abbreviations in names became words.
    assert!(lines <= 275, "{lines} lines");
}
