//! Images that a sensor's camera would take, by the real binary.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use fabkit_tests::contract::find_faults;
use fabkit_tests::fabkit;
use serde_json::Value;

/// An image with its columns and what its file says of itself.
struct Image {
    /// Of 65535 or 255, row by row.
    grey: Vec<f64>,
    comment: String,
}

fn picture(path: &Path) -> Image {
    let mut reader =
        png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let grey = match info.bit_depth {
        png::BitDepth::Eight => bytes.iter().map(|byte| f64::from(*byte)).collect(),
        _ => {
            bytes.chunks(2).map(|pair| f64::from(u16::from_be_bytes([pair[0], pair[1]]))).collect()
        }
    };
    let comment = reader.info().uncompressed_latin1_text[0].text.clone();
    Image { grey, comment }
}

fn capture(folder: &Path, sensor: &str, more: &[&str], name: &str) -> (Value, Image) {
    let first = ["capture", sensor, "-o", name, "--json"];
    let json = fabkit(folder, &[&first[..], more].concat()).ok().json();
    assert!(find_faults(&json).is_empty(), "{:?}", find_faults(&json));
    (json, picture(&folder.join(name)))
}

/// What an image rests on.
fn constant(said: &Value, name: &str) -> f64 {
    let mut constants = said["constants"].as_array().unwrap().iter();
    constants.find(|constant| constant["name"] == name).unwrap()["value"].as_f64().unwrap()
}

const EXACT: [&str; 5] = ["--no-noise", "--bits", "16", "--constants", "light.json"];

/// A unit whose layer spreads no light sideways, so that each pixel tells its own thickness.
const LIGHT: &str = r#"{"format": "fabkit-fit-light", "version": 1, "captures": 3, "held_out_profile_rms_grey": 0.5,
"constants": [{"name": "layer_grey", "value": 127}, {"name": "ground_grey", "value": 111},
{"name": "scatter_per_mm", "value": 0.39}, {"name": "spread_mm", "value": 1e-6}]}"#;

#[test]
fn a_press_is_as_dark_as_its_layer_is_thin() {
    let root = tempfile::tempdir().unwrap();
    std::fs::write(root.path().join("light.json"), LIGHT).unwrap();
    let of =
        |more: &[&str], name: &str| capture(root.path(), "rtac0", &[more, &EXACT].concat(), name);
    let (_, rest) = of(&["--reference"], "rest.png");
    let press = ["--press", "hemisphere@0deg,0deg,0.8mm"];
    let (said, rigid) = of(&[&press[..], &["--contact", "rigid"]].concat(), "rigid.png");
    let of_layer = |name: &str| constant(&said, name);
    let sent = |mm: f64| {
        let scattered = of_layer("scatter_per_mm") * mm;
        of_layer("ground_grey") + of_layer("layer_grey") * scattered / (1.0 + scattered)
    };
    // Drawn 1.5 mm thick with a coat of 0.05 mm in it.
    let ratios = || rigid.grey.iter().zip(&rest.grey).map(|(now, before)| now / before);
    let darkest = ratios().fold(1.0, f64::min);
    let expected = sent(1.45 - 0.8) / sent(1.45);
    // A pixel is 0.1 mm: the deepest place lies within half of one, where a ball of 4 mm has come off by 1 um.
    assert!((darkest / expected - 1.0).abs() < 1e-3, "{darkest} {expected}");
    // What follows the indenter and nothing else makes nothing brighter.
    assert!(ratios().all(|ratio| ratio < 1.0 + 1e-4));
    assert!((said["thickness_mm"][0].as_f64().unwrap() - 0.65).abs() < 2e-3);

    // Gel that is pushed aside does: around the contact it is thicker than at rest.
    let (said, linear) = of(&press, "linear.png");
    let brightest =
        linear.grey.iter().zip(&rest.grey).map(|(now, before)| now / before).fold(0.0, f64::max);
    let bulge_mm = said["elastic"]["bulge_mm"].as_f64().unwrap();
    assert!(bulge_mm > 0.05 && said["contact_level"] == "linear");
    let expected = sent(1.45 + bulge_mm) / sent(1.45);
    assert!(
        brightest > 1.0 + 0.8 * (expected - 1.0) && brightest < expected + 1e-3,
        "{brightest} {expected}"
    );
}

#[test]
fn images_say_what_they_are_and_are_the_same_again() {
    let root = tempfile::tempdir().unwrap();
    let press = ["--press", "ball@1mm,-2mm,1mm", "--spacing", "0.8mm"];
    let of = |more: &[&str], name: &str| {
        let (_, picture) = capture(root.path(), "9dtact", &[&press[..], more].concat(), name);
        (picture, std::fs::read(root.path().join(name)).unwrap())
    };
    let (said, _) = capture(root.path(), "9dtact", &press, "said.png");
    let (first, bytes) = of(&["--seed", "3"], "a.png");
    for word in
        ["simulated by fabkit: 9dtact", "ball@1mm,-2mm,1mm", "linear contact", "seed 3", "design "]
    {
        assert!(first.comment.contains(word), "{}", first.comment);
    }
    let (_, again) = of(&["--seed", "3", "--threads", "1"], "b.png");
    assert!(bytes == again, "another image on another number of threads");
    let (other, _) = of(&["--seed", "4"], "c.png");
    let (ideal, _) = of(&["--no-noise"], "d.png");
    assert!(ideal.comment.contains("no noise"));
    // Noise as the constants say it, and a drift: another one with each seed. Both images are rounded.
    let grey = ideal.grey.iter().sum::<f64>() / ideal.grey.len() as f64;
    let stated = constant(&said, "read_noise_grey").powi(2)
        + constant(&said, "shot_noise_grey").powi(2) * grey
        + 2.0 / 12.0;
    let off = |picture: &Image| {
        let off = picture.grey.iter().zip(&ideal.grey).map(|(a, b)| a - b).collect::<Vec<_>>();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let variance = off.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / off.len() as f64;
        (mean, variance.sqrt())
    };
    let ((drift, noise), (other_drift, _)) = (off(&first), off(&other));
    // Of 300,000 pixels; what is darkest and brightest is cut off.
    assert!((noise / stated.sqrt() - 1.0).abs() < 0.03, "{noise} {stated}");
    assert!((drift - other_drift).abs() > 0.1, "{drift} {other_drift}");
    // The same press in two parts.
    let parts =
        ["--indenter", "ball@1mm,-2mm", "--depth", "1mm", "--spacing", "0.8mm", "--seed", "3"];
    capture(root.path(), "9dtact", &parts, "parts.png");
    assert!(bytes == std::fs::read(root.path().join("parts.png")).unwrap());
    // Rays are means: what is cast four times as finely is the same image, but for edges.
    let (finer, _) = of(&["--no-noise", "--samples", "2"], "e.png");
    let same = finer.grey.iter().zip(&ideal.grey).filter(|(a, b)| (*a - *b).abs() <= 1.0).count();
    assert!(same as f64 > 0.97 * ideal.grey.len() as f64, "{same}");
}

#[test]
fn a_camera_that_sends_jpeg_leaves_its_blocks() {
    let root = tempfile::tempdir().unwrap();
    // How much neighbours differ across the borders of blocks, over how much they do elsewhere.
    let blocks = |picture: &Image| {
        let mut sums = [[0.0; 2]; 2];
        for row in picture.grey.chunks(640) {
            for x in 1..640 {
                let sum = &mut sums[usize::from(x % 8 == 0)];
                *sum = [sum[0] + (row[x] - row[x - 1]).abs(), sum[1] + 1.0];
            }
        }
        let [inside, across] = sums.map(|[sum, count]| sum / count);
        across / inside
    };
    let of =
        |more: &[&str]| capture(root.path(), "rtac0", &[&["--reference"], more].concat(), "a.png");
    let (said, sent) = of(&[]);
    assert_eq!(said["jpeg_quality"], 70);
    // 1.7 to 1.9 in the published captures.
    assert!((1.4..2.2).contains(&blocks(&sent)), "{}", blocks(&sent));
    for more in [&["--no-noise"][..], &["--set", "camera.jpeg_quality=0"]] {
        let (said, taken) = of(more);
        assert!(said["jpeg_quality"].is_null());
        assert!(blocks(&taken) < 1.1, "{}", blocks(&taken));
    }
}

#[test]
fn what_cannot_be_captured_is_refused_and_nothing_is_written() {
    let root = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], says: &str| {
        let run = fabkit(root.path(), arguments);
        assert_eq!(run.code, Some(2), "{}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(says), "{}", run.stderr);
    };
    refused(
        &["capture", "uvdtact", "--light", "uw", "--reference", "-o", "a.png"],
        "no light `uw`: it has white, uv",
    );
    std::fs::write(root.path().join("light.json"), LIGHT).unwrap();
    let fitted = ["--constants", "light.json", "--reference", "-o", "a.png"];
    refused(&[&["capture", "tactip"][..], &fitted].concat(), "translucent layers");
    std::fs::remove_file(root.path().join("light.json")).unwrap();
    let rigid = ["--contact", "rigid", "-o", "a.png"];
    let press = ["--press", "ball@5deg,30deg,1mm"];
    refused(&[&["capture", "shadowtac"][..], &press, &rigid].concat(), "does not move markers");
    let of_skin = ["--reference", "--truth", "a.npz", "-o", "a.png"];
    refused(&[&["capture", "fluidic"][..], &of_skin].concat(), "no ground truth of depth");
    refused(&["capture", "rtac0", "--reference", "-o", "a.jpg"], "does not name a .png file");
    refused(&["capture", "rtac0", "--reference", "-o", "a.png", "--truth", "a.png"], "a.png");
    refused(&["capture", "rtac0", "-o", "a.png"], "--press");
    refused(&["capture", "rtac0", "--press", "bal@0deg,0deg,1mm", "-o", "a.png"], "bal");
    let rigid = ["--press", "ball@0deg,0deg,1mm", "--contact", "rigid", "--friction", "1"];
    refused(&[&["capture", "rtac0", "-o", "a.png"][..], &rigid].concat(), "friction");
    assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 0);
}

/// The middle of what is brighter than an intensity around a pixel, weighted by how much.
fn centroid(picture: &Image, width: usize, [x, y]: [f64; 2], reach: f64, above: f64) -> [f64; 2] {
    let mut sums = [0.0; 3];
    for (i, grey) in picture.grey.iter().enumerate() {
        let at = [(i % width) as f64, (i / width) as f64];
        if (at[0] - x).hypot(at[1] - y) < reach && *grey > above {
            let more = grey - above;
            sums = [sums[0] + more, sums[1] + more * at[0], sums[2] + more * at[1]];
        }
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

#[test]
fn marks_are_where_they_are_said_to_be() {
    let root = tempfile::tempdir().unwrap();
    // At rest, and while something presses between them.
    for what in [&["--reference"][..], &["--press", "hemisphere@7mm,7mm,4mm", "--spacing", "2mm"]] {
        let (said, picture) =
            capture(root.path(), "fluidic", &[what, &["--no-noise"]].concat(), "a.png");
        let mut worst: f64 = 0.0;
        for mark in said["marks"].as_array().unwrap() {
            let pixel = [0, 1].map(|i| mark["pixel"][i].as_f64().unwrap());
            let seen = centroid(&picture, 640, pixel, 16.0, 60.0);
            worst = worst.max((seen[0] - pixel[0]).hypot(seen[1] - pixel[1]));
        }
        // Of a disc that is 10 px wide and seen aslant; its rim is a tenth of a millimetre thick.
        assert!(worst < 0.3, "{worst}");
    }
}

#[test]
fn images_of_halves_are_captures_and_come_back_after_an_interruption() {
    let root = tempfile::tempdir().unwrap();
    let presses = ["ball@24deg,120deg,1mm", "ball@30deg,170deg,0.8mm"];
    let list = format!("first = {}\nsecond = {}\n", presses[0], presses[1]);
    std::fs::write(root.path().join("list.txt"), list).unwrap();
    let fixed = ["dataset", "rtac0", "--presses", "list.txt", "--contact", "linear", "--images"];
    // JPEG makes steps of what is nearly the same.
    let as_taken = ["--set", "camera.jpeg_quality=0", "--spacing", "0.5mm"];
    let more = [&as_taken[..], &["--materialise", "-o", "set", "--json"]].concat();
    let run = |last: &[&str]| fabkit(root.path(), &[&fixed[..], &more, last].concat()).ok();
    run(&[]);
    let set = root.path().join("set");
    let files = ["halves/image/c/0/0/0/0", "samples/image/c/0/0/0/0"];
    let before = files.map(|file| std::fs::read(set.join(file)).unwrap());
    files.iter().for_each(|file| std::fs::remove_file(set.join(file)).unwrap());
    run(&["--resume"]);
    assert!(files.map(|file| std::fs::read(set.join(file)).unwrap()) == before);

    let halves = fabkit_application::dataset::DatasetReader::open(&set).unwrap();
    let images = halves.array("halves/image").unwrap().unwrap();
    for (half, press) in presses.iter().enumerate() {
        let image = images.sample(half).unwrap();
        // Of two patterns: seeds are 5 apart, for a seed of 1.
        let seed = (5 + half).to_string();
        let alone = [&as_taken[..], &["--press", press, "--seed", &seed]].concat();
        let (_, alone) = capture(root.path(), "rtac0", &alone, "alone.png");
        let off = alone.grey.iter().zip(&image).map(|(a, b)| (a - f64::from(*b)).abs());
        let off: Vec<f64> = off.collect();
        // The same noise; nodes of a press by itself lie around it, those of many everywhere.
        let far = off.iter().filter(|off| **off > 1.0).count();
        assert!(far * 500 < off.len(), "{far} of {}", off.len());
        assert!(off.iter().copied().fold(0.0, f64::max) < 12.0);
    }
    let other = fabkit(root.path(), &[&fixed[..], &["--light", "uv", "-o", "other"]].concat());
    assert!(other.code == Some(2) && other.stderr.contains("no light `uv`"), "{other:?}");
    assert!(!root.path().join("other").exists());
}

#[test]
fn a_unit_is_another_sensor_of_the_same_design() {
    let root = tempfile::tempdir().unwrap();
    let of = |more: &[&str], name: &str| {
        capture(root.path(), "9dtact", &[&["--reference", "--no-noise"], more].concat(), name)
    };
    let (drawn, as_drawn) = of(&[], "drawn.png");
    let (said, unit) = of(&["--unit", "3"], "unit.png");
    let (_, again) = of(&["--unit", "3", "--threads", "1"], "again.png");
    let (_, other) = of(&["--unit", "4"], "other.png");
    assert!(drawn["unit"].is_null() && unit.grey == again.grey);
    let differ = |a: &Image, b: &Image| {
        a.grey.iter().zip(&b.grey).filter(|(a, b)| (*a - *b).abs() > 1.0).count()
    };
    assert!(differ(&unit, &as_drawn) > 10_000 && differ(&unit, &other) > 10_000);
    // A core that stands higher leaves less above it, of what this unit's pad and coat came out as.
    let core_mm = said["unit"]["core_off_mm"][2].as_f64().unwrap();
    let dimensions = said["unit"]["dimensions"].as_array().unwrap();
    let size = |path: &str| dimensions.iter().find(|one| one["path"] == path).unwrap();
    let [pad_mm, coat_mm] = ["pad.thickness", "coat.thickness"].map(|path| {
        let [drawn, built, tolerance] =
            ["drawn", "built", "tolerance"].map(|key| size(path)[key].as_f64().unwrap());
        assert!(built != drawn && (built - drawn).abs() < tolerance + 1e-4, "{path} {built}");
        built
    });
    let thin_mm = said["thickness_mm"][0].as_f64().unwrap();
    assert!(
        (thin_mm - (pad_mm - coat_mm - core_mm)).abs() < 1e-6 && core_mm.abs() > 1e-3,
        "{thin_mm} {core_mm}"
    );
    assert_eq!(said["design_hash"], drawn["design_hash"]);
    // Its camera's pose is that of the unit, for the truth as well.
    let moved = [&said, &drawn]
        .map(|of| of["viewpoint"]["sensor_from_camera"]["translation_mm"][0].as_f64().unwrap());
    let by_mm = said["unit"]["camera_moved_mm"][0].as_f64().unwrap();
    assert!((moved[0] - moved[1] - by_mm).abs() < 1e-12);
}

/// Constants outside what light and layers can be are refused with value and limits.
#[test]
fn constants_that_cannot_be_are_refused() {
    let root = tempfile::tempdir().unwrap();
    for (right, wrong, says) in [
        (
            r#""layer_grey", "value": 127"#,
            r#""layer_grey", "value": 1e9"#,
            "between 0.001 and 25500",
        ),
        (r#""ground_grey", "value": 111"#, r#""ground_grey", "value": 256"#, "between 0 and 255"),
        (
            r#""scatter_per_mm", "value": 0.39"#,
            r#""scatter_per_mm", "value": 1000"#,
            "between 0.001 and 100",
        ),
        (r#""spread_mm", "value": 1e-6"#, r#""spread_mm", "value": 50"#, "between 0.000001 and 20"),
        (r#""ground_grey", "value": 111"#, r#""ground_grey", "value": -1"#, "between 0 and 255"),
        (
            r#""ground_grey", "value": 111"#,
            r#""ground_grey", "value": null"#,
            "has no number ground_grey",
        ),
    ] {
        assert!(LIGHT.contains(right));
        std::fs::write(root.path().join("light.json"), LIGHT.replace(right, wrong)).unwrap();
        let capture =
            ["capture", "rtac0", "--reference", "-o", "a.png", "--constants", "light.json"];
        let run = fabkit_tests::fabkit(root.path(), &capture);
        assert!(run.code == Some(2) && run.stderr.contains(says), "{run:?}");
        assert!(run.stderr.contains("light.json has "), "{run:?}");
    }
}
