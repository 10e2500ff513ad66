//! COLMAP's `cameras.txt`.

use std::collections::BTreeSet;

use fabkit_text::{
    Position, YamlContent, YamlEntry, YamlFault, YamlNode, suggestion, to_printable,
};

use super::fields::FieldReader;
use super::{CameraFile, InvalidCameraFile};
use crate::error::InvalidCamera;
use crate::interface::Interface;
use crate::lens::{INTRINSICS, Intrinsics, KannalaBrandt, Lens, OpenCv};

/// Key of the tree under which the cameras stand, each with its line's words. No file has it.
const CAMERAS: &str = "cameras.txt";

/// Names of a model's parameters behind the size, in their order. `f` is both focal lengths.
const MODELS: [(&str, &[&str]); 9] = [
    ("SIMPLE_PINHOLE", &["f", "cx", "cy"]),
    ("PINHOLE", &["fx", "fy", "cx", "cy"]),
    ("SIMPLE_RADIAL", &["f", "cx", "cy", "k1"]),
    ("RADIAL", &["f", "cx", "cy", "k1", "k2"]),
    ("OPENCV", &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"]),
    ("FULL_OPENCV", &["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"]),
    ("SIMPLE_RADIAL_FISHEYE", &["f", "cx", "cy", "k1"]),
    ("RADIAL_FISHEYE", &["f", "cx", "cy", "k1", "k2"]),
    ("OPENCV_FISHEYE", &["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"]),
];

/// Returns whether a line may describe a camera: `1 OPENCV 640 480 ...`.
pub(super) fn is_recognised(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let is_id = words.next().is_some_and(|id| id.bytes().all(|byte| byte.is_ascii_digit()));
    let is_model = words.next().is_some_and(|model| {
        model.starts_with(|letter: char| letter.is_ascii_uppercase())
            && model.bytes().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit() || b == b'_')
    });
    // The last line of a file that was cut off may lack its size.
    is_id && is_model && words.next().is_none_or(|width| width.parse::<f64>().is_ok())
}

/// Parses all lines. A camera is the list of its line's words.
pub(super) fn parse(text: &str) -> (YamlNode, Vec<YamlFault>) {
    let mut cameras: Vec<YamlEntry> = Vec::new();
    let mut twice = Vec::new();
    let mut ids = BTreeSet::new();
    for (number, line) in text.lines().enumerate() {
        let at = Position { line: number + 1, column: 1 };
        if line.trim().is_empty() || line.trim_start().starts_with('#') {
            continue;
        }
        let words = line.split_whitespace().map(|word| {
            let content = YamlContent::Scalar(word.to_owned());
            YamlNode { position: at, content }
        });
        let words: Vec<YamlNode> = words.collect();
        let key = words.first().and_then(YamlNode::text).unwrap_or_default().to_owned();
        if !ids.insert(key.clone()) {
            let message = format!("camera `{}` is written twice", to_printable(&key));
            twice.push(YamlFault::new(at, "", message).hint("keep one of them"));
            continue;
        }
        let value = YamlNode { position: at, content: YamlContent::List(words) };
        cameras.push(YamlEntry { key, key_position: at, value });
    }
    let at = Position { line: 1, column: 1 };
    let value = YamlNode { position: at, content: YamlContent::Map(cameras) };
    let root = YamlEntry { key: CAMERAS.into(), key_position: at, value };
    (YamlNode { position: at, content: YamlContent::Map(vec![root]) }, twice)
}

/// Returns the ids of all cameras.
pub(super) fn cameras(root: &YamlNode) -> Option<Vec<String>> {
    Some(root.get(CAMERAS)?.entries().iter().map(|entry| entry.key.clone()).collect())
}

/// Reads the camera with an id.
pub(super) fn read(root: &YamlNode, id: &str) -> Result<CameraFile, InvalidCameraFile> {
    let mut fields = FieldReader::default();
    let line = root.get(CAMERAS).and_then(|cameras| cameras.get(id));
    let [_, model, width, height, values @ ..] = line.map_or(&[][..], YamlNode::items) else {
        let at = line.map(|line| line.position);
        let fault = YamlFault::new(at, "", "this line has no model and image size");
        return Err(fault.hint("a camera is `CAMERA_ID MODEL WIDTH HEIGHT PARAMS...`").into());
    };
    let size = (fields.pixels(width, "width_px"), fields.pixels(height, "height_px"));
    let lens = read_lens(&mut fields, model, values);
    fields.into_camera(size, lens, Interface::None, None)
}

/// Reads the lens; `None` if its model is unknown or has another number of parameters.
fn read_lens(
    fields: &mut FieldReader,
    model: &YamlNode,
    values: &[YamlNode],
) -> Option<Result<Lens, InvalidCamera>> {
    let name = model.text().unwrap_or_default();
    let Some((_, names)) = MODELS.iter().find(|(known, _)| *known == name) else {
        let message = format!("`{}` has no counterpart here", to_printable(name));
        let hint = suggestion(name, MODELS.map(|(name, _)| name), "known");
        fields.fault(YamlFault::new(model.position, "MODEL", message).hint(hint));
        return None;
    };
    if values.len() != names.len() {
        let message = format!("{} parameters; {name} has {}", values.len(), names.len());
        let hint = names.join(", ");
        fields.fault(YamlFault::new(model.position, "PARAMS", message).hint(hint));
        return None;
    }
    fields.record_position(&INTRINSICS, model.position);
    fields.record_position(&["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"], model.position);
    let numbers: Vec<f64> =
        names.iter().zip(values).map(|(name, node)| fields.parse_number(node, name)).collect();
    let has_one_focal = names[0] == "f";
    let (focal, rest) = numbers.split_at(if has_one_focal { 1 } else { 2 });
    let [cx, cy, k @ ..] = rest else { return None };
    let intrinsics = Intrinsics {
        fx_px: focal[0],
        fy_px: focal[focal.len() - 1],
        // COLMAP puts the centre of the first pixel at (0.5, 0.5).
        cx_px: cx - 0.5,
        cy_px: cy - 0.5,
    };
    if name.ends_with("FISHEYE") {
        // Terms that a shorter model does not have are zero.
        let k = std::array::from_fn(|i| k.get(i).copied().unwrap_or(0.0));
        return Some(KannalaBrandt::new(intrinsics, k).map(Lens::KannalaBrandt));
    }
    let mut k = k.to_vec();
    if matches!(k.len(), 1 | 2) {
        k.resize(4, 0.0);
    }
    Some(OpenCv::new(intrinsics, &k).map(Lens::OpenCv))
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use crate::files::{read, read_file};

    #[test]
    fn all_models_are_opencvs_with_half_a_pixel_less() {
        let point = Point3::new(0.3, -0.2, 1.0);
        let (a, b): (f64, f64) = (point.x, point.y);
        let u = a * a + b * b;
        let theta = u.sqrt().atan();
        let plain = |s: f64| [500.0 * s * a + 319.75, 500.0 * s * b + 239.25];
        let fisheye = |k1: f64, k2: f64| {
            let square = theta * theta;
            plain(theta * (1.0 + square * (k1 + square * k2)) / u.sqrt())
        };
        let tangential = {
            let s = 1.0 - 0.1 * u + 0.02 * u * u;
            let [p1, p2] = [0.001, -0.002];
            let x = s * a + 2.0 * p1 * a * b + p2 * (u + 2.0 * a * a);
            let y = s * b + p1 * (u + 2.0 * b * b) + 2.0 * p2 * a * b;
            [500.0 * x + 319.75, 500.0 * y + 239.25]
        };
        for (line, expected) in [
            ("SIMPLE_PINHOLE 640 480 500 320.25 239.75", plain(1.0)),
            ("PINHOLE 640 480 500 500 320.25 239.75", plain(1.0)),
            ("SIMPLE_RADIAL 640 480 500 320.25 239.75 -0.1", plain(1.0 - 0.1 * u)),
            ("RADIAL 640 480 500 320.25 239.75 -0.1 0.02", plain(1.0 - 0.1 * u + 0.02 * u * u)),
            ("OPENCV 640 480 500 500 320.25 239.75 -0.1 0.02 0.001 -0.002", tangential),
            (
                "FULL_OPENCV 640 480 500 500 320.25 239.75 -0.1 0.02 0 0 0 0.1 0 0",
                plain((1.0 - 0.1 * u + 0.02 * u * u) / (1.0 + 0.1 * u)),
            ),
            ("SIMPLE_RADIAL_FISHEYE 640 480 500 320.25 239.75 -0.01", fisheye(-0.01, 0.0)),
            ("RADIAL_FISHEYE 640 480 500 320.25 239.75 -0.01 0.02", fisheye(-0.01, 0.02)),
            ("OPENCV_FISHEYE 640 480 500 500 320.25 239.75 -0.01 0.02 0 0", fisheye(-0.01, 0.02)),
        ] {
            let camera = *read(&format!("# Camera list\n3 {line}\n")).unwrap().camera();
            let pixel = camera.project(&point).unwrap();
            let error = (pixel.x - expected[0]).hypot(pixel.y - expected[1]);
            // Rounding of ten operations on numbers below 1000.
            assert!(error < 1e-11, "{line}: {error:e}");
        }
    }

    #[test]
    fn cameras_are_named_by_their_ids() {
        let text = "1 PINHOLE 640 480 500 500 320 240\n7 PINHOLE 64 48 50 50 32 24\n";
        assert_eq!(read_file(text, Some("7")).unwrap().estimate.camera().width_px(), 64);
        let error = read_file(text, Some("2")).unwrap_err().to_string();
        assert!(error.starts_with("the file has no camera `2`, but `1`, `7`"), "{error}");
    }

    #[test]
    fn faults_are_named_with_their_lines() {
        for (text, expected) in [
            ("1 FOV 640 480 500 500 320 240 0.9", "line 1: MODEL: `FOV` has no counterpart"),
            ("\n1 PINHOLE 640 480 500", "line 2: PARAMS: 1 parameters; PINHOLE has 4"),
            ("1 PINHOLE 640", "this line has no model and image size"),
            ("1 PINHOLE 640 480 inf 500 320 240", "fx: `inf` is not a finite number"),
            ("1 PINHOLE 640 480 500 500 320 240\n1 PINHOLE 6 4 5 5 3 2", "line 2: camera `1`"),
            ("1 PINHOLE 640 480 500 500 640 480", "calibrated at 1280 x 960 px?"),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
