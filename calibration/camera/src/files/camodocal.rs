//! camodocal's files, which VINS-Mono and VINS-Fusion read.

use fabkit_text::{YamlNode, suggestion, to_printable};

use super::fields::FieldReader;
use super::{CameraFile, InvalidCameraFile, YamlFault};
use crate::error::InvalidCamera;
use crate::interface::Interface;
use crate::lens::{Eucm, Intrinsics, KannalaBrandt, Lens, OpenCv};

/// Lens models that have a counterpart here.
const MODELS: [&str; 4] = ["PINHOLE", "PINHOLE_FULL", "KANNALA_BRANDT", "MEI"];

/// Recognises a file; its camera needs no name.
pub(super) fn cameras(root: &YamlNode) -> Option<Vec<String>> {
    root.get("model_type").map(|_| Vec::new())
}

/// Reads the camera.
pub(super) fn read(root: &YamlNode, _: &str) -> Result<CameraFile, InvalidCameraFile> {
    let mut fields = FieldReader::default();
    let mut side = |key: &str, parameter: &'static str| {
        fields.child(root, key).map_or(0, |node| fields.pixels(node, parameter))
    };
    let size = (side("image_width", "width_px"), side("image_height", "height_px"));
    let lens = read_lens(&mut fields, root);
    fields.into_camera(size, lens, Interface::None, None)
}

/// Reads the lens; `None` if its model is missing or unknown.
fn read_lens(fields: &mut FieldReader, root: &YamlNode) -> Option<Result<Lens, InvalidCamera>> {
    let (model, line) = fields.text(root, "model_type")?;
    // The sections of a model, in the order of the file.
    let projection = |fields: &mut FieldReader, keys: [&'static str; 4]| {
        let [fx_px, fy_px, cx_px, cy_px] = section(
            fields,
            root,
            "projection_parameters",
            [(keys[0], "fx_px"), (keys[1], "fy_px"), (keys[2], "cx_px"), (keys[3], "cy_px")],
        );
        Intrinsics { fx_px, fy_px, cx_px, cy_px }
    };
    let same = |keys: [&'static str; 4]| keys.map(|key| (key, key));
    match model.to_uppercase().as_str() {
        "KANNALA_BRANDT" => {
            let intrinsics = projection(fields, ["mu", "mv", "u0", "v0"]);
            // camodocal counts powers from the linear term: its k2 belongs to the third power.
            let keys = [("k2", "k1"), ("k3", "k2"), ("k4", "k3"), ("k5", "k4")];
            let k = section(fields, root, "projection_parameters", keys);
            Some(KannalaBrandt::new(intrinsics, k).map(Lens::KannalaBrandt))
        }
        "PINHOLE" => {
            let intrinsics = projection(fields, ["fx", "fy", "cx", "cy"]);
            let k = distortion(fields, root, same(["k1", "k2", "p1", "p2"]));
            Some(OpenCv::new(intrinsics, &k).map(Lens::OpenCv))
        }
        "PINHOLE_FULL" => {
            let intrinsics = projection(fields, ["fx", "fy", "cx", "cy"]);
            let keys = ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"].map(|key| (key, key));
            let k = distortion(fields, root, keys);
            Some(OpenCv::new(intrinsics, &k).map(Lens::OpenCv))
        }
        "MEI" => {
            let Intrinsics { fx_px, fy_px, cx_px, cy_px } =
                projection(fields, ["gamma1", "gamma2", "u0", "v0"]);
            let [xi] = section(fields, root, "mirror_parameters", [("xi", "alpha")]);
            let k = distortion(fields, root, same(["k1", "k2", "p1", "p2"]));
            if xi == 0.0 {
                let intrinsics = Intrinsics { fx_px, fy_px, cx_px, cy_px };
                return Some(OpenCv::new(intrinsics, &k).map(Lens::OpenCv));
            }
            if k.iter().any(|k| *k != 0.0 && k.is_finite()) {
                let place = root.get("distortion_parameters").map(|node| node.position);
                let message = format!(
                    "MEI with distortion (k1 = {}, k2 = {}, p1 = {}, p2 = {}) has no counterpart \
                     here",
                    k[0], k[1], k[2], k[3]
                );
                let hint = "calibrate with KANNALA_BRANDT, or with the distortion set to zero";
                fields.fault(YamlFault::new(place, "distortion_parameters", message).hint(hint));
            }
            // As Kalibr's `omni`: see there.
            let scaled =
                Intrinsics { fx_px: fx_px / (1.0 + xi), fy_px: fy_px / (1.0 + xi), cx_px, cy_px };
            Some(Eucm::new(scaled, xi / (1.0 + xi), 1.0).map(Lens::Eucm))
        }
        _ => {
            let message = format!("`{}` has no counterpart here", to_printable(model));
            let hint = suggestion(model, MODELS, "known");
            fields.fault(YamlFault::new(line, "model_type", message).hint(hint));
            None
        }
    }
}

/// Reads numbers of a section by their keys, each with the name of its parameter here.
fn section<const N: usize>(
    fields: &mut FieldReader,
    root: &YamlNode,
    name: &str,
    keys: [(&'static str, &'static str); N],
) -> [f64; N] {
    let Some(map) = root.get(name) else {
        fields.fault(YamlFault::new(None, name, "is missing"));
        return [f64::NAN; N];
    };
    keys.map(|(key, parameter)| {
        let Some(node) = fields.child(map, key) else { return f64::NAN };
        fields.record_position(&[parameter], node.position);
        fields.parse_number(node, key)
    })
}

/// Reads the distortion; zeros if a file has none.
fn distortion<const N: usize>(
    fields: &mut FieldReader,
    root: &YamlNode,
    keys: [(&'static str, &'static str); N],
) -> [f64; N] {
    match root.get("distortion_parameters") {
        Some(_) => section(fields, root, "distortion_parameters", keys),
        None => [0.0; N],
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use crate::files::read;

    const FISHEYE: &str = "%YAML:1.0\n---\nmodel_type: KANNALA_BRANDT\ncamera_name: front\n\
        image_width: 752\nimage_height: 480\nprojection_parameters:\n   k2: -0.02\n   k3: 0.013\n   \
        k4: -0.008\n   k5: 0.0005\n   mu: 461.5\n   mv: 460.25\n   u0: 371.5\n   v0: 248.75\n";
    const MEI: &str = "model_type: MEI\ncamera_name: a\nimage_width: 752\nimage_height: 480\n\
        mirror_parameters:\n   xi: 0.8\ndistortion_parameters:\n   k1: 0.\n   k2: 0.\n   p1: 0.\n   \
        p2: 0.\nprojection_parameters:\n   gamma1: 833.0\n   gamma2: 830.0\n   u0: 373.0\n   \
        v0: 253.0\n";

    #[test]
    fn kannala_brandt_is_a_polynomial_in_the_angle() {
        let camera = *read(FISHEYE).unwrap().camera();
        let point = Point3::new(0.6, -0.3, 0.8);
        let across = f64::hypot(point.x, point.y);
        let t = across.atan2(point.z);
        let r = t - 0.02 * t.powi(3) + 0.013 * t.powi(5) - 0.008 * t.powi(7) + 0.0005 * t.powi(9);
        let pixel = camera.project(&point).unwrap();
        // Rounding of ten operations on numbers below 1000.
        assert!((pixel.x - (461.5 * r * point.x / across + 371.5)).abs() < 1e-11);
        assert!((pixel.y - (460.25 * r * point.y / across + 248.75)).abs() < 1e-11);
    }

    #[test]
    fn mei_is_eucm_without_distortion_and_opencv_without_mirror() {
        let camera = *read(MEI).unwrap().camera();
        let point = Point3::new(3.0, -4.0, 1.0);
        let depth = point.z + 0.8 * point.coords.norm();
        let pixel = camera.project(&point).unwrap();
        assert!((pixel.x - (833.0 * point.x / depth + 373.0)).abs() < 1e-10);
        assert!((pixel.y - (830.0 * point.y / depth + 253.0)).abs() < 1e-10);
        let plain = MEI.replace("xi: 0.8", "xi: 0.").replace("k1: 0.", "k1: -0.1");
        let pinhole = MEI
            .replace("MEI", "PINHOLE")
            .replace("k1: 0.", "k1: -0.1")
            .replace("gamma1", "fx")
            .replace("gamma2", "fy")
            .replace("u0", "cx")
            .replace("v0", "cy");
        assert_eq!(read(&plain).unwrap(), read(&pinhole).unwrap());
        assert_eq!(read(&pinhole).unwrap().camera().lens().coefficients()[0], -0.1);
    }

    #[test]
    fn what_has_no_counterpart_is_named() {
        for (text, from, to, expected) in [
            (MEI, "p1: 0.", "p1: 0.002", "MEI with distortion (k1 = 0, k2 = 0, p1 = 0.002"),
            (MEI, "model_type: MEI", "model_type: SCARAMUZZA", "line 1: model_type: `SCARAMUZZA`"),
            (MEI, "   xi: 0.8", "   x: 0.8", "xi: is missing"),
            (FISHEYE, "k5: 0.0005", "k5: .Inf", "line 11: k5: `.Inf` is not a finite number"),
            (FISHEYE, "   v0: 248.75\n", "", "v0: is missing"),
            (FISHEYE, "image_width: 752\n", "", "image_width: is missing"),
        ] {
            let error = read(&text.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
