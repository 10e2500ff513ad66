//! A printer's profile from its coupon to the files it changes, and fixtures beside their sensor.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use fabkit_tests::{fabkit, read_folder};
use serde_json::Value;

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).unwrap()
}

/// Fills in a coupon as a printer makes it that shrinks by 0.4 % and closes holes by 0.2 mm.
fn printed(coupon: &str) -> String {
    let mut group = "";
    let mut lines = Vec::new();
    for line in coupon.lines() {
        group = line.strip_suffix(':').unwrap_or(group);
        lines.push(match line.split_once(" mm, measured: null") {
            Some((before, rest)) => {
                let nominal: f64 = before.rsplit(' ').next().unwrap().parse().unwrap();
                let offset = if group == "holes" { -0.2 } else { 0.0 };
                format!("{before} mm, measured: {:.4} mm{rest}", 0.996 * nominal + offset)
            }
            None => line.to_owned(),
        });
    }
    lines.join("\n")
}

#[test]
fn a_measured_coupon_changes_files_and_nothing_else() {
    let root = tempfile::tempdir().unwrap();
    fabkit(root.path(), &["export", "rtac0/coupon", "--format=stl"]).ok();
    let coupon = fs::read_to_string(root.path().join("out/rtac0/coupon/coupon.yaml")).unwrap();
    fs::write(root.path().join("coupon.yaml"), printed(&coupon)).unwrap();
    let run = fabkit(root.path(), &["profile", "coupon.yaml", "-o", "shop/my-printer.yaml"]).ok();
    assert!(run.stdout.contains("0.400 +- "), "{}", run.stdout);

    let export = |folder: &str, more: &[&str]| -> BTreeMap<String, Vec<u8>> {
        let arguments = ["export", "rtac0", "--format=stl,tree", "-o", folder];
        fabkit(root.path(), &[&arguments, more].concat()).ok();
        read_folder(&root.path().join(folder))
    };
    let nominal = export("nominal", &[]);
    let fitted = export("fitted", &["--process=shop/my-printer.yaml"]);
    let parts = |files: &BTreeMap<String, Vec<u8>>| {
        json(&files["manifest.json"])["parts"].as_array().unwrap().clone()
    };
    let mut holes = 0;
    for (before, after) in parts(&nominal).iter().zip(&parts(&fitted)) {
        let name = before["name"].as_str().unwrap();
        // The truth stays what was designed, to the byte.
        let tree = format!("{name}.tree.json");
        assert!(nominal[&tree] == fitted[&tree], "{tree} differs");
        let stl = format!("{name}.stl");
        let print = &after["compensation"]["print"];
        if before["process"] != "fdm" {
            assert!(nominal[&stl] == fitted[&stl] && print.is_null(), "{stl} differs");
            continue;
        }
        assert_eq!(print["profile"], "my-printer");
        assert!(after["compensation"]["note"].as_str().unwrap().contains("my-printer"));
        holes += print["holes_fitted"].as_u64().unwrap();
        let size = |part: &Value, i: usize| part["bounds_in_file_mm"][1][i].as_f64().unwrap();
        for i in 0..3 {
            let factor = size(after, i) / size(before, i);
            // Another tolerance may mean another segment: 0.01 mm of 20 mm.
            assert!((factor - 1.0 / 0.996).abs() < 5e-4, "{name}: {factor}");
        }
        // Wider holes take material away, scaling adds more.
        let volume = |part: &Value| part["mesh"]["volume_mm3"].as_f64().unwrap();
        let grown = volume(after) / volume(before);
        // Round holes alone: of a thin tube, more segments on its wall count for as much as 0.05 %.
        assert!(grown < 0.996f64.powi(-3) + 5e-4, "{name}: {grown}");
    }
    assert!(holes > 10, "{holes}");

    let run = fabkit(root.path(), &["export", "rtac0", "--nominal", "--process=x.yaml"]);
    assert_eq!(run.code, Some(2), "{run:?}");
}

#[test]
fn a_bad_coupon_or_profile_is_shown_with_its_line_and_writes_nothing() {
    let root = tempfile::tempdir().unwrap();
    fabkit(root.path(), &["export", "rtac0/coupon", "--format=stl"]).ok();
    let coupon = fs::read_to_string(root.path().join("out/rtac0/coupon/coupon.yaml")).unwrap();
    let profile = |yaml: &str| {
        fs::write(root.path().join("coupon.yaml"), yaml).unwrap();
        fabkit(root.path(), &["profile", "coupon.yaml", "-o", "p.yaml"])
    };
    let run = profile(&coupon);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("holes has 0 measured sizes; a profile needs at least 3"));
    let good = printed(&coupon);
    let run = profile(&good.replacen("1.7920 mm", "nan", 1));
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("--> coupon.yaml:") && run.stderr.contains("is not finite"));
    assert!(!root.path().join("p.yaml").exists());
    for (output, says) in [
        ("coupon.yaml", "would replace what COUPON.yaml reads"),
        ("p.txt", "does not end in .yaml"),
        ("My Printer.yaml", "cannot be a printer's name"),
    ] {
        let run = fabkit(root.path(), &["profile", "coupon.yaml", "-o", output]);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains(says), "{}", run.stderr);
    }
    fs::write(root.path().join("p.yaml"), "format: 1\nname: p\n").unwrap();
    let run = fabkit(root.path(), &["export", "rtac0", "--process", "p.yaml"]);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("the file lacks"), "{}", run.stderr);
}

/// Names of a folder's files, those of its subfolders too.
fn tree(folder: &Path, prefix: &str, names: &mut Vec<String>) {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap()).collect();
    entries.sort_by_key(|entry| entry.file_name());
    for entry in entries {
        let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            tree(&entry.path(), &format!("{name}/"), names)
        } else {
            names.push(name)
        }
    }
}

#[test]
fn fixtures_are_written_beside_their_sensor_or_not_at_all() {
    let root = tempfile::tempdir().unwrap();
    let arguments = ["export", "fluidic", "--fixtures", "--format=stl", "--tolerance=0.1mm"];
    let run = fabkit(root.path(), &[&arguments[..], &["--json"]].concat()).ok();
    let document = json(run.stdout.as_bytes());
    let out = root.path().join("out/fluidic");
    let mut names = Vec::new();
    tree(&out, "", &mut names);
    let fixtures = document["fixtures"].as_object().unwrap();
    assert!(["boards", "coupon", "indenters"].iter().all(|name| fixtures.contains_key(*name)));
    let mut expected = vec!["manifest.json".to_owned()];
    let files = |manifest: &Value| {
        let files = manifest["files"].as_array().unwrap().clone();
        files.into_iter().map(|file| file["name"].as_str().unwrap().to_owned())
    };
    expected.extend(files(&document["manifest"]));
    for (name, manifest) in fixtures {
        expected.push(format!("{name}/manifest.json"));
        expected.extend(files(manifest).map(|file| format!("{name}/{file}")));
        let written = json(&fs::read(out.join(name).join("manifest.json")).unwrap());
        assert_eq!(written["design_hash"], manifest["design_hash"]);
    }
    names.sort();
    expected.sort();
    assert_eq!(names, expected);

    // One fixture's file cannot be written: nothing is.
    let blocked = root.path().join("blocked/coupon/coupon.yaml");
    fs::create_dir_all(&blocked).unwrap();
    let run = fabkit(root.path(), &[&arguments[..], &["-o", "blocked"]].concat());
    assert_eq!(run.code, Some(4), "{run:?}");
    let mut left = Vec::new();
    tree(&root.path().join("blocked"), "", &mut left);
    assert_eq!(left, [""; 0]);
    assert_eq!(fs::read_dir(root.path().join("blocked")).unwrap().count(), 1);

    let run = fabkit(root.path(), &["export", "fluidic/boards", "--fixtures"]);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("write `fabkit export fluidic --fixtures`"), "{}", run.stderr);
}

/// Fills in a gel's coupon as a ball of 12 mm sinks into 12 mm of gel: loads in g of a gel of 75 kPa.
fn weighed(coupon: &str) -> String {
    // From finite elements at large strain in a cup that holds the gel, at Poisson's ratio 0.495, to 0.1 g: that is
    // 0.7 % of the lightest load and less of all others, so that the modulus is within 1 %.
    let rows = [(13.7, 19.5), (41.3, 19.0), (79.6, 18.5), (127.5, 18.0), (183.6, 17.5)];
    let fill = |text: String, (load, gap): (f64, f64)| {
        text.replacen("{load: null, gap: null}", &format!("{{load: {load} g, gap: {gap} mm}}"), 1)
    };
    rows.into_iter().fold(coupon.to_owned(), fill)
}

#[test]
fn a_weighed_gel_becomes_a_material_that_presses_use() {
    let root = tempfile::tempdir().unwrap();
    fabkit(root.path(), &["export", "rtac0/gel-coupon", "--format=stl"]).ok();
    let name = "gel-smooth-on-ecoflex-00-30.yaml";
    let coupon = fs::read_to_string(root.path().join("out/rtac0/gel-coupon").join(name)).unwrap();
    fs::write(root.path().join(name), weighed(&coupon)).unwrap();
    let run = fabkit(root.path(), &["profile", name, "-o", "my batch.yaml", "--json"]).ok();
    let young_mpa = json(run.stdout.as_bytes())["youngs_modulus_mpa"].as_f64().unwrap();
    assert!((young_mpa / 0.075 - 1.0).abs() < 0.01, "{young_mpa}");
    let written = fs::read_to_string(root.path().join("my batch.yaml")).unwrap();
    // In a sensor's file the same section goes for that sensor.
    let section = written.split_once("materials:").unwrap().1;
    let mine = format!("format: 1\nname: mine\nextends: rtac0\nmaterials:{section}");
    fs::write(root.path().join("mine.yaml"), mine).unwrap();
    let press = |sensor: &str| {
        let place = ["press", sensor, "--indenter=hemisphere@0deg,0deg", "--depth=0.5mm", "--json"];
        json(fabkit(root.path(), &place).ok().stdout.as_bytes())["force_n"][2].as_f64().unwrap()
    };
    // The layer below gives way, too: force rises by less than its modulus, from 69 kPa.
    let stiffer = press("mine.yaml") / press("rtac0");
    assert!((1.05..=75.0 / 69.0).contains(&stiffer), "{stiffer}");
}

#[test]
fn readings_that_give_no_modulus_write_nothing() {
    let root = tempfile::tempdir().unwrap();
    fabkit(root.path(), &["export", "9dtact/gel-coupon", "--format=stl"]).ok();
    let folder = root.path().join("out/9dtact/gel-coupon");
    let gels = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let is_gel = |path: &std::path::PathBuf| path.extension().is_some_and(|kind| kind == "yaml");
    let good = weighed(&fs::read_to_string(gels.into_iter().find(is_gel).unwrap()).unwrap());
    for (from, to, says) in [
        ("41.3 g", "41.3", "has no unit"),
        ("41.3 g", "-41.3 g", "between 0.1 g and 20000 g"),
        ("19 mm", "null", "needs both a load and a gap"),
        ("thickness: 12 mm", "thickness: nan mm", "thickness"),
        ("ball: 12 mm", "bal: 12 mm", "`bal` is not a key of a gel coupon"),
        ("gap: 18.5 mm", "gap: 19.2 mm", "scatter so far"),
        ("gap: 17.5 mm", "gap: 25 mm", "no modulus explains these readings"),
    ] {
        assert!(good.contains(from), "{from}");
        fs::write(root.path().join("gel.yaml"), good.replace(from, to)).unwrap();
        let run = fabkit(root.path(), &["profile", "gel.yaml", "-o", "batch.yaml"]);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains(says), "{says}: {}", run.stderr);
        assert!(!root.path().join("batch.yaml").exists());
    }
}
