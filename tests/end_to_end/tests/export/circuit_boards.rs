//! Circuit boards as a fab gets them: every file named, the same on any number of threads, none where there is none.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use fabkit_designs::Design;
use fabkit_geometry::CompiledSolid;
use fabkit_tests::{builtin_designs, fabkit, read_folder};
use serde_json::Value;

/// Boards of a design, by the names of their bodies.
fn boards(design: &Design) -> Vec<&str> {
    design.sensor.circuits.iter().filter_map(|circuit| circuit.board.as_deref()).collect()
}

fn with_boards() -> Vec<Design> {
    let designs: Vec<Design> =
        builtin_designs().into_iter().filter(|d| !boards(d).is_empty()).collect();
    let names: BTreeSet<&str> = designs.iter().map(|design| &*design.sensor.name).collect();
    for family in ["rtac0", "uvdtact", "tactip", "9dtact"] {
        assert!(names.contains(family), "{names:?}");
    }
    designs
}

/// One body alone is meshed; boards are whole whichever parts are asked for.
fn export(root: &Path, design: &Design, threads: &str, into: &str) -> BTreeMap<String, Vec<u8>> {
    let (name, board) = (&*design.sensor.name, boards(design)[0]);
    let words = ["export", name, "--part", board, "--format", "gerber", "--force"];
    fabkit(root, &[&words[..], &["--threads", threads, "-o", into]].concat()).ok();
    let mut files = BTreeMap::new();
    for board in boards(design) {
        let of_board = read_folder(&root.join(into).join(board));
        files.extend(of_board.into_iter().map(|(name, bytes)| (format!("{board}/{name}"), bytes)));
    }
    files.insert("manifest.json".into(), fs::read(root.join(into).join("manifest.json")).unwrap());
    files
}

#[test]
fn the_job_file_and_the_manifest_name_every_file() {
    let root = tempfile::tempdir().unwrap();
    for design in with_boards() {
        let sensor = &design.sensor;
        let files = export(root.path(), &design, "2", &sensor.name);
        let manifest: Value = serde_json::from_slice(&files["manifest.json"]).unwrap();
        let listed = manifest["files"].as_array().unwrap().iter();
        let listed: BTreeSet<&str> = listed.map(|file| file["name"].as_str().unwrap()).collect();
        let there = files.keys().map(String::as_str).filter(|name| *name != "manifest.json");
        assert_eq!(there.collect::<BTreeSet<_>>(), listed, "{}", sensor.name);

        for board in boards(&design) {
            let job: Value =
                serde_json::from_slice(&files[&format!("{board}/{board}.gbrjob")]).unwrap();
            let named = job["FilesAttributes"].as_array().unwrap().iter();
            let named: Vec<&str> = named.map(|file| file["Path"].as_str().unwrap()).collect();
            let prefix = format!("{board}/");
            let made = files.keys().filter_map(|name| name.strip_prefix(&prefix));
            // What is etched and drilled; places, parts and images are no layers.
            let layers: BTreeSet<&str> =
                made.filter(|name| name.ends_with(".gbr") || name.ends_with(".drl")).collect();
            assert_eq!(named.len(), layers.len(), "{}: {named:?}", sensor.name);
            assert_eq!(named.into_iter().collect::<BTreeSet<_>>(), layers, "{}", sensor.name);
            // Two coppers, masks, pastes and prints, the outline, and holes: wires or vias go through each board.
            assert!(layers.len() >= 10, "{}: {layers:?}", sensor.name);

            // A fab reads the size of the board that is drawn, to the hundredth.
            let bounds = CompiledSolid::new(&sensor.body(board).unwrap().solid).unwrap().bounds();
            let size = &job["GeneralSpecs"]["Size"];
            for (axis, key) in ["X", "Y"].into_iter().enumerate() {
                let drawn = bounds.max[axis] - bounds.min[axis];
                let told = size[key].as_f64().unwrap();
                assert!((told - drawn).abs() <= 0.01, "{}: {key} {told}, {drawn}", sensor.name);
            }
            // Whatever is soldered and needs a machine has its place, and each place is a part of the circuit.
            let places =
                String::from_utf8(files[&format!("{board}/{board}-pos.csv")].clone()).unwrap();
            let circuit =
                sensor.circuits.iter().find(|c| c.board.as_deref() == Some(board)).unwrap();
            let placed: BTreeSet<&str> = places
                .lines()
                .skip(1)
                .map(|line| line.split(',').next().unwrap().trim_matches('"'))
                .collect();
            let drawn = circuit
                .parts
                .iter()
                .filter(|part| part.place.is_some() && part.size_mm != [0.0; 2]);
            for part in drawn {
                assert!(placed.contains(&*part.designator), "{}: {}", sensor.name, part.designator);
            }
            assert!(
                placed.iter().all(|name| circuit.part(name).is_some()),
                "{}: {placed:?}",
                sensor.name
            );
        }
    }
}

#[test]
fn boards_are_the_same_on_any_number_of_threads() {
    let root = tempfile::tempdir().unwrap();
    for design in with_boards() {
        let on =
            |threads: &str| export(root.path(), &design, threads, &format!("{threads}-threads"));
        let (one, eight) = (on("1"), on("8"));
        assert!(one == eight, "{}", design.sensor.name);
        for threads in ["1", "8"] {
            fs::remove_dir_all(root.path().join(format!("{threads}-threads"))).unwrap();
        }
    }
}

#[test]
fn a_sensor_without_boards_is_refused_with_what_to_do() {
    let root = tempfile::tempdir().unwrap();
    for design in builtin_designs().iter().filter(|design| boards(design).is_empty()) {
        let name = &*design.sensor.name;
        let run = fabkit(root.path(), &["export", name, "--format", "gerber", "--force"]);
        assert_eq!(run.code, Some(2), "{run:?}");
        for said in [&*format!("{name} has no circuit board"), "= help: leave gerber out"] {
            assert!(run.stderr.contains(said), "{said}: {run:?}");
        }
        assert!(read_folder(root.path()).is_empty(), "{name}");
    }
}

#[test]
fn a_stranger_in_a_boards_folder_is_told() {
    let root = tempfile::tempdir().unwrap();
    let export =
        ["export", "tactip", "--part", "led-board", "--format", "gerber", "--force", "-o", "out"];
    fabkit(root.path(), &export).ok();
    let verify = || fabkit(root.path(), &["verify", "out"]);
    verify().ok();
    let board = root.path().join("out/led-board");
    fs::write(board.join("led-board-In1_Cu.gbr"), "G04 another layer*").unwrap();
    let run = verify();
    assert_eq!(run.code, Some(1), "{run:?}");
    assert!(run.stdout.contains("led-board/led-board-In1_Cu.gbr"), "{run:?}");
    // An export that finds it there names it in its list.
    let again = fabkit(root.path(), &export).ok();
    assert!(
        again.stdout.contains("files that fabkit did not write: led-board/led-board-In1_Cu.gbr"),
        "{again:?}"
    );
    verify().ok();

    // A layer that is gone or changed.
    fs::write(board.join("led-board-F_Cu.gbr"), "G04*").unwrap();
    fs::remove_file(board.join("led-board-B_Cu.gbr")).unwrap();
    let run = verify();
    assert_eq!(run.code, Some(1), "{run:?}");
    for name in ["led-board-F_Cu.gbr", "led-board-B_Cu.gbr"] {
        assert!(run.stdout.contains(name), "{run:?}");
    }
}

/// An archive holds boards as a folder does.
#[test]
fn boards_are_in_archives() {
    let root = tempfile::tempdir().unwrap();
    let words = [
        "export",
        "uvdtact",
        "--part",
        "led-board",
        "--format",
        "gerber",
        "--force",
        "--zip",
        "a.zip",
    ];
    fabkit(root.path(), &words).ok();
    let bytes = fs::read(root.path().join("a.zip")).unwrap();
    let name = b"uvdtact/led-board/led-board.gbrjob";
    assert!(bytes.windows(name.len()).any(|window| window == name));
}

/// Circuits of every built-in sensor keep the rule, with and without boards.
#[test]
fn circuits_light_up() {
    for design in builtin_designs() {
        assert!(!design.sensor.circuits.is_empty(), "{}", design.sensor.name);
        let findings =
            fabkit_tests::find_findings(&design.sensor, &[fabkit_checks::Rule::Circuit]).unwrap();
        assert!(findings.is_empty(), "{}: {findings:#?}", design.sensor.name);
    }
}
