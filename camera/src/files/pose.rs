//! Where a camera is: the pose file that a calibration writes and ground truth reads.

use super::fields::Fields;
use super::tree::{Content, Node, parse};
use super::{Fault, InvalidCameraFile};

/// Where the sensor is in the camera frame, and how sure that is.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseFile {
    /// Maps sensor coordinates to camera coordinates, 4 x 4, row by row, mm; the last row is
    /// 0 0 0 1. Whether its rotation is one, the reader judges.
    pub camera_from_sensor: [[f64; 4]; 4],
    /// 6 x 6: a small rotation about the camera's axes through the sensor's origin, rad, then the
    /// translation, mm. `None` if nothing is known.
    pub covariance: Option<[[f64; 6]; 6]>,
    /// The file of the camera that it was solved with, relative to the pose's, if it names one.
    pub camera: Option<String>,
}

/// Reads the keys `camera_from_sensor` (4 x 4) and, if they are there, `covariance` (6 x 6) and
/// `camera` of a YAML or JSON file. Other keys are left alone: what `fabkit calibrate extrinsics`
/// writes has more of them, and its JSON report is such a file too.
///
/// # Errors
/// Text that is not YAML, a missing matrix, one of another size or with numbers that are none; all
/// at once.
pub fn read_pose(text: &str) -> Result<PoseFile, InvalidCameraFile> {
    let root = parse(text)?;
    let mut fields = Fields::default();
    let camera_from_sensor = match fields.child(&root, "camera_from_sensor") {
        Some(node) => matrix(&mut fields, node, "camera_from_sensor"),
        None => [[f64::NAN; 4]; 4],
    };
    if camera_from_sensor[3].iter().all(|v| v.is_finite())
        && camera_from_sensor[3] != [0.0, 0.0, 0.0, 1.0]
    {
        let message = format!("its last row is {:?}; it must be 0 0 0 1", camera_from_sensor[3]);
        fields.fault(Fault::new(root.line, "camera_from_sensor", message));
    }
    let known = root.get("covariance").filter(|node| !is_nothing(node));
    let covariance = known.map(|node| matrix(&mut fields, node, "covariance"));
    let camera = root.get("camera").and_then(|node| match &node.content {
        Content::Scalar(name) if !name.is_empty() => Some(name.clone()),
        _ => None,
    });
    fields.into_result(PoseFile { camera_from_sensor, covariance, camera })
}

fn is_nothing(node: &Node) -> bool {
    matches!(&node.content, Content::Scalar(text) if text.is_empty())
}

fn matrix<const N: usize>(fields: &mut Fields, node: &Node, name: &str) -> [[f64; N]; N] {
    let rows: &[Node] = match &node.content {
        Content::List(rows) => rows,
        _ => &[],
    };
    if rows.len() != N {
        let message = format!("must be {N} rows of {N} numbers; it has {} rows", rows.len());
        fields.fault(Fault::new(node.line, name, message));
        return [[f64::NAN; N]; N];
    }
    std::array::from_fn(|row| fields.exactly(&rows[row], name))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "camera: pose.camera.yaml\ncamera_from_sensor:\n  - [1.0, 0.0, 0.0, 0.1]\n  \
                        - [0.0, 1.0, 0.0, 0.25]\n  - [0.0, 0.0, 1.0, 7.0]\n  - [0, 0, 0, 1]\n";

    #[test]
    fn matrices_are_read_row_by_row() {
        let rows: String = (0..6).map(|i| format!("  - [{i}, 0, 0, 0, 0, 1.0e-7]\n")).collect();
        let pose = read_pose(&format!("{TEXT}covariance:\n{rows}")).unwrap();
        assert_eq!(pose.camera_from_sensor[1], [0.0, 1.0, 0.0, 0.25]);
        assert_eq!(pose.covariance.unwrap()[4], [4.0, 0.0, 0.0, 0.0, 0.0, 1e-7]);
        assert_eq!(pose.camera.as_deref(), Some("pose.camera.yaml"));
        assert_eq!(read_pose(TEXT).unwrap().covariance, None);
    }

    #[test]
    fn json_with_more_in_it_is_read_too() {
        let text = r#"{ "format": "fabkit-extrinsics", "covariance": null,
            "camera_from_sensor": [[1,0,0,0],[0,1,0,0],[0,0,1,7],[0,0,0,1]] }"#;
        let pose = read_pose(text).unwrap();
        assert_eq!(
            (pose.camera_from_sensor[2][3], pose.covariance, pose.camera),
            (7.0, None, None)
        );
    }

    #[test]
    fn every_fault_is_named() {
        let message = |text: &str| read_pose(text).unwrap_err().to_string();
        assert!(message("a: 1\n").contains("camera_from_sensor: is missing"));
        assert!(message("camera_from_sensor: [[1, 0], [0, 1]]\n").contains("4 rows of 4"));
        let seven = message(&TEXT.replace("7.0", "seven"));
        assert!(seven.contains("line 5: camera_from_sensor: `seven`"), "{seven}");
        assert!(message(&TEXT.replace("0, 1]\n", "0, 2]\n")).contains("0 0 0 1"));
    }
}
