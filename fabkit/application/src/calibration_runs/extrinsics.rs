//! Calibration of the camera's pose from presses of pins.

use std::path::Path;

use fabkit_calibration::assignment::{Discrepancy, assign};
use fabkit_calibration::extrinsics::{
    CalibrationOptions, Drawing, PoseCalibration, SurfaceNormal, calibrate, solve_drawn,
};
use fabkit_calibration::image::GreyImage;
use fabkit_calibration::landmarks::{self, PinLandmarks};
use fabkit_calibration::model::{MarkOffsets, Model, Observation};
use fabkit_calibration::pin_captures::images::read_grey;
use fabkit_calibration::pin_captures::{PinCaptureError, PinCaptures};
use fabkit_calibration::report::{ExtrinsicsReport, PinCrop};
use fabkit_camera::files::CameraFile;
use fabkit_camera::{CameraEstimate, Vector2};
use fabkit_capture::LightConstants;
use fabkit_designs::Design;
use fabkit_files::Error;
use fabkit_files::reading::{self, ExpectedFile};
use fabkit_fixtures::halves::is_from_halves;
use fabkit_fixtures::{DrawnBodies, Project};
use fabkit_geometry::{Point3, Pose};
use fabkit_scene::read_camera_file;

use super::CalibrationRunError;
use super::marks::{LandmarkShapes, PinMarkRenderer, RenderingView};

/// Largest share of marks without a hole. Above it, the labels or the camera are wrong rather than single pins.
const MAX_UNMATCHED_SHARE: f64 = 0.2;

/// Largest distance of the fitted camera from its designed position at which pins are still rendered, mm. A camera
/// farther off may stand inside a drawn body.
const MAX_RENDERED_OFFSET_MM: f64 = 3.0;

/// Number of times the pins are rendered again, each time from the pose and light of the last fit.
const RENDERING_ROUNDS: usize = 2;

/// Outlier limit for marks of protrusions: this many times the median residual, and at least `MIN_OUTLIER_PX` pixels. A mark
/// beyond it belongs to something else.
const OUTLIER_FACTOR: f64 = 5.0;
const MIN_OUTLIER_PX: f64 = 4.0;

/// Largest number of image crops of outlying pins, and side of each crop, px. The side equals the smallest side that an
/// image may have.
const MAX_CROPS: usize = 8;
const CROP_PX: usize = 64;

/// Inputs of the pose calibration.
#[derive(Clone, Copy, Debug)]
pub struct PoseCalibrationInputs<'a> {
    /// Project whose nominal camera is the solver's start. Its semi-domes may be the pressed fixtures.
    pub project: &'a Project,
    /// Calibrated lens; its covariance is propagated.
    pub camera: &'a CameraEstimate,
    /// Name of the camera file in reports.
    pub camera_file: &'a str,
    /// Landmarks of the fixture.
    pub landmarks: &'a PinLandmarks,
    /// Captures with the detected marks.
    pub captures: &'a PinCaptures<'a>,
    /// Radius of the pins' tips, mm; 0 if unknown, and for protrusions of halves.
    pub tip_radius_mm: f64,
    /// Refractive index of the gel for the candidate model with a refracting interface.
    pub gel_index: f64,
}

/// Solves for the camera's pose and hands the report to `look`, whose result it returns.
///
/// # Errors
/// Marks that do not determine the pose, labels that do not fit, and errors of `look`.
pub fn solve<R, E: From<Error>>(
    inputs: &PoseCalibrationInputs,
    look: impl FnOnce(&ExtrinsicsReport) -> Result<R, E>,
) -> Result<R, E> {
    let PoseCalibrationInputs { project, camera, landmarks, captures, .. } = *inputs;
    check_camera_size(camera, captures)?;
    let sensor = &project.design.sensor;
    let nominal = sensor.camera.sensor_from_camera.inverse();
    let Some(mut assignment) = assign(camera.camera(), &nominal, &captures.marked, &landmarks.pins)
    else {
        return Err(Error::from(PinCaptureError::NotAssigned).into());
    };
    let of_halves = is_from_halves(landmarks);
    if of_halves {
        // A protrusion may be cut by the image border, be too large for a pin, or carry several dots. Missing and
        // additional marks are therefore no errors.
        assignment.discrepancies.clear();
    }
    let marks: usize = captures.records.iter().map(|record| record.pins_found).sum();
    let mislabelled = |doubt: &&Discrepancy| !matches!(doubt, Discrepancy::Missing { .. });
    let doubtful = assignment.discrepancies.iter().filter(mislabelled).count();
    let bodies = DrawnBodies::new(sensor, camera.camera()).map_err(CalibrationRunError::from);
    let bodies = bodies.map_err(Error::from)?;
    let displacements =
        |pose: &Pose, contacts: &[Point3<f64>]| bodies.displacements(pose, contacts);
    let drawn = bodies.interface();
    let drawn = drawn.map(|interface| Drawing { interface, displacements: &displacements });
    let start = &assignment.model.camera_from_sensor;
    let mut observations = assignment.observations;
    let touch = sensor.touch.as_ref();
    let normal = touch.map(|touch| |place: &Point3<f64>| touch.depth_mm(place).1);
    let outward = normal.as_ref().map(|normal| SurfaceNormal(normal));
    let solve = |observations: &[Observation], offsets: &MarkOffsets| {
        let options = CalibrationOptions {
            gel_index: inputs.gel_index,
            drawing: drawn,
            mark_offsets: Some(offsets),
            outward,
            ..CalibrationOptions::default()
        };
        calibrate(camera, observations, start, Some(&nominal), &options)
    };
    let constants = LightConstants::for_sensor(sensor);
    // Only marks found by fabkit's detector have its offset. Pixels from elsewhere are taken as tips.
    let rendered = if captures.is_detected {
        let shapes = LandmarkShapes::find(project, landmarks, captures, inputs.tip_radius_mm);
        PinMarkRenderer::new(sensor, camera.camera(), &constants, shapes)
    } else {
        Ok(None)
    };
    let calibration = match &rendered {
        Ok(Some(rendered)) => {
            // The first rendering combines the rotation of the assignment with the designed position. Later ones use
            // the pose that was fitted through the drawn bodies, and the light estimated from the marks.
            let turned = Pose::new(*start.rotation(), *nominal.translation_mm()).unwrap_or(nominal);
            let from = RenderingView::in_assumed_light(turned);
            let mut offsets = rendered.compute_offsets(&from, &observations, None);
            for _ in 0..RENDERING_ROUNDS {
                let mut model = Model::new(camera.camera().without_interface(), turned);
                model.expected_translation_mm = Some(*nominal.translation_mm());
                model.mark_offsets = offsets.clone();
                let loss = CalibrationOptions::default().loss;
                let through = |drawing| solve_drawn(&observations, &model, &drawing, loss).ok();
                // Without a fit through the drawn bodies, the offsets stay as they are.
                let Some(fit) = drawn.and_then(through) else { break };
                // Residuals are meaningful only now that the rendered offsets are included.
                if of_halves {
                    let residuals = fit.residuals_px(&observations);
                    observations = remove_outliers(observations, &residuals);
                }
                let from = RenderingView::from_model(&fit.model);
                let off = from.camera_from_sensor.translation_mm() - turned.translation_mm();
                // Too far from the design: the rendered offsets would be meaningless, so the last good ones are kept.
                if off.norm() > MAX_RENDERED_OFFSET_MM {
                    break;
                }
                offsets = rendered.compute_offsets(&from, &observations, Some(&offsets));
            }
            solve(&observations, &offsets)
        }
        _ => solve(&observations, &MarkOffsets::default()),
    };
    let calibration = calibration.map_err(CalibrationRunError::from).map_err(Error::from)?;
    let not_marked = match rendered {
        Ok(Some(_)) => None,
        Ok(None) if !captures.is_detected => {
            Some("pixels that were given instead of images are taken for tips".to_owned())
        }
        Ok(None) => Some("the light constants of these pins' layers are not known".to_owned()),
        Err(error) => Some(error.to_string()),
    };
    let report = ExtrinsicsReport {
        sensor: &sensor.name,
        camera_file: inputs.camera_file,
        landmarks,
        captures: &captures.records,
        discrepancies: &assignment.discrepancies,
        calibration: &calibration,
        drawing_unused_reason: bodies.missing_reason(),
        mark_offsets_unknown_reason: not_marked.as_deref(),
        saturated_fraction: captures.saturated,
        crops: &crop_outliers(&calibration, captures),
    };
    // Checked after the report is built, because the error quotes its sentences.
    if doubtful as f64 > MAX_UNMATCHED_SHARE * marks as f64 {
        let discrepancies = report.discrepancy_sentences();
        let doubtful = CalibrationRunError::Doubtful { doubtful, marks, discrepancies };
        return Err(Error::from(doubtful).into());
    }
    look(&report)
}

/// Removes observations with a large residual, whose mark belongs to something else: for example a dot beside a
/// protrusion whose own mark was not detected.
fn remove_outliers(
    observations: Vec<Observation>,
    residuals: &[Option<Vector2<f64>>],
) -> Vec<Observation> {
    let off_px = residuals.iter().map(|residual| residual.map_or(f64::INFINITY, |r| r.norm()));
    let off_px: Vec<f64> = off_px.collect();
    let mut sorted = off_px.clone();
    sorted.sort_by(f64::total_cmp);
    // The median is robust: the outliers in question do not move it.
    let typical_px = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
    let most_px = (OUTLIER_FACTOR * typical_px).max(MIN_OUTLIER_PX);
    let kept = observations.into_iter().zip(off_px).filter(|(_, off_px)| *off_px <= most_px);
    kept.map(|(observation, _)| observation).collect()
}

/// Crops the images around outlying pins. Images that cannot be read again are skipped.
fn crop_outliers(calibration: &PoseCalibration, captures: &PinCaptures<'_>) -> Vec<PinCrop> {
    let Some(folder) = &captures.folder else { return Vec::new() };
    let crop = |observation: usize| {
        let pin = calibration.observations.get(observation)?;
        let record = captures.records.get(pin.contact.capture)?;
        let picture = read_grey(&folder.join(&record.file)).ok()?;
        let size = [picture.width_px(), picture.height_px()];
        let [columns, rows] = [0, 1].map(|axis| {
            // No image has a side below `CROP_PX`, so the subtraction cannot underflow.
            let from = pin.pixel[axis].round().max(0.0) as usize;
            let from = from.saturating_sub(CROP_PX / 2).min(size[axis] - CROP_PX);
            from..from + CROP_PX
        });
        let grey: Vec<f32> = rows
            .clone()
            .flat_map(|row| columns.clone().map(move |column| row * size[0] + column))
            .map(|at| picture.values()[at])
            .collect();
        let size_px = [columns.len() as u32, rows.len() as u32];
        let png = GreyImage::new(size_px[0], size_px[1], grey).ok()?.to_png();
        Some(PinCrop {
            observation,
            first_px: [columns.start as u32, rows.start as u32],
            size_px,
            png,
        })
    };
    calibration.checks.outliers.iter().take(MAX_CROPS).filter_map(|(pin, _)| crop(*pin)).collect()
}

/// Reads a camera file; `FILE#NAME` selects one camera of several.
///
/// # Errors
/// The file cannot be read or holds no valid camera.
pub fn read_camera(path: &Path) -> Result<CameraFile, Error> {
    let wrong = |source| CalibrationRunError::Camera { file: path.into(), source };
    Ok(read_camera_file(path)?.map_err(wrong)?)
}

/// Refuses a camera that was calibrated at another size than that of the captures.
///
/// # Errors
/// States both sizes.
pub fn check_camera_size(camera: &CameraEstimate, captures: &PinCaptures<'_>) -> Result<(), Error> {
    let camera_px = [camera.camera().width_px(), camera.camera().height_px()];
    match captures.size_px {
        Some(captures_px) if captures_px != camera_px => {
            Err(CalibrationRunError::CameraSize { captures_px, camera_px }.into())
        }
        _ => Ok(()),
    }
}

/// Reads the landmarks of a fixture.
///
/// # Errors
/// The file cannot be read or holds no valid landmarks.
pub fn read_landmarks(path: &Path) -> Result<PinLandmarks, Error> {
    let expected = ExpectedFile {
        what: "a list of landmarks",
        max_bytes: landmarks::MAX_BYTES as u64,
        hint: "it names each hole of the dome once for each kind of pin",
    };
    let text = reading::read_text(path, expected)?;
    parse_landmarks(&text, Some(path))
}

/// Parses landmarks. `file` is named in errors.
///
/// # Errors
/// Faults of the text.
pub fn parse_landmarks(text: &str, file: Option<&Path>) -> Result<PinLandmarks, Error> {
    PinLandmarks::from_json(text).map_err(|source| {
        CalibrationRunError::Landmarks { file: file.map(Path::to_owned), source }.into()
    })
}

/// Returns the landmarks of a fixture's design.
///
/// # Errors
/// The fixture has no pins.
pub fn fixture_landmarks(dome: &Design) -> Result<&PinLandmarks, CalibrationRunError> {
    let fixture = || dome.sensor.name.clone();
    dome.documents().next().ok_or_else(|| CalibrationRunError::NoPins { fixture: fixture() })
}
