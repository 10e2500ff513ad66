//! Data sets by the real binary: killed and resumed, refused, and never overwritten.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Instant;

use fabkit_tests::{Run, command, fabkit, read_folder};

/// Few and small: what is tested here is the folder.
const SMALL: &[&str] = &["--camera", "camera.yaml", "--set", "fixtures.semi_domes.count=8"];

const CAMERA: &str = "fabkit_camera: 1\nwidth_px: 96\nheight_px: 72\nlens:\n  \
                      model: kannala-brandt\n  fx_px: 43\n  fy_px: 43\n  cx_px: 47.5\n  \
                      cy_px: 35.5\n  k1: 0\n  k2: 0\n  k3: 0\n  k4: 0\n";

fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("camera.yaml"), CAMERA).unwrap();
    root
}

fn dataset(root: &Path, more: &[&str]) -> Run {
    fabkit(root, &[&["dataset", "rtac0", "-o", "set"], SMALL, more].concat())
}

/// Every file below a folder with its hash.
fn hashes(folder: &Path) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.insert(name, blake3::hash(&fs::read(&path).unwrap()).to_hex().to_string());
            }
        }
    }
    found
}

fn assert_says(run: &Run, code: i32, texts: &[&str]) {
    assert_eq!(run.code, Some(code), "{run:?}");
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

#[test]
fn killed_at_any_moment_and_resumed_it_ends_with_the_same_bytes() {
    let (whole, killed) = (folder(), folder());
    let start = Instant::now();
    dataset(whole.path(), &["--materialise"]).ok();
    let usual = start.elapsed();
    let mut kills = 0;
    // Moments spread over a run by the golden section; runs that end sooner do not count, and once
    // the set is whole it is begun anew.
    for attempt in 1..200u32 {
        if kills == 20 {
            break;
        }
        if killed.path().join("set/dataset.json").exists() {
            // Killed after that, a run leaves its notes and its lock to the next one.
            dataset(killed.path(), &["--materialise", "--resume"]).ok();
            assert_eq!(hashes(&killed.path().join("set")), hashes(&whole.path().join("set")));
            fs::remove_dir_all(killed.path().join("set")).unwrap();
        }
        let more: &[&str] = if killed.path().join("set").exists() { &["--resume"] } else { &[] };
        let arguments = [&["dataset", "rtac0", "-o", "set", "--materialise"], SMALL, more].concat();
        let mut child = command(killed.path())
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        sleep(usual.mul_f64((f64::from(attempt) * 0.618_033_988_749_895).fract()));
        if child.try_wait().unwrap().is_none() {
            // SIGKILL: nothing can be tidied up.
            child.kill().unwrap();
            kills += 1;
        }
        child.wait().unwrap();
    }
    assert_eq!(kills, 20);
    let more: &[&str] = if killed.path().join("set").exists() { &["--resume"] } else { &[] };
    dataset(killed.path(), &[&["--materialise"], more].concat()).ok();
    assert_eq!(hashes(&killed.path().join("set")), hashes(&whole.path().join("set")));
}

#[test]
fn threads_change_no_byte_and_both_modes_have_the_same_halves() {
    let (one, two) = (folder(), folder());
    dataset(one.path(), &["--materialise", "--threads", "1"]).ok();
    dataset(two.path(), &["--threads", "3"]).ok();
    let (one, two) = (hashes(&one.path().join("set")), hashes(&two.path().join("set")));
    let mut compared = 0;
    for (name, hash) in
        two.iter().filter(|(name, _)| name.starts_with("halves/c/") || name.contains("/c/"))
    {
        assert_eq!(one.get(name), Some(hash), "{name}");
        compared += 1;
    }
    assert!(compared >= 2);
    assert_eq!(one["reference.npz"], two["reference.npz"]);
    assert_ne!(one["dataset.json"], two["dataset.json"]);
}

#[test]
fn nothing_is_overwritten() {
    let root = folder();
    fs::create_dir(root.path().join("set")).unwrap();
    fs::write(root.path().join("set/mine.txt"), "mine").unwrap();
    assert_says(&dataset(root.path(), &[]), 2, &["set is not empty", "--resume"]);
    assert_says(&dataset(root.path(), &["--resume"]), 2, &["set is not empty"]);
    assert_eq!(read_folder(&root.path().join("set")).len(), 1);
    fs::remove_file(root.path().join("set/mine.txt")).unwrap();
    dataset(root.path(), &[]).ok();
    let before = hashes(&root.path().join("set"));
    assert_says(&dataset(root.path(), &[]), 2, &["set is not empty"]);
    // Another design, another seed, another mode.
    let run = dataset(root.path(), &["--resume", "--set", "coat.thickness=0.1mm"]);
    assert_says(&run, 2, &["holds another data set", "about.design_hash", "asked for"]);
    assert_says(
        &dataset(root.path(), &["--resume", "--seed", "2"]),
        2,
        &["about.seed: 1 there, 2"],
    );
    assert_says(&dataset(root.path(), &["--resume", "--materialise"]), 2, &["materialised: false"]);
    let run = dataset(root.path(), &["--resume"]).ok();
    assert!(run.stdout.contains("0 files made"), "{}", run.stdout);
    assert_eq!(hashes(&root.path().join("set")), before);
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_said_and_can_be_resumed() {
    let (root, whole) = (folder(), folder());
    // A limit on the size of files is a disk that is full for all but the smallest.
    let binary = fabkit_tests::binary().display().to_string();
    let script = format!(
        "trap '' XFSZ; ulimit -f 64; exec {binary} dataset rtac0 -o set {}",
        SMALL.join(" ")
    );
    let run: Run = std::process::Command::new("sh")
        .args(["-c", &script])
        .current_dir(root.path())
        .output()
        .unwrap()
        .into();
    assert_says(&run, 4, &["cannot write", "--resume goes on"]);
    assert!(!root.path().join("set/dataset.json").exists());
    dataset(root.path(), &["--resume"]).ok();
    dataset(whole.path(), &[]).ok();
    assert_eq!(hashes(&root.path().join("set")), hashes(&whole.path().join("set")));
}

#[test]
fn patterns_from_a_file_are_read_and_refused_line_by_line() {
    let root = folder();
    let list = "# by hand\nball = hemisphere@40deg,180deg,1mm\n\
                two = hemisphere@20deg,170deg,0.5mm + hemisphere@60deg,200deg,1.2mm\n";
    fs::write(root.path().join("list.txt"), list).unwrap();
    let run = dataset(root.path(), &["--presses", "list.txt", "--json"]).ok().json();
    assert_eq!((run["patterns"].as_u64(), run["samples"].as_u64()), (Some(2), Some(4)));
    assert_eq!(run["halves_without_contact"].as_array().map(Vec::len), Some(0));

    let wrong = "ball = hemisphere@40deg,180deg,1mm\nball = semi-dome-001\n\
                 a,b = semi-dome-001\nx = semi-dom-001\ny = hemisphere@40deg,180deg\n\
                 deep = hemisphere@40deg,180deg,9mm\nlow = hemisphere@170deg,180deg,1mm\n";
    fs::write(root.path().join("list.txt"), wrong).unwrap();
    let run = fabkit(
        root.path(),
        &[&["dataset", "rtac0", "-o", "new", "--presses", "list.txt"], SMALL].concat(),
    );
    let expected = [
        "list.txt:2:1",
        "there is a pattern `ball` already",
        "2 | ball = semi-dome-001",
        "list.txt:3:1",
        "`a,b` cannot name files",
        "there is no press `semi-dom-001`",
        "press `hemisphere@40deg,180deg`: 2 values follow",
        "press `hemisphere@40deg,180deg,9mm`: 9 mm is out of range",
        "list.txt:7:1",
        "press `hemisphere@170deg,180deg,1mm`: 170 deg is out of range: the surface ends 111.8",
    ];
    assert_says(&run, 2, &expected);
    assert!(!root.path().join("new").exists());

    // On the right of the seam: the left half has nothing.
    fs::write(root.path().join("list.txt"), "ball = hemisphere@40deg,0deg,1mm\n").unwrap();
    let run = fabkit(
        root.path(),
        &[&["dataset", "rtac0", "-o", "new", "--presses", "list.txt"], SMALL].concat(),
    );
    assert!(run.stdout.contains("does not see on their side (2)"), "{run:?}");
}

#[test]
fn presses_past_the_rigid_shell_are_refused_all_at_once() {
    let root = folder();
    let list = "a = pin-1-long\nb = hemisphere@40deg,180deg,1mm + pin-2-long\nc = pin-3-short\n";
    fs::write(root.path().join("list.txt"), list).unwrap();
    let deep = "fixtures.pin_dome.pins.lengths=[5mm,6.4mm]";
    let run = dataset(root.path(), &["--presses", "list.txt", "--set", deep]);
    let expected = [
        "`a`: pin 1 goes 1.750 mm deep at (0.00, 0.00, 19.25) mm, but presses of this surface",
        "`b`: pin 2 goes 1.750 mm deep",
        "leave these out",
    ];
    assert_says(&run, 2, &expected);
    assert!(!run.stderr.contains("pin 3") && !run.stderr.contains("hemisphere"), "{run:?}");
    assert!(!root.path().join("set").exists());
    // A tenth of a millimetre above the shell.
    let fits = "fixtures.pin_dome.pins.lengths=[5mm,6.05mm]";
    dataset(root.path(), &["--presses", "list.txt", "--set", fits]).ok();
}

/// An image of one value; the camera's size unless told otherwise.
fn image(width: u32, value: u8) -> Vec<u8> {
    fabkit_application::export::png(width, 72, &vec![value; 3 * width as usize * 72]).unwrap()
}

#[test]
fn captures_are_stitched_or_every_fault_is_listed() {
    let root = folder();
    let more = ["--set", "fixtures.semi_domes.count=3", "--materialise", "--captures"];
    let with = |captures: &str, out: &str| {
        let fixed = ["dataset", "rtac0", "-o", out, "--camera", "camera.yaml"];
        fabkit(root.path(), &[&fixed[..], &more, &[captures]].concat())
    };
    let captures = root.path().join("captures");
    fs::create_dir(&captures).unwrap();
    for pattern in 1..=3u8 {
        for (side, value) in [("left", 10 * pattern), ("right", 100 + pattern)] {
            let name = format!("semi-dome-{pattern:03}-{side}.png");
            fs::write(captures.join(name), image(96, value)).unwrap();
        }
    }
    with("captures", "set").ok();
    assert!(root.path().join("set/samples/image/c/0/0/0/0").exists());

    fs::write(captures.join("semi-dome-001-left.png"), image(97, 0)).unwrap();
    fs::write(captures.join("semi-dome-002-left.png"), "no image").unwrap();
    fs::remove_file(captures.join("semi-dome-003-right.png")).unwrap();
    let run = with("captures", "new");
    let expected = [
        "97 x 72 px; the camera has 96 x 72",
        "not a readable PNG",
        "no capture of semi-dome-003 right",
    ];
    assert_says(&run, 2, &expected);

    let csv = "pattern,side,file\nsemi-dome-001,left,a.png\nsemi-dome-001,left,b.png\n\
               semi-dome-009,left,c.png\nsemi-dome-001,above,d.png\nonly one\n";
    fs::write(root.path().join("captures.csv"), csv).unwrap();
    let run = with("captures.csv", "new");
    let expected = [
        "2 captures of semi-dome-001 left: a.png, b.png",
        "captures.csv:4: no pattern `semi-dome-009`",
        "captures.csv:5: the side is",
        "captures.csv:6: 1 cells",
        "no capture of semi-dome-002 right",
    ];
    assert_says(&run, 2, &expected);
    assert!(!root.path().join("new").exists());
}

#[test]
fn probes_are_spread_seen_and_limited() {
    let root = folder();
    let probes = |more: &[&str]| {
        let fixed = ["dataset", "uvdtact", "--probes", "-o", "probes.csv"];
        fabkit(root.path(), &[&fixed, more].concat())
    };
    let json = probes(&["--count", "500", "--json"]).ok().json();
    assert!(json["probes_seen"].as_u64().unwrap() > 250, "{json}");
    let text = fs::read_to_string(root.path().join("probes.csv")).unwrap();
    assert_eq!(text.lines().count(), 501);
    let deepest_mm = json["deepest_mm"].as_f64().unwrap();
    for line in text.lines().skip(1) {
        let cell = |i: usize| line.split(',').nth(i).unwrap().parse::<f64>();
        let number = |i: usize| cell(i).unwrap();
        let (r, theta, phi) = (number(7), number(8), number(9));
        let point = [r * theta.sin() * phi.cos(), r * theta.sin() * phi.sin(), r * theta.cos()];
        assert!((0..3).all(|i| (point[i] - number(2 + i)).abs() < 1e-9), "{line}");
        assert!(number(1) > 0.0 && number(1) <= deepest_mm);
        // The nominal camera looks along z, so that angles around it are those in the image.
        if let Ok(phi_image) = cell(10) {
            assert!((phi - phi_image).abs() < 1e-9, "{line}");
        }
    }
    assert_says(
        &probes(&["--depth", "19mm"]),
        2,
        &["probes of 19 mm are too deep", "simulated to"],
    );
}

/// A search through the bodies begins with what led to the places before: in an order that threads do not change.
#[test]
fn threads_change_no_byte_of_probes() {
    let root = tempfile::tempdir().unwrap();
    let probes = |threads: &str| {
        let file = format!("{threads}.csv");
        let options = ["--probes", "--count", "5000", "--threads", threads, "-o", &file];
        fabkit(root.path(), &[&["dataset", "rtac0"], &options[..]].concat()).ok();
        fs::read(root.path().join(file)).unwrap()
    };
    assert!(probes("1") == probes("2"));
}
