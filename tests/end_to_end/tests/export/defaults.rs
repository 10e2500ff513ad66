//! `fabkit.yaml` in the working folder: what options of `export` are where they are not given.

use std::fs;

use fabkit_tests::fabkit;

const PART: [&str; 4] = ["export", "rtac0/diffuser", "--format=stl", "--json"];

#[test]
fn options_are_what_the_file_says_unless_they_are_given() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    let plain = fabkit(folder, &PART).ok().json();
    assert_eq!(plain["folder"], "out/rtac0");
    assert!(plain.get("defaults").is_none(), "{plain}");
    let yaml = "format: 1\nbed: form-4\ntolerance: 0.1 mm\noutput: prints\nkerf: 0.3 mm\n";
    fs::write(folder.join("fabkit.yaml"), yaml).unwrap();
    let told = fabkit(folder, &PART).ok().json();
    assert_eq!(told["folder"], "prints/rtac0");
    assert_eq!(told["defaults"]["file"], "fabkit.yaml");
    let keys = serde_json::json!(["tolerance", "bed", "kerf", "output"]);
    assert_eq!(told["defaults"]["keys"], keys);
    let options = &told["manifest"]["options"];
    assert_eq!(options["tolerance_mm"], 0.1, "{options}");
    assert_eq!(options["bed_mm"], serde_json::json!([200.0, 125.0]), "{options}");
    assert_eq!(options["kerf_mm"], 0.3, "{options}");
    // Options win, and `--nominal` rules the kerf out.
    let own = ["--tolerance=0.02mm", "--bed=100x100mm", "--nominal", "-o", "here"];
    let own = fabkit(folder, &[&PART[..], &own].concat()).ok().json();
    assert_eq!(own["folder"], "here");
    assert!(own.get("defaults").is_none(), "{own}");
    assert_eq!(own["manifest"]["options"]["tolerance_mm"], 0.02);
    let text = fabkit(folder, &["export", "rtac0/diffuser", "--format=stl"]).ok().stdout;
    assert!(text.contains("from fabkit.yaml: tolerance, bed, kerf, output\n"), "{text}");
}

#[test]
fn everything_that_is_wrong_with_the_file_is_told_with_its_line() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    let yaml = "format: 1\nbed: form-44\ntolerence: 0.1 mm\nkerf: 7 mm\nprofile: none.yaml\n";
    fs::write(folder.join("fabkit.yaml"), yaml).unwrap();
    let wrong = fabkit(folder, &PART[..3]);
    assert_eq!(wrong.code, Some(2), "{wrong:?}");
    for text in [
        "fabkit.yaml:2:6",
        "did you mean `form-4`",
        "fabkit.yaml:3:1",
        "did you mean `tolerance`?",
        "fabkit.yaml:4:7",
        "7 mm is not between 0 mm and 2 mm",
        "3 problems",
    ] {
        assert!(wrong.stderr.contains(text), "no `{text}` in:\n{}", wrong.stderr);
    }
    // Other commands have no use for it.
    fabkit(folder, &["list", "--quiet"]).ok();
    // A profile that is not there is a file that is not there; without one, nothing asks for it.
    fs::write(folder.join("fabkit.yaml"), "format: 1\nprofile: none.yaml\n").unwrap();
    assert_eq!(fabkit(folder, &PART).code, Some(4));
    fabkit(folder, &[&PART[..], &["--nominal"]].concat()).ok();
    fs::write(folder.join("fabkit.yaml"), "bed: form-4\n").unwrap();
    assert!(fabkit(folder, &PART[..3]).stderr.contains("the format is missing"));
}
