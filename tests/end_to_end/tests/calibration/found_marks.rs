//! A pin's mark is not its tip: images of pins, rendered from the drawn layers, give the camera's place back by the real
//! binary, and pixels of the same marks taken for tips do not.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use fabkit_application::calibration_runs::extrinsics::fixture_landmarks;
use fabkit_application::fixtures;
use fabkit_calibration::landmarks::PinLandmark;
use fabkit_camera::files::{CameraFormat, write};
use fabkit_camera::{Camera, CameraEstimate};
use fabkit_designs::builtin_yaml;
use fabkit_geometry::sequences::SplitMix64;
use fabkit_tests::fabkit;
use rayon::prelude::*;
use serde_json::Value;

const CAPTURES: usize = 5;
const PINS: usize = 5;
/// Nearer to each other pins are no two marks, mm.
const APART_MM: f64 = 6.0;

fn calibrate(root: &Path, folder: &str) -> Value {
    let first = ["calibrate", "extrinsics", "rtac0", "--camera", "camera.yaml", "--json"];
    fabkit(root, &[&first[..], &["--captures", folder, "-o", "pose.yaml"]].concat()).ok().json()
}

/// Where the sensor's origin is before the camera, mm, and one standard deviation of it.
fn distance_mm(report: &Value) -> [f64; 2] {
    let of = |value: &Value| value.as_f64().unwrap();
    [of(&report["camera_from_sensor"][2][3]), of(&report["covariance"][5][5]).sqrt()]
}

#[test]
fn rendered_pins_tell_where_the_camera_is_and_their_marks_alone_do_not() {
    let root = tempfile::tempdir().unwrap();
    let project = fixtures::load("rtac0", builtin_yaml("rtac0").unwrap(), &[]).unwrap();
    let nominal = &project.design.sensor.camera;
    let lens = Camera::from_data_sheet(
        nominal.width_px,
        nominal.height_px,
        nominal.field_of_view.rad(),
        nominal.lens.projection.terms(),
    );
    let lens = CameraEstimate::new(lens.unwrap(), None).unwrap();
    let text = write(&lens, CameraFormat::Fabkit).unwrap();
    fs::write(root.path().join("camera.yaml"), text).unwrap();
    let dome = project.fixture("pin-dome").unwrap();
    let pins = &fixture_landmarks(&dome).unwrap().pins;
    // Holes that the camera sees, apart from each other, of any length.
    let mut random = SplitMix64::new(5);
    let mut list = String::from("file,hole,kind\n");
    let mut presses = Vec::new();
    for capture in 0..CAPTURES {
        let mut chosen: Vec<&PinLandmark> = Vec::new();
        while chosen.len() < PINS {
            let pin = random.choose(pins);
            let place = pin.contact_in_sensor_mm;
            let is_apart =
                |o: &&PinLandmark| nalgebra::distance(&o.contact_in_sensor_mm, &place) > APART_MM;
            if pin.hole != 24 && pin.hole != 28 && chosen.iter().all(is_apart) {
                chosen.push(pin);
            }
        }
        for pin in &chosen {
            writeln!(list, "{capture}.png,{},{}", pin.hole, pin.kind).unwrap();
        }
        presses
            .push(chosen.iter().map(|p| format!("pin-{}-{}", p.hole, p.kind)).collect::<Vec<_>>());
    }
    fs::create_dir(root.path().join("pins")).unwrap();
    fs::write(root.path().join("pins/captures.csv"), &list).unwrap();
    presses.par_iter().enumerate().for_each(|(capture, presses)| {
        let (seed, name) = (capture.to_string(), format!("pins/{capture}.png"));
        let mut words = vec!["capture", "rtac0", "--seed", &seed, "-o", &name];
        words.extend(presses.iter().flat_map(|press| ["--press", press.as_str()]));
        fabkit(root.path(), &words).ok();
    });
    fabkit(root.path(), &["capture", "rtac0", "--reference", "--seed", "99", "-o", "pins/ref.png"])
        .ok();

    let report = calibrate(root.path(), "pins");
    assert_eq!(report["marks_rendered"], true);
    let name = report["model"]["name"].as_str().unwrap();
    assert!(name.starts_with("drawn") && !name.contains("radial"), "{name}");
    assert_eq!(report["within_tolerances"], true);
    let drawn_mm = nominal.sensor_from_camera.inverse().translation_mm().z;
    let [found_mm, sigma_mm] = distance_mm(&report);
    println!("{name}: {found_mm:.3} mm +- {sigma_mm:.3}, drawn {drawn_mm}");
    assert!((found_mm - drawn_mm).abs() < 3.0 * sigma_mm && sigma_mm < 0.5);

    // The same marks by their pixels: nobody knows whose detector found them.
    let mut pixels = String::from("file,hole,kind,x_px,y_px\n");
    for capture in report["captures"].as_array().unwrap() {
        let file = capture["file"].as_str().unwrap();
        for pin in capture["pins"].as_array().unwrap() {
            let hole = pin["hole"].as_u64().unwrap();
            let row = |line: &&str| line.starts_with(&format!("{file},{hole},"));
            let kind = list.lines().find(row).unwrap().rsplit(',').next().unwrap();
            writeln!(pixels, "{file},{hole},{kind},{},{}", pin["pixel"][0], pin["pixel"][1])
                .unwrap();
        }
    }
    fs::create_dir(root.path().join("tips")).unwrap();
    fs::write(root.path().join("tips/captures.csv"), pixels).unwrap();
    let report = calibrate(root.path(), "tips");
    assert_eq!(report["marks_rendered"], false);
    let [as_tips_mm, sigma_mm] = distance_mm(&report);
    println!("taken for tips: {as_tips_mm:.3} mm +- {sigma_mm:.3}");
    assert!((as_tips_mm - drawn_mm).abs() > 3.0 * (found_mm - drawn_mm).abs().max(0.3));
}
