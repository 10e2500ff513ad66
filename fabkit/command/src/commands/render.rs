//! `fabkit render SENSOR[/PART] -o FILE.png`

use std::path::Path;

use fabkit_application::camera_view::{self, DrawnRay};
use fabkit_application::images::{self, ImageView, MAX_PIXELS};
use fabkit_application::memory::{self, MemoryHint};
use fabkit_application::progress::ProgressStep;
use fabkit_application::reading::has_extension;
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;
use fabkit_application::{Error, bodies};
use serde_json::json;

use super::Outcome;
use super::progress::Progress;
use crate::cli::{Global, Render};
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;
use crate::table::format_size;

/// Largest memory of an image, its filtered copy and its file, bytes for each pixel; for the camera's view, additional
/// memory for what each pixel saw.
const PIXEL_BYTES: u64 = 9;
const VIEW_PIXEL_BYTES: u64 = 28;
/// Memory of the tiles that threads are rendering.
const TILES_BYTES: u64 = 200 * memory::MB;

pub(super) fn run(args: &Render, global: &Global) -> Result<Outcome, Failure> {
    let target = Target::new(&args.sensor).with_preset(args.preset.as_deref());
    let is_view = args.camera.is_some();
    let camera = args.camera.as_ref().and_then(Option::as_deref);
    if !has_extension(&args.output, "png") {
        let message = format!("{} does not name a .png file", args.output.display());
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    FileRoles::default()
        .reads("SENSOR", target.files())
        .reads_camera(camera)
        .reads("--pose", &args.pose)
        .writes("-o", [&args.output])
        .check()?;
    if args.rays || is_view {
        return draw_camera_view(args, global, &target, camera);
    }
    if args.pose.is_some() {
        let message = "--pose is only for views of the camera: --rays or --camera";
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    let part = target.part;
    admit(args.size, PIXEL_BYTES)?;
    if part.is_some() && (args.exploded || args.assembly.is_some()) {
        let message = "--exploded and --assembly are for whole assemblies, not for one part";
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }

    let shot = ImageView { size_px: args.size, is_section: args.section, from: args.view };
    let design = target.design(&args.set)?;
    let progress = Progress::new(global, format!("drawing {}", args.sensor));
    let show = |step: ProgressStep| progress.show(step);
    let bytes = match part {
        Some(part) => {
            let body = bodies::find_target(&design.sensor, part)?;
            images::draw_body(body, shot, &show)?
        }
        None => {
            let assembly = args.assembly.clone();
            let assembly = assembly.unwrap_or_else(|| images::default_assembly(&design.sensor));
            images::draw_assembly(&design.sensor, &assembly, args.exploded, shot, &show)?
        }
    };
    drop(progress);

    write_image(args, args.size, &bytes)
}

/// Draws the camera's view: its rays in a section, or its image.
fn draw_camera_view(
    args: &Render,
    global: &Global,
    target: &Target,
    camera: Option<&Path>,
) -> Result<Outcome, Failure> {
    if let Some(name) = target.fixture.or(target.part) {
        let message = format!("the camera's view is drawn of a whole sensor, not of its {name}");
        let hint = format!("write `{}`", target.sensor);
        return Err(Failure::new(ErrorKind::BadInput, message, hint));
    }
    let project = target.project(&args.set)?;
    let viewpoint = super::camera_files::load_viewpoint(&project, camera, args.pose.as_deref())?;
    let sensor = &project.design.sensor;
    let lens = viewpoint.camera();
    // The camera's own image has the camera's resolution.
    let size = if args.rays { args.size } else { [lens.width_px(), lens.height_px()] };
    admit(size, PIXEL_BYTES + VIEW_PIXEL_BYTES)?;
    let stack = camera_view::build_stack(sensor, &viewpoint).map_err(Error::from)?;
    let progress = Progress::new(global, format!("drawing {}", args.sensor));
    let show = |step: ProgressStep| progress.show(step);
    if !args.rays {
        let bytes = camera_view::draw_camera_view(sensor, &viewpoint, &stack, &show)?;
        drop(progress);
        return write_image(args, size, &bytes);
    }
    let shot = ImageView { size_px: size, is_section: true, from: args.view };
    let (bytes, rays) = camera_view::draw_rays(sensor, &viewpoint, &stack, shot, &show)?;
    drop(progress);
    let mut outcome = write_image(args, size, &bytes)?;
    let ray = |ray: &DrawnRay| json!({ "pixel": ray.pixel, "seen_by": ray.seen_by, "path_in_sensor_mm": ray.path_mm });
    outcome.json["rays"] = rays.iter().map(ray).collect();
    Ok(outcome)
}

fn admit([width_px, height_px]: [u32; 2], pixel_bytes: u64) -> Result<(), Failure> {
    if u64::from(width_px) * u64::from(height_px) > MAX_PIXELS {
        let message = format!("an image of {width_px} x {height_px} has more than {MAX_PIXELS} px");
        return Err(Failure::new(ErrorKind::Limit, message, "ask for a smaller --size"));
    }
    Ok(memory::check_memory(
        &format!("an image of {width_px} x {height_px} px"),
        pixel_bytes * u64::from(width_px) * u64::from(height_px) + TILES_BYTES,
        MemoryHint::Pixels,
    )?)
}

fn write_image(
    args: &Render,
    [width_px, height_px]: [u32; 2],
    bytes: &[u8],
) -> Result<Outcome, Failure> {
    let count = bytes.len() as u64;
    interrupt::begin_writing()?;
    write_each([(args.output.clone(), bytes)], &interrupt::is_requested)?;
    let shown = args.output.display().to_string();
    let json = json!({
        "format": "fabkit-render",
        "version": 1,
        "file": shown,
        "width_px": width_px,
        "height_px": height_px,
        "bytes": count,
    });
    let text = format!("{shown}: {width_px} x {height_px} px, {}\n", format_size(count));
    Ok(Outcome { text, json, failed: false })
}
