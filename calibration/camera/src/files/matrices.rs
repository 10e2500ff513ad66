//! Formats with a camera matrix and a distortion vector: OpenCV's `FileStorage` and ROS's `camera_info`.

use fabkit_text::{YamlContent, YamlNode, suggestion, to_printable};

use super::fields::FieldReader;
use super::{CameraFile, InvalidCameraFile, YamlFault, list, regions};
use crate::camera::Camera;
use crate::interface::Interface;
use crate::lens::{INTRINSICS, Intrinsics, KannalaBrandt, Lens, OpenCv};

/// Spellings of each key in OpenCV's and ROS's calibration tools, in ROS messages, and in common scripts.
const MATRIX: [&str; 7] =
    ["camera_matrix", "K", "k", "cameraMatrix", "Camera_Matrix", "intrinsic_matrix", "mtx"];
const DISTORTION: [&str; 11] = [
    "distortion_coefficients",
    "D",
    "d",
    "distCoeffs",
    "Distortion_Coefficients",
    "dist_coeffs",
    "dist_coeff",
    "dist_coefs",
    "distortion_coeffs",
    "dist",
    "distortion",
];
/// Matrix and vector of each camera of a pair, in OpenCV's samples and common scripts. The matrix's key is the name.
const PAIRS: [(&str, &str); 8] = [
    ("M1", "D1"),
    ("M2", "D2"),
    ("K1", "D1"),
    ("K2", "D2"),
    ("cameraMatrix1", "distCoeffs1"),
    ("cameraMatrix2", "distCoeffs2"),
    ("camera_matrix_1", "dist_coeffs_1"),
    ("camera_matrix_2", "dist_coeffs_2"),
];
const WIDTH: [&str; 4] = ["image_width", "width", "image_Width", "w"];
const HEIGHT: [&str; 4] = ["image_height", "height", "image_Height", "h"];
/// Both sides in one list, width first.
const SIZE: [&str; 6] = ["image_size", "imageSize", "resolution", "dim", "DIM", "img_size"];

/// Lens model of the distortion vector.
#[derive(Clone, Copy, PartialEq)]
enum DistortionModel {
    OpenCv,
    Fisheye,
}

fn first<'a>(root: &'a YamlNode, spellings: &[&str]) -> Option<&'a YamlNode> {
    spellings.iter().find_map(|key| root.get(key))
}

/// Returns the names of the cameras of a pair, or of mappings that hold a camera each; empty for a file with one camera at
/// its top.
pub(super) fn cameras(root: &YamlNode) -> Option<Vec<String>> {
    if first(root, &MATRIX).is_some() {
        return Some(Vec::new());
    }
    let keys = PAIRS.iter().map(|(matrix, _)| *matrix).filter(|key| root.get(key).is_some());
    let pair: Vec<String> = keys.map(str::to_owned).collect();
    if !pair.is_empty() {
        return Some(pair);
    }
    let has_camera = |node: &YamlNode| first(node, &MATRIX).is_some();
    let entries = root.entries().iter().filter(|entry| has_camera(&entry.value));
    let names: Vec<String> = entries.map(|entry| entry.key.clone()).collect();
    (!names.is_empty()).then_some(names)
}

/// Returns what a file without camera matrix lacks, if it has other parts of a camera.
pub(super) fn missing_part(root: &YamlNode) -> Option<&'static str> {
    let others = [&DISTORTION[..], &WIDTH, &SIZE, &["distortion_model", "camera_model"]];
    others.into_iter().any(|keys| first(root, keys).is_some()).then_some("`camera_matrix`")
}

/// Reads a camera in OpenCV's or ROS's format.
pub(super) fn read(file: &YamlNode, name: &str) -> Result<CameraFile, InvalidCameraFile> {
    let mut fields = FieldReader::default();
    let pair = PAIRS.iter().find(|(matrix, _)| *matrix == name);
    let root = match pair {
        None if !name.is_empty() => file.get(name).unwrap_or(file),
        _ => file,
    };
    let size = read_size(&mut fields, root, file);
    let (matrix, distortion) = match pair {
        Some((matrix, distortion)) => (file.get(matrix), file.get(distortion)),
        None => (first(root, &MATRIX), first(root, &DISTORTION)),
    };
    let intrinsics = matrix.map(|node| read_intrinsics(&mut fields, node));
    let Some(distortion) = distortion else {
        let hint = "write `distortion_coefficients: []` for a lens without distortion";
        fields.fault(YamlFault::new(None, DISTORTION[0], "is missing").hint(hint));
        return Err(fields.into_faults(size, None, Interface::None));
    };
    let coefficients = matrix_data(&mut fields, distortion, DISTORTION[0]);
    // Violations of any coefficient point to the vector as a whole.
    fields.record_position(&["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"], distortion.position);
    let model = read_model(&mut fields, root, distortion, &coefficients);
    let (Some(mut intrinsics), Some(model)) = (intrinsics, model) else {
        return Err(fields.into_faults(size, None, Interface::None));
    };
    let size = regions::apply(&mut fields, root, size, &mut intrinsics);
    let lens = match model {
        DistortionModel::Fisheye => {
            let k = require_count(&mut fields, distortion, &coefficients, &[4]);
            k.map(|k| KannalaBrandt::new(intrinsics, std::array::from_fn(|i| k[i])))
                .map(|lens| lens.map(Lens::KannalaBrandt))
        }
        DistortionModel::OpenCv => {
            let used = drop_zero_prism_and_tilt(&mut fields, distortion, &coefficients);
            let k = require_count(&mut fields, distortion, used, &[0, 4, 5, 8]);
            k.map(|k| OpenCv::new(intrinsics, k).map(Lens::OpenCv))
        }
    };
    fields.into_camera(size, lens, Interface::None, None)
}

/// Reads the image's size, of the camera or of the whole file.
fn read_size(fields: &mut FieldReader, root: &YamlNode, file: &YamlNode) -> (u32, u32) {
    if let Some(node) = first(root, &SIZE).or_else(|| first(file, &SIZE)) {
        return fields.size(node, "image size");
    }
    let mut side = |spellings: &[&'static str], field: &'static str| {
        let Some(node) = first(root, spellings).or_else(|| first(file, spellings)) else {
            let message = "is missing; without the image's size a camera is not complete";
            let hint = "add `image_width` and `image_height` of the images of the calibration";
            fields.fault(YamlFault::new(None, spellings[0], message).hint(hint));
            return 0;
        };
        fields.pixels(node, field)
    };
    (side(&WIDTH, "width_px"), side(&HEIGHT, "height_px"))
}

/// Reads the numbers of a matrix, row by row: `data` of a mapping, a list of rows, or a plain list.
fn matrix_data(fields: &mut FieldReader, node: &YamlNode, field: &str) -> Vec<f64> {
    match &node.content {
        YamlContent::Map(_) => fields
            .child(node, "data")
            .map_or_else(Vec::new, |data| matrix_data(fields, data, field)),
        YamlContent::List(rows) if rows.iter().any(YamlNode::is_list) => {
            // One number less in a row moves all that follow it.
            let columns = rows[0].items().len();
            if let Some(row) = rows.iter().find(|row| row.items().len() != columns) {
                let message = "its rows have different numbers of columns";
                fields.fault(YamlFault::new(row.position, field, message));
            }
            rows.iter().flat_map(|row| fields.numbers(row, field)).collect()
        }
        // `D:` without a value, as of rectified cameras.
        YamlContent::Nothing => Vec::new(),
        _ => fields.numbers(node, field),
    }
}

/// Reads the camera matrix, and reports skew or another form.
fn read_intrinsics(fields: &mut FieldReader, node: &YamlNode) -> Intrinsics {
    fields.record_position(&INTRINSICS, node.position);
    let k = matrix_data(fields, node, MATRIX[0]);
    let [fx_px, skew, cx_px, below, fy_px, cy_px, rest @ ..] = match <[f64; 9]>::try_from(&k[..]) {
        Ok(k) => k,
        Err(_) => {
            let message = format!("has {} numbers; 9 are needed", k.len());
            fields.fault(YamlFault::new(node.position, MATRIX[0], message));
            [f64::NAN; 9]
        }
    };
    if k.len() == 9 && k[..8].iter().all(|value| *value == 0.0) {
        let fault =
            YamlFault::new(node.position, MATRIX[0], "is zero: the camera is not calibrated");
        fields.fault(fault.hint("ROS drivers publish zeros until a calibration is loaded"));
    }
    if skew != 0.0 && skew.is_finite() {
        let fault = YamlFault::new(node.position, MATRIX[0], format!("has a skew of {skew} px"));
        fields.fault(fault.hint("no lens model here has one; calibrate without it"));
    }
    if below.is_finite() && (below != 0.0 || rest != [0.0, 0.0, 1.0]) {
        let message = "is not of the form [fx, 0, cx; 0, fy, cy; 0, 0, 1]";
        let fault = YamlFault::new(node.position, MATRIX[0], message);
        let is_transposed = rest[2] == 1.0 && [skew, below, cx_px, cy_px] == [0.0; 4];
        fields.fault(if is_transposed {
            fault.hint("written column by column, as Open3D does? Write it row by row")
        } else {
            fault
        });
    }
    Intrinsics { fx_px, fy_px, cx_px, cy_px }
}

/// Reads which lens model the coefficients belong to.
///
/// OpenCV's own files do not always distinguish its two models, and both can have four coefficients. A file with four
/// numbers and no other statement is refused.
fn read_model(
    fields: &mut FieldReader,
    root: &YamlNode,
    vector: &YamlNode,
    coefficients: &[f64],
) -> Option<DistortionModel> {
    let count = coefficients.len();
    if root.get("distortion_model").is_some() {
        let (name, line) = fields.text(root, "distortion_model")?;
        return match name {
            "plumb_bob" | "rational_polynomial" | "radtan" => Some(DistortionModel::OpenCv),
            "equidistant" | "equi" | "fisheye" => Some(DistortionModel::Fisheye),
            // A camera whose images are rectified.
            "" | "none" if count == 0 => Some(DistortionModel::OpenCv),
            "" => {
                let message = format!("is empty, but there are {count} coefficients");
                let hint = "expected plumb_bob, rational_polynomial or equidistant";
                fields.fault(YamlFault::new(line, "distortion_model", message).hint(hint));
                None
            }
            other => {
                let message = format!("`{}` is not known", to_printable(other));
                let hint =
                    suggestion(other, ["plumb_bob", "rational_polynomial", "equidistant"], "known");
                fields.fault(YamlFault::new(line, "distortion_model", message).hint(hint));
                None
            }
        };
    }
    if root.get("fisheye_model").is_some() {
        let (flag, line) = fields.text(root, "fisheye_model")?;
        return match flag {
            "0" | "false" => Some(DistortionModel::OpenCv),
            "1" | "true" => Some(DistortionModel::Fisheye),
            other => {
                let message = format!("is `{}`, but must be 0 or 1", to_printable(other));
                fields.fault(YamlFault::new(line, "fisheye_model", message));
                None
            }
        };
    }
    // `cv2.fisheye.calibrate` returns a column of four, `cv2.calibrateCamera` never four numbers. Four zeros are
    // written by people.
    let is_column = vector.items().len() == 4 && vector.items().iter().all(YamlNode::is_list);
    if count == 4 && is_column && coefficients.iter().any(|k| *k != 0.0) {
        fields.note(
            "four coefficients in a column are read as those of a fisheye, as \
             `cv2.fisheye.calibrate` returns them; state `fisheye_model: 1`, or 0 for k1 k2 p1 p2",
        );
        return Some(DistortionModel::Fisheye);
    }
    if count == 4 {
        let message = "four coefficients are either k1 k2 p1 p2 or the k1 k2 k3 k4 of a fisheye, \
                       and the file does not say which";
        let hint = "add the line `fisheye_model: 0` or `fisheye_model: 1`";
        fields.fault(YamlFault::new(vector.position, DISTORTION[0], message).hint(hint));
        return None;
    }
    Some(DistortionModel::OpenCv)
}

/// Shortens OpenCV's 12 or 14 coefficients to 8, if those beyond the eighth are zero.
fn drop_zero_prism_and_tilt<'a>(
    fields: &mut FieldReader,
    node: &YamlNode,
    k: &'a [f64],
) -> &'a [f64] {
    if !matches!(k.len(), 12 | 14) {
        return k;
    }
    let (used, beyond) = k.split_at(8);
    if beyond.iter().any(|value| *value != 0.0) {
        let message = "has thin prism or tilted sensor terms that are not zero";
        let hint = "no lens model here has them; calibrate with 5 or 8 coefficients";
        fields.fault(YamlFault::new(node.position, DISTORTION[0], message).hint(hint));
    }
    used
}

/// Returns the coefficients if their number is allowed, else reports it.
fn require_count<'a>(
    fields: &mut FieldReader,
    node: &YamlNode,
    k: &'a [f64],
    allowed: &[usize],
) -> Option<&'a [f64]> {
    if allowed.contains(&k.len()) {
        return Some(k);
    }
    let counts: Vec<String> = allowed.iter().map(usize::to_string).collect();
    let message = format!("has {} numbers; this model has {}", k.len(), counts.join(", "));
    fields.fault(YamlFault::new(node.position, DISTORTION[0], message));
    None
}

/// Returns camera matrix, coefficients and model of a lens that both formats have, or in words what would be lost.
fn matrix_and_coefficients(camera: &Camera) -> Result<([f64; 9], &[f64], DistortionModel), String> {
    let Intrinsics { fx_px, fy_px, cx_px, cy_px } = camera.lens().intrinsics();
    let matrix = [fx_px, 0.0, cx_px, 0.0, fy_px, cy_px, 0.0, 0.0, 1.0];
    let coefficients = camera.lens().coefficients();
    match camera.lens() {
        Lens::OpenCv(_) => Ok((matrix, coefficients, DistortionModel::OpenCv)),
        Lens::KannalaBrandt(_) => Ok((matrix, coefficients, DistortionModel::Fisheye)),
        other => Err(format!("the lens model ({})", other.model_name())),
    }
}

/// Writes OpenCV's format, or returns in words what would be lost.
pub(super) fn write_opencv(camera: &Camera) -> Result<String, String> {
    let (matrix, k, model) = matrix_and_coefficients(camera)?;
    let as_matrix = |name: &str, rows: usize, columns: usize, data: &[f64]| {
        let data = list(data.iter().copied());
        format!(
            "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: {data}\n"
        )
    };
    Ok(format!(
        "%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\nfisheye_model: {}\n{}{}",
        camera.width_px(),
        camera.height_px(),
        u8::from(model == DistortionModel::Fisheye),
        as_matrix("camera_matrix", 3, 3, &matrix),
        as_matrix("distortion_coefficients", k.len(), 1, k),
    ))
}

/// Writes ROS's format, or returns in words what would be lost.
pub(super) fn write_ros(camera: &Camera) -> Result<String, String> {
    let (matrix, k, model) = matrix_and_coefficients(camera)?;
    let [fx, _, cx, _, fy, cy, ..] = matrix;
    let name = match (model, k.len()) {
        (DistortionModel::Fisheye, _) => "equidistant",
        (DistortionModel::OpenCv, 8) => "rational_polynomial",
        _ => "plumb_bob",
    };
    let as_matrix = |name: &str, rows: usize, columns: usize, data: &[f64]| {
        let data = list(data.iter().copied());
        format!("{name}:\n  rows: {rows}\n  cols: {columns}\n  data: {data}\n")
    };
    Ok(format!(
        "image_width: {}\nimage_height: {}\ncamera_name: camera\n{}distortion_model: {name}\n{}{}{}",
        camera.width_px(),
        camera.height_px(),
        as_matrix("camera_matrix", 3, 3, &matrix),
        as_matrix("distortion_coefficients", 1, k.len(), k),
        as_matrix("rectification_matrix", 3, 3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
        as_matrix(
            "projection_matrix",
            3,
            4,
            &[fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ),
    ))
}
