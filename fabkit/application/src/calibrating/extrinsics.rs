//! The pose of a camera, from pins.

use std::path::Path;

use fabkit_calibration::assignment::{Discrepancy, assign};
use fabkit_calibration::extrinsics::{
    CalibrationOptions, Drawing, Outward, PoseCalibration, calibrate, solve_drawn,
};
use fabkit_calibration::image::GreyImage;
use fabkit_calibration::landmarks::{self, PinLandmarks};
use fabkit_calibration::model::{MarkOffsets, Model, Observation};
use fabkit_calibration::pin_captures::pictures::read_grey;
use fabkit_calibration::pin_captures::{PinCaptureError, PinCaptures};
use fabkit_calibration::report::{Crop, ExtrinsicsReport};
use fabkit_camera::{CameraEstimate, Vector2, files};
use fabkit_capture::LightConstants;
use fabkit_designs::Design;
use fabkit_files::Error;
use fabkit_files::reading::{self, Expected};
use fabkit_fixtures::halves::are_of_halves;
use fabkit_fixtures::{DrawnBodies, Project};
use fabkit_geometry::{Point3, Pose};

use super::CalibratingError;
use super::marks::{PinMarks, SeenFrom, Shapes};

/// Above this part of all marks without a hole, the labels or the camera are wrong, not the pins.
const MAX_DOUBTFUL: f64 = 0.2;

/// Farther from where the design has it no camera looks at rendered pins, mm: it would stand in what is drawn.
const RENDERED_MM: f64 = 3.0;

/// So many times pins are rendered again, each time nearer to where and in which light they were seen.
const ROUNDS: usize = 2;

/// So many times as far from where it is expected as most, and at least so far, px, the mark that is taken for a
/// protrusion's is another's.
const ASTRAY: f64 = 5.0;
const ASTRAY_PX: f64 = 4.0;

/// Most pictures of pins that are far off, and their sides, px: the least that a picture has.
const CROPS: usize = 8;
const CROP_PX: usize = 64;

/// What a pose is solved from.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Its sensor's nominal camera is where the solver begins; its halves may be what presses.
    pub project: &'a Project,
    /// The calibrated lens; its covariance is handed on.
    pub camera: &'a CameraEstimate,
    /// What reports call it.
    pub camera_file: &'a str,
    /// The pins that were to be had.
    pub landmarks: &'a PinLandmarks,
    /// What was seen.
    pub captures: &'a PinCaptures<'a>,
    /// Radius of the pins' tips, mm; 0 where nobody says it, and for protrusions of halves.
    pub tip_radius_mm: f64,
    /// Refractive index of the gel behind an interface that is tried.
    pub gel_index: f64,
}

/// Solves for the pose, and gives the account of it.
///
/// # Errors
/// Marks that do not tell the pose, labels that do not fit, and what `look` says.
pub fn solve<R, E: From<Error>>(
    inputs: &Inputs,
    look: impl FnOnce(&ExtrinsicsReport) -> Result<R, E>,
) -> Result<R, E> {
    let Inputs { project, camera, landmarks, captures, .. } = *inputs;
    let sensor = &project.design.sensor;
    let nominal = sensor.camera.sensor_from_camera.inverse();
    let Some(mut assignment) = assign(camera.camera(), &nominal, &captures.marked, &landmarks.pins)
    else {
        return Err(Error::from(PinCaptureError::NotAssigned).into());
    };
    let of_halves = are_of_halves(landmarks);
    if of_halves {
        // Protrusions are cut by the picture's edge, too large for a pin, or many dots: marks that are missing, or more
        // of them, are no mistakes.
        assignment.discrepancies.clear();
    }
    let marks: usize = captures.records.iter().map(|record| record.pins_found).sum();
    let mislabelled = |doubt: &&Discrepancy| !matches!(doubt, Discrepancy::Missing { .. });
    let doubtful = assignment.discrepancies.iter().filter(mislabelled).count();
    let bodies = DrawnBodies::of(sensor, camera.camera()).map_err(CalibratingError::from);
    let bodies = bodies.map_err(Error::from)?;
    let displacements =
        |pose: &Pose, contacts: &[Point3<f64>]| bodies.displacements(pose, contacts);
    let drawn = bodies.interface();
    let drawn = drawn.map(|interface| Drawing { interface, displacements: &displacements });
    let start = &assignment.model.camera_from_sensor;
    let mut observations = assignment.observations;
    let touch = sensor.touch.as_ref();
    let normal = touch.map(|touch| |place: &Point3<f64>| touch.depth_mm(place).1);
    let outward = normal.as_ref().map(|normal| Outward(normal));
    let solve = |observations: &[Observation], offsets: &MarkOffsets| {
        let options = CalibrationOptions {
            gel_index: inputs.gel_index,
            drawn,
            mark_offsets: Some(offsets),
            outward,
            ..CalibrationOptions::default()
        };
        calibrate(camera, observations, start, Some(&nominal), &options)
    };
    let constants = LightConstants::of(sensor);
    let rendered = match captures.is_detected {
        true => {
            let shapes = Shapes::of(project, landmarks, captures, inputs.tip_radius_mm);
            PinMarks::of(sensor, camera.camera(), &constants, shapes)
        }
        false => Ok(None),
    };
    let calibration = match &rendered {
        Ok(Some(rendered)) => {
            // Turned as it is, where the design has it; then where the drawn bodies say it is, in the light that marks tell of.
            let turned = Pose::new(*start.rotation(), *nominal.translation_mm()).unwrap_or(nominal);
            let from = SeenFrom::in_assumed_light(turned);
            let mut offsets = rendered.all(&from, &observations, None);
            for _ in 0..ROUNDS {
                let mut model = Model::new(camera.camera().in_air(), turned);
                model.expected_translation_mm = Some(*nominal.translation_mm());
                model.mark_offsets = offsets.clone();
                let loss = CalibrationOptions::default().loss;
                let through = |drawing| solve_drawn(&observations, &model, &drawing, loss).ok();
                let Some(fit) = drawn.and_then(through) else { break };
                if of_halves {
                    let residuals = fit.residuals_px(&observations);
                    observations = not_astray(observations, &residuals);
                }
                let from = SeenFrom::of(&fit.model);
                let off = from.camera_from_sensor.translation_mm() - turned.translation_mm();
                if off.norm() > RENDERED_MM {
                    break;
                }
                offsets = rendered.all(&from, &observations, Some(&offsets));
            }
            solve(&observations, &offsets)
        }
        _ => solve(&observations, &MarkOffsets::default()),
    };
    let calibration = calibration.map_err(CalibratingError::from).map_err(Error::from)?;
    let not_marked = match rendered {
        Ok(Some(_)) => None,
        Ok(None) if !captures.is_detected => {
            Some("pixels that were given instead of pictures are taken for tips".to_owned())
        }
        Ok(None) => Some("nobody says how layers show these pins".to_owned()),
        Err(error) => Some(error.to_string()),
    };
    let report = ExtrinsicsReport {
        sensor: &sensor.name,
        camera_file: inputs.camera_file,
        landmarks,
        captures: &captures.records,
        discrepancies: &assignment.discrepancies,
        calibration: &calibration,
        not_drawn: bodies.why_not(),
        not_marked: not_marked.as_deref(),
        saturated: captures.saturated,
        crops: &crops(&calibration, captures),
    };
    if doubtful as f64 > MAX_DOUBTFUL * marks as f64 {
        let discrepancies = report.doubt_sentences();
        let doubtful = CalibratingError::Doubtful { doubtful, marks, discrepancies };
        return Err(Error::from(doubtful).into());
    }
    look(&report)
}

/// Those that are not so far off that their marks are of something else: a dot beside a protrusion whose own mark is not
/// found.
fn not_astray(
    observations: Vec<Observation>,
    residuals: &[Option<Vector2<f64>>],
) -> Vec<Observation> {
    let off_px = residuals.iter().map(|residual| residual.map_or(f64::INFINITY, |r| r.norm()));
    let off_px: Vec<f64> = off_px.collect();
    let mut sorted = off_px.clone();
    sorted.sort_by(f64::total_cmp);
    let typical_px = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
    let most_px = (ASTRAY * typical_px).max(ASTRAY_PX);
    let kept = observations.into_iter().zip(off_px).filter(|(_, off_px)| *off_px <= most_px);
    kept.map(|(observation, _)| observation).collect()
}

/// The pictures of pins that are far off; those that cannot be read again are left out.
fn crops(calibration: &PoseCalibration, captures: &PinCaptures<'_>) -> Vec<Crop> {
    let Some(folder) = &captures.folder else { return Vec::new() };
    let crop = |observation: usize| {
        let pin = calibration.observations.get(observation)?;
        let record = captures.records.get(pin.contact.capture)?;
        let picture = read_grey(&folder.join(&record.file)).ok()?;
        let size = [picture.width_px(), picture.height_px()];
        let [columns, rows] = [0, 1].map(|axis| {
            // No picture is smaller.
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
        Some(Crop {
            observation,
            first_px: [columns.start as u32, rows.start as u32],
            size_px,
            png,
        })
    };
    calibration.checks.far.iter().take(CROPS).filter_map(|(pin, _)| crop(*pin)).collect()
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
