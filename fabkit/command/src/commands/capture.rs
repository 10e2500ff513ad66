//! `fabkit capture SENSOR --press ID -o picture.png`

use std::sync::Arc;

use fabkit_application::capturing::{
    SimulatedCapture, SkinView, Unit, capture_comment, capture_document, select_lighting,
};
use fabkit_application::export::png_with_comment;
use fabkit_application::fixtures::{Press, Project};
use fabkit_application::ground_truth::{FileSelection, MapCollector};
use fabkit_application::press_simulation::{PressRequest, farthest_marker};
use fabkit_application::reading::has_extension;
use fabkit_application::scene::SensorView;
use fabkit_application::source::convert_press_error;
use serde_json::{Value, json};

use super::files::Files;
use super::{Outcome, view};
use crate::cli::Capture;
use crate::failure::{ErrorKind, Failure};

pub(super) fn run(args: &Capture) -> Result<Outcome, Failure> {
    let options = &args.options;
    let output = Some(args.output.clone());
    view::roles(&args.design, &args.camera)
        .reads("--constants", &options.constants)
        .writes("-o", &output)
        .writes("--truth", &args.truth)
        .check()?;
    ends(&args.output, "png")?;
    args.truth.as_ref().map_or(Ok(()), |path| ends(path, "npz"))?;
    let is_told = options.friction.is_some() || options.spacing.is_some();
    if options.contact == "rigid" && is_told {
        let message = "friction and spacing are only for `linear` contact";
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    let unit = options.unit.map(Unit);
    let (project, viewpoint) = view::load_viewpoint(&args.design, &args.camera, unit)?;
    let sensor = &project.design.sensor;
    let (lighting, constants) =
        select_lighting(&project, options.light.as_deref(), options.constants.as_deref())?;
    let viewpoint = view::lighting_viewpoint(lighting, &args.camera, viewpoint)?;
    let presses = presses(&project, args)?;
    let capturing = options.capturing(&presses, lighting, &constants)?;
    let camera = viewpoint.camera();
    let rays = [camera.width_px(), camera.height_px()].map(|px| px * options.samples);
    let wanted = FileSelection { npz: args.truth.is_some(), ..FileSelection::default() };
    let mut truth = MapCollector::new(wanted, rays);
    let captured = if PressRequest::is_on_skin(sensor) {
        refuse_on_skin(args)?;
        let view = SkinView { project: Arc::clone(&project), viewpoint: viewpoint.clone() };
        capturing.render_skin(&view)?
    } else {
        let scene = SensorView::new(Arc::clone(&project), viewpoint.clone())?;
        capturing.render(&scene, wanted.bytes_per_ray(), |seen| {
            if args.truth.is_some() {
                truth.add(seen.map, seen.sigmas).map_err(fabkit_application::Error::bug)?;
            }
            Ok(())
        })?
    };
    let words = capture_comment(&project, &capturing, &captured);
    let json = capture_document(&project, &viewpoint, &capturing, &captured);
    write(args, &captured, &words, json, &mut truth)
}

/// Refuses options that do not exist for a skin with liquid channels.
fn refuse_on_skin(args: &Capture) -> Result<(), Failure> {
    let problem = if args.truth.is_some() {
        "a skin with channels of liquid has no ground truth of depth"
    } else if args.options.shear != [0.0; 2] || args.options.friction.is_some() {
        "a skin with channels of liquid is pressed straight down, without friction"
    } else {
        return Ok(());
    };
    Err(Failure::plain(ErrorKind::BadInput, problem))
}

fn write(
    args: &Capture,
    captured: &SimulatedCapture,
    words: &str,
    mut json: Value,
    truth: &mut MapCollector,
) -> Result<Outcome, Failure> {
    let [width, height] = captured.size_px;
    let is_deep = args.bits == "16";
    let png = png_with_comment(width, height, &captured.grey, is_deep, words);
    let mut files = Files::default();
    files.add(&args.output, png.map_err(Failure::bug)?);
    if let Some(path) = &args.truth {
        files.add(path, truth.take_npz().map_err(Failure::bug)?);
    }
    files.write()?;
    json["bits"] = json!(if is_deep { 16 } else { 8 });
    json["files"] = files.json();
    let mut text = files.text();
    let [least, most] = captured.range_grey();
    let kind = if captured.channels == 3 { "red, green, blue" } else { "intensity" };
    text += &format!("{words}\n");
    text += &format!("{width} x {height} px, {kind} {least:.0} to {most:.0}; {}", captured.shown);
    if let Some([thin, thick]) = json["thickness_mm"].as_array().map(Vec::as_slice) {
        let mm = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        text += &format!(", {:.3} to {:.3} mm", mm(thin), mm(thick));
    }
    if let Some((mark, mm)) = farthest_marker(&captured.marks).filter(|(_, mm)| *mm > 0.0) {
        text += &format!("; `{mark}` moves farthest, {mm:.3} mm");
    }
    text += &format!("\nlit by {}\n", captured.light_sources);
    if let Some(gain) = captured.camera_gain.phrase() {
        text += &format!("{gain}\n");
    }
    Ok(Outcome { text, json, failed: false })
}

fn ends(path: &std::path::Path, ending: &str) -> Result<(), Failure> {
    if has_extension(path, ending) {
        return Ok(());
    }
    let message = format!("{} does not name a .{ending} file", path.display());
    Err(Failure::plain(ErrorKind::BadInput, message))
}

fn presses(project: &Project, args: &Capture) -> Result<Vec<Press>, Failure> {
    let finder = if PressRequest::is_on_skin(&project.design.sensor) {
        project.skin_press_finder()
    } else {
        project.press_finder()
    };
    let press = |id: &String| {
        finder.press(id).map_err(|error| convert_press_error(&args.design.sensor, error).into())
    };
    let of_indenter = args.indenter.as_ref().zip(args.depth);
    let of_indenter = of_indenter.map(|(indenter, depth_mm)| format!("{indenter},{depth_mm}mm"));
    args.press.iter().chain(&of_indenter).map(press).collect()
}
