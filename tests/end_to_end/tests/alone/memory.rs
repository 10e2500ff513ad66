//! No command takes more memory than it may: what would is refused before it begins, and what is
//! allowed stays below what was said of it.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::Command;

use fabkit_tests::{Run, binary, fabkit};

/// Runs the command with an address space of so many KiB: above, allocations fail and it aborts.
fn within(kib: u64, folder: &Path, arguments: &[&str]) -> Run {
    let mut command = Command::new("sh");
    command.current_dir(folder).env("MALLOC_ARENA_MAX", "1");
    command.args(["-c", &format!("ulimit -v {kib} && exec \"$0\" --threads 2 \"$@\"")]);
    command.arg(binary()).args(arguments).output().unwrap().into()
}

/// Two threads' stacks, the program itself, and what the allocator keeps.
const SLACK_KIB: u64 = 150_000;

/// Commands whose memory grows with nothing that is asked for, or that are held to the limit by tests of their own below.
const OTHERS: [&str; 17] = [
    "bench",
    "calibrate",
    "check",
    "completions",
    "diff",
    "export",
    "fit-light",
    "guide",
    "help",
    "list",
    "man",
    "new",
    "profile",
    "schema",
    "show",
    "sweep",
    "verify",
];

/// A large request to every command whose memory grows with it: what needs more than the limit says how much, and allocates
/// no more than the limit before that.
#[test]
fn every_command_keeps_to_the_limit_or_refuses() {
    let root = tempfile::tempdir().unwrap();
    let large = ["--set", "camera.width_px=6000", "--set", "camera.height_px=6000"];
    write_png(&root.path().join("rest.png"), [6000, 6000], png::BitDepth::Eight);
    let requests: [(&str, &[&str]); 7] = [
        ("capture", &["rtac0", "--reference", "-o", "c.png"]),
        ("dataset", &["rtac0", "-o", "ds"]),
        ("depth", &["rtac0", "--reference", "-o", "d.npz"]),
        ("optics-pack", &["digit-like", "-o", "pack"]),
        ("reconstruct", &["digit-like", "--reference", "rest.png", "rest.png", "-o", "r"]),
        ("render", &["rtac0", "--size", "8000x8000", "-o", "r.png"]),
        (
            "press",
            &["rtac0", "--indenter", "ball@0deg,0deg", "--depth", "0.5mm", "--spacing", "0.05mm"],
        ),
    ];
    for (command, arguments) in requests {
        let set = if ["render", "press"].contains(&command) { &[][..] } else { &large };
        let all = [&[command][..], arguments, set, &["--memory", "1GB"]].concat();
        let run = within(1_000_000_000 / 1024 + SLACK_KIB, root.path(), &all);
        let is_told = run.stderr.contains("of memory; the limit is 1GB")
            && run.stderr.contains("or allow it with --memory ");
        // `press` has a largest number of nodes that fits into any limit.
        let is_within = run.code == Some(0) || command == "press" && run.code.is_some();
        assert!(is_within || run.code == Some(3) && is_told, "{command}: {run:?}");
    }
    // A new command is put into one of the lists.
    let help = fabkit(root.path(), &["--help"]).ok().stdout;
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let listed = listed.take_while(|line| !line.is_empty());
    // Further lines of a long description are indented more.
    let listed = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    for name in listed.filter_map(|line| line.split_whitespace().next()) {
        let is_known = OTHERS.contains(&name) || requests.iter().any(|(known, _)| *known == name);
        assert!(is_known, "{name} is in neither list");
    }
}

/// A capture that is allowed stays within what it said.
#[test]
fn captures_fit() {
    let root = tempfile::tempdir().unwrap();
    // 1.2 million rays, pressed and at rest.
    let size = ["--set", "camera.width_px=640", "--set", "camera.height_px=480", "--samples", "2"];
    let rest = ["capture", "rtac0", "--reference", "-o", "c.png"];
    let press = ["capture", "rtac0", "--press", "hemisphere@30deg,120deg,1.2mm", "-o", "c.png"];
    let truth = [&press[..], &["--truth", "t.npz"]].concat();
    for capture in [&rest[..], &press, &truth] {
        let capture = [capture, &size].concat();
        let refused = fabkit(root.path(), &[&capture[..], &["--memory", "150MB"]].concat());
        assert_eq!(refused.code, Some(3), "{refused:?}");
        let wanted = refused.stderr.rsplit("--memory ").next().unwrap().trim().to_owned();
        let mb: u64 = wanted.strip_suffix("MB").unwrap().parse().unwrap();
        let kib = mb * 1_000_000 / 1024 + SLACK_KIB;
        within(kib, root.path(), &[&capture[..], &["--memory", &wanted]].concat()).ok();
    }
}

const SMALL: [&str; 4] = ["--set", "camera.width_px=160", "--set", "camera.height_px=120"];

#[test]
fn what_is_too_large_is_refused_with_both_figures_and_a_way_out() {
    let root = tempfile::tempdir().unwrap();
    let large = ["--set", "camera.width_px=8000", "--set", "camera.height_px=8000"];
    let depth = ["depth", "rtac0", "--reference", "-o", "d.npz"];
    for (arguments, what) in [
        ([&depth[..], &large].concat(), "casting 8000 x 8000 rays"),
        ([&["dataset", "rtac0", "-o", "ds"][..], &large].concat(), "a data set of 8000 x 8000 px"),
        (
            vec!["render", "rtac0", "-o", "r.png", "--size", "8000x8000", "--memory", "500MB"],
            "an image of 8000 x 8000 px",
        ),
    ] {
        let run = within(1_000_000, root.path(), &arguments);
        assert_eq!(run.code, Some(3), "{run:?}");
        assert!(run.stderr.contains(what) && run.stderr.contains("of memory; the limit is"));
        assert!(run.stderr.contains("or allow it with --memory "), "{}", run.stderr);
    }
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
}

/// As much as is stated, and not more: the same cast that is allowed with a limit works within it.
#[test]
fn what_is_allowed_fits() {
    let root = tempfile::tempdir().unwrap();
    // 1.2 million rays: 91 bytes of arrays and the images are most of it.
    let cast = [
        "depth",
        "rtac0",
        "--press",
        "hemisphere@30deg,120deg,1.2mm",
        "--samples",
        "2",
        "-o",
        "d.npz",
        "--png",
        "d.png",
        "--ply",
        "d.ply",
    ];
    let refused = fabkit(root.path(), &[&cast[..], &["--memory", "200MB"]].concat());
    assert_eq!(refused.code, Some(3), "{refused:?}");
    let wanted = refused.stderr.rsplit("--memory ").next().unwrap().trim().to_owned();
    let mb: u64 = wanted.strip_suffix("MB").unwrap().parse().unwrap();
    let kib = mb * 1_000_000 / 1024 + SLACK_KIB;
    within(kib, root.path(), &[&cast[..], &["--memory", &wanted]].concat()).ok();
}

/// Bands of rows are what the whole is.
#[test]
fn casting_in_bands_changes_no_byte() {
    use fabkit_application::Error;
    use fabkit_application::fixtures::load;
    use fabkit_application::ground_truth::{Viewpoint, arrays};
    use fabkit_application::press_simulation::ContactModel;
    use fabkit_application::scene::{Cast, SensorView};

    let root = tempfile::tempdir().unwrap();
    // More rays than a band has.
    let cast = ["depth", "rtac0", "--press", "hemisphere@30deg,120deg,1.2mm", "-o", "d.npz"];
    fabkit(root.path(), &[&cast[..], &["--samples", "2"]].concat()).ok();

    let yaml = fabkit_application::designs::builtin_yaml("rtac0").unwrap();
    let project = load("rtac0.yaml", yaml, &[]).unwrap();
    let viewpoint = Viewpoint::new(&project.design.sensor.camera, None, None).unwrap();
    let press = project.press("hemisphere@30deg,120deg,1.2mm").unwrap();
    let scene = SensorView::new(std::sync::Arc::new(project), viewpoint).unwrap();
    let cast = Cast {
        presses: &[press],
        samples: 2,
        contact: ContactModel::Rigid,
        shear_mm: [0.0; 2],
        print_sigma_mm: 0.05,
        allow_no_contact: false,
    };
    let whole = scene
        .cast(&cast, 0, |seen| {
            let arrays = arrays(seen.map, seen.sigmas);
            Ok::<_, Error>(fabkit_application::export::npz(&arrays).unwrap())
        })
        .unwrap();
    assert!(fs::read(root.path().join("d.npz")).unwrap() == whole);
}

/// A PNG of one grey, so that a few kilobytes are many pixels.
fn write_png(path: &Path, [width, height]: [u32; 2], depth: png::BitDepth) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    let mut stream = writer.stream_writer().unwrap();
    let row = vec![0x60; depth as usize / 2 * width as usize];
    for _ in 0..height {
        std::io::Write::write_all(&mut stream, &row).unwrap();
    }
    stream.finish().unwrap();
}

#[test]
fn images_are_refused_by_their_headers() {
    use png::BitDepth::{Eight, Sixteen};

    let root = tempfile::tempdir().unwrap();
    for i in 0..4 {
        write_png(&root.path().join(format!("bomb{i}.png")), [6000, 6000], Sixteen);
    }
    write_png(&root.path().join("small.png"), [160, 120], Eight);
    fabkit(root.path(), &["export", "rtac0/boards", "-o", "boards"]).ok();
    let bombs = ["bomb0.png", "bomb1.png", "bomb2.png", "bomb3.png"];

    // Not of the reference's size.
    let pins = [&["calibrate", "pins", "--reference", "small.png"][..], &bombs].concat();
    let run = within(SLACK_KIB + 50_000, root.path(), &pins);
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("bomb3.png: [6000, 6000] px, but the reference has [160, 120]"));
    // All of one size, which is too large.
    let pins = ["calibrate", "pins", "--memory", "1GB", "--reference"];
    let run = within(SLACK_KIB + 50_000, root.path(), &[&pins[..], &bombs].concat());
    assert_eq!(run.code, Some(3), "{run:?}");
    assert!(run.stderr.contains("looking for pins in an image of 6000 x 6000 px takes"));
    // Not of the camera's size.
    let board = ["--board", "boards/checkerboard.board.json", "-o", "c.yaml"];
    let intrinsics = ["calibrate", "intrinsics", "rtac0"];
    let run = within(
        SLACK_KIB + 50_000,
        root.path(),
        &[&intrinsics[..], &SMALL, &board, &bombs].concat(),
    );
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("the sensor's camera has 160 x 120 px"), "{}", run.stderr);
    // Captures of a data set.
    fs::create_dir(root.path().join("captures")).unwrap();
    for side in ["left", "right"] {
        let place = root.path().join(format!("captures/semi-dome-003-{side}.png"));
        write_png(&place, [6000, 6000], Eight);
    }
    fs::write(root.path().join("one.txt"), "semi-dome-003\n").unwrap();
    let data = ["dataset", "rtac0", "-o", "ds", "--presses", "one.txt", "--captures", "captures"];
    let run = within(SLACK_KIB + 100_000, root.path(), &[&data[..], &SMALL].concat());
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("6000 x 6000 px; the camera has 160 x 120"), "{}", run.stderr);
}

/// Neither waits for a pipe that nobody writes to, nor reads a device for ever, nor what is larger than
/// its kind can be.
#[test]
fn what_is_no_file_of_its_kind_is_refused_at_once() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("one.txt"), "semi-dome-003\n").unwrap();
    assert!(Command::new("mkfifo").arg(root.path().join("pipe")).status().unwrap().success());
    fs::File::create(root.path().join("long.csv")).unwrap().set_len(3 << 30).unwrap();
    let begin: [&[&str]; 2] = [
        &["dataset", "rtac0", "-o", "ds", "--presses", "one.txt", "--captures"],
        &["calibrate", "extrinsics", "rtac0", "-o", "p.yaml", "--captures", ".", "--camera"],
    ];
    for begin in begin {
        for (file, said) in [
            ("pipe", "pipe is a device or a pipe, not a file"),
            ("/dev/zero", "/dev/zero is a device or a pipe, not a file"),
            ("long.csv", "long.csv has 3221225472 bytes"),
        ] {
            let run = within(400_000, root.path(), &[begin, &[file][..]].concat());
            assert!(matches!(run.code, Some(2 | 3)), "{run:?}");
            assert!(run.stderr.contains(said), "{}", run.stderr);
        }
    }
    // A pipe among the captures.
    fs::create_dir(root.path().join("captures")).unwrap();
    for side in ["left", "right"] {
        let place = root.path().join(format!("captures/semi-dome-003-{side}.png"));
        assert!(Command::new("mkfifo").arg(place).status().unwrap().success());
    }
    let list = "pattern,side,file\nsemi-dome-003,left,pipe\nsemi-dome-003,right,/dev/zero\n";
    fs::write(root.path().join("list.csv"), list).unwrap();
    for captures in ["captures", "list.csv"] {
        let run = within(400_000, root.path(), &[begin[0], &[captures], &SMALL].concat());
        assert_eq!(run.code, Some(2), "{run:?}");
    }
}

/// A wrong file costs what it takes to read it: 20 problems are shown, the others counted. Before, hints were sought for
/// each of them with copies of all, for 40 s and in 900 MB.
#[test]
fn thousands_of_unknown_keys_are_refused_soon_and_in_little_memory() {
    /// Address space of a process that keeps 50 MB.
    const KIB: u64 = SLACK_KIB + 50_000;
    let root = tempfile::tempdir().unwrap();
    let keys: String = (0..5000).map(|key| format!("k{key}: {key}\n")).collect();
    // One of them stands in a section, where a value is out of its limits, too.
    let text = format!(
        "format: 1\nextends: tactip\nname: mine\ntitle: Mine\n{keys}camera: {{hight_px: 1, height_px: 0}}\n"
    );
    fs::write(root.path().join("mine.yaml"), text).unwrap();
    let mut quickest = f64::INFINITY;
    for _ in 0..5 {
        let start = std::time::Instant::now();
        let run = within(KIB, root.path(), &["check", "mine.yaml"]);
        quickest = quickest.min(start.elapsed().as_secs_f64());
        assert_eq!(run.code, Some(2), "{run:?}");
        assert_eq!(run.stderr.matches("error: ").count(), 20, "{}", run.stderr);
        let says = "\n5002 problems, of which the first 20 are shown\n";
        assert!(run.stderr.ends_with(says), "{}", run.stderr);
    }
    assert!(quickest < 1.0 || cfg!(debug_assertions), "{quickest} s");
    let refused = within(KIB, root.path(), &["check", "mine.yaml", "--json"]).json();
    assert_eq!(refused["problems"].as_array().map(Vec::len), Some(20));
    assert_eq!(refused["unlisted_problems"], 4982);
}
