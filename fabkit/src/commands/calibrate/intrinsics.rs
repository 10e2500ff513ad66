//! `fabkit calibrate intrinsics SENSOR --board board.json IMAGE... -o camera.yaml`

use std::fmt::Write;

use fabkit::calibration::intrinsics::{CalibrateError, Calibration, LensModel, calibrate};
use fabkit::calibration::report::IntrinsicsReport;
use fabkit::camera::Camera;
use fabkit::camera::files::{self, Format};
use fabkit::geometry::NominalCamera;
use fabkit::staging::write_each;

use super::Report;
use super::boards::{self, Views};
use crate::authored::{may_replace, signed};
use crate::cli::CalibrateIntrinsics;
use crate::failure::{Exit, Failure};
use crate::interrupt;
use crate::roles::Roles;
use crate::source::Target;

pub(super) fn run(args: &CalibrateIntrinsics) -> Result<Report, Failure> {
    Roles::default()
        .reads("SENSOR", Target::new(&args.sensor).file())
        .reads("--board", [&args.board])
        .reads("--corners", &args.corners)
        .reads("IMAGE", &args.images)
        .writes("--report", &args.report)
        .writes("-o", [&args.output])
        .check()?;
    let design = Target::new(&args.sensor).design(&args.set)?;
    let camera = &design.sensor.camera;
    let board = boards::read_board(&args.board)?;
    let views = match &args.corners {
        Some(list) => boards::from_list(list, &board)?,
        None => boards::from_pictures(&args.images, &board, camera, args.detector)?,
    };
    let calibration = solve(&views, camera, &args.models)?;
    let report = IntrinsicsReport {
        sensor: &design.sensor.name,
        board: &board.name,
        pictures: &views.records,
        calibration: &calibration,
    };
    write(args, &report)?;
    Ok(Report { text: summary(args, &report), json: report.to_json(), failed: false })
}

/// Solves for the camera, beginning with the sensor's nominal one; no models are all of them.
///
/// # Errors
/// Views that do not tell the camera.
pub fn solve(
    views: &Views,
    nominal: &NominalCamera,
    models: &[LensModel],
) -> Result<Calibration, Failure> {
    let NominalCamera { width_px, height_px, field_of_view, .. } = nominal;
    let nominal =
        Camera::equidistant(*width_px, *height_px, field_of_view.rad()).map_err(Failure::bug)?;
    let models = if models.is_empty() { &LensModel::ALL[..] } else { models };
    calibrate(&views.usable, &nominal, models).map_err(|error| cannot_calibrate(error, views))
}

/// The error with every picture that could not be used, since that is most often why.
fn cannot_calibrate(error: CalibrateError, views: &Views) -> Failure {
    let mut message = error.to_string();
    for record in &views.records {
        if let Some(reason) = &record.unused {
            let _ = write!(message, "\n  {}: {reason}", record.file);
        }
    }
    let hint = match error {
        CalibrateError::TooFewViews { .. } => {
            "10 to 20 pictures of the board, tilted to all sides and out to the image's border, \
             are usual"
        }
        CalibrateError::TooManyViews { .. } => "choose those that differ most",
        CalibrateError::NoStart { .. } => {
            "is this the board, and are the sensor's camera.field_of_view and the size of the \
             pictures right?"
        }
        CalibrateError::NoModel { .. } => "try all lens models, without --model",
        CalibrateError::NotObservable { .. } => "add pictures of the board in other poses",
        CalibrateError::Impossible { .. } => "look at the list of corners",
        CalibrateError::Covariance(_) => return Failure::bug(message),
    };
    Failure::new(Exit::BadInput, message, hint)
}

fn write(args: &CalibrateIntrinsics, report: &IntrinsicsReport<'_>) -> Result<(), Failure> {
    let camera =
        files::write(&report.calibration.estimate, Format::Fabkit).map_err(Failure::bug)?;
    // The report first: a camera that is there has its report.
    let html = args.report.clone().map(|path| (path, report.to_html().into_bytes()));
    let camera = (args.output.clone(), signed(&camera).into_bytes());
    let files: Vec<_> = html.into_iter().chain([camera]).collect();
    may_replace(&files, args.force)?;
    interrupt::begin_writing()?;
    let files = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
    Ok(write_each(files, &interrupt::requested)?)
}

fn summary(args: &CalibrateIntrinsics, report: &IntrinsicsReport<'_>) -> String {
    let calibration = report.calibration;
    let corners: usize = calibration.views.iter().map(|view| view.corners.len()).sum();
    let mut text = format!(
        "{}: {} of {} views, {corners} corners\n",
        report.sensor,
        calibration.views.len(),
        report.pictures.len()
    );
    let mut row = |name: &str, value: String| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {name:<15} {value}");
    };
    row("lens model", calibration.model.name().into());
    row("rms", format!("{:.3} px", calibration.rms_px));
    let [focal_px, focal_sigma_px] = calibration.focal_px;
    row("scale on axis", format!("{focal_px:.3} +- {focal_sigma_px:.3} px per radian"));
    for (name, known) in report.rays() {
        row(name, format!("+- {known}"));
    }
    let sigmas = calibration.estimate.sigmas().unwrap_or_default();
    for ((name, value), sigma) in calibration.estimate.camera().parameters().iter().zip(sigmas) {
        row(name, format!("{value:.5} +- {sigma:.5}"));
    }
    for sentence in report.warnings() {
        let _ = writeln!(text, "warning: {sentence}");
    }
    let _ = writeln!(text, "{}", args.output.display());
    text
}
