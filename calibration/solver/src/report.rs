//! What was calibrated, for scripts and for people.
//!
//! [`ExtrinsicsReport::to_json`] is the machine's account; [`ExtrinsicsReport::to_html`] one file
//! that needs no network and no script, and prints on paper.

mod html;
mod intrinsics;
mod json;
mod maps;
mod words;

use fabkit_report::step;
use nalgebra::Vector2;

pub use intrinsics::{IntrinsicsReport, PictureRecord};

use crate::assignment::Discrepancy;
use crate::extrinsics::{PoseCalibration, Trial};
use crate::landmarks::PinLandmarks;
use crate::model::Observation;

/// One picture of pins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CaptureRecord {
    /// Name of its file.
    pub file: String,
    /// How many pins its label names; `None` without a label.
    pub pins_expected: Option<usize>,
    /// How many marks were found in it.
    pub pins_found: usize,
}

/// A part of a capture around a pin.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Which of the calibration's observations.
    pub observation: usize,
    /// Its first column and row in the capture, px.
    pub first_px: [u32; 2],
    /// Its width and height, px.
    pub size_px: [u32; 2],
    /// Its file.
    pub png: Vec<u8>,
}

/// A calibration with where it comes from.
#[derive(Clone, Copy, Debug)]
pub struct ExtrinsicsReport<'a> {
    /// Name of the sensor.
    pub sensor: &'a str,
    /// Name of the camera's file.
    pub camera_file: &'a str,
    /// The pins that were to be had.
    pub landmarks: &'a PinLandmarks,
    /// In the order of the observations' capture numbers.
    pub captures: &'a [CaptureRecord],
    /// What did not fit its label.
    pub discrepancies: &'a [Discrepancy],
    /// The result.
    pub calibration: &'a PoseCalibration,
    /// Why the bodies that the design draws took no part, as a sentence.
    pub not_drawn: Option<&'a str>,
    /// Why it is not known how far from their tips marks are found, if it is not.
    pub not_marked: Option<&'a str>,
    /// The largest share of what is lit that is saturated in a capture, 0 to 1.
    pub saturated: f64,
    /// Pins that are far off, as far as there are pictures of them.
    pub crops: &'a [Crop],
}

impl ExtrinsicsReport<'_> {
    /// The observations of a capture with their residuals, observed minus projected, px: of the fit
    /// and of the fit to the other captures.
    fn of_capture(
        &self,
        capture: usize,
    ) -> impl Iterator<Item = (&Observation, Option<Vector2<f64>>, Option<Vector2<f64>>)> {
        let chosen = self.calibration.chosen();
        let observations = &self.calibration.observations;
        let residuals = chosen.fit.residuals_px(observations);
        let all = observations.iter().zip(residuals).zip(&chosen.held_out_px);
        all.map(|((o, r), held)| (o, r, *held)).filter(move |(o, ..)| o.contact.capture == capture)
    }

    fn chosen(&self) -> &Trial {
        self.calibration.chosen()
    }
}

/// Root mean square length; `None` for nothing, or where a residual is missing.
fn rms_px(residuals: impl Iterator<Item = Option<Vector2<f64>>>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for residual in residuals {
        sum += residual?.norm_squared();
        count += 1;
    }
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// How many times their length residuals are drawn, so that the longest one takes about this part of
/// the picture's width: a round number, so that lengths can be judged.
fn magnification(residuals_px: impl Iterator<Item = Vector2<f64>>, width_px: f64) -> f64 {
    const LONGEST: f64 = 0.03;
    let longest_px = residuals_px.map(|residual| residual.norm()).fold(1e-9, f64::max);
    step(LONGEST * width_px / longest_px, 1.0)
}
