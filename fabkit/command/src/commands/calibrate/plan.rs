//! `fabkit calibrate plan SENSOR`

use std::fmt::Write;

use fabkit_application::calibration::planning::ExpectedErrors;
use fabkit_application::calibration_runs::captures::pressed_pins;
use fabkit_application::calibration_runs::planning::{
    PlanReport, PlanRequest, build_forecast, plan_captures,
};
use fabkit_application::image::has_image_extension as is_image;
use fabkit_application::source::{Source, Target};

use super::super::camera_files::read_camera;
use super::Outcome;
use crate::cli::CalibratePlan;
use crate::failure::Failure;
use crate::roles::FileRoles;
use crate::table::{Align, table, wrap_text};

pub(super) fn run(args: &CalibratePlan) -> Result<Outcome, Failure> {
    let is_read = |name: &str| is_image(name) || name.ends_with(".csv");
    FileRoles::default()
        .reads("SENSOR", Target::new(&args.sensor).files())
        .reads_camera(&args.camera)
        .reads_all("--done", args.done.as_deref(), is_read)
        .check()?;
    let source = Source::find(&args.sensor)?;
    let project = source.load(&args.set)?;
    let lens = args.camera.as_deref().map(read_camera).transpose()?;
    let forecast = build_forecast(&source, &project)?;
    let done = match &args.done {
        Some(folder) => pressed_pins(folder, &forecast.landmarks, args.pin.as_deref())?,
        None => Vec::new(),
    };
    let wanted = PlanRequest {
        lens: lens.as_ref(),
        done: &done,
        captures: args.captures.map(usize::from),
        pins: args.pins.map(usize::from),
    };
    let plan = plan_captures(&project, &forecast, &wanted)?;
    let camera = args.camera.as_ref().map(|path| path.display().to_string());
    let json = plan.to_json(&project.design.sensor.name, camera.as_deref());
    Ok(Outcome { text: words(&plan, done.len()), json, failed: false })
}

fn words(plan: &PlanReport, done: usize) -> String {
    let mut text = String::new();
    let [seen, all] = plan.visible_pins;
    let marks = match (&plan.unrendered_reason, plan.marks_rendered) {
        (Some(why), _) => format!("marks are taken as tips: {why}"),
        (None, count) => format!("{count} marks are rendered (simulated)"),
    };
    let _ = writeln!(text, "{seen} of {all} pins are seen; {marks}");
    let loose = &plan.looseness;
    let line = format!(
        "expected errors (1 sigma). Assumed in each image: marks {} px, tips {:.2} mm, seat {:.2} mm and {:.2} deg off:",
        plan.noise_px,
        loose.across_mm,
        loose.dome_mm[0],
        loose.dome_rad[2].to_degrees(),
    );
    let _ = writeln!(text, "{}\n", wrap_text(&line, 0));
    let heading =
        ["captures", "pins in each", "surface, mm", "worst, mm", "camera, mm", "same mark, px"];
    let mut rows = vec![heading.map(String::from).to_vec()];
    for (captures, pins, expected) in &plan.efforts {
        rows.push(
            [vec![captures.to_string(), pins.to_string()], cells(expected.as_ref())].concat(),
        );
    }
    text += &table(&[Align::Right; 6], &rows);
    let [captures, pins] = plan.compared;
    let _ = writeln!(text, "\n{captures} captures of {pins} pins, by kinds of pin:\n");
    let mut rows =
        vec![[&["kinds"], &heading[2..]].concat().into_iter().map(String::from).collect()];
    for (kind, expected) in &plan.kinds {
        rows.push([vec![kind.clone()], cells(expected.as_ref())].concat());
    }
    text += &table(&[Align::Left, Align::Right, Align::Right, Align::Right, Align::Right], &rows);
    if done > 0 {
        let told = cells(plan.done.as_ref());
        let _ = writeln!(
            text,
            "\ncaptures so far: {done}; surface {} mm, worst {} mm",
            told[0], told[1]
        );
    }
    let _ = writeln!(text, "\npress next; each row lowers the error on the surface most:\n");
    let mut rows = vec![
        [&["", "holes", "kind"], &heading[2..]].concat().into_iter().map(String::from).collect(),
    ];
    for (number, next) in (done + 1..).zip(&plan.next) {
        let holes = next.holes.iter().map(u32::to_string).collect::<Vec<_>>().join("_");
        let row = vec![number.to_string(), holes, next.kind.clone()];
        rows.push([row, cells(next.expected.as_ref())].concat());
    }
    let right = [Align::Right; 4];
    text += &table(&[&[Align::Right, Align::Left, Align::Left][..], &right].concat(), &rows);
    text
}

fn cells(expected: Option<&ExpectedErrors>) -> Vec<String> {
    match expected {
        Some(e) => vec![
            format!("{:.3}", e.surface_mm),
            format!("{:.3}", e.worst_mm),
            format!("{:.3}", e.position_mm),
            format!("{:.2}", e.scatter_px),
        ],
        None => vec!["-".to_owned(); 4],
    }
}
