//! Settings of ORB-SLAM2 and ORB-SLAM3: `Camera.fx`, `Camera1.k1` and the like.

use fabkit_text::{YamlNode, suggestion, to_printable};

use super::fields::FieldReader;
use super::{CameraFile, InvalidCameraFile, YamlFault};
use crate::interface::Interface;
use crate::lens::{Intrinsics, KannalaBrandt, Lens, OpenCv};

/// Prefixes of the cameras' keys.
const PREFIXES: [&str; 3] = ["Camera", "Camera1", "Camera2"];
/// Lens models, as values of `Camera.type`.
const TYPES: [&str; 3] = ["PinHole", "KannalaBrandt8", "Rectified"];

/// Returns the prefixes of all cameras with a focal length.
pub(super) fn cameras(root: &YamlNode) -> Option<Vec<String>> {
    let has = |prefix: &&str| root.get(&format!("{prefix}.fx")).is_some();
    let names: Vec<String> = PREFIXES.into_iter().filter(has).map(str::to_owned).collect();
    (!names.is_empty()).then_some(names)
}

/// Reads one camera.
pub(super) fn read(root: &YamlNode, name: &str) -> Result<CameraFile, InvalidCameraFile> {
    let mut fields = FieldReader::default();
    let size = ["width", "height"].map(|side| {
        // The second camera of a pair has the size of the first, unless it states its own.
        let own = root.get(&format!("{name}.{side}"));
        let key = format!("Camera.{side}");
        let parameter = if side == "width" { "width_px" } else { "height_px" };
        match own.or_else(|| root.get(&key)) {
            Some(node) => fields.pixels(node, parameter),
            None => {
                let hint = format!("add the line `{key}: NUMBER` with the size of the images");
                fields.fault(YamlFault::new(None, &key, "is missing").hint(hint));
                0
            }
        }
    });
    let mut number = |key: &'static str, parameter: &'static str| {
        let path = format!("{name}.{key}");
        let Some(node) = fields.child(root, &path) else { return f64::NAN };
        fields.record_position(&[parameter], node.position);
        fields.parse_number(node, &path)
    };
    let intrinsics = Intrinsics {
        fx_px: number("fx", "fx_px"),
        fy_px: number("fy", "fy_px"),
        cx_px: number("cx", "cx_px"),
        cy_px: number("cy", "cy_px"),
    };
    let is_given = |key: &str| root.get(&format!("{name}.{key}")).is_some();
    let kind = root.get("Camera.type").map_or("PinHole", |node| node.text().unwrap_or_default());
    let lens = match kind {
        "KannalaBrandt8" => {
            let k = ["k1", "k2", "k3", "k4"].map(|key| number(key, key));
            Some(KannalaBrandt::new(intrinsics, k).map(Lens::KannalaBrandt))
        }
        "PinHole" if ["k1", "k2", "p1", "p2", "k3"].into_iter().any(is_given) => {
            let mut k = ["k1", "k2", "p1", "p2"].map(|key| number(key, key)).to_vec();
            if is_given("k3") {
                k.push(number("k3", "k3"));
            }
            Some(OpenCv::new(intrinsics, &k).map(Lens::OpenCv))
        }
        "PinHole" | "Rectified" => Some(OpenCv::new(intrinsics, &[]).map(Lens::OpenCv)),
        other => {
            let message = format!("`{}` is not known", to_printable(other));
            let place = root.get("Camera.type").map(|node| node.position);
            let hint = suggestion(other, TYPES, "known");
            fields.fault(YamlFault::new(place, "Camera.type", message).hint(hint));
            None
        }
    };
    if kind == "PinHole" && is_given("k4") {
        let message = "is a term that ORB-SLAM's pinhole does not have";
        let place = root.get(&format!("{name}.k4")).map(|node| node.position);
        let hint = "for a fisheye write `Camera.type: KannalaBrandt8`";
        fields.fault(YamlFault::new(place, "k4", message).hint(hint));
    }
    if root.get("Camera.newWidth").is_some() || root.get("Camera.newHeight").is_some() {
        fields.note(format!(
            "`Camera.newWidth` and `Camera.newHeight` are not used: the camera is that of images of \
             {} x {} px",
            size[0], size[1]
        ));
    }
    fields.into_camera(size.into(), lens, Interface::None, None)
}

#[cfg(test)]
mod tests {
    use crate::files::{read, read_file};

    const PAIR: &str = "%YAML:1.0\n# ----\nCamera.type: \"KannalaBrandt8\"\nCamera1.fx: 190.5\n\
        Camera1.fy: 190.25\nCamera1.cx: 254.5\nCamera1.cy: 256.75\nCamera1.k1: 0.0034\n\
        Camera1.k2: 0.0007\nCamera1.k3: -0.002\nCamera1.k4: 0.0002\nCamera2.fx: 191.5\n\
        Camera2.fy: 190.25\nCamera2.cx: 254.5\nCamera2.cy: 256.75\nCamera2.k1: 0.0034\n\
        Camera2.k2: 0.0007\nCamera2.k3: -0.002\nCamera2.k4: 0.0002\nCamera.width: 512\n\
        Camera.height: 512\nCamera.fps: 20\n";

    #[test]
    fn one_of_a_pair_is_read_by_its_name() {
        let second = read_file(PAIR, Some("Camera2")).unwrap();
        let lens = second.estimate.camera().lens();
        assert_eq!(lens.intrinsics().fx_px, 191.5);
        assert_eq!(lens.model_name(), "kannala-brandt");
        assert_eq!(lens.coefficients(), [0.0034, 0.0007, -0.002, 0.0002]);
        let error = read(PAIR).unwrap_err().to_string();
        assert!(error.contains("2 cameras: `Camera1`, `Camera2` (write FILE#Camera1"), "{error}");
    }

    #[test]
    fn pinholes_of_both_versions_are_opencvs() {
        let text = "Camera.fx: 500.0\nCamera.fy: 501.0\nCamera.cx: 318.0\nCamera.cy: 238.0\n\
            Camera.k1: 0.26\nCamera.k2: -0.95\nCamera.p1: -0.005\nCamera.p2: 0.0026\n\
            Camera.k3: 1.16\nCamera.width: 640\nCamera.height: 480\nThDepth: 40\n";
        let five = read(text).unwrap();
        assert_eq!(five.camera().lens().coefficients(), [0.26, -0.95, -0.005, 0.0026, 1.16]);
        let newer = text.replace("Camera.", "Camera1.").replace("Camera1.w", "Camera.w");
        let newer = newer.replace("Camera1.h", "Camera.h") + "Camera.type: PinHole\n";
        assert_eq!(read(&newer).unwrap(), five);
        for (from, to, expected) in [
            ("Camera.width: 640\n", "", "Camera.width: is missing (add the line"),
            ("Camera.p1: -0.005\n", "", "Camera.p1: is missing"),
            ("500.0", ".nan", "line 1: Camera.fx: `.nan` is not a finite number"),
            ("ThDepth: 40", "Camera.type: Mei", "`Mei` is not known"),
            ("ThDepth: 40", "Camera.k4: 0.1", "KannalaBrandt8"),
        ] {
            let error = read(&text.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
