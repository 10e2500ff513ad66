//! Images of what the camera sees, by the real binary: its rays, its own view, its coverage.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use fabkit_tests::fabkit;
use serde_json::Value;

/// Width, height, channels and bytes.
struct Pixels {
    size: [usize; 2],
    channels: usize,
    bytes: Vec<u8>,
}

impl Pixels {
    fn read(path: &Path) -> Self {
        let decoder = png::Decoder::new(BufReader::new(File::open(path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        bytes.truncate(info.buffer_size());
        let channels = info.color_type.samples();
        Self { size: [info.width as usize, info.height as usize], channels, bytes }
    }

    fn at(&self, column: usize, row: usize) -> &[u8] {
        let at = self.channels * (row * self.size[0] + column);
        &self.bytes[at..at + self.channels]
    }

    /// Share of the pixels that are not as in another image of the same size.
    fn unlike(&self, other: &Self) -> f64 {
        assert_eq!((self.size, self.channels), (other.size, other.channels));
        let pairs = self.bytes.chunks(self.channels).zip(other.bytes.chunks(self.channels));
        pairs.filter(|(a, b)| a != b).count() as f64 / (self.size[0] * self.size[1]) as f64
    }
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Rays end at the surface where `depth` says that the pixel sees it; they lie in the section, and bend.
#[test]
fn rays_end_where_depth_says() {
    let root = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| fabkit(root.path(), args).ok();
    for name in ["rtac0", "shadowtac", "tactip", "9dtact"] {
        let rays = ["render", name, "--rays", "--size", "320x240", "-o", "rays.png", "--json"];
        let document = run(&rays).json();
        assert_eq!(Pixels::read(&root.path().join("rays.png")).size, [320, 240]);
        run(&["depth", name, "--reference", "--mask", "mask.png"]);
        let mask = Pixels::read(&root.path().join("mask.png"));
        let rays = document["rays"].as_array().unwrap();
        assert!(rays.len() > 30, "{name}: {}", rays.len());
        let (mut bent, mut on_surface) = (0, 0);
        for ray in rays {
            let pixel = floats(&ray["pixel"]);
            let is_surface = ray["seen_by"] == "surface";
            on_surface += usize::from(is_surface);
            // The middle row of an image of even height is the edge between two.
            let near = [-0.6, 0.6].iter().flat_map(|dx| [-0.6, 0.6].map(|dy| [*dx, dy]));
            let near = near.map(|[dx, dy]| {
                // Pixels are centred on whole numbers.
                let at = |value: f64, size: usize| (value.round().max(0.0) as usize).min(size - 1);
                let (x, y) = (at(pixel[0] + dx, mask.size[0]), at(pixel[1] + dy, mask.size[1]));
                mask.at(x, y)[0] == 255
            });
            let near: Vec<bool> = near.collect();
            assert!(near.contains(&is_surface), "{name} {pixel:?}: {ray} {near:?}");
            let path: Vec<Vec<f64>> =
                ray["path_in_sensor_mm"].as_array().unwrap().iter().map(floats).collect();
            assert!(path.iter().all(|point| point[1].abs() < 1.0), "{name}: {path:?}");
            bent += usize::from(path.len() > 2);
        }
        // A fluid lens may lie right in front of the camera: most rays pass a face askew.
        assert!(bent > 20 && on_surface > 5, "{name}: {bent} {on_surface}");
    }
}

/// A lens by itself looks through the drawn bodies as the design's does; one that says nothing looks past them.
#[test]
fn a_lens_by_itself_looks_through_what_is_drawn() {
    let root = tempfile::tempdir().unwrap();
    let coverage = |more: &[&str]| {
        let args = ["depth", "rtac0", "--reference", "--json", "--mask", "mask.png"];
        fabkit(root.path(), &[&args[..], more].concat()).ok().json()["coverage"].clone()
    };
    let light = fabkit(root.path(), &["export", "rtac0", "--format", "light", "-o", "light"]);
    light.ok();
    let text = fs::read_to_string(root.path().join("light/light.json")).unwrap();
    let camera = serde_json::from_str::<Value>(&text).unwrap()["camera"].clone();
    let mut file = format!(
        "fabkit_camera: 1\nwidth_px: {}\nheight_px: {}\nlens:\n  model: kannala-brandt\n",
        camera["width_px"], camera["height_px"]
    );
    for (name, value) in camera["parameters"].as_object().unwrap() {
        file += &format!("  {name}: {value}\n");
    }
    let write = |text: &str| fs::write(root.path().join("camera.yaml"), text).unwrap();
    write(&file);
    let straight = coverage(&["--camera", "camera.yaml"]);
    write(&format!("{file}interface:\n  kind: drawn\n"));
    let drawn = coverage(&["--camera", "camera.yaml"]);
    assert_eq!(drawn, coverage(&[]));
    assert!(straight.as_f64().unwrap() > drawn.as_f64().unwrap() + 0.05, "{straight} {drawn}");
}

/// The image has the camera's size, and what it shows is the mask's business too: where the surface is seen
/// there is another colour than where a black body is. A narrower bore shows, and threads do not.
#[test]
fn the_view_is_the_camera_s() {
    let root = tempfile::tempdir().unwrap();
    let render = |more: &[&str], file: &str| {
        // A sixteenth of its pixels, which see the same.
        let size = ["--set", "camera.width_px=160", "--set", "camera.height_px=120"];
        let arguments = [&["render", "rtac0", "--camera", "-o", file], &size[..], more].concat();
        let document = fabkit(root.path(), &[&arguments[..], &["--json"]].concat()).ok().json();
        assert_eq!(document["width_px"], 160);
        Pixels::read(&root.path().join(file))
    };
    let [one, four] = [render(&["--threads", "1"], "1.png"), render(&["--threads", "4"], "4.png")];
    assert_eq!(one.size, [160, 120]);
    assert_eq!(one.bytes, four.bytes);
    let narrow = render(&["--set", "diffuser.bore_radius=6mm"], "narrow.png");
    let share = one.unlike(&narrow);
    assert!((0.1..0.9).contains(&share), "{share}");
    // The middle of the image shows the same surface through either bore.
    assert_eq!(one.at(80, 60), narrow.at(80, 60));

    let camera = "name: wide\n";
    fs::write(root.path().join("camera.yaml"), camera).unwrap();
    let wrong = ["render", "rtac0", "--camera=camera.yaml", "-o", "x.png"];
    assert_eq!(fabkit(root.path(), &wrong).code, Some(2));
    for wrong in [
        &["render", "rtac0/shell", "--camera", "-o", "x.png"][..],
        &["render", "rtac0/shell", "--rays", "-o", "x.png"],
        &["render", "rtac0", "--pose", "camera.yaml", "-o", "x.png"],
        &["render", "rtac0", "--rays", "--camera", "-o", "x.png"],
    ] {
        assert_eq!(fabkit(root.path(), wrong).code, Some(2), "{wrong:?}");
        assert!(!root.path().join("x.png").exists());
    }
}

/// A pad is drawn as it is, so that the colours' shares of its pixels are the shares of its area.
#[test]
fn the_map_of_coverage_has_the_shares_that_are_told() {
    let root = tempfile::tempdir().unwrap();
    let depth = |name: &str, file: &str, more: &[&str]| {
        let arguments = ["depth", name, "--reference", "--coverage-map", file, "--json"];
        fabkit(root.path(), &[&arguments[..], more].concat()).ok().json()
    };
    for (name, lost) in [("9dtact", "beside the picture"), ("gelsight-like", "beside the picture")]
    {
        let document = depth(name, "map.png", &[]);
        let map = Pixels::read(&root.path().join("map.png"));
        let count = |color: [u8; 3]| map.bytes.chunks(3).filter(|pixel| *pixel == color).count();
        let (seen, beside) = (count([246, 239, 214]) as f64, count([122, 138, 160]) as f64);
        let area = document["coverage"].as_f64().unwrap();
        assert!((seen / (seen + beside) - area).abs() < 0.01, "{name}: {seen} {beside} {area}");
        let told = document["coverage_lost"][lost].as_f64().unwrap();
        assert!((beside / (seen + beside) - told).abs() < 0.01, "{name}: {told}");
    }
    depth("rtac0", "1.png", &["--threads", "1"]);
    depth("rtac0", "4.png", &["--threads", "4"]);
    let read = |file: &str| fs::read(root.path().join(file)).unwrap();
    assert_eq!(read("1.png"), read("4.png"));
    let run = fabkit(root.path(), &["depth", "rtac0", "--reference", "--coverage-map", "m.txt"]);
    assert_eq!(run.code, Some(2), "{run:?}");
}
