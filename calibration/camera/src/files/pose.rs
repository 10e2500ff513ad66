//! Pose files: written by the calibration, read for ground truth.

use std::fmt::Write;

use fabkit_text::YamlNode;
use nalgebra::DMatrix;

use super::fields::FieldReader;
use super::yaml::parse;
use super::{InvalidCameraFile, YamlFault, list};
use crate::camera::Camera;
use crate::estimate::{CameraEstimate, InvalidCovariance};
use crate::joint::{JointEstimate, POSE_PARAMETER_COUNT, POSE_PARAMETERS};

/// Pose of the sensor in the camera frame, with its covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseFile {
    /// Transform from sensor to camera coordinates, 4 x 4, row by row, mm; the last row is 0 0 0 1. Whether its upper
    /// left block is a rotation is not checked here.
    pub camera_from_sensor: [[f64; 4]; 4],
    /// Covariance of the pose alone, in the order of [`POSE_PARAMETERS`]; `None` if it is unknown.
    pub covariance: Option<[[f64; POSE_PARAMETER_COUNT]; POSE_PARAMETER_COUNT]>,
    /// Joint covariance of the pose and the camera; `None` in older files.
    pub joint: Option<StoredJointCovariance>,
    /// Path of the camera file used to solve for the pose, relative to the pose file, if it names one.
    pub camera: Option<String>,
}

/// Joint covariance as stored in a file: with the names of its parameters and the camera that it was solved with, so
/// that it cannot be applied to another camera.
///
/// ```
/// use fabkit_camera::files::{StoredJointCovariance, read_pose};
/// use fabkit_camera::{Camera, DMatrix, JointEstimate};
/// let camera = Camera::equidistant(640, 480, 2.8)?;
/// let joint = JointEstimate::new(camera, DMatrix::identity(14, 14))?;
/// let stored = StoredJointCovariance::from_estimate(&joint);
/// let pose = "camera_from_sensor: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 7], [0, 0, 0, 1]]\n";
/// let read = read_pose(&format!("{pose}joint_covariance:\n{}", stored.to_yaml()))?;
/// assert_eq!(read.joint.as_ref(), Some(&stored));
/// assert!(stored.is_for_camera(&camera));
/// assert!(!stored.is_for_camera(&Camera::equidistant(640, 480, 2.81)?));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StoredJointCovariance {
    /// Names of the pose's parameters, then of the camera's.
    pub names: Vec<String>,
    /// Values of the camera's parameters, in the order of their names.
    pub camera_values: Vec<f64>,
    /// Covariance, in the order of the names.
    pub matrix: DMatrix<f64>,
}

impl StoredJointCovariance {
    /// Creates the file's form of an estimate.
    pub fn from_estimate(estimate: &JointEstimate) -> Self {
        Self {
            names: estimate.names().into_iter().map(str::to_owned).collect(),
            camera_values: estimate.camera().parameters().into_iter().map(|(_, v)| v).collect(),
            matrix: estimate.covariance().clone(),
        }
    }

    /// Returns whether `camera` is the camera that this was solved with, to the last digit.
    pub fn is_for_camera(&self, camera: &Camera) -> bool {
        let values = camera.parameters().into_iter().map(|(_, value)| value);
        self.names == JointEstimate::parameter_names(camera)
            && values.eq(self.camera_values.iter().copied())
    }

    /// Returns the pose's 6 x 6 block.
    fn pose(&self) -> [[f64; POSE_PARAMETER_COUNT]; POSE_PARAMETER_COUNT] {
        std::array::from_fn(|r| std::array::from_fn(|c| self.matrix[(r, c)]))
    }

    /// Writes the value of the key `joint_covariance` in YAML, from the line below the key.
    pub fn to_yaml(&self) -> String {
        let mut text = format!(
            "  names: [{}]\n  camera_values: {}\n  matrix:\n",
            self.names.join(", "),
            list(self.camera_values.iter().copied())
        );
        for row in self.matrix.row_iter() {
            // Writing to a string does not fail.
            let _ = writeln!(text, "    - {}", list(row.iter().copied()));
        }
        text
    }
}

impl PoseFile {
    /// Combines this pose with a camera estimate: with the joint covariance if `estimate` has the camera that the pose
    /// was solved with, else as independent.
    ///
    /// # Errors
    /// Fails for a matrix that is no covariance.
    ///
    /// ```
    /// use fabkit_camera::Camera;
    /// use fabkit_camera::files::read_pose;
    /// let variance = (0..6).map(|i| format!("  - {:?}\n", [0, 1, 2, 3, 4, 5].map(|j| i32::from(i == j))));
    /// let text = format!(
    ///     "camera_from_sensor: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 7], [0, 0, 0, 1]]\n\
    ///      covariance:\n{}",
    ///     variance.collect::<String>()
    /// );
    /// // A file without joint covariance tells of the pose alone.
    /// let joint = read_pose(&text)?.with_camera(&Camera::equidistant(640, 480, 2.8)?.into())?;
    /// assert_eq!(joint.coverage().to_string(), "pose, shape");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_camera(
        &self,
        estimate: &CameraEstimate,
    ) -> Result<JointEstimate, InvalidCovariance> {
        match self.joint.as_ref().filter(|joint| joint.is_for_camera(estimate.camera())) {
            Some(joint) => JointEstimate::new(*estimate.camera(), joint.matrix.clone()),
            None => JointEstimate::independent(estimate, self.covariance.as_ref()),
        }
    }
}

/// Reads a pose from a YAML or JSON file: the key `camera_from_sensor` (4 x 4) and, if present, `covariance` (6 x 6),
/// `joint_covariance` (`names`, `camera_values`, `matrix`) and `camera`. Other keys are ignored, because files from
/// `fabkit calibrate extrinsics` have more of them. Its JSON report is such a file too.
///
/// # Errors
/// Reports text that is not YAML, a missing matrix, a matrix of another size, or entries that are not numbers; all
/// together.
///
/// ```
/// use fabkit_camera::files::read_pose;
/// let text = "camera: lens.yaml\n\
///             camera_from_sensor: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 7], [0, 0, 0, 1]]\n";
/// let pose = read_pose(text)?;
/// // The sensor's origin is 7 mm in front of the lens.
/// assert_eq!(pose.camera_from_sensor[2][3], 7.0);
/// assert_eq!((pose.camera.as_deref(), pose.covariance), (Some("lens.yaml"), None));
/// // The last row is that of a transform.
/// assert!(read_pose(&text.replace("0, 1]]", "0, 2]]")).is_err());
/// # Ok::<(), fabkit_camera::files::InvalidCameraFile>(())
/// ```
pub fn read_pose(text: &str) -> Result<PoseFile, InvalidCameraFile> {
    parse(text, read_root)
}

/// Reads a pose file's tree.
fn read_root(root: &YamlNode) -> Result<PoseFile, InvalidCameraFile> {
    let mut fields = FieldReader::default();
    let camera_from_sensor = match fields.child(root, "camera_from_sensor") {
        Some(node) => matrix(&mut fields, node, "camera_from_sensor"),
        None => [[f64::NAN; 4]; 4],
    };
    if camera_from_sensor[3].iter().all(|v| v.is_finite())
        && camera_from_sensor[3] != [0.0, 0.0, 0.0, 1.0]
    {
        let message = format!("its last row is {:?}; it must be 0 0 0 1", camera_from_sensor[3]);
        fields.fault(YamlFault::new(root.position, "camera_from_sensor", message));
    }
    let known = root.get("covariance").filter(|node| !is_empty_node(node));
    let covariance = known.map(|node| matrix(&mut fields, node, "covariance"));
    let known = root.get("joint_covariance").filter(|node| !is_empty_node(node));
    let joint = known.and_then(|node| read_joint(&mut fields, node));
    let of_joint = joint.as_ref().map(StoredJointCovariance::pose);
    // Contradicting covariances would give different results to different readers.
    if let Some((alone, together)) = covariance.zip(of_joint)
        && !agree(&alone, &together)
    {
        let message = "is not the pose's part of `joint_covariance`";
        let hint = "the one follows from the other: take one of them out";
        fields.fault(YamlFault::new(root.position, "covariance", message).hint(hint));
    }
    let covariance = covariance.or(of_joint);
    let camera = root.get("camera").and_then(YamlNode::text).filter(|name| !name.is_empty());
    let camera = camera.map(str::to_owned);
    fields.into_result(PoseFile { camera_from_sensor, covariance, joint, camera })
}

/// Reads a joint covariance: names that begin with the pose's, a value for each of the camera's names, and a matrix for
/// all.
fn read_joint(fields: &mut FieldReader, map: &YamlNode) -> Option<StoredJointCovariance> {
    const KEY: &str = "joint_covariance";
    fields.require_known_keys(map, &["names", "camera_values", "matrix"]);
    let [names, values, matrix] =
        ["names", "camera_values", "matrix"].map(|key| fields.child(map, key));
    let (names, values, matrix) = (names?, values?, matrix?);
    let found: Vec<String> =
        names.items().iter().filter_map(|item| item.text().map(str::to_owned)).collect();
    if !found.iter().map(String::as_str).take(POSE_PARAMETER_COUNT).eq(POSE_PARAMETERS) {
        let message = "do not begin with the parameters of a pose";
        let hint = format!("they are {}", POSE_PARAMETERS.join(", "));
        fields.fault(YamlFault::new(names.position, "names", message).hint(hint));
        return None;
    }
    let count = found.len();
    let camera_values = fields.numbers(values, KEY);
    if camera_values.len() != count - POSE_PARAMETER_COUNT {
        let message = format!(
            "has {} numbers; the names are those of {} parameters of a camera",
            camera_values.len(),
            count - POSE_PARAMETER_COUNT
        );
        fields.fault(YamlFault::new(values.position, "camera_values", message));
        return None;
    }
    let numbers: Vec<Vec<f64>> =
        matrix.items().iter().map(|row| fields.numbers(row, KEY)).collect();
    if numbers.len() != count || numbers.iter().any(|row| row.len() != count) {
        let message = format!("must be {count} rows of {count} numbers, one for each name");
        fields.fault(YamlFault::new(matrix.position, "matrix", message));
        return None;
    }
    let matrix = DMatrix::from_fn(count, count, |r, c| numbers[r][c]);
    Some(StoredJointCovariance { names: found, camera_values, matrix })
}

/// Compares two covariances with a tolerance, because written numbers may have lost their last digits.
fn agree(
    alone: &[[f64; POSE_PARAMETER_COUNT]; POSE_PARAMETER_COUNT],
    together: &[[f64; POSE_PARAMETER_COUNT]; POSE_PARAMETER_COUNT],
) -> bool {
    let near = |r: usize, c: usize| {
        let scale = (alone[r][r] * alone[c][c]).abs().sqrt();
        (alone[r][c] - together[r][c]).abs() <= 1e-6 * scale
    };
    // Entries that are not numbers have already been reported.
    let all = alone.iter().chain(together).flatten();
    all.copied().any(f64::is_nan)
        || (0..POSE_PARAMETER_COUNT).all(|r| (0..POSE_PARAMETER_COUNT).all(|c| near(r, c)))
}

fn is_empty_node(node: &YamlNode) -> bool {
    node.text() == Some("")
}

/// Reads an `N` x `N` matrix; entries that cannot be read become NaN.
fn matrix<const N: usize>(fields: &mut FieldReader, node: &YamlNode, name: &str) -> [[f64; N]; N] {
    let rows = node.items();
    if rows.len() != N {
        let message = format!("must be {N} rows of {N} numbers; it has {} rows", rows.len());
        fields.fault(YamlFault::new(node.position, name, message));
        return [[f64::NAN; N]; N];
    }
    std::array::from_fn(|row| fields.read_exactly(&rows[row], name))
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

    fn joint() -> JointEstimate {
        let camera = Camera::equidistant(64, 48, 2.8).unwrap();
        let count = POSE_PARAMETER_COUNT + camera.parameter_count();
        let row = |i: usize| (i + 1) as f64 * 1e-3;
        let covariance =
            DMatrix::from_fn(count, count, |r, c| row(r) * row(c) * if r == c { 1.0 } else { 0.3 });
        JointEstimate::new(camera, covariance).unwrap()
    }

    #[test]
    fn the_joint_covariance_comes_back_with_the_camera_it_belongs_to() {
        let joint = joint();
        let text = format!(
            "{TEXT}joint_covariance:\n{}",
            StoredJointCovariance::from_estimate(&joint).to_yaml()
        );
        let pose = read_pose(&text).unwrap();
        assert_eq!(pose.with_camera(&joint.camera_estimate()).unwrap(), joint);
        assert_eq!(pose.covariance, Some(joint.pose_covariance()));
        assert_eq!(joint.coverage().to_string(), "pose, lens, shape");
        // Another camera: each by itself, and said.
        let other = CameraEstimate::from(Camera::equidistant(64, 48, 2.81).unwrap());
        let apart = pose.with_camera(&other).unwrap();
        assert_eq!(apart.pose_covariance(), joint.pose_covariance());
        assert_eq!(apart.coverage().to_string(), "pose, shape");
        let known =
            CameraEstimate::new(*other.camera(), joint.camera_estimate().covariance().cloned());
        let apart = pose.with_camera(&known.unwrap()).unwrap();
        assert_eq!(
            apart.coverage().to_string(),
            "pose, lens, shape; pose and camera as if independent"
        );
        assert_eq!(apart.covariance()[(0, POSE_PARAMETER_COUNT)], 0.0);
    }

    #[test]
    fn a_joint_covariance_that_cannot_be_is_refused() {
        let good = format!(
            "{TEXT}joint_covariance:\n{}",
            StoredJointCovariance::from_estimate(&joint()).to_yaml()
        );
        let message = |text: &str| read_pose(text).unwrap_err().to_string();
        let text = message(&good.replace("rotation_y_rad, ", ""));
        assert!(text.contains("names: do not begin with the parameters of a pose"), "{text}");
        let text = message(&good.replace("k4]", "k4, k5]"));
        assert!(text.contains("camera_values: has 8 numbers"), "{text}");
        let (short, _) = good.rsplit_once("    - ").unwrap();
        assert!(message(short).contains("must be 14 rows of 14 numbers"), "{}", message(short));
        let rows = "  - [0.5, 0, 0, 0, 0, 0]\n".repeat(6);
        let text = message(&format!("{good}covariance:\n{rows}"));
        assert!(text.contains("not the pose's part of `joint_covariance`"), "{text}");
        // Correlations of 2 are read, and refused where they are used.
        let doubled = good.replace("matrix:\n    - [1.0e-6, ", "matrix:\n    - [1.0e-7, ");
        assert_ne!(doubled, good);
        let pose = read_pose(&doubled).unwrap();
        assert!(pose.with_camera(&joint().camera_estimate()).is_err());
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
