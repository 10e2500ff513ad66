//! Fuzz targets. Each reads bytes of one kind and uses the result a little. None may panic, hang, or exceed the memory
//! limit of its runner.

use std::path::Path;
use std::sync::OnceLock;

use fabkit_application::calibration::board::{Board, find_corners, read_corners};
use fabkit_application::calibration::captures;
use fabkit_application::calibration::image::GreyImage;
use fabkit_application::calibration::landmarks::PinLandmarks;
use fabkit_application::calibration::pin_detection::{DetectionOptions, detect};
use fabkit_application::camera::Point2;
use fabkit_application::camera::files::{self, CameraFormat};
use fabkit_application::dataset::{SampleArray, read_patterns};
use fabkit_application::designs::builtin_yaml;
use fabkit_application::designs::profile::{MeasuredProfile, ProcessProfile};
use fabkit_application::fixtures::{Project, load};
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::network::Network;
use fabkit_application::sweep_runs;
use fabkit_application::text::{FileSafeName, Scalar};

/// Function with the name of its corpus, `tests/fuzz/corpus/NAME/`.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name of the corpus, and of the function.
    pub name: &'static str,
    /// Function that reads the bytes.
    pub run: fn(&[u8]),
}

/// All targets.
pub const TARGETS: [Target; 15] = [
    Target { name: "sensor", run: sensor },
    Target { name: "override", run: r#override },
    Target { name: "camera", run: camera },
    Target { name: "pose", run: pose },
    Target { name: "landmarks", run: landmarks },
    Target { name: "press", run: press },
    Target { name: "picture", run: picture },
    Target { name: "marks", run: marks },
    Target { name: "board", run: board },
    Target { name: "corners", run: corners },
    Target { name: "plan", run: plan },
    Target { name: "zarr", run: zarr },
    Target { name: "profile", run: profile },
    Target { name: "coupon", run: coupon },
    Target { name: "network", run: network },
];

/// Sensor to which the other inputs refer.
const SENSOR: &str = "rtac0";

fn project() -> Option<&'static Project> {
    static PROJECT: OnceLock<Option<Project>> = OnceLock::new();
    PROJECT.get_or_init(|| load(SENSOR, builtin_yaml(SENSOR)?, &[]).ok()).as_ref()
}

/// Reads a sensor file with its fixtures section, and builds one of the fixtures.
pub fn sensor(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    match load("fuzz.yaml", text, &[]) {
        Ok(project) => drop(project.fixture("coupon")),
        Err(invalid) => drop(invalid.to_string()),
    }
}

/// Reads arguments of `--set`, one per line.
pub fn r#override(data: &[u8]) {
    let (Ok(text), Some(yaml)) = (std::str::from_utf8(data), builtin_yaml(SENSOR)) else { return };
    let overrides: Vec<String> = text.lines().take(8).map(str::to_owned).collect();
    let _ = load(SENSOR, yaml, &overrides);
}

/// Reads a camera file in any notation, by the names that its corpus has.
pub fn camera(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let names = [None, Some("cam1"), Some("Camera2"), Some("right"), Some("2")];
    let Some(file) = names.into_iter().find_map(|name| files::read_file(text, name).ok()) else {
        return;
    };
    let _ = file.warnings();
    let estimate = file.estimate;
    let camera = estimate.camera();
    let [width, height] = [camera.width_px(), camera.height_px()].map(f64::from);
    for (x, y) in [(0.0, 0.0), (0.5, 0.5), (0.9, 0.1), (1.0, 1.0)] {
        let pixel = Point2::new(x * (width - 1.0), y * (height - 1.0));
        if let Ok(ray) = camera.unproject(&pixel) {
            let _ = camera.project(&ray.at(10.0));
        }
    }
    for format in
        [CameraFormat::Fabkit, CameraFormat::OpenCv, CameraFormat::Ros, CameraFormat::Kalibr]
    {
        let _ = files::write(&estimate, format);
    }
}

/// Reads a pose file.
pub fn pose(data: &[u8]) {
    let (Ok(text), Some(project)) = (std::str::from_utf8(data), project()) else { return };
    if let Ok(pose) = files::read_pose(text) {
        let _ = Viewpoint::new(&project.design.sensor.camera, None, Some(&pose));
    }
}

/// Reads a list of landmarks.
pub fn landmarks(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(landmarks) = PinLandmarks::from_json(text) {
        let _ = (landmarks.kinds(), landmarks.find(1, None), landmarks.to_json());
    }
}

/// Reads a list of presses; each line is also an argument of `--press`.
pub fn press(data: &[u8]) {
    let (Ok(text), Some(project)) = (std::str::from_utf8(data), project()) else { return };
    let _ = read_patterns(text, project);
    let finder = project.press_finder();
    text.lines().take(4).for_each(|id| drop(finder.press(id)));
}

/// Reads an image: of pins, of a board, or a capture.
pub fn picture(data: &[u8]) {
    // Larger images are skipped: detection would take too long.
    let _ = GreyImage::size_px(data).ok().filter(|px| px.iter().all(|px| *px <= 256)).map(|_| {
        let Ok(image) = GreyImage::read(data) else { return };
        let _ = find_corners(&image, a_board());
        let _ = detect(&image, &image.blurred(1.0), &DetectionOptions::default());
    });
}

/// Reads a depth network; a valid one is evaluated on a small image.
pub fn network(data: &[u8]) {
    if let Ok(network) = Network::read(data) {
        let _ = network.run(&[0.5; 12], 4);
        let _ = network.run_nonzero(&[0.0, 1.0], 2);
    }
}

/// Reads the list in a folder of pin captures.
pub fn marks(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = captures::read_list(text);
    text.lines().take(4).for_each(|name| drop(captures::holes_from_name(name)));
}

/// Reads a board file.
pub fn board(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(board) = Board::from_json(text) {
        let _ = (board.inner_corners(), board.to_json());
    }
}

/// Reads a list of a board's corners.
pub fn corners(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let _ = read_corners(text, a_board());
}

/// Reads a plan of a sweep of built-in sensors, and loads its last variant.
pub fn plan(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    // The folder does not exist: sensor files have their own target.
    if let Ok(plan) = sweep_runs::parse_plan("fuzz.yaml", text, Path::new("/nonexistent"), &[]) {
        let _ = plan.load(&plan.variant(plan.len() - 1));
    }
}

/// Reads the metadata of an array in a data set and one shard of it, separated by a line `---`.
pub fn zarr(data: &[u8]) {
    const BETWEEN: &[u8] = b"\n---\n";
    let at = data.windows(BETWEEN.len()).position(|window| window == BETWEEN);
    let (metadata, shard) =
        at.map_or((data, &data[data.len()..]), |at| (&data[..at], &data[at + BETWEEN.len()..]));
    let Ok(folder) = tempfile::tempdir() else { return };
    let place = folder.path().join("c/0/0");
    let written = std::fs::create_dir_all(&place)
        .and_then(|()| std::fs::write(folder.path().join("zarr.json"), metadata))
        .and_then(|()| std::fs::write(place.join("0"), shard));
    if written.is_ok()
        && let Ok(array) = SampleArray::open(folder.path())
    {
        let _ = (array.sample(0), array.sample(1), array.sample(usize::MAX));
    }
}

/// Reads a printer profile.
pub fn profile(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(profile) = ProcessProfile::read("fuzz.yaml", text) {
        let _ = (profile.scale(), profile.hole_mm(3.0), profile.to_yaml(&[]));
    }
}

/// Reads a coupon with measurements.
pub fn coupon(data: &[u8]) {
    let (Ok(text), Ok(name)) = (std::str::from_utf8(data), FileSafeName::parse("printer")) else {
        return;
    };
    if let Ok(measured) = MeasuredProfile::read("fuzz.yaml", text, &name) {
        let _ = measured.profile.to_yaml(&[]);
    }
}

/// Returns the board of the corpus.
fn a_board() -> &'static Board {
    static BOARD: OnceLock<Board> = OnceLock::new();
    BOARD.get_or_init(|| {
        let text = include_str!("../../corpus/board/charuco.json");
        Board::from_json(text).expect("the corpus has a board")
    })
}
