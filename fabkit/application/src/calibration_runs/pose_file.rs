//! Files of a calibrated pose.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use fabkit_calibration::report::ExtrinsicsReport;
use fabkit_camera::POSE_PARAMETERS;
use fabkit_camera::files::{self, CameraFormat, StoredJointCovariance, list};
use fabkit_files::Error;

use super::CalibrationRunError;
use crate::edited_files::sign_text;

/// Returns `pose.yaml` and the camera file that belongs to it, with their contents.
///
/// A pose is valid only with the camera it was solved with, which may have gained an interface or other radial terms.
/// That camera is therefore written beside the pose, which names it.
///
/// # Errors
/// See [`camera_path`].
pub fn pose_files(
    output: &Path,
    report: &ExtrinsicsReport<'_>,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Error> {
    let camera_place = camera_path(output)?;
    let camera_name = camera_place.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let estimate = report.calibration.joint.camera_estimate();
    let camera_text = files::write(&estimate, CameraFormat::Fabkit).map_err(Error::bug)?;
    let text = format_pose(report, camera_name);
    let camera = (camera_place, sign_text(&camera_text).into_bytes());
    Ok(vec![camera, (output.to_owned(), sign_text(&text).into_bytes())])
}

/// Returns the path of a pose's camera file: `pose.camera.yaml` for `pose.yaml`.
///
/// # Errors
/// A path without a file name, or a name that is not UTF-8, which the pose file cannot hold.
///
/// ```
/// use std::path::Path;
///
/// use fabkit_application::calibration_runs::pose_file::camera_path;
/// assert_eq!(camera_path(Path::new("runs/pose.yaml"))?, Path::new("runs/pose.camera.yaml"));
/// assert!(camera_path(Path::new("..")).is_err());
/// # Ok::<(), fabkit_application::calibration_runs::CalibrationRunError>(())
/// ```
pub fn camera_path(output: &Path) -> Result<PathBuf, CalibrationRunError> {
    let stem =
        output.file_stem().ok_or_else(|| CalibrationRunError::NotAFileName(output.into()))?;
    let stem = stem.to_str().ok_or_else(|| CalibrationRunError::NotUtf8(output.into()))?;
    Ok(output.with_file_name(format!("{stem}.camera.yaml")))
}

/// Formats the text of a pose file.
pub fn format_pose(report: &ExtrinsicsReport<'_>, camera_name: &str) -> String {
    let chosen = report.calibration.chosen_trial();
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let mut text = String::new();
    let _ = write!(
        text,
        "# Written by `fabkit calibrate extrinsics`.\n\
         fabkit_pose: 1\n\
         sensor: {}\n\
         # The camera it was solved with; the pose means nothing with another.\n\
         camera: {}\n\
         model: {}\n\
         held_out_rms_px: {:.4}\n\
         # Sensor frame to camera frame, mm.\n\
         camera_from_sensor:\n",
        quoted(report.sensor),
        quoted(camera_name),
        quoted(&chosen.candidate.to_string()),
        chosen.held_out_rms_px
    );
    for row in report.matrix() {
        let _ = writeln!(text, "  - {}", list(row));
    }
    let names = POSE_PARAMETERS.join(", ");
    let _ = writeln!(text, "# Of {names}; rotations turn about the camera's axes.");
    text += "covariance:\n";
    for row in report.pose_covariance() {
        let _ = writeln!(text, "  - {}", list(row));
    }
    text += "# Of pose and camera together, for the camera with these values; zeros: held.\n";
    let _ = write!(
        text,
        "joint_covariance:\n{}",
        StoredJointCovariance::from_estimate(&report.calibration.joint).to_yaml()
    );
    text
}
