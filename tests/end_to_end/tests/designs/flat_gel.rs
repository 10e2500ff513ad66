//! A flat sensor with another pad, and nothing else changed, is built, cast and exported as the original.

use std::fs;

use fabkit_tests::{fabkit, read_folder};

const OTHER_PAD: &str = "format: 1\nextends: 9dtact\nname: mine\ntitle: another pad\n\
                         pad: {length: 20 mm, width: 25 mm, thickness: 3 mm}\n";

#[test]
fn a_pad_of_another_size_is_checked_and_exported() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("mine.yaml"), OTHER_PAD).unwrap();

    let report = fabkit(root.path(), &["check", "mine.yaml", "--json"]).ok().json();
    let findings = report["findings"].as_array().unwrap();
    assert!(findings.iter().all(|finding| finding["severity"] == "note"), "{report:#}");
    // Gel, coat and bed are poured: three cavities that end where the layers do.
    let rules = report["rules"].as_array().unwrap();
    let of = |rule: &str| rules.iter().find(|r| r["rule"] == rule).unwrap()["examined"].as_u64();
    assert_eq!([of("casting"), of("trapped-air"), of("demolding")], [Some(3); 3], "{report:#}");

    fabkit(root.path(), &["export", "mine.yaml", "-o", "out", "--format=stl,3mf,dxf,svg"]).ok();
    let files = read_folder(&root.path().join("out"));
    for name in ["shell.stl", "base.3mf", "plate.dxf", "led-board.svg", "mold-coat.stl"] {
        assert!(files.contains_key(name), "{name}: {:?}", files.keys());
    }
}
