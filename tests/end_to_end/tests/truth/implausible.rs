//! Images that cannot be what they are taken for, by the real binary: each has the right size, and a wrong result.

use std::fs;
use std::path::Path;

use fabkit_application::export::{grey16_png, png};
use fabkit_application::network::writer::{ChainLayer, write_chain};
use fabkit_application::reconstructing::CapturedImage;
use fabkit_tests::contract::find_faults;
use fabkit_tests::fabkit;
use serde_json::Value;

/// A quarter of the pixels shows as much, in a quarter of the time.
const SMALL: [&str; 4] = ["--set", "camera.width_px=320", "--set", "camera.height_px=240"];
/// The same for a flat gel, whose camera says how large a pixel is.
const SMALL_PAD: [&str; 6] = [
    "--set",
    "camera.width_px=320",
    "--set",
    "camera.height_px=240",
    "--set",
    "camera.pixel_pitch=0.06mm",
];

fn capture(folder: &Path, sensor: &[&str], words: &[&str], name: &str) -> CapturedImage {
    fabkit(folder, &[&["capture"][..], sensor, words, &["-q", "-o", name]].concat()).ok();
    CapturedImage::read(&folder.join(name)).unwrap()
}

/// Writes an image in colour, each pixel taken from another place, and its colours in another order.
fn write_rearranged(
    path: &Path,
    image: &CapturedImage,
    from: impl Fn([usize; 2]) -> [usize; 2],
    colors: [usize; 3],
) {
    let [width, height] = image.size_px;
    let pixel = |i: usize| {
        let [x, y] = from([i % width, i / width]);
        colors.map(|k| (255.0 * image.values[3 * (y * width + x) + k]).round() as u8)
    };
    let rgb: Vec<u8> = (0..width * height).flat_map(pixel).collect();
    fs::write(path, png(width as u32, height as u32, &rgb).unwrap()).unwrap();
}

/// Runs `reconstruct` and returns its document, and the codes of its findings.
fn reconstruct(folder: &Path, words: &[&str], code: i32) -> (Value, Vec<String>) {
    let run = fabkit(folder, &[&["reconstruct"][..], words, &["-o", "out", "--json"]].concat());
    assert_eq!(run.code, Some(code), "{words:?}: {} {}", run.stdout, run.stderr);
    let json = run.json();
    assert!(find_faults(&json).is_empty(), "{:?}", find_faults(&json));
    let findings = json["plausibility"]["findings"].as_array().unwrap();
    let codes = findings.iter().map(|one| one["code"].as_str().unwrap().to_owned()).collect();
    (json, codes)
}

#[test]
fn colored_images_that_cannot_be_right_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    let digit = [&["digit-like"][..], &SMALL_PAD].concat();
    let other = [&["gelsight-like"][..], &SMALL_PAD].concat();
    let rest = capture(folder, &digit, &["--reference"], "rest.png");
    let press = ["--press", "ball@0mm,0mm,0.5mm"];
    let pressed = capture(folder, &digit, &press, "pressed.png");
    capture(folder, &other, &["--reference"], "other.png");
    let turned = |[x, y]: [usize; 2]| [319 - x, 239 - y];
    for (name, image) in [("rest", &rest), ("pressed", &pressed)] {
        let path = |what: &str| folder.join(format!("{name}_{what}.png"));
        write_rearranged(&path("bgr"), image, |at| at, [2, 1, 0]);
        write_rearranged(&path("turned"), image, turned, [0, 1, 2]);
    }
    let words = |reference, image| [&digit[..], &["--reference", reference, image]].concat();

    let (json, codes) = reconstruct(folder, &words("rest.png", "pressed.png"), 0);
    assert!(codes.is_empty() && json["written"] == true, "{json:#}");
    // A tenth of 0.5 mm is what reconstruction may be off; see docs/capture.md.
    let deepest_mm = json["files"][0]["deepest_mm"].as_f64().unwrap();
    assert!((deepest_mm - 0.5).abs() < 0.05, "{deepest_mm}");
    let not_known = json["plausibility"]["not_known"].as_array().unwrap();
    assert!(not_known.iter().any(|one| one["what"] == "mirrored_with_exchanged_colors"));
    fs::remove_dir_all(folder.join("out")).unwrap();

    for (reference, image, expected, told) in [
        ("other.png", "pressed.png", "other_light", "the light is not that of this sensor"),
        ("rest.png", "pressed_bgr.png", "rearranged", "red and blue exchanged"),
        ("rest_bgr.png", "pressed_bgr.png", "rearranged", "red and blue exchanged"),
        ("rest_turned.png", "pressed_turned.png", "rearranged", "turned by 180 degrees"),
        ("rest.png", "pressed_turned.png", "rearranged", "turned by 180 degrees"),
    ] {
        let words = words(reference, image);
        let (json, codes) = reconstruct(folder, &words, 1);
        assert!(codes.iter().any(|code| code == expected), "{reference} {image}: {codes:?}");
        let findings = &json["plausibility"]["findings"];
        assert!(findings.to_string().contains(told), "{findings:#}");
        // 20 mm of a pad of 3 mm.
        let is_deep = codes.iter().any(|code| code == "too_deep");
        assert!(is_deep || reference != "other.png", "{codes:?}");
        assert!(json["written"] == false && !folder.join("out").exists());
        // People read it, too, in short lines.
        let run = fabkit(folder, &[&["reconstruct"][..], &words, &["-o", "out"]].concat());
        assert!(run.code == Some(1) && run.stdout.contains(told), "{}", run.stdout);
        assert!(run.stdout.lines().all(|line| line.len() <= 200), "{}", run.stdout);
    }
    let (json, codes) = reconstruct(
        folder,
        &[&words("rest_bgr.png", "pressed_bgr.png")[..], &["--force"]].concat(),
        0,
    );
    assert!(!codes.is_empty() && json["written"] == true);
    assert!(folder.join("out/pressed_bgr.npz").exists());
}

#[test]
fn twelve_bits_in_sixteen_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    let sensor = [&["rtac0"][..], &SMALL].concat();
    for (name, words) in
        [("rest", &["--reference"][..]), ("pressed", &["--press", "ball@24deg,120deg,1mm"])]
    {
        let file = format!("{name}.png");
        let image = capture(folder, &sensor, words, &file);
        let [width, height] = image.size_px.map(|px| px as u32);
        let codes: Vec<u16> =
            image.clone().grey().iter().map(|value| (4095.0 * value).round() as u16).collect();
        let bytes = grey16_png(width, height, &codes).unwrap();
        fs::write(folder.join(format!("{name}12.png")), bytes).unwrap();
    }
    let words = |reference, image| [&sensor[..], &["--reference", reference, image]].concat();
    let (json, codes) = reconstruct(folder, &words("rest.png", "pressed.png"), 0);
    assert!(codes.is_empty());
    // Nothing that was not compared counts as passed.
    let not_known = json["plausibility"]["not_known"].as_array().unwrap();
    for what in ["order_of_colors", "turn", "other_sensor"] {
        assert!(not_known.iter().any(|one| one["what"] == what), "{what}: {not_known:?}");
    }
    for (reference, image) in [("rest12.png", "pressed12.png"), ("rest.png", "pressed12.png")] {
        let (json, codes) = reconstruct(folder, &words(reference, image), 1);
        assert!(codes.iter().any(|code| code == "narrow_range"), "{codes:?}");
        let findings = json["plausibility"]["findings"].to_string();
        assert!(findings.contains("12 bits, multiply the values by 16"), "{findings}");
    }
}

#[test]
fn networks_that_divide_by_zero_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    let image = |dark: u8| {
        let square = |i: usize| (220..260).contains(&(i / 640)) && (300..340).contains(&(i % 640));
        let grey = (0..640 * 480).map(|i| if square(i) { 120 - dark } else { 120 });
        png(640, 480, &grey.flat_map(|grey| [grey; 3]).collect::<Vec<u8>>()).unwrap()
    };
    fs::write(folder.join("rest.png"), image(0)).unwrap();
    fs::write(folder.join("pressed.png"), image(26)).unwrap();
    let network = [
        ChainLayer::operator("Div").with_constant(&[1], &[0.0]),
        ChainLayer::convolution([1, 1, 1, 1], 1, &[1.0], &[0.0]),
    ];
    fs::write(folder.join("net.onnx"), write_chain(&network)).unwrap();
    let words = ["reconstruct", "rtac0", "--network", "net.onnx", "--reference", "rest.png"];
    let run =
        fabkit(folder, &[&words[..], &["pressed.png", "-o", "out", "--force", "--json"]].concat());
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    let problem = &run.json()["problems"][0];
    assert_eq!(problem["code"], "bad_network");
    let message = problem["message"].as_str().unwrap();
    // The square, and what the blur of 5 px carries outwards: 40 x 40 to 44 x 44 pixels.
    let count: usize = message
        .split(": ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .and_then(|count| count.parse().ok())
        .unwrap();
    assert!((1600..=1936).contains(&count), "{message}");
    assert!(
        message.contains("of 307200 depths") && message.contains("the first is inf"),
        "{message}"
    );
    assert!(!folder.join("out").exists());
}

#[test]
fn fits_of_light_say_what_they_can_fit() {
    let root = tempfile::tempdir().unwrap();
    fs::create_dir(root.path().join("balls")).unwrap();
    for name in ["ref.png", "1.png"] {
        let bytes = png(64, 64, &[120; 3 * 64 * 64]).unwrap();
        fs::write(root.path().join("balls").join(name), bytes).unwrap();
    }
    for sensor in ["digit-like", "gelsight-like"] {
        let words = [
            "fit-light",
            sensor,
            "--ball-diameter",
            "6mm",
            "--scale",
            "0.06mm",
            "--captures",
            "balls",
        ];
        let run = fabkit(root.path(), &words);
        assert_eq!(run.code, Some(2));
        let told = "only translucent layers can be fitted";
        assert!(
            run.stderr.contains(told) && run.stderr.contains("slopes of a coat"),
            "{}",
            run.stderr
        );
        assert!(!run.stderr.contains("built-in sensor"), "{}", run.stderr);
    }
}
