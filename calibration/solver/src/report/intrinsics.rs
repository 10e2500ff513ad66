//! Reports of an intrinsic calibration: JSON here, HTML in [`html`].

mod html;

use serde_json::{Map, Value, json};

use crate::intrinsics::{COVERAGE, LensCalibration, LensCandidate, RaySigmas, SolvedView};

/// Image of the board, or view of a list of corners, in a report.
///
/// ```
/// use fabkit_calibration::board::BoardNotFound;
/// use fabkit_calibration::report::ImageRecord;
/// // An image that shows no board, with the detector's reason.
/// let reason = BoardNotFound::Incomplete { found: 30, expected: 40 };
/// let record = ImageRecord {
///     file: "07.png".into(),
///     corners_found: 0,
///     unused_reason: Some(reason.to_string()),
/// };
/// let reason = record.unused_reason.unwrap();
/// assert!(reason.ends_with("a grid of 30 corners was found, and the board has 40"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageRecord {
    /// File name of the image, or name of the view in the list.
    pub file: String,
    /// Number of corners found in it.
    pub corners_found: usize,
    /// Reason why it was not used.
    pub unused_reason: Option<String>,
}

/// Intrinsic calibration with its sources.
#[derive(Clone, Copy, Debug)]
pub struct IntrinsicsReport<'a> {
    /// Name of the sensor.
    pub sensor: &'a str,
    /// Name of the board.
    pub board: &'a str,
    /// All images, including those not used.
    pub images: &'a [ImageRecord],
    /// Result of the calibration.
    pub calibration: &'a LensCalibration,
}

impl IntrinsicsReport<'_> {
    /// Writes the JSON report `fabkit-intrinsics`, version 1. Lengths are in mm, angles in degrees if the name says so,
    /// pixels in px. A root mean square takes both coordinates of a corner together.
    pub fn to_json(&self) -> Value {
        let calibration = self.calibration;
        let camera = calibration.estimate.camera();
        let parameters: Map<String, Value> = camera
            .parameters()
            .into_iter()
            .map(|(name, value)| (name.to_owned(), json!(value)))
            .collect();
        let covariance = calibration.estimate.covariance().map(|matrix| {
            let rows = matrix.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>());
            rows.collect::<Vec<_>>()
        });
        let coverage = &calibration.advice.coverage;
        json!({
            "format": "fabkit-intrinsics",
            "version": 1,
            "sensor": self.sensor,
            "board": self.board,
            "image_px": [camera.width_px(), camera.height_px()],
            "model": calibration.model.name(),
            "parameters": parameters,
            "sigmas": calibration.estimate.sigmas(),
            "covariance": covariance,
            "covariance_of": calibration.estimate.names(),
            "focal_px_per_rad": calibration.focal_px[0],
            "focal_sigma_px_per_rad": calibration.focal_px[1],
            // Standard deviations of rays relative to each other, which are comparable between models.
            "rays": {
                "seen": rays_json(&calibration.rays.observed),
                "beyond": calibration.rays.extrapolated.as_ref().map(rays_json),
            },
            "reprojection_rms_px": calibration.rms_px,
            "residual_scale": calibration.residual_scale,
            "corners": calibration.views.iter().map(|view| view.corners.len()).sum::<usize>(),
            "pictures": self.images.iter().map(image_json).collect::<Vec<_>>(),
            "views": self.views().map(|(view, growth, tilt_deg, adds_nothing)| json!({
                "file": view.name,
                "corners": view.corners.len(),
                "rms_px": view.rms_px,
                "tilt_deg": tilt_deg,
                // JSON has no infinity: null means that the other views do not determine the camera.
                "sigma_growth_without": growth.is_finite().then_some(growth),
                "adds_nothing": adds_nothing,
            })).collect::<Vec<_>>(),
            "coverage": {
                "columns": COVERAGE[0],
                "rows": COVERAGE[1],
                "corners": coverage.corners,
                "share": coverage.covered_fraction,
                "seen_deg": coverage.observed_max_angle_deg,
                "image_deg": coverage.image_max_angle_deg,
            },
            "tried": calibration.candidates.iter().map(candidate_json).collect::<Vec<_>>(),
            "warnings": self.warnings(),
        })
    }

    /// Describes the uncertainty of the rays: a name and a text for each part of the image.
    pub fn rays(&self) -> Vec<(&'static str, String)> {
        let known = |RaySigmas { typical, worst }: &RaySigmas| {
            format!(
                "{:.3} mrad ({:.3} px), {:.3} mrad ({:.3} px) at worst",
                1e3 * typical.angle_rad,
                typical.px,
                1e3 * worst.angle_rad,
                worst.px
            )
        };
        let rays = &self.calibration.rays;
        let beyond = rays.extrapolated.as_ref().map(|beyond| ("rays elsewhere", known(beyond)));
        [("rays at corners", known(&rays.observed))].into_iter().chain(beyond).collect()
    }

    /// Lists images that could not be used, then what the calibration lacks.
    pub fn warnings(&self) -> Vec<String> {
        let unused = self.images.iter().filter_map(|image| {
            let reason = image.unused_reason.as_ref()?;
            Some(format!("{} was not used: {reason}", image.file))
        });
        unused.chain(self.calibration.advice.warnings.iter().cloned()).collect()
    }

    /// Lists each view with the growth of a standard deviation without it, its tilt in degrees, and whether it adds
    /// nothing.
    fn views(&self) -> impl Iterator<Item = (&SolvedView, f64, f64, bool)> {
        let calibration = self.calibration;
        let pairs = calibration.views.iter().zip(&calibration.advice.influence);
        pairs.map(|(view, influence)| {
            (view, influence.growth, influence.tilt_deg, influence.adds_nothing)
        })
    }
}

/// Describes an image.
fn image_json(image: &ImageRecord) -> Value {
    json!({
        "file": image.file,
        "corners_found": image.corners_found,
        "used": image.unused_reason.is_none(),
        "reason": image.unused_reason,
    })
}

/// Describes the uncertainty of rays over a part of the image.
fn rays_json(RaySigmas { typical, worst }: &RaySigmas) -> Value {
    json!({
        "typical_mrad": 1e3 * typical.angle_rad,
        "typical_px": typical.px,
        "worst_mrad": 1e3 * worst.angle_rad,
        "worst_px": worst.px,
    })
}

/// Describes a lens model that was tried.
fn candidate_json(candidate: &LensCandidate) -> Value {
    json!({
        "model": candidate.model.name(),
        "parameters": candidate.parameters,
        "reprojection_rms_px": candidate.fit.map(|fit| fit.rms_px),
        // JSON has no infinity: null means that the other views do not determine the camera.
        "held_out_rms_px": candidate.fit.map(|fit| fit.held_out_rms_px).filter(|v| v.is_finite()),
        "bayesian_information_criterion": candidate.fit.map(|fit| fit.criterion),
    })
}
