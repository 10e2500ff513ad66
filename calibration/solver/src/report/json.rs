//! JSON report `fabkit-extrinsics`, version 1.

use fabkit_camera::files::StoredJointCovariance;
use fabkit_camera::{POSE_PARAMETER_COUNT, POSE_PARAMETERS};
use serde_json::{Value, json};

use super::{ExtrinsicsReport, rms_px};
use crate::extrinsics::Trial;
use crate::observability::UnobservableCombination;

impl ExtrinsicsReport<'_> {
    /// Writes the complete report. Lengths are in mm, angles in rad, pixels in px. A root mean square takes both
    /// coordinates of a pin together.
    pub fn to_json(&self) -> Value {
        let calibration = self.calibration;
        let chosen = self.chosen();
        let model = calibration.model();
        let captures: Vec<Value> =
            (0..self.captures.len()).map(|capture| self.capture_json(capture)).collect();
        let parameters = chosen.fit.parameters.iter().map(|parameter| {
            let (value, sigma) = self.value_and_sigma(*parameter).unwrap_or_default();
            json!({ "name": parameter.to_string(), "value": value, "sigma": sigma })
        });
        let camera = model.camera.parameters().into_iter();
        let trials = calibration.selection.trials.iter().map(trial_json);
        json!({
            "format": "fabkit-extrinsics",
            "version": 1,
            "sensor": self.sensor,
            "camera_file": self.camera_file,
            "fixture": self.landmarks.fixture,
            "captures": captures,
            "pins": calibration.observations.len(),
            "reprojection_rms_px": number(chosen.rms_px),
            "held_out_rms_px": number(chosen.held_out_rms_px),
            "pin_scatter_rms_px": calibration.scatter.map(|s| s.rms_px),
            "pin_scatter_degrees_of_freedom": calibration.scatter.map(|s| s.degrees_of_freedom),
            // null if the pose alone could not be fitted; `not_fitted` says why.
            "plain": calibration.plain_trial().map(|plain| json!({
                "reprojection_rms_px": number(plain.rms_px),
                "held_out_rms_px": number(plain.held_out_rms_px),
            })),
            "misfit": number(calibration.misfit),
            "model": {
                "name": chosen.candidate.to_string(),
                "parameters": parameters.collect::<Vec<_>>(),
                "camera": camera.map(|(name, value)| (name.to_owned(), json!(value))).collect::<serde_json::Map<_, _>>(),
                "interface": model.camera.interface().kind_name(),
                "is_drawn_behind": model.camera.interface().has_drawn_bodies_behind(),
                "unobservable": chosen.unobservable.iter().map(unobservable_json).collect::<Vec<_>>(),
            },
            "seating_offset_observable": calibration.selection.is_seating_observable,
            "camera_from_sensor": self.matrix(),
            "covariance": self.pose_covariance(),
            "covariance_of": POSE_PARAMETERS,
            "joint_covariance": self.joint_json(),
            "tried": trials.collect::<Vec<_>>(),
            "explanations": calibration.selection.trials.iter().map(explanation_json).collect::<Vec<_>>(),
            "within_tolerances": chosen.within_tolerances(),
            "jackknife_ratio": calibration.jackknife_ratio(),
            "errors": {
                "pins": calibration.errors.pins,
                "dome_shift_mm": calibration.errors.dome_mm,
                "dome_turn_rad": calibration.errors.dome_rad,
                "marks_px": calibration.errors.marks_px,
            },
            "cross_checks": self.cross_checks_json(),
            "marks_rendered": self.mark_offsets_unknown_reason.is_none(),
            "not_fitted": calibration.selection.failed.iter().map(|(candidate, error)| {
                json!({ "name": candidate.to_string(), "reason": error.to_string() })
            }).collect::<Vec<_>>(),
            "explanation": self.explanation(),
            "warnings": self.warnings(),
        })
    }

    /// Describes the comparison with other captures.
    fn cross_checks_json(&self) -> Value {
        let checks = &self.calibration.checks;
        let without = self.captures.iter().enumerate().map(|(capture, record)| {
            json!({
                "file": record.file,
                "surface_mm": checks.without_mm.get(capture).copied().flatten(),
                "influence": checks.influence(capture),
            })
        });
        let far = checks.outliers.iter().map(|(observation, sigmas)| {
            let observation = &self.calibration.observations[*observation];
            json!({
                "file": self.captures.get(observation.contact.capture).map(|record| &record.file),
                "hole": observation.contact.hole,
                "pixel": [observation.pixel.x, observation.pixel.y],
                "sigmas": sigmas,
            })
        });
        json!({
            "sigma_mm": checks.sigma_mm,
            "halves_mm": checks.halves_mm,
            "halves_expected_mm": checks.halves_expected_mm(),
            "without": without.collect::<Vec<_>>(),
            "far_pins": far.collect::<Vec<_>>(),
        })
    }

    /// Transform from sensor frame to camera frame, 4 x 4, row by row, mm.
    pub fn matrix(&self) -> [[f64; 4]; 4] {
        let pose = &self.calibration.model().camera_from_sensor;
        std::array::from_fn(|r| {
            std::array::from_fn(|c| match (r, c) {
                (3, 3) => 1.0,
                (3, _) => 0.0,
                (_, 3) => pose.translation_mm()[r],
                _ => pose.rotation()[(r, c)],
            })
        })
    }

    /// Covariance of the pose alone, in the order of [`POSE_PARAMETERS`].
    pub fn pose_covariance(&self) -> [[f64; POSE_PARAMETER_COUNT]; POSE_PARAMETER_COUNT] {
        self.calibration.joint.pose_covariance()
    }

    /// Writes the joint covariance as in a pose file.
    fn joint_json(&self) -> Value {
        let StoredJointCovariance { names, camera_values, matrix } =
            StoredJointCovariance::from_estimate(&self.calibration.joint);
        let rows = matrix.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>());
        json!({
            "names": names,
            "camera_values": camera_values,
            "matrix": rows.collect::<Vec<_>>(),
        })
    }

    /// Describes a capture with its pins.
    fn capture_json(&self, capture: usize) -> Value {
        let record = &self.captures[capture];
        let pins: Vec<Value> = self
            .observations_of_capture(capture)
            .map(|(o, residual, held_out)| {
                json!({
                    "hole": o.contact.hole,
                    "pixel": [o.pixel.x, o.pixel.y],
                    "sigma_px": o.sigma_px,
                    "residual_px": residual.map(|r| [r.x, r.y]),
                    "held_out_px": held_out.map(|r| [r.x, r.y]),
                })
            })
            .collect();
        json!({
            "file": record.file,
            "pins_found": record.pins_found,
            "pins_expected": record.pins_expected,
            "left_out": record.left_out.count,
            "left_out_contrast": record.left_out.max_contrast,
            "pins_used": pins.len(),
            "rms_px": rms_px(self.observations_of_capture(capture).map(|(_, r, _)| r)),
            "held_out_rms_px": rms_px(self.observations_of_capture(capture).map(|(.., held)| held)),
            "pins": pins,
        })
    }
}

/// Describes an explanation with its differences from the drawing.
fn explanation_json(trial: &Trial) -> Value {
    let differs = trial.differences_beyond_tolerance().map(|difference| {
        json!({
            "name": difference.name,
            "by": difference.deviation,
            "sigma": difference.sigma,
            "sigmas": difference.sigmas(),
        })
    });
    json!({
        "name": trial.candidate.to_string(),
        "held_out_rms_px": number(trial.held_out_rms_px),
        "log_predictive_density": number(trial.log_predictive_density()),
        "within_tolerances": trial.within_tolerances(),
        "differs": differs.collect::<Vec<_>>(),
    })
}

/// Describes a trial with its errors.
fn trial_json(trial: &Trial) -> Value {
    json!({
        "name": trial.candidate.to_string(),
        "parameters": trial.fit.parameters.len(),
        "reprojection_rms_px": number(trial.rms_px),
        "held_out_rms_px": number(trial.held_out_rms_px),
        "aicc": number(trial.aicc),
        "from_design_mm": trial.from_design_mm,
        "plausible": trial.is_position_plausible(),
        "unobservable": trial.unobservable.iter().map(unobservable_json).collect::<Vec<_>>(),
    })
}

fn unobservable_json(unknown: &UnobservableCombination) -> Value {
    let terms = unknown.terms.iter();
    let terms =
        terms.map(|(parameter, part)| json!({ "name": parameter.to_string(), "part": part }));
    json!({ "remaining": unknown.remaining, "terms": terms.collect::<Vec<_>>() })
}

/// Returns `None` (JSON null) for numbers that are not finite, which JSON does not have.
fn number(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}
