//! `fabkit depth SENSOR --press ID -o FILE.npz`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit::depth::truth::DepthMap;
use fabkit::export::{ExportError, npz, png};
use fabkit::fixtures::Press;
use fabkit::ground_truth::{self, Deepest, GREY_STEP_MM, Shown, arrays, cloud, picture};
use fabkit::staging::{OutputFile, write_all};
use serde_json::json;

use super::{Report, view};
use crate::cli::Depth;
use crate::failure::{Exit, Failure};
use crate::interrupt;
use crate::scene::{Cast, Scene, Seen, press_failure};
use crate::table::size;

pub(super) fn run(args: &Depth) -> Result<Report, Failure> {
    let scene = view::scene(&args.design, &args.view)?;
    let presses = presses(&scene, args)?;
    let cast = Cast {
        presses: &presses,
        samples: args.samples,
        membrane_mm: args.view.membrane,
        print_sigma_mm: args.print_sigma,
        allow_no_contact: args.allow_no_contact,
    };
    scene.cast(&cast, |seen| write(args, &scene, seen))
}

fn write(args: &Depth, scene: &Scene, seen: Seen) -> Result<Report, Failure> {
    let Seen { map, sigma_mm, deepest, surface_px } = seen;
    let default = if args.press.is_empty() { Shown::Range } else { Shown::Indentation };
    let shown = args.show.map_or(default, Shown::from);
    let files = files(args, map, sigma_mm, shown)?;

    interrupt::begin_writing()?;
    let mut text = String::new();
    let mut listed = Vec::new();
    // Files of one folder appear together.
    let mut folders: BTreeMap<PathBuf, Vec<OutputFile>> = BTreeMap::new();
    for (path, bytes) in files {
        let shown = path.display().to_string();
        text += &format!("{shown}: {}\n", size(bytes.len() as u64));
        listed.push(json!({ "file": shown, "bytes": bytes.len() }));
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let folder = folder.unwrap_or(Path::new(".")).to_path_buf();
        folders.entry(folder).or_default().push(OutputFile { name, bytes });
    }
    for (folder, files) in &folders {
        write_all(folder, files, &interrupt::requested)?;
    }

    let contact = map.contact().filter(|contact| *contact).count();
    text += &scene.coverage_text();
    text += &format!(
        "{} x {} px, {} see the surface, {contact} of them contact\n",
        map.width_px(),
        map.height_px(),
        surface_px,
    );
    if let Some(Deepest { depth_mm, label, .. }) = deepest {
        let name = &map.names()[usize::from(label)];
        text += &format!("deepest contact seen: {depth_mm:.3} mm ({name})\n");
    }
    let median = median(sigma_mm);
    let of =
        if scene.viewpoint.is_unsure() { " (shape alone: no covariance was given)" } else { "" };
    text += &format!("median sigma of the range: {median:.4} mm{of}\n");
    if args.grey.is_some() {
        text += &format!("grey: {GREY_STEP_MM} mm a step, 0 where there is no value\n");
    }
    let json = json!({
        "format": "fabkit-depth",
        "version": 1,
        "files": listed,
        "viewpoint": scene.viewpoint.to_json(),
        "surface_seen": scene.coverage_json(),
        "width_px": map.width_px(),
        "height_px": map.height_px(),
        "pixels_seen": surface_px,
        "pixels_in_contact": contact,
        "labels": map.names(),
        "deepest_mm": deepest.map(|deepest| deepest.depth_mm),
        "deepest_in_sensor_mm": deepest.map(|d| <[f64; 3]>::from(d.point_in_sensor)),
        "membrane_mm": args.view.membrane,
        "median_sigma_mm": Some(median).filter(|median| median.is_finite()),
        "sigma_of": if scene.viewpoint.is_unsure() { "shape" } else { "camera, pose, shape" },
        "grey_step_mm": GREY_STEP_MM,
    });
    Ok(Report { text, json, failed: false })
}

fn presses(scene: &Scene, args: &Depth) -> Result<Vec<Press>, Failure> {
    let project = &scene.project;
    let press =
        |id: &String| project.press(id).map_err(|error| press_failure(&args.design.sensor, error));
    args.press.iter().map(press).collect()
}

/// Every file asked for with its bytes.
fn files(
    args: &Depth,
    map: &DepthMap,
    sigma_mm: &[f64],
    shown: Shown,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    let values_mm = shown.values_mm(map, sigma_mm);
    let (width, height) = (map.width_px(), map.height_px());
    let mut files = Vec::new();
    let mut add =
        |path: &Option<PathBuf>, ends: &[&str], bytes: &dyn Fn() -> Result<_, ExportError>| {
            let Some(path) = path else { return Ok(()) };
            let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
            if !ends.contains(&ending.to_ascii_lowercase().as_str()) {
                let message = format!("{} does not name a .{} file", path.display(), ends[0]);
                return Err(Failure::plain(Exit::BadInput, message));
            }
            if files.iter().any(|(other, _)| other == path) {
                let message = format!("{} is named for two files", path.display());
                return Err(Failure::plain(Exit::BadInput, message));
            }
            files.push((path.clone(), bytes().map_err(Failure::bug)?));
            Ok(())
        };
    add(&args.output, &["npz"], &|| npz(&arrays(map, sigma_mm)))?;
    add(&args.png, &["png"], &|| {
        let picture = picture(width, &values_mm);
        png(picture.width_px, picture.height_px, &picture.rgb)
    })?;
    add(&args.grey, &["png"], &|| ground_truth::grey(width, height, &values_mm))?;
    add(&args.tiff, &["tiff", "tif"], &|| ground_truth::tiff(width, height, &values_mm))?;
    add(&args.ply, &["ply"], &|| Ok(cloud(map)))?;
    Ok(files)
}

fn median(values: &[f64]) -> f64 {
    let mut finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    finite.get(finite.len() / 2).copied().unwrap_or(f64::NAN)
}
