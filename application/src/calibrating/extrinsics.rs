//! The pose of a camera, from pins.

use std::path::Path;

use fabkit_calibration::assignment::{Discrepancy, assign};
use fabkit_calibration::extrinsics::{CalibrationOptions, Drawing, calibrate};
use fabkit_calibration::landmarks::{self, PinLandmarks};
use fabkit_calibration::report::ExtrinsicsReport;
use fabkit_camera::CameraEstimate;
use fabkit_camera::files;
use fabkit_designs::Design;
use fabkit_fixtures::DrawnBodies;
use fabkit_geometry::{Point3, Pose, Sensor};

use super::CalibratingError;
use super::captures::PinCaptures;
use crate::Error;
use crate::reading::{self, Expected};

/// Above this part of all marks without a hole, the labels or the camera are wrong, not the pins.
const MAX_DOUBTFUL: f64 = 0.2;

/// What a pose is solved from.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Its nominal camera is where the solver begins.
    pub sensor: &'a Sensor,
    /// The calibrated lens; its covariance is handed on.
    pub camera: &'a CameraEstimate,
    /// What reports call it.
    pub camera_file: &'a str,
    /// The pins that were to be had.
    pub landmarks: &'a PinLandmarks,
    /// What was seen.
    pub captures: &'a PinCaptures<'a>,
    /// Refractive index of the gel behind an interface that is tried.
    pub gel_index: f64,
}

/// Solves for the pose, and gives the account of it.
///
/// # Errors
/// Marks that do not tell the pose, labels that do not fit, and what `look` says.
pub fn solve<R, E: From<CalibratingError>>(
    inputs: &Inputs,
    look: impl FnOnce(&ExtrinsicsReport) -> Result<R, E>,
) -> Result<R, E> {
    let Inputs { sensor, camera, landmarks, captures, .. } = *inputs;
    let nominal = sensor.camera.sensor_from_camera.inverse();
    let Some(assignment) = assign(camera.camera(), &nominal, &captures.marked, &landmarks.pins)
    else {
        return Err(CalibratingError::NotAssigned.into());
    };
    let marks: usize = captures.records.iter().map(|record| record.pins_found).sum();
    let mislabelled = |doubt: &&Discrepancy| !matches!(doubt, Discrepancy::Missing { .. });
    let doubtful = assignment.discrepancies.iter().filter(mislabelled).count();
    let bodies = DrawnBodies::of(sensor, camera.camera()).map_err(CalibratingError::from)?;
    let displacements =
        |pose: &Pose, contacts: &[Point3<f64>]| bodies.displacements(pose, contacts);
    let drawn = bodies.interface();
    let drawn = drawn.map(|interface| Drawing { interface, displacements: &displacements });
    let options =
        CalibrationOptions { gel_index: inputs.gel_index, drawn, ..CalibrationOptions::default() };
    let start = &assignment.model.camera_from_sensor;
    let calibration = calibrate(camera, &assignment.observations, start, Some(&nominal), &options)
        .map_err(CalibratingError::from)?;
    let report = ExtrinsicsReport {
        sensor: &sensor.name,
        camera_file: inputs.camera_file,
        landmarks,
        captures: &captures.records,
        discrepancies: &assignment.discrepancies,
        calibration: &calibration,
        not_drawn: bodies.why_not(),
    };
    if doubtful as f64 > MAX_DOUBTFUL * marks as f64 {
        let discrepancies = report.doubt_sentences();
        return Err(CalibratingError::Doubtful { doubtful, marks, discrepancies }.into());
    }
    look(&report)
}

/// Reads a camera's file.
///
/// # Errors
/// A file that cannot be read, or holds no camera.
pub fn read_camera(path: &Path) -> Result<CameraEstimate, Error> {
    let hint = "fabkit reads its own camera files and those of OpenCV, ROS and Kalibr";
    let text =
        reading::read_text(path, Expected { what: "a camera's file", max_bytes: 1 << 20, hint })?;
    let wrong = |source| CalibratingError::Camera { file: path.into(), source };
    Ok(files::read(&text).map_err(wrong)?)
}

/// Reads a dome's landmarks.
///
/// # Errors
/// A file that cannot be read, or holds none.
pub fn read_landmarks(path: &Path) -> Result<PinLandmarks, Error> {
    let expected = Expected {
        what: "a list of landmarks",
        max_bytes: landmarks::MAX_BYTES as u64,
        hint: "it names each hole of the dome once for each kind of pin",
    };
    let text = reading::read_text(path, expected)?;
    landmarks(&text, Some(path))
}

/// A dome's landmarks from their text, which came from `file`.
///
/// # Errors
/// What is wrong with them.
pub fn landmarks(text: &str, file: Option<&Path>) -> Result<PinLandmarks, Error> {
    PinLandmarks::from_json(text).map_err(|source| {
        CalibratingError::Landmarks { file: file.map(Path::to_owned), source }.into()
    })
}

/// Those that a dome comes with.
///
/// # Errors
/// A fixture without pins.
pub fn landmarks_of(dome: &Design) -> Result<&PinLandmarks, CalibratingError> {
    let fixture = || dome.sensor.name.clone();
    dome.documents().next().ok_or_else(|| CalibratingError::NoPins { fixture: fixture() })
}
