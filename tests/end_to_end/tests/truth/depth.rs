//! `fabkit depth` by the real binary: what it writes, and what it refuses.

use std::fs;

use fabkit_tests::{Run, fabkit, read_folder};

fn assert_says(run: &Run, code: i32, texts: &[&str]) {
    assert_eq!(run.code, Some(code), "{run:?}");
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

#[test]
fn every_file_is_written_and_the_deepest_contact_is_as_asked() {
    let root = tempfile::tempdir().unwrap();
    let arguments = [
        "depth",
        "rtac0",
        "--press",
        "hemisphere@30deg,120deg,1.2mm",
        "--json",
        "-o",
        "a.npz",
        "--png",
        "a.png",
        "--grey",
        "g.png",
        "--tiff",
        "a.tiff",
        "--ply",
        "a.ply",
    ];
    let json = fabkit(root.path(), &arguments).ok().json();
    assert_eq!(read_folder(root.path()).len(), 5);
    // The nearest pixel is off the tip by at most half a pixel: 4 um deep on a ball of 2 mm.
    let deepest_mm = json["deepest_mm"].as_f64().unwrap();
    assert!((1.19..=1.2 + 1e-9).contains(&deepest_mm), "{deepest_mm}");
    assert_eq!(json["labels"][2], "hemisphere");
    assert_eq!(json["sigma_of"], "shape");
    let first = read_folder(root.path());
    fabkit(root.path(), &[&arguments[..], &["--threads", "1"]].concat()).ok();
    assert!(first == read_folder(root.path()), "the same bytes on one thread");
}

#[test]
fn a_camera_that_misses_the_surface_is_refused_with_angles() {
    let root = tempfile::tempdir().unwrap();
    let away =
        "camera_from_sensor:\n- [1, 0, 0, 0]\n- [0, -1, 0, 0]\n- [0, 0, -1, -50]\n- [0, 0, 0, 1]\n";
    fs::write(root.path().join("pose.yaml"), away).unwrap();
    let run = fabkit(
        root.path(),
        &["depth", "rtac0", "--reference", "--pose", "pose.yaml", "-o", "a.npz"],
    );
    assert_says(
        &run,
        2,
        &["sees none of the surface", "deg off the camera's axis", "camera_from_sensor"],
    );
    assert_eq!(read_folder(root.path()).len(), 1);
    // A little of it: said, and done.
    let aside =
        "camera_from_sensor:\n- [1, 0, 0, 40]\n- [0, 1, 0, 0]\n- [0, 0, 1, 7]\n- [0, 0, 0, 1]\n";
    fs::write(root.path().join("pose.yaml"), aside).unwrap();
    let run = fabkit(
        root.path(),
        &["depth", "rtac0", "--reference", "--pose", "pose.yaml", "-o", "a.npz"],
    );
    assert!(run.ok().stdout.contains("warning: the camera sees"));
}

#[test]
fn presses_and_poses_that_cannot_be_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let depth =
        |more: &[&str]| fabkit(root.path(), &[&["depth", "rtac0", "-o", "a.npz"], more].concat());
    assert_says(
        &depth(&["--press", "semi-dome-17"]),
        2,
        &["no press `semi-dome-17`", "did you mean `semi-dome-017`"],
    );
    assert_says(
        &depth(&["--press", "xyz"]),
        2,
        &["no press `xyz`", "semi-dome-001", "hemisphere@30deg"],
    );
    assert_says(&depth(&["--press", "hemisphere@1deg"]), 2, &["1 value follows the `@`"]);
    assert_says(&depth(&["--press", "hemisphere@30deg,0deg,1"]), 2, &["depth: ", "no unit"]);
    let deep = depth(&["--press", "hemisphere@30deg,0deg,3mm"]);
    assert_says(&deep, 2, &["3 mm is out of range", "1.5 mm, as deep as presses"]);
    // Pins and halves as well as tools; what their own rules allow may still be too deep.
    let long = ["--set", "fixtures.pin_dome.pins.lengths=[5mm,6.4mm]", "--press", "pin-1-long"];
    let expected = [
        "`pin-1-long`: pin 1 goes 1.750 mm deep",
        "presses of this surface are simulated to 1.5 mm",
    ];
    assert_says(&depth(&long), 2, &expected);
    let deep = ["--set", "fixtures.semi_domes.depth.deepest=1.6mm", "--press", "semi-dome-001"];
    assert_says(&depth(&deep), 2, &["deepest is 1.6 mm", "1.500 mm thick"]);
    assert_says(&depth(&[]), 2, &["--press", "--reference"]);
    let run = fabkit(root.path(), &["depth", "rtac0", "--reference", "-o", "a.txt"]);
    assert_says(&run, 2, &["a.txt does not name a .npz file"]);
    let run = fabkit(root.path(), &["depth", "rtac0/semi-domes", "--reference", "-o", "a.npz"]);
    assert_says(&run, 2, &["whole sensor", "write `rtac0`"]);

    let pose = |text: &str| {
        fs::write(root.path().join("pose.yaml"), text).unwrap();
        depth(&["--reference", "--pose", "pose.yaml"])
    };
    assert_says(&pose("a: 1\n"), 2, &["pose.yaml: ", "camera_from_sensor: is missing"]);
    let mirrored =
        "camera_from_sensor:\n- [-1, 0, 0, 0]\n- [0, 1, 0, 0]\n- [0, 0, 1, 7]\n- [0, 0, 0, 1]\n";
    assert_says(&pose(mirrored), 2, &["no rigid motion", "determinant -1"]);
    let stretched = mirrored.replace("-1", "1.01");
    assert_says(&pose(&stretched), 2, &["no rigid motion", "off by 2.0e-2"]);
    fs::write(root.path().join("camera.yaml"), "fabkit_camera: 1\nwidth_px: -3\n").unwrap();
    let run = depth(&["--reference", "--camera", "camera.yaml"]);
    assert_says(&run, 2, &["camera.yaml: ", "width_px"]);
    assert!(!root.path().join("a.npz").exists());
}
