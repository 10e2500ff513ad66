//! `fabkit depth SENSOR --press ID -o FILE.npz`

use std::path::PathBuf;

use fabkit_application::export::ExportError;
use fabkit_application::fixtures::Press;
use fabkit_application::ground_truth::{
    DeepestContact, FileSelection, GREY_STEP_MM, MapCollector, MapQuantity,
};
use fabkit_application::press_simulation::{self, ContactGap};
use fabkit_application::reading::has_extension;
use fabkit_application::scene::SensorView;
use fabkit_application::source::convert_press_error;
use serde_json::{Value, json};

use super::files::Files;
use super::{Outcome, view};
use crate::cli::Depth;
use crate::failure::{ErrorKind, Failure};

pub(super) fn run(args: &Depth) -> Result<Outcome, Failure> {
    view::roles(&args.design, &args.view.camera)
        .writes("-o", &args.output)
        .writes("--png", &args.png)
        .writes("--grey", &args.grey)
        .writes("--tiff", &args.tiff)
        .writes("--mask", &args.mask)
        .writes("--coverage-map", &args.coverage_map)
        .writes("--ply", &args.ply)
        .check()?;
    if let Some(path) = args.coverage_map.as_ref().filter(|path| !has_extension(path, "png")) {
        let message = format!("{} does not name a .png file", path.display());
        return Err(Failure::plain(ErrorKind::BadInput, message));
    }
    let scene = view::build_scene(&args.design, &args.view.camera)?;
    let presses = presses(&scene, args)?;
    let cast = args.options.cast(&presses, &args.view.contact)?;
    let default = if args.press.is_empty() { MapQuantity::Range } else { MapQuantity::Indentation };
    let is_shown = args.png.is_some() || args.grey.is_some() || args.tiff.is_some();
    let wanted = FileSelection {
        npz: args.output.is_some(),
        quantity: is_shown.then(|| args.show.map_or(default, MapQuantity::from)),
        png: args.png.is_some(),
        grey: args.grey.is_some(),
        tiff: args.tiff.is_some(),
        mask: args.mask.is_some(),
        cloud: args.ply.is_some(),
    };
    let camera = scene.viewpoint.camera();
    let [width, height] = [camera.width_px(), camera.height_px()].map(|px| px * cast.samples);
    let mut collected = MapCollector::new(wanted, [width, height]);
    let mut elastic = None;
    let mut gap = None;
    scene.cast_in_bands(&cast, wanted.bytes_per_ray(), |seen| {
        collected.add(seen.map, seen.sigmas).map_err(convert_export_error)?;
        collected.surface_px += seen.surface_px;
        if let (Some(answer), Some(here)) = (seen.answer, &seen.gap) {
            let all: &mut ContactGap = gap.get_or_insert_default();
            all.merge(here);
            elastic = Some(press_simulation::visible_solution_document(answer, Some(all)));
        }
        // The last one of equals is taken, as within a band.
        let before = collected.deepest.map_or(f64::NEG_INFINITY, |deepest| deepest.depth_mm);
        let deeper = seen.deepest.filter(|deepest| deepest.depth_mm.total_cmp(&before).is_ge());
        collected.deepest = deeper.or(collected.deepest);
        Ok::<_, Failure>(())
    })?;
    write(args, &scene, [width, height], collected, (cast.contact.name(), elastic))
}

fn write(
    args: &Depth,
    scene: &SensorView,
    [width, height]: [u32; 2],
    mut collected: MapCollector,
    (level, elastic): (&str, Option<Value>),
) -> Result<Outcome, Failure> {
    let [median, of_points] = collected.median_sigmas_mm();
    let mut files = files(args, &mut collected)?;
    if let Some(path) = &args.coverage_map {
        files.add(path, scene.coverage_map_png()?);
    }
    let MapCollector { names, deepest, surface_px, contact_px: contact, .. } = collected;
    files.write()?;
    let mut text = files.text();
    text += &view::coverage_text(&scene.coverage);
    text += &format!(
        "{width} x {height} px: {surface_px} see the surface, {contact} of these see contact\n",
    );
    if let Some(DeepestContact { depth_mm, label, .. }) = deepest {
        let name = &names[usize::from(label)];
        text += &format!("deepest contact seen: {depth_mm:.3} mm ({name})\n");
    }
    text += &elastic.as_ref().map(|elastic| elastic_text(level, elastic)).unwrap_or_default();
    let sigma_of = scene.viewpoint.sigma_contributions();
    let sigma_parameters = scene.viewpoint.sigma_parameters();
    let alone =
        if sigma_parameters.is_empty() { " only, because no covariance was given" } else { "" };
    text += &format!(
        "median sigma of points on the surface: {of_points:.4} mm, of ranges: {median:.4} mm; from {sigma_of}{alone}\n"
    );
    if args.grey.is_some() {
        text += &format!(
            "greyscale image: {GREY_STEP_MM} mm per step; 0 marks pixels without a value\n"
        );
    }
    let json = json!({
        "format": "fabkit-depth",
        "version": 1,
        "files": files.json(),
        "viewpoint": scene.viewpoint.to_json(),
        "surface_seen": scene.coverage.to_json(),
        "coverage": scene.coverage.area,
        "coverage_lost": scene.coverage.lost_json(),
        "width_px": width,
        "height_px": height,
        "pixels_seen": surface_px,
        "pixels_in_contact": contact,
        "labels": names,
        "deepest_mm": deepest.map(|deepest| deepest.depth_mm),
        "deepest_in_sensor_mm": deepest.map(|d| <[f64; 3]>::from(d.point_in_sensor)),
        "membrane_mm": args.view.contact.membrane,
        "contact_level": level,
        "elastic": elastic,
        "median_sigma_mm": Some(median).filter(|median| median.is_finite()),
        "median_point_sigma_mm": Some(of_points).filter(|median| median.is_finite()),
        "sigma_of": sigma_of,
        "sigma_parameters": sigma_parameters,
        "grey_step_mm": GREY_STEP_MM,
    });
    Ok(Outcome { text, json, failed: false })
}

/// Formats the solution of the elastic layers, and the error of the rigid contact model against it.
fn elastic_text(level: &str, elastic: &Value) -> String {
    let mut text = String::new();
    if let Some(force_n) = elastic["force_n"].as_array() {
        let part = |i: usize| force_n.get(i).and_then(Value::as_f64).unwrap_or(f64::NAN);
        text += &format!(
            "{level} contact (simulated): force on the sensor {:.3}, {:.3}, {:.3} N\n",
            part(0),
            part(1),
            part(2)
        );
    }
    let gap = &elastic["against_rigid"];
    let of = |place: &str, value: &str| gap[place][value].as_f64().unwrap_or(f64::NAN);
    text + &format!(
        "contact model: rigid contact differs by {:.3} mm rms in contact (at most {:.3} mm) and {:.3} mm rms beside it (at most {:.3} mm)\n",
        of("touched", "rms_mm"),
        of("touched", "max_mm"),
        of("beside", "rms_mm"),
        of("beside", "max_mm"),
    )
}

fn presses(scene: &SensorView, args: &Depth) -> Result<Vec<Press>, Failure> {
    let finder = scene.project.press_finder();
    let press = |id: &String| {
        finder.press(id).map_err(|error| convert_press_error(&args.design.sensor, error).into())
    };
    args.press.iter().map(press).collect()
}

/// Converts an encoding error: some file formats limit the number of pixels.
fn convert_export_error(error: ExportError) -> Failure {
    match error {
        ExportError::TooLarge { .. } => {
            Failure::new(ErrorKind::Limit, error, "ask for fewer --samples")
        }
        other => Failure::bug(other),
    }
}

/// Encodes all requested files.
fn files(args: &Depth, collected: &mut MapCollector) -> Result<Files, Failure> {
    type Bytes<'a> = &'a dyn Fn(&mut MapCollector) -> Result<Vec<u8>, ExportError>;
    let mut files = Files::default();
    let mut add = |path: &Option<PathBuf>, ends: &[&str], bytes: Bytes| {
        let Some(path) = path else { return Ok(()) };
        if !ends.iter().any(|ending| has_extension(path, ending)) {
            let message = format!("{} does not name a .{} file", path.display(), ends[0]);
            return Err(Failure::plain(ErrorKind::BadInput, message));
        }
        files.add(path, bytes(collected).map_err(convert_export_error)?);
        Ok(())
    };
    add(&args.output, &["npz"], &MapCollector::take_npz)?;
    add(&args.png, &["png"], &|collected| collected.false_color_png())?;
    add(&args.grey, &["png"], &|collected| collected.grey())?;
    add(&args.tiff, &["tiff", "tif"], &|collected| collected.tiff())?;
    add(&args.mask, &["png"], &|collected| collected.mask_png())?;
    add(&args.ply, &["ply"], &|collected| Ok(collected.take_cloud()))?;
    Ok(files)
}
