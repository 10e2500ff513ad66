//! Camera files at the command: one camera of several, impossible ones, and warnings.

use std::fs;
use std::path::Path;

use fabkit_tests::{Run, fabkit};

/// A chain of two cameras; the second has its principal point off the centre.
const CHAIN: &str = "\
cam0:
  camera_model: pinhole
  intrinsics: [286.0, 286.0, 319.5, 239.5]
  distortion_model: equidistant
  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]
  resolution: [640, 480]
cam1:
  camera_model: pinhole
  intrinsics: [286.0, 286.0, 180.0, 239.5]
  distortion_model: equidistant
  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]
  resolution: [640, 480]
";

fn depth(folder: &Path, camera: &str) -> Run {
    let args = ["depth", "rtac0", "--reference", "--camera", camera, "--png", "d.png", "--json"];
    fabkit(folder, &args)
}

#[test]
fn one_camera_of_several_is_named_behind_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("chain.yaml"), CHAIN).unwrap();
    let first = depth(path, "chain.yaml#cam0").ok();
    assert_eq!(first.stderr, "");
    let viewpoint = &first.json()["viewpoint"];
    assert_eq!(viewpoint["parameters"]["cx_px"], 319.5);
    assert!(viewpoint.get("warnings").is_none());

    let second = depth(path, "chain.yaml#cam1").ok();
    let warning = "the principal point (180.0, 239.5) lies far from the centre of the image";
    assert!(second.stderr.starts_with(&format!("warning: {warning}")), "{}", second.stderr);
    let told = second.json()["viewpoint"]["warnings"][0].as_str().unwrap().to_owned();
    assert!(told.starts_with(warning), "{told}");

    // A file whose own name has the sign goes on working.
    fs::write(path.join("lens#2.yaml"), &CHAIN[..CHAIN.find("cam1").unwrap()]).unwrap();
    depth(path, "lens#2.yaml").ok();

    for (camera, code, expected) in [
        ("chain.yaml", 2, "the file holds 2 cameras: `cam0`, `cam1`"),
        ("chain.yaml#cam7", 2, "the file has no camera `cam7`, but `cam0`, `cam1`"),
        ("nothing.yaml#cam0", 4, "nothing.yaml"),
    ] {
        let run = depth(path, camera);
        assert_eq!(run.code, Some(code), "{run:?}");
        assert!(run.stdout.contains(expected), "{run:?}");
    }
    // An output that would replace the file is still recognised.
    let args =
        ["depth", "rtac0", "--reference", "--camera", "chain.yaml#cam0", "--png", "chain.yaml"];
    assert!(fabkit(path, &args).stderr.contains("would replace what --camera reads"));
}

#[test]
fn impossible_cameras_are_refused_by_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let metres = CHAIN[..CHAIN.find("cam1").unwrap()]
        .replace("[286.0, 286.0, 319.5, 239.5]", "[0.0036, 0.0036, 0.00192, 0.00144]");
    fs::write(path.join("camera.yaml"), metres).unwrap();
    fs::create_dir(path.join("captures")).unwrap();
    for args in [
        &["depth", "rtac0", "--reference", "--camera", "camera.yaml", "--png", "o.png"][..],
        &["capture", "rtac0", "--reference", "--camera", "camera.yaml", "-o", "o.png"],
        &["render", "rtac0", "--camera=camera.yaml", "-o", "o.png"],
        &["calibrate", "plan", "rtac0", "--camera", "camera.yaml"],
        &[
            "calibrate",
            "extrinsics",
            "rtac0",
            "--camera",
            "camera.yaml",
            "--captures",
            "captures",
            "-o",
            "p.yaml",
        ],
    ] {
        let run = fabkit(path, args);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.contains("is the matrix in metres?"), "{run:?}");
        assert!(!path.join("o.png").exists());
    }
}

#[test]
fn unusual_cameras_are_said_in_the_json_of_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("chain.yaml"), CHAIN).unwrap();
    let camera = "--camera=chain.yaml#cam1";
    for args in [
        &["depth", "rtac0", "--reference", camera, "--png=d.png"][..],
        &["capture", "rtac0", "--reference", camera, "-o=c.png"],
        &["render", "rtac0", camera, "-o=r.png"],
        &["reconstruct", "rtac0", "--reference=c.png", "c.png", camera, "-o=r", "--force"],
        &["dataset", "rtac0", "--probes", "--count=2", camera, "-o=p.csv"],
        &["optics-pack", "rtac0", camera, "-o=pack"],
        &["calibrate", "plan", "rtac0", camera],
    ] {
        let run = fabkit(path, &[args, &["--json"]].concat());
        assert!(run.stderr.contains("warning: the principal point"), "{args:?}: {run:?}");
        let warnings = run.json()["camera_warnings"].clone();
        let first = warnings[0].as_str().unwrap_or_else(|| panic!("{args:?}: {warnings}"));
        assert!(first.starts_with("the principal point (180.0, 239.5)"), "{args:?}: {first}");
        assert_eq!(warnings.as_array().map(Vec::len), Some(1), "{args:?}");
    }
}
