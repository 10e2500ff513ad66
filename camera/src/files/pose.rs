//! Where a camera is: the pose file that a calibration writes and ground truth reads.

use std::fmt::Write;

use super::fields::Fields;
use super::tree::{Content, Node, parse};
use super::{Fault, InvalidCameraFile, list};

/// Where the sensor is in the camera frame, and how sure that is.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseFile {
    /// Maps sensor coordinates to camera coordinates, 4 x 4, row by row, mm; the last row is
    /// 0 0 0 1. Whether its rotation is one, the reader judges.
    pub camera_from_sensor: [[f64; 4]; 4],
    /// 6 x 6: a small rotation about the camera's axes through the sensor's origin, rad, then the
    /// translation, mm. `None` if nothing is known.
    pub covariance: Option<[[f64; 6]; 6]>,
}

/// Reads the keys `camera_from_sensor` (4 x 4) and, if it is there, `covariance` (6 x 6) of a YAML
/// or JSON file. Other keys are left alone: the report of a calibration is such a file too.
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
    fields.into_result(PoseFile { camera_from_sensor, covariance })
}

/// Writes a pose file that [`read_pose`] gives back to the last bit.
pub fn write_pose(pose: &PoseFile) -> String {
    let mut text = String::from(
        "# Sensor frame to camera frame, mm. Covariance: rotation about the camera's axes, rad,\n\
         # then translation, mm.\nfabkit_pose: 1\ncamera_from_sensor:\n",
    );
    for row in pose.camera_from_sensor {
        // Writing to a string does not fail, here and below.
        let _ = writeln!(text, "  - {}", list(row));
    }
    if let Some(covariance) = &pose.covariance {
        text += "covariance:\n";
        for row in covariance {
            let _ = writeln!(text, "  - {}", list(*row));
        }
    }
    text
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

    fn pose() -> PoseFile {
        let mut covariance = [[0.0; 6]; 6];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = 1e-7 / 3.0 * (1.0 + i as f64);
        }
        let camera_from_sensor = [
            [1.0, 0.0, 0.0, 0.1],
            [0.0, 1.0, 0.0, 1.0 / 3.0],
            [0.0, 0.0, 1.0, 7.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        PoseFile { camera_from_sensor, covariance: Some(covariance) }
    }

    #[test]
    fn what_is_written_is_read_to_the_bit() {
        assert_eq!(read_pose(&write_pose(&pose())).unwrap(), pose());
        let unsure = PoseFile { covariance: None, ..pose() };
        assert_eq!(read_pose(&write_pose(&unsure)).unwrap(), unsure);
    }

    #[test]
    fn json_with_more_in_it_is_read_too() {
        let text = r#"{ "format": "fabkit-extrinsics", "covariance": null,
            "camera_from_sensor": [[1,0,0,0],[0,1,0,0],[0,0,1,7],[0,0,0,1]] }"#;
        let pose = read_pose(text).unwrap();
        assert_eq!((pose.camera_from_sensor[2][3], pose.covariance), (7.0, None));
    }

    #[test]
    fn every_fault_is_named() {
        let message = |text: &str| read_pose(text).unwrap_err().to_string();
        assert!(message("a: 1\n").contains("camera_from_sensor: is missing"));
        assert!(message("camera_from_sensor: [[1, 0], [0, 1]]\n").contains("4 rows of 4"));
        let text = write_pose(&pose()).replace("7.0]", "seven]");
        assert!(
            message(&text).contains("line 7: camera_from_sensor: `seven`"),
            "{}",
            message(&text)
        );
        let text = write_pose(&pose()).replace("0.0, 1.0]", "0.0, 2.0]");
        assert!(message(&text).contains("0 0 0 1"), "{}", message(&text));
    }
}
