//! Marks that are followed in images, by the real binary, beside where the images' own truth has them.

use std::fs;
use std::path::Path;

use fabkit_application::export::png as write_png;
use fabkit_application::reconstructing::CapturedImage;
use fabkit_tests::contract::find_faults;
use fabkit_tests::fabkit;
use serde_json::Value;

type Px = [f64; 2];

/// Names and pixels of the marks that an image is made with.
fn capture(folder: &Path, words: &[&str], name: &str) -> Vec<(String, Px)> {
    let run = fabkit(folder, &[&["capture"], words, &["-o", name, "--json"]].concat()).ok().json();
    let mark = |mark: &Value| {
        let px = |k: usize| mark["pixel"][k].as_f64().unwrap_or(f64::NAN);
        (mark["name"].as_str().unwrap().to_owned(), [px(0), px(1)])
    };
    run["marks"].as_array().unwrap().iter().map(mark).collect()
}

fn reconstruct(folder: &Path, words: &[&str]) -> Value {
    let all = [&["reconstruct"], words, &["-o", "out", "--json"]].concat();
    let json = fabkit(folder, &all).ok().json();
    assert!(find_faults(&json).is_empty(), "{:?}", find_faults(&json));
    json
}

/// Numbers of an array in an NPZ file, which is not compressed: behind the file's name and NPY's own header.
fn numbers(path: &Path, array: &str) -> Vec<f64> {
    let bytes = fs::read(path).unwrap();
    let find = |what: &[u8], from: usize| {
        from + bytes[from..].windows(what.len()).position(|part| part == what).unwrap()
    };
    let magic = find(b"\x93NUMPY", find(format!("{array}.npy").as_bytes(), 0));
    let header = usize::from(u16::from_le_bytes([bytes[magic + 8], bytes[magic + 9]]));
    let text = std::str::from_utf8(&bytes[magic + 10..magic + 10 + header]).unwrap();
    let shape = text.split('(').nth(1).unwrap().split(')').next().unwrap();
    let count = shape.split(',').filter_map(|n| n.trim().parse::<usize>().ok()).product::<usize>();
    let values = &bytes[magic + 10 + header..];
    if text.contains("<u2") {
        let of = |pair: &[u8]| f64::from(u16::from_le_bytes([pair[0], pair[1]]));
        return values.chunks(2).take(count).map(of).collect();
    }
    let of = |eight: &[u8]| f64::from_le_bytes(eight.try_into().unwrap());
    values.chunks(8).take(count).map(of).collect()
}

fn pairs(path: &Path, array: &str) -> Vec<Px> {
    numbers(path, array).chunks(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn away(a: &Px, b: &Px) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// What is found of an image, beside the truth.
struct Judged {
    at_rest: usize,
    seen: usize,
    wrong: usize,
    /// How far movements are off, px, sorted.
    off_px: Vec<f64>,
}

impl Judged {
    fn new(npz: &Path, rest: &[(String, Px)], now: &[(String, Px)]) -> Self {
        let (rest_px, px) = (pairs(npz, "mark_rest_px"), pairs(npz, "mark_px"));
        let moved = pairs(npz, "mark_moved_px");
        let ids = numbers(npz, "mark_id");
        assert!(ids.iter().enumerate().all(|(i, id)| *id == (i + 1) as f64));
        let mut own = Self { at_rest: 0, seen: 0, wrong: 0, off_px: Vec::new() };
        // What is seen of a mark may lie beside the drawn place: as far in all images.
        let beside = |i: usize| [0, 1].map(|k| rest_px[i][k] - rest[i].1[k]);
        for i in 0..px.len() {
            own.at_rest += usize::from(rest_px[i][0].is_finite());
            if !px[i][0].is_finite() {
                continue;
            }
            own.seen += 1;
            let to = |j: &usize| {
                let by = if rest_px[*j][0].is_finite() { beside(*j) } else { [0.0; 2] };
                let at = [0, 1].map(|k| now[*j].1[k] + by[k]);
                if at[0].is_finite() { away(&px[i], &at) } else { f64::INFINITY }
            };
            let nearest = (0..now.len()).min_by(|a, b| to(a).total_cmp(&to(b))).unwrap();
            own.wrong += usize::from(nearest != i);
            let really = [0, 1].map(|k| now[i].1[k] - rest[i].1[k]);
            own.off_px.push(away(&moved[i], &really));
        }
        own.off_px.sort_by(f64::total_cmp);
        own
    }

    fn part(&self, part: f64) -> f64 {
        self.off_px[((self.off_px.len() - 1) as f64 * part) as usize]
    }

    fn say(&self, what: &str) {
        let Self { at_rest, seen, wrong, .. } = self;
        let [half, most] = [0.5, 0.95].map(|part| self.part(part));
        println!(
            "{what}: {seen} of {at_rest} seen, {wrong} wrong; off by {half:.3} px, 95 % by less than {most:.3} px"
        );
    }
}

#[test]
fn marks_are_followed_by_their_names() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    // A disc of radius r that is sampled once a pixel has an edge of 2 pi r pixels, each of which is wrong by a variance of
    // about a tenth of a pixel's area: its middle by sqrt(0.1 / (pi r)) along each axis, 0.06 px of the skin's markers; from
    // image to image, in two directions, twice that. The tip's dots, less than a pixel wide, have 8 x 8 rays, but a
    // middle between two pixels that both hold all of it is known to half of one. A column's end lies between two pixels.
    for (sensor, more, press, bounds_px, least_seen) in [
        ("fluidic", &["--spacing", "2mm"][..], "hemisphere@20mm,3mm,5mm", [0.12, 0.12 * 2.45], 100),
        (
            "fluidic",
            &["--light", "display", "--spacing", "2mm"],
            "hemisphere@20mm,3mm,5mm",
            [0.5, 1.0],
            16,
        ),
        ("tactip", &["--samples", "8"], "disc-107@15deg,60deg,2mm", [0.5, 1.0], 45),
    ] {
        let words = |what: &[&'static str]| [&[sensor], more, what].concat();
        let reference: Vec<&str> =
            more.iter().filter(|w| !w.starts_with("--spacing") && **w != "2mm").copied().collect();
        let rest = capture(
            folder,
            &[&[sensor][..], &reference, &["--reference", "--seed", "1"]].concat(),
            "rest.png",
        );
        let now = capture(folder, &words(&["--press", press, "--seed", "2"]), "now.png");
        let light: Vec<&str> = match more.first() {
            Some(&"--light") => more[..2].to_vec(),
            _ => Vec::new(),
        };
        let json = reconstruct(
            folder,
            &[&[sensor][..], &light, &["--reference", "rest.png", "now.png", "rest.png"]].concat(),
        );
        assert_eq!(json["marks"]["drawn"], rest.len());
        assert!(
            json["files"][0]["contact_px"].is_null() && json["files"][0]["deepest_mm"].is_null()
        );
        assert!(json["left_out"][0].as_str().unwrap().contains("depth needs light that shows"));
        let judged = Judged::new(&folder.join("out/now.npz"), &rest, &now);
        judged.say(&format!("{sensor} {more:?}, {press}"));
        assert_eq!(judged.wrong, 0);
        assert!(judged.seen >= least_seen, "{}", judged.seen);
        assert!(judged.part(0.5) < bounds_px[0] && judged.part(0.95) < bounds_px[1]);
        assert_eq!(json["files"][0]["marks_seen"], judged.seen);
        // The image at rest has not moved.
        let still = pairs(&folder.join("out/rest.npz"), "mark_moved_px");
        let still: Vec<&Px> = still.iter().filter(|px| px[0].is_finite()).collect();
        assert_eq!(still.len(), json["marks"]["at_rest"].as_u64().unwrap() as usize);
        assert!(still.iter().all(|moved| **moved == [0.0; 2]));
    }
}

/// The same image farther to the right and down.
fn shifted(image: &CapturedImage, [right, down]: [usize; 2]) -> Vec<u8> {
    let [width, height] = image.size_px;
    let value = |column: usize, row: usize, k: usize| {
        let from = column.saturating_sub(right) + row.saturating_sub(down) * width;
        (255.0 * image.values[from * image.channels + k.min(image.channels - 1)]).round() as u8
    };
    let pixel = |i: usize| [0, 1, 2].map(|k| value(i % width, i / width, k));
    let rgb: Vec<u8> = (0..width * height).flat_map(pixel).collect();
    write_png(width as u32, height as u32, &rgb).unwrap()
}

#[test]
fn a_pattern_that_has_moved_by_half_of_its_pitch_is_the_same_pattern() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    // Squares of 41 to 45 px, and rings around each other of which the nearest two are 9 px apart.
    for (sensor, light, shift) in [("fluidic", "white", [22, 0]), ("uvdtact", "uv", [3, 3])] {
        let words = [sensor, "--light", light, "--reference"];
        let drawn = capture(folder, &words, "rest.png");
        let rest = CapturedImage::read(&folder.join("rest.png")).unwrap();
        fs::write(folder.join("now.png"), shifted(&rest, shift)).unwrap();
        reconstruct(folder, &[sensor, "--light", light, "--reference", "rest.png", "now.png"]);
        let npz = folder.join("out/now.npz");
        let moved = pairs(&npz, "mark_moved_px");
        let rest_px = pairs(&npz, "mark_rest_px");
        // Where it is drawn, it is found: no other is nearer.
        for (i, at) in rest_px.iter().enumerate() {
            let to = |j: &usize| away(at, &drawn[*j].1);
            assert_eq!((0..drawn.len()).min_by(|a, b| to(a).total_cmp(&to(b))), Some(i));
        }
        let seen: Vec<&Px> = moved.iter().filter(|px| px[0].is_finite()).collect();
        let off = seen.iter().map(|moved| away(moved, &shift.map(|px| px as f64)));
        let off = off.fold(0.0, f64::max);
        println!(
            "{sensor}: {} of {} marks seen, off by {off:.3} px at most",
            seen.len(),
            moved.len()
        );
        assert!(seen.len() * 100 >= moved.len() * 98);
        // Pixels are shrunk together by two or three, and the shift is no multiple of that.
        assert!(off < 0.35, "{off}");
    }
}

#[test]
fn an_image_without_marks_is_refused() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    // Nothing of a tip, dark all over.
    let dark = write_png(30, 30, &[0; 3 * 30 * 30]).unwrap();
    fs::write(folder.join("dark.png"), dark).unwrap();
    let words = ["reconstruct", "tactip", "--reference", "dark.png", "dark.png", "-o", "none"];
    let run = fabkit(folder, &words);
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("only 0 of 57 markers in view are found"), "{}", run.stderr);
    assert!(!folder.join("none").exists());
}

/// At rest each dot of the tip is a disc without a gap, the one in the middle too, and is found by its name.
#[test]
fn every_dot_of_a_tip_at_rest_is_seen_and_found() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    // Dots of 6 pixels across at least, which one ray for each pixel shows; and as the sensor's camera takes them.
    for more in [&["--set", "camera.pixels=240"][..], &["--set", "camera.pixels=241"], &[]] {
        let words = [&["tactip"], more].concat();
        let drawn = capture(folder, &[&words[..], &["--reference"]].concat(), "rest.png");
        assert_eq!(drawn.len(), 57);
        let all = [&words[..], &["--reference", "rest.png", "rest.png"]].concat();
        let marks = reconstruct(folder, &all)["marks"].clone();
        assert_eq!((&marks["drawn"], &marks["at_rest"]), (&57.into(), &57.into()), "{more:?}");
        if more.is_empty() {
            continue;
        }
        let image = CapturedImage::read(&folder.join("rest.png")).unwrap();
        for (name, at) in drawn {
            // The pixel that a dot's centre is seen in, and its eight neighbours.
            let near = (0..9).map(|k| {
                let [x, y] = [k % 3, k / 3].map(|by| by as f64 - 1.0);
                let [column, row] = [at[0] + x, at[1] + y].map(|px| px.round() as usize);
                image.values[(column + row * image.size_px[0]) * image.channels]
            });
            let near: Vec<f32> = near.collect();
            let least = near.iter().copied().fold(f32::INFINITY, f32::min);
            let most = near.iter().copied().fold(0.0, f32::max);
            // One face in one light: half of it would be a hole.
            assert!(most > 0.1 && least > 0.5 * most, "{name} {more:?}: {near:?}");
        }
    }
}
