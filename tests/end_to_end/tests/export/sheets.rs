//! Drawings of flat parts, and what exported copies make up for.

use std::f64::consts::PI;

use fabkit_geometry::Process;
use fabkit_tests::{builtin_designs, fabkit, read_folder};
use serde_json::Value;

fn part<'a>(manifest: &'a Value, name: &str) -> &'a Value {
    let parts = manifest["parts"].as_array().unwrap();
    parts.iter().find(|part| part["name"] == name).unwrap_or_else(|| panic!("no {name}"))
}

fn figure(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} in {value}"))
}

/// Molds in halves are larger than what is cast in them; silicone takes its shape from glass.
const PRINTED: [&str; 4] = ["export", "rtac0", "--set", "molds.route=printed"];

fn export(arguments: &[&str]) -> Value {
    let root = tempfile::tempdir().unwrap();
    let run = fabkit(root.path(), &[&PRINTED[..], &["--json"], arguments].concat()).ok();
    run.json()["manifest"].clone()
}

#[test]
fn every_laser_and_board_part_of_every_sensor_is_flat() {
    let mut count = 0;
    for design in builtin_designs() {
        for part in design.sensor.parts() {
            if matches!(part.process(), Some(Process::Laser | Process::Pcb)) {
                let sheet = part.solid.as_sheet().unwrap_or_else(|e| panic!("{}: {e}", part.name));
                assert_eq!(Some(sheet.profile.holes.len() as i32), part.genus, "{}", part.name);
                count += 1;
            }
        }
    }
    assert!(count > 0);
}

#[test]
fn flat_parts_get_drawings_without_asking_and_stock_sheets_with_all_of_them() {
    let root = tempfile::tempdir().unwrap();
    let run = fabkit(root.path(), &PRINTED).ok();
    let files = read_folder(&root.path().join("out/rtac0"));
    let drawings: Vec<&str> =
        files.keys().filter(|name| name.ends_with(".dxf")).map(String::as_str).collect();
    let sheet = "sheet-acrylic-frosted-on-both-sides-2mm-1.dxf";
    assert_eq!(drawings, ["diffuser.dxf", "led-board.dxf", sheet]);
    assert!(run.stdout.contains(&format!("{sheet}: 1 piece,")), "{}", run.stdout);
    assert!(run.stdout.contains("for a kerf of 0.2 mm: diffuser\n"), "{}", run.stdout);
    let shrunk = "scaled by 1.001001 for 0.1 % shrinkage of what is cast in it: mold-transparent";
    assert!(run.stdout.contains(shrunk), "{}", run.stdout);
}

#[test]
fn the_kerf_is_the_materials_or_ones_own_and_the_manifest_says_so() {
    let sheet = |arguments: &[&str], name: &str| {
        let manifest = export(&[&["--format=svg"], arguments].concat());
        let part = part(&manifest, name);
        (figure(&part["compensation"], "kerf_mm"), part["sheet"].clone())
    };
    let (kerf, nominal) = sheet(&["--nominal"], "diffuser");
    assert_eq!(kerf, 0.0);
    for (arguments, expected) in [(&[][..], 0.2), (&["--kerf=0.3mm"], 0.3), (&["--kerf=0mm"], 0.0)]
    {
        let (kerf, cut) = sheet(arguments, "diffuser");
        assert_eq!(kerf, expected);
        for i in 0..2 {
            let grown =
                cut["size_mm"][i].as_f64().unwrap() - nominal["size_mm"][i].as_f64().unwrap();
            assert!((grown - expected).abs() < 1e-9, "{grown}");
        }
        // Outer and inner boundary both move by half a kerf; what corners do is of second order.
        let ring = figure(&nominal, "cut_mm") * expected / 2.0;
        let grown = figure(&cut, "area_mm2") - figure(&nominal, "area_mm2");
        assert!((grown - ring).abs() <= 4.0 * PI * expected * expected, "{grown} for {ring}");
    }
    // Boards are routed to their outline by whoever makes them.
    assert_eq!(sheet(&["--kerf=0.3mm"], "led-board"), sheet(&["--nominal"], "led-board"));
}

#[test]
fn molds_are_larger_by_what_shrinks_and_nothing_else_is() {
    let (scaled, nominal) =
        (export(&["--format=stl,tree"]), export(&["--format=stl,tree", "--nominal"]));
    let parts = nominal["parts"].as_array().unwrap();
    let mut molds = 0;
    for before in parts {
        let name = before["name"].as_str().unwrap();
        let after = part(&scaled, name);
        let scale = figure(&after["compensation"], "scale");
        assert_eq!(before["compensation"]["note"], "none");
        assert_eq!(scale != 1.0, name.contains("-gel"), "{name}");
        molds += i32::from(scale != 1.0);
        for axis in 0..3 {
            let size = |part: &Value| part["bounds_in_file_mm"][1][axis].as_f64().unwrap();
            // Both are exact to rounding: corners and quadrants of circles are vertices.
            let expected = size(before) * scale;
            assert!((size(after) - expected).abs() < 1e-9 * expected.max(1.0), "{name}");
        }
        // The chord tolerance changes by a thousandth, and with it at most that share of what the
        // facets cut off; f32 vertices are off by 4e-6 mm over the surface.
        let volume = |part: &Value| figure(&part["mesh"], "volume_mm3");
        let slack = 1e-5 * figure(&before["mesh"], "area_mm2");
        assert!((volume(after) - volume(before) * scale.powi(3)).abs() < slack, "{name}");
    }
    assert_eq!(molds, 6);
    // The tree is the truth and knows nothing of it.
    let hash = |manifest: &Value, name: &str| {
        let files = manifest["files"].as_array().unwrap();
        files.iter().find(|file| file["name"] == name).unwrap()["blake3"].clone()
    };
    let tree = "mold-transparent-gel-a.tree.json";
    let stl = "mold-transparent-gel-a.stl";
    assert_ne!(hash(&scaled, stl), hash(&nominal, stl));
    assert!(hash(&scaled, "base.stl") == hash(&nominal, "base.stl"));
    let root = tempfile::tempdir().unwrap();
    let mut solids = ["", "--nominal"].map(|extra| {
        let arguments = ["--format=tree", "-o", "here", extra];
        let arguments = &arguments[..if extra.is_empty() { 3 } else { 4 }];
        fabkit(root.path(), &[&PRINTED[..], arguments].concat()).ok();
        let bytes = read_folder(&root.path().join("here")).remove(tree).unwrap();
        serde_json::from_slice::<Value>(&bytes).unwrap()["solid"].take()
    });
    assert_eq!(solids[0].take(), solids[1].take());
}

#[test]
fn what_cannot_be_cut_is_refused_with_a_way_out() {
    let root = tempfile::tempdir().unwrap();
    for (arguments, message, hint) in [
        (
            &["--stock=30x25mm"][..],
            "diffuser needs 26.8 x 26.8 mm; a stock sheet of 30 x 25 mm has 24.0 x 19.0 mm",
            "--stock",
        ),
        (&["--part=base", "--format=dxf"], "none of these parts is cut from a sheet: base", "stl"),
        (&["--kerf=3mm"], "3 mm is not between 0 mm and 2 mm", "--kerf"),
        (&["--kerf=0.1mm", "--nominal"], "cannot be used with", "--nominal"),
    ] {
        let run = fabkit(root.path(), &[&["export", "rtac0"], arguments].concat());
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains(message) && run.stderr.contains(hint), "{}", run.stderr);
    }
    assert!(read_folder(root.path()).is_empty(), "nothing was written");
}
