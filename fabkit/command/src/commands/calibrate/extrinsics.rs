//! `fabkit calibrate extrinsics SENSOR --camera camera.yaml --captures DIR -o pose.yaml`

use std::fmt::Write;

use fabkit_application::calibration::landmarks::PinLandmarks;
use fabkit_application::calibration::report::ExtrinsicsReport;
use fabkit_application::calibration_runs::extrinsics::{
    PoseCalibrationInputs, fixture_landmarks, read_landmarks, solve,
};
use fabkit_application::calibration_runs::{captures, pose_file};
use fabkit_application::edited_files::check_replaceable;
use fabkit_application::image::has_image_extension as is_image;
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;

use super::super::camera_files::read_camera;
use super::Outcome;
use crate::cli::CalibrateExtrinsics;
use crate::failure::Failure;
use crate::interrupt;
use crate::roles::FileRoles;
use crate::table::format_count;

pub(super) fn run(args: &CalibrateExtrinsics) -> Result<Outcome, Failure> {
    roles(args)?.check()?;
    let project = Target::new(&args.sensor).project(&args.set)?;
    let camera = read_camera(&args.camera)?;
    let landmarks = match &args.landmarks {
        Some(path) => read_landmarks(path)?,
        // A named fixture may have other pins than the sensor's dome or plate.
        None => match args.fixture.as_deref() {
            None => own_landmarks(args)?,
            fixture => {
                let target = Target { sensor: &args.sensor, fixture, part: None, preset: None };
                fixture_landmarks(&target.design(&args.set)?)?.clone()
            }
        },
    };
    let kind = args.pin.as_deref();
    let captures = captures::read(&args.captures, args.reference.as_deref(), &landmarks, kind)?;
    let tip_radius_mm = match landmarks.tip_radius_mm {
        // A foreign list does not state the tip radius; then the pins are taken to be those of this sensor's own dome.
        0.0 => own_landmarks(args).map_or(0.0, |own| own.tip_radius_mm),
        told => told,
    };
    let inputs = PoseCalibrationInputs {
        project: &project,
        camera: &camera,
        camera_file: &args.camera.display().to_string(),
        landmarks: &landmarks,
        captures: &captures,
        tip_radius_mm,
        gel_index: args.gel_index,
    };
    solve(&inputs, |report| {
        write(args, report)?;
        Ok(Outcome { text: summary(args, report), json: report.to_json(), failed: false })
    })
}

fn write(args: &CalibrateExtrinsics, report: &ExtrinsicsReport<'_>) -> Result<(), Failure> {
    // The report is written first, so that an existing pose always has its report.
    let html = args.report.clone().map(|path| (path, report.to_html().into_bytes()));
    let files: Vec<_> =
        html.into_iter().chain(pose_file::pose_files(&args.output, report)?).collect();
    check_replaceable(&files, args.force)?;
    interrupt::begin_writing()?;
    let files = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
    Ok(write_each(files, &interrupt::is_requested)?)
}

fn roles(args: &CalibrateExtrinsics) -> Result<FileRoles, Failure> {
    let is_read = |name: &str| is_image(name) || name.ends_with(".csv");
    let captures = Some(args.captures.as_path());
    Ok(FileRoles::default()
        .reads("SENSOR", Target::new(&args.sensor).files())
        .reads_camera([&args.camera])
        .reads("--landmarks", &args.landmarks)
        .reads("--reference", &args.reference)
        .reads_all("--captures", captures, is_read)
        .writes("--report", &args.report)
        .writes("-o", [&args.output])
        .writes("-o (the camera of the pose)", [pose_file::camera_path(&args.output)?]))
}

/// Returns the landmarks of the dome or plate that `fabkit export SENSOR/pin-dome` (or `pin-plate`) writes with the
/// same overrides.
fn own_landmarks(args: &CalibrateExtrinsics) -> Result<PinLandmarks, Failure> {
    let target = Target { sensor: &args.sensor, fixture: None, part: None, preset: None };
    Ok(fixture_landmarks(&target.pin_fixture(&args.set)?)?.clone())
}

fn summary(args: &CalibrateExtrinsics, report: &ExtrinsicsReport<'_>) -> String {
    let chosen = report.calibration.chosen_trial();
    let plain = report.calibration.plain_trial();
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {}, {}",
        report.sensor,
        format_count(report.captures.len(), "capture"),
        format_count(report.calibration.observations.len(), "pin")
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
