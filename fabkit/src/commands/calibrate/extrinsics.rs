//! `fabkit calibrate extrinsics SENSOR --camera camera.yaml --captures DIR -o pose.yaml`

use std::fmt::Write;
use std::path::Path;

use fabkit::calibration::assignment::{Doubt, assign};
use fabkit::calibration::extrinsics::{CalibrationError, CalibrationOptions, calibrate};
use fabkit::calibration::landmarks::{self, PinLandmarks};
use fabkit::calibration::report::ExtrinsicsReport;
use fabkit::camera::CameraEstimate;
use fabkit::camera::files::{self, InvalidCameraFile};
use fabkit::designs::Design;
use fabkit::geometry::Sensor;
use fabkit::staging::write_each;

use super::captures::{self, Captures};
use super::{Report, pose_file};
use crate::authored::may_replace;
use crate::cli::CalibrateExtrinsics;
use crate::failure::{Exit, Failure};
use crate::interrupt;
use crate::reading::{self, Expected};
use crate::roles::Roles;
use crate::source::Target;

/// Above this part of all marks without a hole, the labels or the camera are wrong, not the pins.
const MAX_DOUBTFUL: f64 = 0.2;

pub(super) fn run(args: &CalibrateExtrinsics) -> Result<Report, Failure> {
    roles(args)?.check()?;
    let design = Target::new(&args.sensor).design(&args.set)?;
    let camera = read_camera(&args.camera)?;
    let landmarks = match &args.landmarks {
        Some(path) => read_landmarks(path)?,
        None => own_landmarks(args)?,
    };
    let kind = args.pin.as_deref();
    let captures = captures::read(&args.captures, args.reference.as_deref(), &landmarks, kind)?;
    let inputs = Inputs {
        sensor: &design.sensor,
        camera: &camera,
        camera_file: &args.camera.display().to_string(),
        landmarks: &landmarks,
        captures: &captures,
        gel_index: args.gel_index,
    };
    solve(&inputs, |report| {
        write(args, report)?;
        Ok(Report { text: summary(args, report), json: report.to_json(), failed: false })
    })
}

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
    pub captures: &'a Captures<'a>,
    /// Refractive index of the gel behind an interface that is tried.
    pub gel_index: f64,
}

/// Solves for the pose, and gives the account of it.
///
/// # Errors
/// Marks that do not tell the pose, labels that do not fit, and what `look` says.
pub fn solve<R>(
    inputs: &Inputs,
    look: impl FnOnce(&ExtrinsicsReport) -> Result<R, Failure>,
) -> Result<R, Failure> {
    let Inputs { sensor, camera, landmarks, captures, .. } = *inputs;
    let nominal = sensor.camera.sensor_from_camera.inverse();
    let Some(assignment) = assign(camera.camera(), &nominal, &captures.marked, &landmarks.pins)
    else {
        return Err(Failure::new(
            Exit::BadInput,
            "the marks in the pictures are not where the holes would be seen from any side",
            "is the camera's file the one of this camera, and are the landmarks this dome's?",
        ));
    };
    let marks: usize = captures.records.iter().map(|record| record.pins_found).sum();
    let mislabelled = |doubt: &&Doubt| !matches!(doubt, Doubt::Missing { .. });
    let doubtful = assignment.doubts.iter().filter(mislabelled).count();
    let options =
        CalibrationOptions { gel_index: inputs.gel_index, ..CalibrationOptions::default() };
    let start = &assignment.model.camera_from_sensor;
    let calibration = calibrate(camera, &assignment.observations, start, Some(&nominal), &options)
        .map_err(cannot_calibrate)?;
    let report = ExtrinsicsReport {
        sensor: &sensor.name,
        camera_file: inputs.camera_file,
        landmarks,
        captures: &captures.records,
        doubts: &assignment.doubts,
        calibration: &calibration,
    };
    if doubtful as f64 > MAX_DOUBTFUL * marks as f64 {
        let named: Vec<String> = report.doubt_sentences();
        let message = format!(
            "{doubtful} of {marks} marks are at no labelled hole:\n  {}",
            named.join("\n  ")
        );
        return Err(Failure::new(Exit::BadInput, message, "check the labels and the landmarks"));
    }
    look(&report)
}

fn write(args: &CalibrateExtrinsics, report: &ExtrinsicsReport<'_>) -> Result<(), Failure> {
    // The report first: a pose that is there has its report.
    let html = args.report.clone().map(|path| (path, report.to_html().into_bytes()));
    let files: Vec<_> = html.into_iter().chain(pose_file::files(&args.output, report)?).collect();
    may_replace(&files, args.force)?;
    interrupt::begin_writing()?;
    let files = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
    Ok(write_each(files, &interrupt::requested)?)
}

fn roles(args: &CalibrateExtrinsics) -> Result<Roles, Failure> {
    let is_read = |name: &str| [".png", ".csv"].iter().any(|ending| name.ends_with(ending));
    let captures = Some(args.captures.as_path());
    Ok(Roles::default()
        .reads("SENSOR", Target::new(&args.sensor).file())
        .reads("--camera", [&args.camera])
        .reads("--landmarks", &args.landmarks)
        .reads("--reference", &args.reference)
        .reads_all("--captures", captures, is_read)
        .writes("--report", &args.report)
        .writes("-o", [&args.output])
        .writes("-o (the camera of the pose)", [pose_file::camera_of(&args.output)?]))
}

fn read_camera(path: &Path) -> Result<CameraEstimate, Failure> {
    let hint = "fabkit reads its own camera files and those of OpenCV, ROS and Kalibr";
    let text = reading::text(path, Expected { what: "a camera's file", max_bytes: 1 << 20, hint })?;
    let wrong = |error: InvalidCameraFile| {
        let faults: Vec<String> =
            error.faults.iter().map(|fault| format!("{}: {fault}", path.display())).collect();
        Failure::plain(Exit::BadInput, faults.join("\n"))
    };
    files::read(&text).map_err(wrong)
}

fn read_landmarks(path: &Path) -> Result<PinLandmarks, Failure> {
    let expected = Expected {
        what: "a list of landmarks",
        max_bytes: landmarks::MAX_BYTES as u64,
        hint: "it names each hole of the dome once for each kind of pin",
    };
    let text = reading::text(path, expected)?;
    PinLandmarks::from_json(&text)
        .map_err(|error| Failure::plain(Exit::BadInput, format!("{}: {error}", path.display())))
}

/// Those of the dome or plate that `fabkit export SENSOR/pin-dome` (or `pin-plate`) writes, with the
/// same overrides.
fn own_landmarks(args: &CalibrateExtrinsics) -> Result<PinLandmarks, Failure> {
    let target = Target { sensor: &args.sensor, fixture: None, part: None, preset: None };
    landmarks_of(&target.pins(&args.set)?)
}

/// Those that a dome comes with.
///
/// # Errors
/// A fixture without pins.
pub fn landmarks_of(dome: &Design) -> Result<PinLandmarks, Failure> {
    let file = dome.companions.iter().find(|file| file.name.ends_with(".landmarks.json"));
    let Some(file) = file else {
        let message = format!("{} has no pins, and so no landmarks", dome.sensor.name);
        return Err(Failure::plain(Exit::BadInput, message));
    };
    let text = String::from_utf8_lossy(&file.bytes);
    PinLandmarks::from_json(&text).map_err(Failure::bug)
}

fn cannot_calibrate(error: CalibrationError) -> Failure {
    let hint = match &error {
        // What was computed from the file's is no covariance, because the file's hardly is one.
        CalibrationError::Covariance(_) => "look at the covariance in the camera's file",
        CalibrationError::OnePlane { .. } => {
            "press pins in holes of at least two rings, or pins of two lengths"
        }
        CalibrationError::NoExplanation { .. } => {
            "is the camera's file the one of this camera, and are the landmarks this dome's?"
        }
    };
    Failure::new(Exit::BadInput, error, hint)
}

fn summary(args: &CalibrateExtrinsics, report: &ExtrinsicsReport<'_>) -> String {
    let chosen = report.calibration.chosen();
    let plain = report.calibration.plain();
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {} captures, {} pins",
        report.sensor,
        report.captures.len(),
        report.calibration.observations.len()
    );
    let _ = writeln!(text, "  model                    {}", chosen.candidate);
    let _ = writeln!(text, "  held-out rms             {:.2} px", chosen.held_out_rms_px);
    let of_plain = plain.map_or("not fitted".into(), |p| format!("{:.2} px", p.held_out_rms_px));
    let _ = writeln!(text, "  plain model, held out    {of_plain}");
    if let Some(scatter) = report.calibration.scatter {
        let _ = writeln!(text, "  same pin pressed again   {:.2} px", scatter.rms_px);
    }
    for sentence in report.explanation() {
        let _ = writeln!(text, "note: {sentence}");
    }
    for sentence in report.warnings() {
        let _ = writeln!(text, "warning: {sentence}");
    }
    let _ = writeln!(text, "{}", args.output.display());
    text
}
