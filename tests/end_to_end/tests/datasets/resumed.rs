//! Folders that runs fill which may be stopped, damaged, and in two hands at once: nothing that is
//! not what was written is taken for it, and one process writes at a time.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use fabkit_tests::{Run, command, fabkit};

const CAMERA: &str = "fabkit_camera: 1\nwidth_px: 96\nheight_px: 72\nlens:\n  \
                      model: kannala-brandt\n  fx_px: 43\n  fy_px: 43\n  cx_px: 47.5\n  \
                      cy_px: 35.5\n  k1: 0\n  k2: 0\n  k3: 0\n  k4: 0\n";
const DATASET: &[&str] = &[
    "dataset",
    "rtac0",
    "-o",
    "out",
    "--camera",
    "camera.yaml",
    "--set",
    "fixtures.semi_domes.count=3",
];
const PLAN: &str = "format: 1\nsensor: rtac0\nsample: 40\naxes:\n  \
                    camera.depth: {from: 6 mm, to: 7 mm}\nmetrics: [layers_mass_g]\n";
const SWEEP: &[&str] = &["sweep", "plan.yaml", "-o", "out"];

fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("camera.yaml"), CAMERA).unwrap();
    fs::write(root.path().join("plan.yaml"), PLAN).unwrap();
    root
}

fn run(root: &Path, arguments: &[&str], more: &[&str]) -> Run {
    fabkit(root, &[arguments, more].concat())
}

/// Every file below a folder.
fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(tree(&path))
        } else {
            match fs::read(&path) {
                Ok(bytes) => drop(found.insert(path, bytes)),
                // A run that goes on has put it in its place, or removed it.
                Err(error) => assert_eq!(error.kind(), std::io::ErrorKind::NotFound, "{error}"),
            }
        }
    }
    found
}

/// A folder whose run was killed at this many files or more, before it was whole.
fn stopped(root: &Path, arguments: &[&str], files: usize) -> BTreeMap<PathBuf, Vec<u8>> {
    let out = root.join("out");
    for _ in 0..20 {
        let mut child = command(root)
            .args([arguments, &["--threads", "1"]].concat())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while tree(&out).len() < files && start.elapsed() < Duration::from_secs(30) {
            sleep(Duration::from_micros(500));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let found = tree(&out);
        let is_whole = ["dataset.json", "sweep.json"].iter().any(|name| out.join(name).exists());
        if found.len() >= files && !is_whole {
            return found;
        }
        fs::remove_dir_all(&out).unwrap();
    }
    panic!("{arguments:?} always ends before it is killed");
}

/// Positions in a file of some length: the ends, and some in between.
fn positions(length: usize, seed: u64, count: usize) -> Vec<usize> {
    if length == 0 {
        return Vec::new();
    }
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 33) as usize
    };
    let mut bits = vec![0, 8 * length - 1];
    bits.extend((0..count).map(|_| next() % (8 * length)));
    bits
}

/// A flipped bit in a whole folder is an error that names the file and replaces nothing.
fn flipped_in_a_whole_folder(arguments: &[&str], each: usize) {
    let root = folder();
    run(root.path(), arguments, &[]).ok();
    let whole = tree(&root.path().join("out"));
    for (number, (path, bytes)) in whole.iter().enumerate() {
        for bit in positions(bytes.len(), number as u64, each) {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            fs::write(path, &flipped).unwrap();
            let again = run(root.path(), arguments, &["--resume"]);
            let name = path.file_name().unwrap().to_str().unwrap();
            assert_eq!(again.code, Some(4), "{} bit {bit}: {again:?}", path.display());
            assert!(again.stderr.contains(name), "{again:?}");
            assert_eq!(fs::read(path).unwrap(), flipped);
            fs::write(path, bytes).unwrap();
        }
    }
    // Removed, it is made again.
    let (path, _) = whole.iter().next_back().unwrap();
    fs::remove_file(path).unwrap();
    run(root.path(), arguments, &["--resume"]).ok();
    assert_eq!(tree(&root.path().join("out")), whole);
}

/// In a stopped one, the piece is made again, or the error says that the plan is damaged.
fn flipped_in_a_stopped_folder(arguments: &[&str], files: usize, each: usize) {
    let (root, other) = (folder(), folder());
    run(other.path(), arguments, &[]).ok();
    let other = other.path().join("out");
    let whole: Vec<_> = tree(&other)
        .into_iter()
        .map(|(path, bytes)| (path.strip_prefix(&other).unwrap().to_path_buf(), bytes))
        .collect();
    let out = root.path().join("out");
    let there = stopped(root.path(), arguments, files);
    for (number, (path, bytes)) in there.iter().enumerate() {
        for bit in positions(bytes.len(), number as u64, each) {
            fs::remove_dir_all(&out).unwrap();
            for (path, bytes) in &there {
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, bytes).unwrap();
            }
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            fs::write(path, &flipped).unwrap();
            let again = run(root.path(), arguments, &["--resume"]);
            match again.code {
                Some(0) => {
                    let found: Vec<_> = tree(&out)
                        .into_iter()
                        .map(|(path, bytes)| {
                            (path.strip_prefix(&out).unwrap().to_path_buf(), bytes)
                        })
                        .collect();
                    assert!(found == whole, "{} bit {bit}", path.display());
                }
                _ => {
                    assert_eq!(again.code, Some(4), "{again:?}");
                    assert!(again.stderr.contains("plan.json is damaged"), "{again:?}");
                }
            }
        }
    }
}

#[test]
fn a_flipped_bit_of_a_data_set_is_noticed() {
    flipped_in_a_whole_folder(&[DATASET, &["--materialise"]].concat(), 1);
    flipped_in_a_stopped_folder(&[DATASET, &["--materialise"]].concat(), 7, 1);
}

#[test]
fn a_flipped_bit_of_a_sweep_is_noticed() {
    flipped_in_a_whole_folder(SWEEP, 2);
    flipped_in_a_stopped_folder(SWEEP, 4, 1);
}

#[test]
fn what_is_no_finished_piece_is_made_again_or_refused() {
    let (root, other) = (folder(), folder());
    let arguments = [DATASET, &["--materialise"]].concat();
    run(other.path(), &arguments, &[]).ok();
    let out = root.path().join("out");
    stopped(root.path(), &arguments, 7);
    let start = Instant::now();
    #[cfg(unix)]
    {
        let pipe = out.join("halves/zarr.json");
        fs::remove_file(&pipe).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let again = run(root.path(), &arguments, &["--resume"]);
        assert_eq!(again.code, Some(4), "{again:?}");
        assert!(again.stderr.contains("a device or a pipe"), "{again:?}");
        fs::remove_file(&pipe).unwrap();
    }
    let huge = fs::OpenOptions::new().write(true).open(out.join("zarr.json")).unwrap();
    huge.set_len(3 << 30).unwrap();
    drop(huge);
    let again = run(root.path(), &arguments, &["--resume"]).ok();
    assert!(start.elapsed() < Duration::from_secs(20), "nothing was read that is no piece");
    assert!(again.stdout.contains("damaged files, made again"), "{again:?}");
    assert!(
        tree(&out).into_values().eq(tree(&other.path().join("out")).into_values()),
        "the same bytes"
    );
}

/// Ten at once: one works, the others are told so, or come when it has finished.
fn ten_at_once(arguments: &[&str]) {
    let (root, other) = (folder(), folder());
    run(other.path(), arguments, &[]).ok();
    let whole: Vec<Vec<u8>> = tree(&other.path().join("out")).into_values().collect();
    for round in 0..3 {
        let _ = fs::remove_dir_all(root.path().join("out"));
        if round > 0 {
            stopped(root.path(), arguments, 3 + round);
        }
        let begun = root.path().join("out").exists();
        let more: &[&str] = if begun { &["--resume"] } else { &[] };
        let children: Vec<_> = (0..10)
            .map(|_| {
                let mut child = command(root.path());
                child.args([arguments, more].concat());
                child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
            })
            .collect();
        let runs: Vec<Run> =
            children.into_iter().map(|child| child.wait_with_output().unwrap().into()).collect();
        let mut worked = 0;
        for run in &runs {
            match run.code {
                Some(0) => worked += 1,
                // Or `another process`, as long as that has not yet said who it is.
                Some(4) => {
                    assert!(run.stderr.contains("is being written to by "), "{run:?}");
                }
                // Without --resume, when the first one has finished.
                Some(2) if !begun => assert!(run.stderr.contains("is not empty"), "{run:?}"),
                _ => panic!("{run:?}"),
            }
        }
        assert!(worked >= 1 && (begun || worked == 1), "{runs:?}");
        let found: Vec<Vec<u8>> = tree(&root.path().join("out")).into_values().collect();
        assert!(found == whole, "round {round}: another folder");
    }
}

#[test]
fn ten_data_sets_at_once_are_one() {
    ten_at_once(DATASET);
}

#[test]
fn ten_sweeps_at_once_are_one() {
    ten_at_once(SWEEP);
}
