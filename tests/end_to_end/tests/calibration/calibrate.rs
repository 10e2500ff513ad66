//! `fabkit calibrate`, end to end on synthetic images.

use std::fs;
use std::path::Path;

use fabkit_calibration::landmarks::{PinLandmark, PinLandmarks};
use fabkit_calibration::model::Model;
use fabkit_calibration::synthetic::SyntheticSensor;
use fabkit_camera::files::{self, CameraFormat};
use fabkit_camera::{Camera, CameraEstimate, DMatrix};
use fabkit_fixtures::DrawnBodies;
use fabkit_geometry::{Angle, Point3, Pose, Vector3};
use fabkit_tests::{Run, build_design, fabkit};
use serde_json::Value;

const CAPTURES: [[u32; 5]; 4] =
    [[1, 2, 6, 14, 22], [1, 3, 8, 17, 25], [1, 5, 12, 20, 28], [2, 4, 9, 16, 23]];

/// 29 pins on a 15 mm dome about (0, 0, 6).
fn landmarks() -> PinLandmarks {
    let mut pins = Vec::new();
    for (polar_deg, count) in [(0.0f64, 1), (14.0, 4), (28.0, 8), (41.0, 8), (53.0, 8)] {
        for k in 0..count {
            let (s, c) = polar_deg.to_radians().sin_cos();
            let (sa, ca) = (f64::from(k) * std::f64::consts::TAU / f64::from(count)).sin_cos();
            let outward = Vector3::new(s * ca, s * sa, c);
            let contact = Point3::new(0.0, 0.0, 6.0) + outward * 14.5;
            pins.push(PinLandmark {
                hole: pins.len() as u32 + 1,
                kind: "short".into(),
                tip_centre_in_sensor_mm: contact + outward,
                contact_in_sensor_mm: contact,
                axis_in_sensor: Some(-outward),
            });
        }
    }
    PinLandmarks::new("rtac0", "pin-dome", 1.0, pins).unwrap()
}

fn name_of(holes: &[u32]) -> String {
    let words: Vec<String> = holes.iter().map(|hole| format!("{hole:02}")).collect();
    words.join("_") + ".png"
}

/// A folder with everything a calibration needs, and the truth.
struct Setup {
    root: tempfile::TempDir,
    truth: Pose,
}

impl Setup {
    fn new() -> Self {
        let root = tempfile::tempdir().unwrap();
        let camera = Camera::equidistant(640, 480, 160f64.to_radians()).unwrap();
        let quarter = Angle::from_deg(91.0).unwrap();
        let truth = Pose::translation(0.4, -0.3, 7.5).then_in(Pose::rotation_z(quarter));
        let landmarks = landmarks();
        // A unit that is as drawn.
        let bodies = DrawnBodies::new(&build_design("rtac0", &[]).sensor, &camera).unwrap();
        let mut model =
            Model::new(camera, truth).with_drawn_interface(&bodies.interface().unwrap()).unwrap();
        let contacts: Vec<_> = landmarks.pins.iter().map(|pin| pin.contact_in_sensor_mm).collect();
        model.displacements = bodies.displacements(&truth, &contacts);
        let mut bench = SyntheticSensor::new(model, 2);
        bench.play_mm = 0.05;
        let folder = root.path().join("captures");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("ref.png"), bench.reference(1.0).unwrap().to_png()).unwrap();
        for (i, holes) in CAPTURES.iter().enumerate() {
            let pins: Vec<&PinLandmark> =
                holes.iter().map(|hole| landmarks.find(*hole, None).unwrap()).collect();
            let light = 0.9 + 0.05 * i as f64;
            let capture = bench.capture(i, &pins, light).unwrap();
            fs::write(folder.join(name_of(holes)), capture.image.to_png()).unwrap();
        }
        let estimate = CameraEstimate::new(camera, None).unwrap();
        let text = files::write(&estimate, CameraFormat::Fabkit).unwrap();
        fs::write(root.path().join("camera.yaml"), text).unwrap();
        fs::write(root.path().join("landmarks.json"), landmarks.to_json()).unwrap();
        Self { root, truth }
    }

    fn path(&self) -> &Path {
        self.root.path()
    }

    fn capture(&self, name: &str) -> std::path::PathBuf {
        self.path().join("captures").join(name)
    }

    fn calibrate(&self, more: &[&str]) -> Run {
        let args = [
            &["calibrate", "extrinsics", "rtac0", "--camera", "camera.yaml"][..],
            &["--captures", "captures", "--landmarks", "landmarks.json", "-o", "pose.yaml"],
            more,
        ];
        fabkit(self.path(), &args.concat())
    }

    /// Must fail as bad input, without a file.
    fn refused(&self, more: &[&str]) -> String {
        let run = self.calibrate(more);
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(!self.path().join("pose.yaml").exists());
        assert!(!self.path().join("pose.camera.yaml").exists());
        run.stderr
    }
}

#[test]
fn a_camera_of_another_size_than_the_captures_is_refused() {
    let setup = Setup::new();
    let camera = Camera::equidistant(1280, 960, 160f64.to_radians()).unwrap();
    let text = files::write(&camera.into(), CameraFormat::Fabkit).unwrap();
    fs::write(setup.path().join("camera.yaml"), text).unwrap();
    let error = setup.refused(&[]);
    let expected = "the captures have 640 x 480 px, the camera is that of images of 1280 x 960 px";
    assert!(error.contains(expected), "{error}");
}

#[test]
fn images_become_a_pose_with_a_report() {
    let setup = Setup::new();
    let run = setup.calibrate(&["--report", "report.html", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((&report["format"], &report["version"]), (&"fabkit-extrinsics".into(), &1.into()));
    let captures = report["captures"].as_array().unwrap();
    assert_eq!(captures.len(), CAPTURES.len());
    assert!(captures.iter().all(|c| c["pins_found"] == 5 && c["pins_used"] == 5));
    // Play of 0.05 mm is about half a pixel here.
    for key in ["reprojection_rms_px", "held_out_rms_px"] {
        assert!((0.3..2.0).contains(&report[key].as_f64().unwrap()), "{key}: {}", report[key]);
    }
    for r in 0..3 {
        let shift_mm = report["camera_from_sensor"][r][3].as_f64().unwrap();
        let sigma_mm = report["covariance"][r + 3][r + 3].as_f64().unwrap().sqrt();
        let error_mm = shift_mm - setup.truth.translation_mm()[r];
        assert!(error_mm.abs() < 4.0 * sigma_mm && sigma_mm < 0.5, "{error_mm} {sigma_mm}");
    }
    // The pose names its camera, which reads back.
    let pose = fs::read_to_string(setup.path().join("pose.yaml")).unwrap();
    assert!(pose.contains("camera: \"pose.camera.yaml\""), "{pose}");
    files::read(&fs::read_to_string(setup.path().join("pose.camera.yaml")).unwrap()).unwrap();
    // One file, no network, no script.
    let html = fs::read_to_string(setup.path().join("report.html")).unwrap();
    for needless in ["http", "<script", "<link", "<img", "NaN", "inf"] {
        assert!(!html.contains(needless), "{needless}");
    }
    assert!(html.contains("01_02_06_14_22.png"));
    // The same input gives the same bytes, on any number of threads.
    let again = setup.calibrate(&["--report", "report.html", "--json", "--threads", "1"]);
    assert_eq!(again.stdout, run.stdout);
    assert_eq!(fs::read_to_string(setup.path().join("report.html")).unwrap(), html);
}

/// What the lens's calibration did not know reaches ground truth, together with the pose; files that
/// do not belong together, and files of before, are taken for independent, and that is said.
#[test]
fn the_lens_and_the_pose_are_unsure_together() {
    let setup = Setup::new();
    let write = |name: &str, text: &str| fs::write(setup.path().join(name), text).unwrap();
    let read = |name: &str| fs::read_to_string(setup.path().join(name)).unwrap();
    let alone = setup.calibrate(&["--json"]).ok().json();
    let exact = "camera.yaml states no covariance";
    assert!(alone["warnings"].to_string().contains(exact), "{}", alone["warnings"]);
    let camera = *files::read(&read("camera.yaml")).unwrap().camera();
    let mut covariance = DMatrix::zeros(8, 8);
    for (i, sigma) in [1.0, 1.0, 0.5, 0.5, 0.01].into_iter().enumerate() {
        covariance[(i, i)] = f64::powi(sigma, 2);
    }
    let estimate = CameraEstimate::new(camera, Some(covariance)).unwrap();
    write("camera.yaml", &files::write(&estimate, CameraFormat::Fabkit).unwrap());
    let report = setup.calibrate(&["--json"]).ok().json();
    assert!(!report["warnings"].to_string().contains(exact));
    // The pose is what it was, and less sure.
    assert_eq!(report["camera_from_sensor"], alone["camera_from_sensor"]);
    let variance = |report: &Value| report["covariance"][5][5].as_f64().unwrap();
    assert!(variance(&report) > 1.05 * variance(&alone));
    let names = report["joint_covariance"]["names"].as_array().unwrap();
    assert_eq!(
        (names.len(), &names[5], &names[6]),
        (18, &"translation_z_mm".into(), &"fx_px".into())
    );

    let depth = |more: &[&str]| {
        let args = ["depth", "rtac0", "--reference", "--json", "-o", "a.npz"];
        let json = fabkit(setup.path(), &[&args[..], more].concat()).ok().json();
        (json["sigma_of"].as_str().unwrap().to_owned(), json["median_sigma_mm"].as_f64().unwrap())
    };
    let pose = ["--pose", "pose.yaml", "--print-sigma", "0mm"];
    let (together, sigma_mm) = depth(&pose);
    assert_eq!(together, "pose, lens, interface, shape");
    // The camera file beside it is the same camera, by whatever name it comes.
    let named = [&pose[..], &["--camera", "pose.camera.yaml"]].concat();
    assert_eq!(depth(&named), (together, sigma_mm));
    let apart = "pose, lens, interface, shape; pose and camera as if independent";
    let text = read("pose.yaml");
    let (before, _) = text.split_once("joint_covariance:").unwrap();
    write("pose.yaml", before);
    let (of_before, apart_mm) = depth(&pose);
    assert_eq!(of_before, apart);
    assert!((apart_mm / sigma_mm - 1.0).abs() > 0.02, "{apart_mm} {sigma_mm}");
    write("pose.yaml", &text);
    write("other.yaml", &read("pose.camera.yaml").replace("k4: 0.0", "k4: 1.0e-9"));
    let other = [&pose[..], &["--camera", "other.yaml"]].concat();
    assert_eq!(depth(&other).0, apart);
    // A lens alone does not see what a lens behind gel saw.
    let mixed = ["depth", "rtac0", "--reference", "-o", "b.npz", "--camera", "camera.yaml"];
    let run = fabkit(setup.path(), &[&mixed[..], &pose].concat());
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("contains the interface; the camera given has none"), "{run:?}");
    let alone = format!("{}interface:\n  kind: drawn\n", read("camera.yaml"));
    write("alone.yaml", &alone);
    let mixed = ["depth", "rtac0", "--reference", "-o", "b.npz", "--camera", "alone.yaml"];
    let run = fabkit(setup.path(), &[&mixed[..], &pose].concat());
    assert_eq!(run.code, Some(2), "{run:?}");
    assert!(run.stderr.contains("the camera given has a drawn one"), "{run:?}");
    assert_eq!(depth(&["--camera", "camera.yaml"]).0, "lens, shape");
}

#[test]
fn a_list_says_which_pins_and_where() {
    let setup = Setup::new();
    let found = fabkit(
        setup.path(),
        &[
            "calibrate",
            "pins",
            "--reference",
            "captures/ref.png",
            "captures/01_02_06_14_22.png",
            "--json",
        ],
    );
    let pins: Value = serde_json::from_str(&found.stdout).unwrap();
    assert_eq!(pins["images"][0]["pins"].as_array().unwrap().len(), 5);
    // The names no longer say it; the list does.
    let mut list = String::from("file,hole,kind\n");
    for (i, holes) in CAPTURES.iter().enumerate() {
        fs::rename(setup.capture(&name_of(holes)), setup.capture(&format!("{i}.png"))).unwrap();
        for hole in holes {
            list += &format!("{i}.png,{hole},short\n");
        }
    }
    fs::write(setup.capture("captures.csv"), list).unwrap();
    assert_eq!(setup.calibrate(&[]).code, Some(0));
}

#[test]
fn a_wrong_label_is_named() {
    let setup = Setup::new();
    let wrong = "01_02_06_14_23.png";
    fs::rename(setup.capture("01_02_06_14_22.png"), setup.capture(wrong)).unwrap();
    let run = setup.calibrate(&[]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let sentence = "01_02_06_14_23.png: the label says hole 23, but the mark is at hole 22";
    assert!(run.stdout.contains(sentence), "{}", run.stdout);
}

#[test]
fn bad_captures_are_refused_by_name() {
    let setup = Setup::new();
    let first = setup.capture("01_02_06_14_22.png");
    let good = fs::read(&first).unwrap();
    let reference = fs::read(setup.capture("ref.png")).unwrap();

    fs::write(&first, &good[..500]).unwrap();
    let message = setup.refused(&[]);
    assert!(message.contains("01_02_06_14_22.png: not a readable PNG"), "{message}");
    fs::write(&first, &reference).unwrap();
    let message = setup.refused(&[]);
    assert!(message.contains("the image is the reference itself"), "{message}");
    fs::write(&first, &good).unwrap();

    fs::write(setup.capture("01_99.png"), &good).unwrap();
    let message = setup.refused(&[]);
    assert!(message.contains("01_99.png: the landmarks have no hole 99"), "{message}");
    fs::remove_file(setup.capture("01_99.png")).unwrap();

    let message = setup.refused(&["--pin", "long"]);
    assert!(message.contains("has no pin of kind `long`"), "{message}");
    assert!(message.contains("its kinds are: short"), "{message}");

    fs::remove_file(setup.capture("ref.png")).unwrap();
    let message = setup.refused(&[]);
    assert!(message.contains("no image without contact"), "{message}");
    assert!(message.contains("--reference"), "{message}");
}

#[test]
fn bad_files_are_refused_with_the_place() {
    let setup = Setup::new();
    let write = |name: &str, text: &str| fs::write(setup.path().join(name), text).unwrap();
    let good = fs::read_to_string(setup.path().join("camera.yaml")).unwrap();
    write("camera.yaml", "just: text\n");
    assert!(setup.refused(&[]).contains("no camera file that fabkit knows"));
    write("camera.yaml", &good);
    write("landmarks.json", "{\"1\": [0, 0]}");
    assert!(setup.refused(&[]).contains("landmarks.json: not a list of pin landmarks: hole 1"));
    write("landmarks.json", &landmarks().to_json());
    let empty = fabkit(
        setup.path(),
        &[
            "calibrate",
            "extrinsics",
            "rtac0",
            "--camera",
            "camera.yaml",
            "--captures",
            "nowhere",
            "--landmarks",
            "landmarks.json",
            "-o",
            "pose.yaml",
        ],
    );
    assert!(empty.stderr.contains("cannot read"), "{}", empty.stderr);
}

/// A sensor with a flat pad takes the landmarks of its own pin plate.
#[test]
fn marks_of_a_flat_sensor_s_own_plate_become_its_pose() {
    let root = tempfile::tempdir().unwrap();
    let yaml = fabkit_designs::builtin_yaml("9dtact").unwrap();
    let project = fabkit_fixtures::load("9dtact", yaml, &[]).unwrap();
    let plate = project.fixture(project.pin_fixture_name()).unwrap();
    let file = plate.companions.iter().find(|c| c.name == "pin-plate.landmarks.json").unwrap();
    let landmarks = PinLandmarks::from_json(std::str::from_utf8(file.bytes()).unwrap()).unwrap();
    let nominal = &project.design.sensor.camera;
    let size = [nominal.width_px, nominal.height_px];
    let camera = Camera::equidistant(size[0], size[1], nominal.field_of_view.rad()).unwrap();
    let turn = |deg: f64| Angle::from_deg(deg).unwrap();
    let off = Pose::translation(0.2, -0.1, 0.15).then_in(Pose::rotation_x(turn(1.0)));
    let truth = off.then_in(nominal.sensor_from_camera.inverse());
    let estimate = CameraEstimate::new(camera, None).unwrap();
    let text = files::write(&estimate, CameraFormat::Fabkit).unwrap();
    fs::write(root.path().join("camera.yaml"), text).unwrap();
    let mut list = String::from("file,hole,kind,x_px,y_px\n");
    for (i, pin) in landmarks.pins.iter().enumerate() {
        let at = camera.project(&truth.point(pin.contact_in_sensor_mm)).unwrap();
        list += &format!("{}.png,{},{},{},{}\n", i % 8, pin.hole, pin.kind, at.x, at.y);
    }
    fs::create_dir(root.path().join("captures")).unwrap();
    fs::write(root.path().join("captures/captures.csv"), list).unwrap();
    let run = fabkit(
        root.path(),
        &[
            &["calibrate", "extrinsics", "9dtact", "--camera", "camera.yaml", "--json"][..],
            &["--captures", "captures", "-o", "pose.yaml"],
        ]
        .concat(),
    );
    let report = run.ok().json();
    for r in 0..3 {
        let shift_mm = report["camera_from_sensor"][r][3].as_f64().unwrap();
        let error_mm = shift_mm - truth.translation_mm()[r];
        // Exact marks: what is left is the solver's last step.
        assert!(error_mm.abs() < 1e-3, "{r}: {error_mm} mm");
    }
}
