//! `fabkit calibrate intrinsics SENSOR --board board.json IMAGE... -o camera.yaml`

use std::fmt::Write;

use fabkit_application::calibration::report::IntrinsicsReport;
use fabkit_application::calibration_runs::boards;
use fabkit_application::calibration_runs::intrinsics::solve;
use fabkit_application::camera::files::{self, CameraFormat};
use fabkit_application::edited_files::{check_replaceable, sign_text};
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;

use super::Outcome;
use crate::cli::CalibrateIntrinsics;
use crate::failure::Failure;
use crate::interrupt;
use crate::roles::FileRoles;

pub(super) fn run(args: &CalibrateIntrinsics) -> Result<Outcome, Failure> {
    FileRoles::default()
        .reads("SENSOR", Target::new(&args.sensor).files())
        .reads("--board", [&args.board])
        .reads("--corners", &args.corners)
        .may_read("IMAGE", &args.images)
        .writes("--report", &args.report)
        .writes("-o", [&args.output])
        .check()?;
    let design = Target::new(&args.sensor).design(&args.set)?;
    let camera = &design.sensor.camera;
    let board = boards::read_board(&args.board)?;
    let views = match &args.corners {
        Some(list) => boards::from_list(list, &board)?,
        None => boards::from_files(&args.images, &board, camera, args.detector.into())?,
    };
    let calibration = solve(&views, camera, &args.models)?;
    let report = IntrinsicsReport {
        sensor: &design.sensor.name,
        board: &board.name,
        images: &views.records,
        calibration: &calibration,
    };
    write(args, &report)?;
    Ok(Outcome { text: summary(args, &report), json: report.to_json(), failed: false })
}

fn write(args: &CalibrateIntrinsics, report: &IntrinsicsReport<'_>) -> Result<(), Failure> {
    let camera =
        files::write(&report.calibration.estimate, CameraFormat::Fabkit).map_err(Failure::bug)?;
    // The report is written first, so that an existing camera file always has its report.
    let html = args.report.clone().map(|path| (path, report.to_html().into_bytes()));
    let camera = (args.output.clone(), sign_text(&camera).into_bytes());
    let files: Vec<_> = html.into_iter().chain([camera]).collect();
    check_replaceable(&files, args.force)?;
    interrupt::begin_writing()?;
    let files = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
    Ok(write_each(files, &interrupt::is_requested)?)
}

fn summary(args: &CalibrateIntrinsics, report: &IntrinsicsReport<'_>) -> String {
    let calibration = report.calibration;
    let corners: usize = calibration.views.iter().map(|view| view.corners.len()).sum();
    let mut text = format!(
        "{}: {} of {} views, {corners} corners\n",
        report.sensor,
        calibration.views.len(),
        report.images.len()
    );
    let mut row = |name: &str, value: String| {
        // Writing to a string cannot fail.
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
