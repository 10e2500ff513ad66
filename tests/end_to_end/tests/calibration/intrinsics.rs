//! `fabkit calibrate intrinsics`, from rendered images to the camera's file.

#[path = "../../../../calibration/solver/tests/solver/common/mod.rs"]
mod common;

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use common::scene::{Studio, USUAL, charuco, fisheye, save, somewhere};
use fabkit_calibration::board::Board;
use fabkit_calibration::image::GreyImage;
use fabkit_camera::files;
use fabkit_geometry::sequences::SplitMix64;
use fabkit_tests::{Run, fabkit, read_folder};
use tempfile::TempDir;

const IMAGES: usize = 10;

fn board() -> Board {
    charuco([12, 9], 4.0, 3.0)
}

/// A folder with `board.json` and images `0.png` to `9.png`, made once.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<TempDir> = OnceLock::new();
    let make = || {
        let folder = tempfile::tempdir().unwrap();
        let (studio, board, mut random) = (Studio::new(fisheye()), board(), SplitMix64::new(20));
        fs::write(folder.path().join("board.json"), board.to_json()).unwrap();
        for index in 0..IMAGES {
            let pose = somewhere(&board, &mut random, [22.0, 45.0], 40.0, 45.0);
            let picture = studio.picture(&board, &pose, USUAL, &mut random);
            save(&picture, folder.path().join(format!("{index}.png")));
        }
        folder
    };
    FOLDER.get_or_init(make).path()
}

fn images() -> Vec<String> {
    (0..IMAGES).map(|index| format!("{index}.png")).collect()
}

fn calibrate(images: &[String], more: &[&str]) -> Run {
    let mut arguments = vec!["calibrate", "intrinsics", "rtac0", "--board", "board.json"];
    arguments.extend(images.iter().map(String::as_str));
    arguments.extend(more);
    fabkit(folder(), &arguments)
}

#[test]
fn images_become_a_camera_with_its_covariance() {
    let out = tempfile::tempdir().unwrap();
    let camera_file = out.path().join("camera.yaml");
    let report_file = out.path().join("report.html");
    let outputs =
        ["-o", camera_file.to_str().unwrap(), "--report", report_file.to_str().unwrap(), "--json"];
    let run = calibrate(&images(), &outputs).ok();
    let json = run.json();
    assert_eq!(json["format"], "fabkit-intrinsics");
    assert_eq!(json["pictures"].as_array().unwrap().len(), IMAGES);
    assert!(json["reprojection_rms_px"].as_f64().unwrap() < 0.15, "{json:#}");

    let estimate = files::read(&fs::read_to_string(&camera_file).unwrap()).unwrap();
    let (sigmas, truth) = (estimate.sigmas().unwrap(), fisheye());
    let found = estimate.camera().parameters();
    for (i, (name, expected)) in truth.parameters().into_iter().enumerate().take(4) {
        let error = (found[i].1 - expected).abs();
        assert!(error < 4.0 * sigmas[i], "{name}: {} +- {}", found[i].1, sigmas[i]);
        assert!(sigmas[i] < 0.5, "{name} +- {}", sigmas[i]);
    }

    let html = fs::read_to_string(&report_file).unwrap();
    assert!(html.ends_with("</html>\n") && html.contains("kannala-brandt"));
    for outside in ["http:", "https:", "<script", "NaN"] {
        assert!(!html.contains(outside), "{outside}");
    }

    // The same on one thread, to the last byte.
    let before = read_folder(out.path());
    let again: Vec<&str> = outputs.into_iter().chain(["--threads", "1"]).collect();
    assert_eq!(calibrate(&images(), &again).ok().stdout, run.stdout);
    assert_eq!(read_folder(out.path()), before);
}

#[test]
fn lists_of_corners_do_as_well() {
    let (studio, board, mut random) = (Studio::new(fisheye()), board(), SplitMix64::new(21));
    let mut list = String::from("view,corner,x_px,y_px\n");
    for view in 0..8 {
        let pose = somewhere(&board, &mut random, [25.0, 40.0], 40.0, 45.0);
        for (id, pixel) in studio.in_sight(&board, &pose, 0.0).into_iter().enumerate() {
            let Some(pixel) = pixel else { continue };
            list += &format!("view {view},{id},{:.4},{:.4}\n", pixel.x, pixel.y);
        }
    }
    let out = tempfile::tempdir().unwrap();
    fs::write(out.path().join("corners.csv"), &list).unwrap();
    fs::write(out.path().join("board.json"), board.to_json()).unwrap();
    let arguments = [
        "calibrate",
        "intrinsics",
        "rtac0",
        "--board",
        "board.json",
        "--corners",
        "corners.csv",
        "-o",
        "camera.yaml",
    ];
    fabkit(out.path(), &arguments).ok();
    let text = fs::read_to_string(out.path().join("camera.yaml")).unwrap();
    let found = files::read(&text).unwrap().camera().lens().intrinsics();
    assert!((found.fx_px - 281.3).abs() < 1e-3, "{}", found.fx_px);

    let wrong = list.replacen("view 0,", "view 0,9999,1,", 1) + "view 3,7,nan,3\n";
    fs::write(out.path().join("corners.csv"), wrong).unwrap();
    let run = fabkit(out.path(), &arguments);
    assert_eq!(run.code, Some(2), "{run:?}");
    for text in ["corners.csv: line 2: 6 cells", "NaN px; the limits are"] {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}

#[test]
fn images_that_cannot_be_are_named_all_at_once() {
    let bad = tempfile::tempdir().unwrap();
    let path = |name: &str| bad.path().join(name).to_str().unwrap().to_owned();
    fs::write(path("text.png"), "no image").unwrap();
    save(&GreyImage::new(320, 240, vec![0.5; 320 * 240]).unwrap(), path("small.png"));
    let mut given = images();
    given.extend([path("text.png"), path("small.png"), path("missing.png"), given[3].clone()]);
    let output = path("camera.yaml");
    let run = calibrate(&given, &["-o", &output]);
    assert_eq!(run.code, Some(2), "{run:?}");
    let expected = [
        "text.png: not a readable PNG",
        "small.png: 320 x 240 px; the sensor's camera has 640 x 480 px",
        "missing.png",
        "3.png and 3.png are the same image",
    ];
    for text in expected {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
    assert!(!Path::new(&output).exists());
}

#[test]
fn images_without_the_board_are_not_enough() {
    let bad = tempfile::tempdir().unwrap();
    let path = |name: &str| bad.path().join(name).to_str().unwrap().to_owned();
    let plain = |value: f32| GreyImage::new(640, 480, vec![value; 640 * 480]).unwrap();
    save(&plain(1.0), path("white.png"));
    save(&plain(0.4), path("grey.png"));
    let given = [images()[0].clone(), path("white.png"), path("grey.png")];
    let run = calibrate(&given, &["-o", &path("camera.yaml")]);
    assert_eq!(run.code, Some(2), "{run:?}");
    let expected = [
        "views with at least 6 corners of the board: 1; 3 are needed",
        "white.png: 100 % of the image is saturated: lower the exposure",
        "grey.png: the image has no contrast",
    ];
    for text in expected {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
    assert!(!bad.path().join("camera.yaml").exists());
}
