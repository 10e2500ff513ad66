//! Halves calibrate as pins do: images of a few of them give the camera's place back, by the real binary.

use std::fs;
use std::path::Path;

use fabkit_application::calibration_runs::extrinsics::fixture_landmarks;
use fabkit_application::fixtures;
use fabkit_calibration::landmarks::PinLandmarks;
use fabkit_camera::files::{CameraFormat, write};
use fabkit_camera::{Camera, CameraEstimate};
use fabkit_designs::builtin_yaml;
use fabkit_tests::fabkit;
use rayon::prelude::*;
use serde_json::Value;

/// Every eighth of the hundred, on the right where this number is odd.
const HALVES: std::ops::Range<u32> = 1..13;

/// Writes the nominal lens, and says how far the sensor's origin is before the camera.
fn camera(root: &Path) -> f64 {
    let project = fixtures::load("rtac0", builtin_yaml("rtac0").unwrap(), &[]).unwrap();
    let nominal = &project.design.sensor.camera;
    let terms = nominal.lens.projection.terms();
    let field_rad = nominal.field_of_view.rad();
    let lens =
        Camera::from_data_sheet(nominal.width_px, nominal.height_px, field_rad, terms).unwrap();
    let lens = CameraEstimate::new(lens, None).unwrap();
    fs::write(root.join("camera.yaml"), write(&lens, CameraFormat::Fabkit).unwrap()).unwrap();
    fs::create_dir(root.join("halves")).unwrap();
    nominal.sensor_from_camera.inverse().translation_mm().z
}

fn take_captures(root: &Path) {
    let take = |words: &[&str]| {
        let same = ["capture", "rtac0", "--spacing", "0.5mm", "--quiet"];
        fabkit(root, &[&same[..], words].concat()).ok();
    };
    HALVES.into_par_iter().for_each(|k| {
        let name = format!("semi-dome-{:03}{}", 8 * k, ["", "-flipped"][k as usize % 2]);
        let (seed, file) = (k.to_string(), format!("halves/{name}.png"));
        take(&["--press", &name, "--seed", &seed, "-o", &file]);
    });
    take(&["--reference", "--seed", "99", "-o", "halves/ref.png"]);
}

#[test]
fn images_of_halves_tell_where_the_camera_is() {
    let root = tempfile::tempdir().unwrap();
    let drawn_mm = camera(root.path());
    take_captures(root.path());
    let words = ["calibrate", "extrinsics", "rtac0", "--camera", "camera.yaml", "--json"];
    let given = ["--captures", "halves", "--fixture", "semi-domes", "-o", "pose.yaml"];
    let report: Value = fabkit(root.path(), &[&words[..], &given].concat()).ok().json();
    assert_eq!(report["marks_rendered"], true);
    assert_eq!(report["within_tolerances"], true);
    let of = |value: &Value| value.as_f64().unwrap();
    let found_mm = of(&report["camera_from_sensor"][2][3]);
    let sigma_mm = of(&report["covariance"][5][5]).sqrt();
    println!("{found_mm:.3} mm +- {sigma_mm:.3}, drawn {drawn_mm}");
    assert!((found_mm - drawn_mm).abs() < 3.0 * sigma_mm && sigma_mm < 0.5);

    // The file that an export writes holds all of them, on either side.
    let project = fixtures::load("rtac0", builtin_yaml("rtac0").unwrap(), &[]).unwrap();
    let set = project.fixture("semi-domes").unwrap();
    let list = set.companions.iter().find(|file| file.name == "semi-domes.landmarks.json").unwrap();
    let list = PinLandmarks::from_json(std::str::from_utf8(list.bytes()).unwrap()).unwrap();
    assert_eq!(&list, fixture_landmarks(&set).unwrap());
    let on = |end: &str| {
        list.pins.iter().filter(|pin| pin.kind == format!("semi-dome-071{end}")).count()
    };
    assert!(on("") > 0 && on("") == on("-flipped"));
}

#[test]
fn names_that_are_no_halves_are_refused() {
    let root = tempfile::tempdir().unwrap();
    camera(root.path());
    for name in ["ref", "semi-dome-008", "a"] {
        fs::write(root.path().join(format!("halves/{name}.png")), "").unwrap();
    }
    let words = ["calibrate", "extrinsics", "rtac0", "--camera", "camera.yaml"];
    let given = ["--captures", "halves", "--fixture", "semi-domes", "-o", "pose.yaml"];
    let run = fabkit(root.path(), &[&words[..], &given].concat());
    assert_eq!(run.code, Some(2), "{run:?}");
    for said in ["semi-dome-001", "more"] {
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
    assert!(!root.path().join("pose.yaml").exists());
}
