//! What commands write over: never what they read, never what somebody changed, and a list of
//! contents that tells the truth about its folder.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use fabkit_tests::{Run, binary, command, fabkit, read_folder};
use serde_json::Value;

const CAMERA: &str = "fabkit_camera: 1\nwidth_px: 96\nheight_px: 72\nlens:\n  \
                      model: kannala-brandt\n  fx_px: 43\n  fy_px: 43\n  cx_px: 47.5\n  \
                      cy_px: 35.5\n  k1: 0\n  k2: 0\n  k3: 0\n  k4: 0\n";

fn assert_refused(run: &Run, texts: &[&str]) {
    assert_eq!(run.code, Some(2), "{run:?}");
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

fn manifest(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("manifest.json")).unwrap()).unwrap()
}

fn names(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap()).collect()
}

/// Name and why.
fn others(manifest: &Value) -> BTreeMap<&str, &str> {
    let Some(others) = manifest["others"].as_array() else { return BTreeMap::new() };
    others.iter().map(|o| (o["name"].as_str().unwrap(), o["why"].as_str().unwrap())).collect()
}

#[test]
fn measurements_in_a_coupon_are_not_erased_by_a_second_export() {
    let root = tempfile::tempdir().unwrap();
    let export = |more: &[&str]| {
        fabkit(root.path(), &[&["export", "rtac0/coupon", "--format=stl"], more].concat())
    };
    export(&[]).ok();
    // As it is, it may be written again.
    export(&[]).ok();
    let coupon = root.path().join("out/rtac0/coupon/coupon.yaml");
    let mine = fs::read_to_string(&coupon).unwrap() + "# measured on Monday\n";
    fs::write(&coupon, &mine).unwrap();
    let before = read_folder(coupon.parent().unwrap());
    assert_refused(&export(&[]), &["coupon.yaml was changed since fabkit wrote it", "--force"]);
    assert_eq!(read_folder(coupon.parent().unwrap()), before);
    // A part of it does not touch the file, and says that it is not as listed.
    export(&["--part=coupon"]).ok();
    assert_eq!(fs::read_to_string(&coupon).unwrap(), mine);
    assert_eq!(others(&manifest(coupon.parent().unwrap()))["coupon.yaml"], "changed");
    assert_refused(&export(&[]), &["coupon.yaml"]);
    export(&["--force"]).ok();
    assert!(!fs::read_to_string(&coupon).unwrap().contains("Monday"));
}

#[test]
fn a_manifest_keeps_what_is_still_true_and_names_the_rest() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("out");
    let export =
        |more: &[&str]| fabkit(root.path(), &[&["export", "rtac0", "-o", "out"], more].concat());
    export(&["--part=collar", "--part=base", "--format=stl,3mf"]).ok();
    let both = fs::read(out.join("manifest.json")).unwrap();
    // One part again: all that is listed is there, all that is there is listed.
    export(&["--part=base", "--format=stl,3mf"]).ok();
    assert_eq!(fs::read(out.join("manifest.json")).unwrap(), both);

    // Another version of the design: one part is new, the other one stale.
    let newer = ["--set", "coat.thickness=0.12mm", "--part=base"];
    fs::write(out.join("notes.txt"), "mine").unwrap();
    let run = export(&[&newer[..], &["--format=stl"]].concat()).ok();
    for text in ["another version", "base.3mf, collar.3mf, collar.stl", "--clean", "notes.txt"] {
        assert!(run.stdout.contains(text), "no `{text}` in:\n{}", run.stdout);
    }
    let list = manifest(&out);
    assert_eq!(names(&list["files"]), ["base.stl"]);
    let expected = [
        ("base.3mf", "stale"),
        ("collar.3mf", "stale"),
        ("collar.stl", "stale"),
        ("notes.txt", "foreign"),
    ];
    assert_eq!(others(&list), BTreeMap::from(expected));

    // Cleaned: what nobody changed goes, the rest stays and is named.
    fs::write(out.join("collar.stl"), "mine too").unwrap();
    let run = export(&[&newer[..], &["--format=stl", "--clean", "--json"]].concat()).ok();
    assert_eq!(run.json()["removed"], serde_json::json!(["base.3mf", "collar.3mf"]));
    let left: Vec<String> = read_folder(&out).into_keys().collect();
    assert_eq!(left, ["base.stl", "collar.stl", "manifest.json", "notes.txt"]);
    let list = manifest(&out);
    assert_eq!(names(&list["files"]), ["base.stl"]);
    assert_eq!(others(&list).len(), 2);
}

#[test]
fn other_options_make_other_files() {
    let root = tempfile::tempdir().unwrap();
    let export = |more: &[&str]| {
        let all = [&["export", "rtac0", "-o", "out", "--format=stl"], more].concat();
        fabkit(root.path(), &all).ok()
    };
    export(&["--part=collar"]);
    export(&["--part=base", "--tolerance=0.05mm"]);
    let list = manifest(&root.path().join("out"));
    assert_eq!(names(&list["files"]), ["base.stl"]);
    assert_eq!(others(&list), BTreeMap::from([("collar.stl", "stale")]));
}

#[test]
fn another_designs_folder_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("out");
    let export = |sensor: &str, more: &[&str]| {
        let all = [&["export", sensor, "-o", "out", "--format=stl"], more].concat();
        fabkit(root.path(), &all)
    };
    export("rtac0", &["--part=collar"]).ok();
    let before = read_folder(&out);
    for other in ["tactip/pin-dome", "rtac0/coupon"] {
        assert_refused(&export(other, &[]), &["out holds the export of rtac0, not of", "--clean"]);
        assert_eq!(read_folder(&out), before);
    }
    export("rtac0/coupon", &["--clean"]).ok();
    assert!(!out.join("collar.stl").exists());
    assert_eq!(manifest(&out)["sensor"], "rtac0-coupon");
}

#[test]
fn files_that_fabkit_did_not_write_are_not_replaced() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("out");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("collar.stl"), "somebody's").unwrap();
    let export = |more: &[&str]| {
        let all = ["export", "rtac0", "-o", "out", "--part=collar", "--format=stl"];
        fabkit(root.path(), &[&all, more].concat())
    };
    assert_refused(&export(&[]), &["out/collar.stl is there, and no manifest says", "--force"]);
    fs::rename(out.join("collar.stl"), out.join("manifest.json")).unwrap();
    assert_refused(&export(&[]), &["out/manifest.json is there"]);
    assert_eq!(read_folder(&out).len(), 1);
    export(&["--force"]).ok();
    assert_eq!(names(&manifest(&out)["files"]), ["collar.stl"]);
}

/// A list that somebody wrote by hand names files elsewhere: they are not touched.
#[test]
fn a_manifest_reaches_no_other_folder() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("out");
    let export = ["export", "rtac0", "-o", "out", "--part=collar", "--format=stl", "--clean"];
    fabkit(root.path(), &export).ok();
    fs::write(root.path().join("victim"), "x").unwrap();
    let text = fs::read_to_string(out.join("manifest.json")).unwrap();
    let hash = blake3::hash(b"x").to_hex().to_string();
    let entry = format!(
        "\"files\": [{{\"name\": \"../victim\", \"parts\": [], \"format\": \"stl\", \"bytes\": 1, \
         \"blake3\": \"{hash}\"}},"
    );
    let text = text.replacen("\"files\": [", &entry, 1);
    fs::write(out.join("manifest.json"), &text).unwrap();
    // It no longer ends with its own checksum; those of old versions have none.
    assert_refused(&fabkit(root.path(), &export), &["manifest.json was changed", "--force"]);
    let (text, _) = text.rsplit_once(",\n  \"blake3\"").unwrap();
    fs::write(out.join("manifest.json"), format!("{text}\n}}\n")).unwrap();
    fabkit(root.path(), &export).ok();
    assert!(root.path().join("victim").exists());
}

/// A folder with a camera, a board, corners and landmarks that need not be good: the names are
/// looked at first.
fn inputs() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    let path = |name: &str| root.path().join(name);
    for name in ["pose.camera.yaml", "board.json", "corners.csv", "marks.json", "mine.yaml"] {
        fs::write(path(name), CAMERA).unwrap();
    }
    fs::create_dir(path("captures")).unwrap();
    fs::write(path("captures/01.png"), "picture").unwrap();
    symlink("board.json", path("soft.json")).unwrap();
    fs::hard_link(path("board.json"), path("hard.json")).unwrap();
    root
}

#[test]
fn outputs_never_replace_inputs_or_each_other() {
    let root = inputs();
    let all = || -> BTreeMap<String, Vec<u8>> {
        let entries = fs::read_dir(root.path()).unwrap().map(|e| e.unwrap().path());
        let files = entries.filter(|path| path.is_file());
        files.map(|p| (p.display().to_string(), fs::read(&p).unwrap())).collect()
    };
    let before = all();
    let refused = |line: &str, says: &[&str]| {
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_refused(&fabkit(root.path(), &words), says);
        assert_eq!(all(), before, "{line}");
    };
    let pose = "calibrate extrinsics rtac0 --captures captures";
    let lens = "calibrate intrinsics rtac0 --corners corners.csv";
    let depth = "depth rtac0 --reference --camera pose.camera.yaml";
    // The camera that belongs to a pose has a name of its own.
    refused(
        &format!("{pose} --camera pose.camera.yaml -o pose.yaml"),
        &["the camera of the pose", "--camera"],
    );
    refused(&format!("{pose} --camera mine.yaml -o ./mine.yaml"), &["-o ./mine.yaml", "--camera"]);
    refused(
        &format!("{pose} --camera mine.yaml --landmarks marks.json -o x.yaml --report marks.json"),
        &["--report marks.json", "--landmarks"],
    );
    refused(
        &format!("{pose} --camera mine.yaml -o captures/01.png"),
        &["-o captures/01.png", "--captures"],
    );
    refused(
        &format!("{pose} --camera mine.yaml -o x.yaml --report x.yaml"),
        &["-o x.yaml", "--report x.yaml", "the same file"],
    );
    for same in ["./board.json", "captures/../board.json", "soft.json", "hard.json"] {
        refused(&format!("{lens} --board board.json -o {same}"), &["-o", same, "--board"]);
    }
    refused(&format!("{lens} --board board.json -o c.yaml --report corners.csv"), &["--corners"]);
    refused("profile ./mine.yaml -o mine.yaml", &["-o mine.yaml", "COUPON.yaml", "./mine.yaml"]);
    refused(&format!("{depth} --png x.png --grey ./x.png"), &["--png", "--grey"]);
    refused(&format!("{depth} --png x.png --grey X.png"), &["--png", "--grey"]);
    refused("verify mine.yaml --report ./mine.yaml", &["--report", "SENSOR"]);
}

/// Ends of 29 pins on a dome, and where an equidistant lens sees five of them in each of six captures.
fn marks() -> tempfile::TempDir {
    const HOLES: [[usize; 5]; 6] = [
        [1, 2, 6, 14, 22],
        [1, 3, 8, 17, 25],
        [1, 5, 12, 20, 28],
        [2, 4, 9, 16, 23],
        [1, 7, 11, 18, 27],
        [3, 10, 13, 15, 24],
    ];
    let mut ends = Vec::new();
    for (polar_deg, count) in [(0.0_f64, 1), (18.0, 4), (36.0, 8), (54.0, 8), (72.0, 8)] {
        for k in 0..count {
            let (s, c) = polar_deg.to_radians().sin_cos();
            let (sa, ca) = (f64::from(k) * std::f64::consts::TAU / f64::from(count)).sin_cos();
            ends.push([14.5 * s * ca, 14.5 * s * sa, 6.0 + 14.5 * c]);
        }
    }
    let landmarks: BTreeMap<usize, [f64; 3]> = (1..).zip(ends.iter().copied()).collect();
    let mut captures = String::from("file,hole,x_px,y_px\n");
    for (capture, holes) in HOLES.iter().enumerate() {
        for hole in holes {
            let [x, y, z] = ends[hole - 1];
            let (u, v) = (0.4 - y, x - 0.3);
            let (r, angle) = (u.hypot(v), u.hypot(v).atan2(z + 7.5));
            let phase = 12.9 * *hole as f64 + 78.2 * capture as f64;
            let (px, py) = (319.5 + 229.18 * angle * u / r, 239.5 + 229.18 * angle * v / r);
            let (px, py) = (px + 0.2 * phase.sin(), py + 0.2 * phase.cos());
            captures += &format!("{capture}.png,{hole},{px:.3},{py:.3}\n");
        }
    }
    let root = tempfile::tempdir().unwrap();
    fs::create_dir(root.path().join("captures")).unwrap();
    let camera = CAMERA
        .replace("width_px: 96\nheight_px: 72", "width_px: 640\nheight_px: 480")
        .replace(": 43", ": 229.18")
        .replace(": 47.5", ": 319.5")
        .replace(": 35.5", ": 239.5");
    fs::write(root.path().join("camera.yaml"), camera).unwrap();
    fs::write(root.path().join("captures/captures.csv"), captures).unwrap();
    let landmarks = serde_json::to_string(&landmarks).unwrap();
    fs::write(root.path().join("landmarks.json"), landmarks).unwrap();
    root
}

#[test]
fn what_a_user_edited_is_not_replaced_without_force() {
    let root = marks();
    let line = "calibrate extrinsics rtac0 --camera camera.yaml --captures captures --landmarks \
                landmarks.json -o pose.yaml";
    let words: Vec<&str> = line.split_whitespace().collect();
    let calibrate = |more: &[&str]| fabkit(root.path(), &[&words[..], more].concat());
    calibrate(&[]).ok();
    // As fabkit wrote them, both may be replaced, also by others.
    calibrate(&[]).ok();
    calibrate(&["--gel-index=1.35"]).ok();
    for name in ["pose.yaml", "pose.camera.yaml"] {
        let path = root.path().join(name);
        let whole = fs::read_to_string(&path).unwrap();
        let mine = format!("# by hand\n{whole}");
        fs::write(&path, &mine).unwrap();
        assert_refused(&calibrate(&[]), &[name, "was changed since fabkit wrote it", "--force"]);
        assert_eq!(fs::read_to_string(&path).unwrap(), mine);
        fs::write(&path, "sensor: mine\n").unwrap();
        assert_refused(&calibrate(&[]), &[name, "fabkit did not write it", "--force"]);
        calibrate(&["--force"]).ok();
        assert!(!fs::read_to_string(&path).unwrap().contains("mine"));
    }
    // It is read all the same: the line is a comment.
    fabkit(root.path(), &["depth", "rtac0", "--pose=pose.yaml", "--reference", "-o", "a.npz"]).ok();
}

#[test]
fn what_verify_keeps_follows_the_rules_of_an_export() {
    let root = tempfile::tempdir().unwrap();
    let python = root.path().join("python");
    // Says yes to everything.
    let answer = "#!/bin/sh\necho '{\"passed\": true, \"kernels\": [], \"results\": []}'\n";
    fs::write(&python, answer).unwrap();
    std::fs::set_permissions(&python, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let verify = |target: &str| -> Run {
        let mut command = command(root.path());
        command.env("FABKIT_PYTHON", &python).args(["verify", target, "--keep", "kept"]);
        command.output().unwrap().into()
    };
    verify("rtac0/collar").ok();
    verify("rtac0/collar").ok();
    let mesh = root.path().join("kept/collar.stl");
    fs::write(&mesh, "mine").unwrap();
    assert_refused(&verify("rtac0/collar"), &["collar.stl was changed", "--keep"]);
    assert_eq!(fs::read(&mesh).unwrap(), b"mine");
    assert_refused(&verify("tactip/body"), &["kept holds the export of rtac0", "--keep"]);
}

#[test]
fn a_data_set_that_does_not_come_about_replaces_no_image() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("camera.yaml"), CAMERA).unwrap();
    fs::create_dir(root.path().join("set")).unwrap();
    fs::write(root.path().join("set/mine"), "mine").unwrap();
    fs::write(root.path().join("s.png"), "mine").unwrap();
    let run = fabkit(
        root.path(),
        &[
            "dataset",
            "rtac0",
            "--camera=camera.yaml",
            "--set=fixtures.semi_domes.count=8",
            "--contact-sheet=s.png",
            "-o",
            "set",
        ],
    );
    assert_refused(&run, &["set is not empty"]);
    assert_eq!(fs::read_to_string(root.path().join("s.png")).unwrap(), "mine");
}

#[test]
fn outputs_in_several_folders_appear_together_or_not_at_all() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("camera.yaml"), CAMERA).unwrap();
    fs::create_dir_all(root.path().join("b/x.png")).unwrap();
    let depth = |png: &str| {
        let all = ["depth", "rtac0", "--reference", "--camera=camera.yaml", "-o", "a/x.npz"];
        fabkit(root.path(), &[&all[..], &["--png", png]].concat())
    };
    let run = depth("b/x.png");
    assert_eq!(run.code, Some(4), "{run:?}");
    assert!(!root.path().join("a").exists());
    depth("b/y.png").ok();
    assert!(root.path().join("a/x.npz").exists() && root.path().join("b/y.png").exists());
}

#[test]
fn names_need_not_be_text_and_may_be_long() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("camera.yaml"), CAMERA).unwrap();
    let long = "x".repeat(246);
    let odd = OsStr::from_bytes(b"caf\xe9.npz");
    let status = command(root.path())
        .args(["depth", "rtac0", "--reference", "--camera=camera.yaml", "--quiet", "-o"])
        .arg(odd)
        .args(["--png", &format!("{long}.png")])
        .status()
        .unwrap();
    assert!(status.success());
    assert!(root.path().join(odd).exists());
    assert!(root.path().join(format!("{long}.png")).exists());
}

/// The system's answer to a file beyond `ulimit -f` is a signal that ends processes.
#[test]
fn a_file_beyond_the_systems_limit_is_an_error_and_leaves_nothing() {
    let root = tempfile::tempdir().unwrap();
    let run: Run = Command::new("sh")
        .args(["-c", r#"ulimit -f 200; exec "$0" "$@""#])
        .arg(binary())
        .args(["export", "rtac0", "-o", "out"])
        .current_dir(root.path())
        .output()
        .unwrap()
        .into();
    assert_eq!(run.code, Some(4), "{run:?}");
    assert!(run.stderr.contains("File too large"), "{}", run.stderr);
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
}
