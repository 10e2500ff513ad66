//! What a lens does to how bright and how sharp images are, where a sensor's file says it, by the real binary.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use fabkit_tests::contract::find_faults;
use fabkit_tests::fabkit;
use serde_json::Value;

const WIDTH: usize = 640;

/// What the command says of an image at rest without noise, and its intensities, of 65535.
fn at_rest(folder: &Path, sensor: &str, sets: &[&str]) -> (Value, Vec<f64>) {
    let sets: Vec<String> = sets.iter().map(|set| format!("--set=camera.{set}")).collect();
    let first = ["capture", sensor, "--reference", "--no-noise", "--bits=16", "--samples=1"];
    let output = ["-o", "a.png", "--json"];
    let sets = sets.iter().map(String::as_str);
    let all: Vec<&str> = first.into_iter().chain(output).chain(sets).collect();
    let json = fabkit(folder, &all).ok().json();
    assert!(find_faults(&json).is_empty(), "{:?}", find_faults(&json));
    let file = BufReader::new(File::open(folder.join("a.png")).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    let pairs = bytes.chunks(2).map(|pair| f64::from(u16::from_be_bytes([pair[0], pair[1]])));
    (json, pairs.collect())
}

#[test]
fn an_image_is_darker_off_the_axis_by_the_cosine_to_the_fourth() {
    let root = tempfile::tempdir().unwrap();
    let (plain, before) = at_rest(root.path(), "rtac0", &[]);
    let (said, after) = at_rest(root.path(), "rtac0", &["vignetting=4"]);
    let names = |said: &Value| said["constants"].to_string();
    assert!(!names(&plain).contains("vignetting_power"));
    assert!(names(&said).contains("vignetting_power"));
    assert!(plain["left_out"].to_string().contains("vignetting and defocus of the lens"));
    assert!(said["left_out"].to_string().contains("\"defocus of the lens\""));
    // An equisolid lens of 160 degrees over a diagonal of 800 px: r = 2 f sin(angle / 2).
    let twice_focal_px = 400.0 / 40.0_f64.to_radians().sin();
    let mut compared = 0;
    for (i, (before, after)) in before.iter().zip(&after).enumerate() {
        let [x, y] = [(i % WIDTH) as f64 - 319.5, (i / WIDTH) as f64 - 239.5];
        let angle = 2.0 * (x.hypot(y) / twice_focal_px).asin();
        // Both are rounded to whole numbers, half of one off at most.
        let said = before * angle.cos().powi(4);
        assert!((after - said).abs() <= 1.01, "{x}, {y}: {after}, {said}");
        compared += usize::from(said > 1000.0);
    }
    assert!(compared > 100_000, "{compared}");
}

/// Mean square of how far light of a marker is spread along a row, beside that in a sharp image, px^2.
fn spread(sharp: &[f64], blurred: &[f64], [x, y]: [usize; 2]) -> f64 {
    let near = || (y - 22..=y + 22).flat_map(|row| (x - 22..=x + 22).map(move |col| [col, row]));
    let at = |image: &[f64], [col, row]: [usize; 2]| image[row * WIDTH + col];
    let dark = near().map(|place| at(sharp, place)).fold(f64::INFINITY, f64::min);
    let whole: f64 = near().map(|place| at(sharp, place) - dark).sum();
    let middle =
        near().map(|place| (at(sharp, place) - dark) * place[0] as f64).sum::<f64>() / whole;
    let moment = |image: &[f64]| {
        near().map(|place| at(image, place) * (place[0] as f64 - middle).powi(2)).sum::<f64>()
    };
    (moment(blurred) - moment(sharp)) / whole
}

#[test]
fn markers_are_as_wide_as_a_thin_lens_makes_them() {
    let root = tempfile::tempdir().unwrap();
    let (said, sharp) = at_rest(root.path(), "fluidic", &[]);
    let pixel = |mark: &Value| [0, 1].map(|axis| mark["pixel"][axis].as_f64());
    let from_middle = |[x, y]: [f64; 2]| (x - 319.5).hypot(y - 239.5);
    let marks = said["marks"].as_array().unwrap().iter().map(pixel);
    let marks = marks.filter_map(|[x, y]| Some([x?, y?]));
    let mark = marks.min_by(|a, b| from_middle(*a).total_cmp(&from_middle(*b))).unwrap();
    let mark = mark.map(|px| px.round() as usize);
    // Variance of an even disk along one axis is a sixteenth of its diameter's square, and pixels add a twelfth (Sheppard).
    let diameter_px = |pupil_mm: f64, focus_mm: f64| {
        let sets = [format!("aperture={pupil_mm}mm"), format!("focus={focus_mm}mm")];
        let (_, blurred) = at_rest(root.path(), "fluidic", &[&sets[0], &sets[1]]);
        4.0 * (spread(&sharp, &blurred, mark) - 1.0 / 12.0).max(0.0).sqrt()
    };
    // Proportional to the aperture, and to the difference of one over distances: with the focus farther away than the
    // markers, the image at two foci says where they look to be, and the third follows.
    let pupil_mm = 1.5;
    let [far, farther, farthest] = [200.0, 400.0, 1e5].map(|focus| diameter_px(pupil_mm, focus));
    // 1 / x - 1 / focus: linear in 1 / focus.
    let slope = (farthest - far) / (1.0 / 200.0 - 1e-5);
    let said = far + slope * (1.0 / 200.0 - 1.0 / 400.0);
    assert!(far > 3.0, "{far}");
    // Beside binning, markers next to it may come in: a fiftieth.
    assert!((farther / said - 1.0).abs() < 0.02, "{farther}, {said}");
    let half = diameter_px(pupil_mm / 2.0, 1e5);
    assert!((2.0 * half / farthest - 1.0).abs() < 0.02, "{half}, {farthest}");
    // The slope is the aperture times what a radian is long: 80 degrees, equidistant, over a diagonal of 800 px. It comes
    // from a difference of a third of the diameters, each off by a fiftieth at most.
    let focal_px = 400.0 / 40.0_f64.to_radians();
    assert!((slope / pupil_mm / focal_px - 1.0).abs() < 0.06, "{slope}");
}

#[test]
fn bytes_are_the_same_on_one_and_on_two_threads_and_what_is_wrong_is_refused_at_its_line() {
    let root = tempfile::tempdir().unwrap();
    let image = |threads: &str| {
        let name = format!("{threads}.png");
        let command = ["capture", "tactip", "--reference", "--threads", threads, "-o", &name];
        let sets = ["--set=camera.aperture=2mm", "--set=camera.focus=40mm"];
        fabkit(root.path(), &[&command[..], &sets, &["--set=camera.vignetting=4"]].concat()).ok();
        fs::read(root.path().join(&name)).unwrap()
    };
    assert_eq!(image("1"), image("2"));
    for (key, value, limit) in
        [("vignetting", "9", "8"), ("aperture", "-1 mm", "0 mm"), ("focus", "0 mm", "1 mm")]
    {
        let own = format!("format: 1\nextends: tactip\nname: own\ncamera:\n  {key}: {value}\n");
        fs::write(root.path().join("own.yaml"), own).unwrap();
        let run = fabkit(root.path(), &["capture", "own.yaml", "--reference", "-o", "b.png"]);
        assert_eq!(run.code, Some(2), "{run:?}");
        for says in [&format!("camera.{key}"), "own.yaml:5", limit, "nearest allowed value"] {
            assert!(run.stderr.contains(says), "{says}: {}", run.stderr);
        }
        assert!(!root.path().join("b.png").exists());
    }
}
