//! Kalibr's camera chains.

use fabkit_text::{YamlNode, suggestion, to_printable};

use super::fields::FieldReader;
use super::{CameraFile, InvalidCameraFile, YamlFault, list};
use crate::camera::Camera;
use crate::error::InvalidCamera;
use crate::interface::Interface;
use crate::lens::{DoubleSphere, Eucm, INTRINSICS, Intrinsics, KannalaBrandt, Lens, OpenCv};

/// Returns the names `cam0`, `cam1`, ... of a chain's cameras.
pub(super) fn cameras(root: &YamlNode) -> Option<Vec<String>> {
    let is_number =
        |text: &str| !text.is_empty() && text.chars().all(|digit| digit.is_ascii_digit());
    let names = root.entries().iter().map(|entry| &entry.key);
    let names = names.filter(|key| key.strip_prefix("cam").is_some_and(is_number));
    let names: Vec<String> = names.cloned().collect();
    (!names.is_empty()).then_some(names)
}

/// Reads one camera of a chain.
pub(super) fn read(root: &YamlNode, name: &str) -> Result<CameraFile, InvalidCameraFile> {
    let mut fields = FieldReader::default();
    let Some(camera) = fields.child(root, name) else {
        return Err(fields.into_faults((0, 0), None, Interface::None));
    };
    let size = fields.child(camera, "resolution").map(|node| fields.size(node, "resolution"));
    let lens = read_lens(&mut fields, camera);
    match size {
        Some(size) => fields.into_camera(size, lens, Interface::None, None),
        None => Err(fields.into_faults((0, 0), lens, Interface::None)),
    }
}

/// Reads the lens; `None` if something required is missing or unknown.
fn read_lens(fields: &mut FieldReader, map: &YamlNode) -> Option<Result<Lens, InvalidCamera>> {
    let (model, line) = fields.text(map, "camera_model")?;
    let node = fields.child(map, "intrinsics");
    if let Some(node) = node {
        fields.record_position(&INTRINSICS, node.position);
        // In sphere models Kalibr's intrinsics begin with the model's coefficients.
        fields.record_position(&["xi", "alpha", "beta"], node.position);
    }
    let node = node?;
    let intrinsics =
        |[fx_px, fy_px, cx_px, cy_px]: [f64; 4]| Intrinsics { fx_px, fy_px, cx_px, cy_px };
    match model {
        "pinhole" => {
            let intrinsics = intrinsics(fields.read_exactly(node, "intrinsics"));
            read_distorted(fields, map, intrinsics)
        }
        "ds" => {
            no_distortion(fields, map, model);
            let [xi, alpha, rest @ ..] = fields.read_exactly::<6>(node, "intrinsics");
            Some(DoubleSphere::new(intrinsics(rest), xi, alpha).map(Lens::DoubleSphere))
        }
        "eucm" => {
            no_distortion(fields, map, model);
            let [alpha, beta, rest @ ..] = fields.read_exactly::<6>(node, "intrinsics");
            Some(Eucm::new(intrinsics(rest), alpha, beta).map(Lens::Eucm))
        }
        "omni" => {
            // Mei's `x / (z + xi d)` is the unified model `x / (alpha d + (1 - alpha) z)` with
            // `alpha = xi / (1 + xi)`, scaled by `1 + xi`.
            no_distortion(fields, map, model);
            let [xi, fx, fy, cx, cy] = fields.read_exactly(node, "intrinsics");
            let scaled = intrinsics([fx / (1.0 + xi), fy / (1.0 + xi), cx, cy]);
            Some(Eucm::new(scaled, xi / (1.0 + xi), 1.0).map(Lens::Eucm))
        }
        other => {
            let message = format!("`{}` is not known", to_printable(other));
            let hint = suggestion(other, ["pinhole", "omni", "ds", "eucm"], "known");
            fields.fault(YamlFault::new(line, "camera_model", message).hint(hint));
            None
        }
    }
}

/// Reads a pinhole with one of Kalibr's distortions.
fn read_distorted(
    fields: &mut FieldReader,
    map: &YamlNode,
    intrinsics: Intrinsics,
) -> Option<Result<Lens, InvalidCamera>> {
    let (distortion, line) = fields.text(map, "distortion_model")?;
    if distortion == "none" {
        return Some(OpenCv::new(intrinsics, &[]).map(Lens::OpenCv));
    }
    let node = fields.child(map, "distortion_coeffs")?;
    fields.record_position(&["k1", "k2", "p1", "p2", "k3", "k4"], node.position);
    match distortion {
        "radtan" => {
            let k = fields.read_exactly::<4>(node, "distortion_coeffs");
            Some(OpenCv::new(intrinsics, &k).map(Lens::OpenCv))
        }
        "equidistant" | "equi" => {
            let k = fields.read_exactly::<4>(node, "distortion_coeffs");
            Some(KannalaBrandt::new(intrinsics, k).map(Lens::KannalaBrandt))
        }
        other => {
            let message = format!("`{}` is not known", to_printable(other));
            let hint = suggestion(other, ["none", "radtan", "equidistant"], "known");
            fields.fault(YamlFault::new(line, "distortion_model", message).hint(hint));
            None
        }
    }
}

/// Refuses distortion on top of a sphere model, which describes the whole lens here.
fn no_distortion(fields: &mut FieldReader, map: &YamlNode, model: &str) {
    let Some(node) = map.get("distortion_coeffs") else { return };
    let coefficients = fields.numbers(node, "distortion_coeffs");
    if coefficients.iter().any(|k| *k != 0.0 && k.is_finite()) {
        let message = format!("`{model}` with further distortion has no counterpart here");
        let hint = "calibrate with `pinhole-equi`, `ds-none` or `eucm-none`";
        fields.fault(YamlFault::new(node.position, "distortion_coeffs", message).hint(hint));
    }
}

/// Writes the file's text, or returns in words what the format cannot hold.
pub(super) fn write(camera: &Camera) -> Result<String, String> {
    let Intrinsics { fx_px, fy_px, cx_px, cy_px } = camera.lens().intrinsics();
    let pinhole = [fx_px, fy_px, cx_px, cy_px];
    let k = camera.lens().coefficients();
    let (model, intrinsics, distortion, coefficients) = match camera.lens() {
        Lens::OpenCv(_) if k.iter().all(|k| *k == 0.0) => {
            ("pinhole", pinhole.into(), "none", &k[..0])
        }
        // Kalibr's `radtan` has four terms: k3 to k6 must be zero.
        Lens::OpenCv(_) if k[4..].iter().all(|k| *k == 0.0) => {
            ("pinhole", pinhole.into(), "radtan", &k[..4])
        }
        Lens::OpenCv(_) => {
            let names = camera.lens().coefficient_names().iter().zip(k).skip(4);
            let lost: Vec<_> = names.filter(|(_, k)| **k != 0.0).map(|(name, _)| *name).collect();
            return Err(format!("the distortion beyond k1 k2 p1 p2 ({})", lost.join(" ")));
        }
        Lens::KannalaBrandt(_) => ("pinhole", pinhole.into(), "equidistant", k),
        lens => match lens.kalibr_name() {
            Some(model) => (model, [k, &pinhole].concat(), "none", &k[..0]),
            None => return Err(format!("the lens model ({})", lens.model_name())),
        },
    };
    Ok(format!(
        "cam0:\n  camera_model: {model}\n  intrinsics: {}\n  distortion_model: {distortion}\n  \
         distortion_coeffs: {}\n  resolution: [{}, {}]\n",
        list(intrinsics),
        list(coefficients.iter().copied()),
        camera.width_px(),
        camera.height_px(),
    ))
}
