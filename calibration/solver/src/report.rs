//! Reports of a calibration, for scripts and for people.
//!
//! [`ExtrinsicsReport::to_json`] is for scripts. [`ExtrinsicsReport::to_html`] is one file that needs no network and no
//! script, and can be printed.

mod findings;
mod html;
mod intrinsics;
mod json;
mod maps;

use fabkit_report::round_tick_step;
use nalgebra::Vector2;

pub use intrinsics::{ImageRecord, IntrinsicsReport};

use crate::assignment::Discrepancy;
use crate::extrinsics::{PoseCalibration, Trial};
use crate::landmarks::PinLandmarks;
use crate::model::Observation;
use crate::significance::LeftOut;

/// Image of pins in a report.
#[derive(Clone, Debug, PartialEq)]
pub struct CaptureRecord {
    /// Name of its file.
    pub file: String,
    /// Number of pins that its label names; `None` without a label.
    pub pins_expected: Option<usize>,
    /// Number of marks found in it.
    pub pins_found: usize,
    /// Fainter spots that were left out; none where marks come from elsewhere.
    pub left_out: LeftOut,
}

/// Part of a capture around a pin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PinCrop {
    /// Index of the observation in the calibration.
    pub observation: usize,
    /// First column and row of the part in the capture, px.
    pub first_px: [u32; 2],
    /// Width and height of the part, px.
    pub size_px: [u32; 2],
    /// PNG file of the part.
    pub png: Vec<u8>,
}

/// Extrinsic calibration with its sources.
///
/// ```
/// use fabkit_calibration::extrinsics::{CalibrationOptions, calibrate};
/// use fabkit_calibration::landmarks::PinLandmarks;
/// use fabkit_calibration::model::Model;
/// use fabkit_calibration::report::{CaptureRecord, ExtrinsicsReport};
/// use fabkit_calibration::significance::LeftOut;
/// use fabkit_calibration::synthetic::SyntheticSensor;
/// use fabkit_camera::Camera;
/// use fabkit_geometry::Pose;
/// let map = r#"{"1": [0, 0, 15], "2": [9, 0, 12], "3": [0, 9, 12], "4": [-9, 0, 12],
///     "5": [0, -12, 9], "6": [12, 0, 9], "7": [-12, 0, 9]}"#;
/// let landmarks = PinLandmarks::from_json(map)?;
/// let (camera, pose) = (Camera::equidistant(640, 480, 2.8)?, Pose::translation(0.0, 0.0, 7.0));
/// let captures = vec![landmarks.pins.iter().collect(); 3];
/// let seen = SyntheticSensor::new(Model::new(camera, pose), 1).observe(&captures, 0.3)?;
/// let options = CalibrationOptions::default();
/// let calibration = calibrate(&camera.into(), &seen, &pose, Some(&pose), &options)?;
/// let record = |file: &str| {
///     let file = file.to_owned();
///     CaptureRecord { file, pins_expected: Some(7), pins_found: 7, left_out: LeftOut::default() }
/// };
/// let report = ExtrinsicsReport {
///     sensor: "rtac0",
///     camera_file: "lens.yaml",
///     landmarks: &landmarks,
///     captures: &["a.png", "b.png", "c.png"].map(record),
///     discrepancies: &[],
///     calibration: &calibration,
///     drawing_unused_reason: None,
///     mark_offsets_unknown_reason: Some("the design does not say what the layer is"),
///     saturated_fraction: 0.0,
///     crops: &[],
/// };
/// assert_eq!(report.to_json()["pins"], 21);
/// let warning = &report.warnings()[0];
/// assert!(warning.starts_with("The distance of marks from the pins' tips is not known"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ExtrinsicsReport<'a> {
    /// Name of the sensor.
    pub sensor: &'a str,
    /// Name of the camera file.
    pub camera_file: &'a str,
    /// Pins that could be pressed.
    pub landmarks: &'a PinLandmarks,
    /// Captures, in the order of the observations' capture indices.
    pub captures: &'a [CaptureRecord],
    /// Differences between captures and their labels.
    pub discrepancies: &'a [Discrepancy],
    /// Result of the calibration.
    pub calibration: &'a PoseCalibration,
    /// Reason why the drawn bodies were not used, as a sentence.
    pub drawing_unused_reason: Option<&'a str>,
    /// Reason why the offsets of marks from their tips are unknown, if they are.
    pub mark_offsets_unknown_reason: Option<&'a str>,
    /// Largest fraction of lit pixels that are saturated in a capture, 0 to 1.
    pub saturated_fraction: f64,
    /// Outlying pins, as far as there are images of them.
    pub crops: &'a [PinCrop],
}

impl ExtrinsicsReport<'_> {
    /// Lists the observations of a capture with two residuals, observed minus projected, px: of the fit to all captures
    /// and of the fit to the others.
    fn observations_of_capture(
        &self,
        capture: usize,
    ) -> impl Iterator<Item = (&Observation, Option<Vector2<f64>>, Option<Vector2<f64>>)> {
        let chosen = self.calibration.chosen_trial();
        let observations = &self.calibration.observations;
        let residuals = chosen.fit.residuals_px(observations);
        let all = observations.iter().zip(residuals).zip(&chosen.held_out_px);
        all.map(|((o, r), held)| (o, r, *held)).filter(move |(o, ..)| o.contact.capture == capture)
    }

    fn chosen(&self) -> &Trial {
        self.calibration.chosen_trial()
    }
}

/// Computes the root mean square length; `None` for an empty list, or if a residual is missing.
fn rms_px(residuals: impl Iterator<Item = Option<Vector2<f64>>>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for residual in residuals {
        sum += residual?.norm_squared();
        count += 1;
    }
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// Returns the factor by which residuals are enlarged in drawings, so that the longest takes about 3 % of the image's
/// width: a round number, so that lengths can be read off.
fn magnification(residuals_px: impl Iterator<Item = Vector2<f64>>, width_px: f64) -> f64 {
    const LONGEST: f64 = 0.03;
    let longest_px = residuals_px.map(|residual| residual.norm()).fold(1e-9, f64::max);
    round_tick_step(LONGEST * width_px / longest_px, 1.0)
}
