//! `fabkit reconstruct SENSOR --reference ref.png pictures... -o DIR`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fabkit_application::Error;
use fabkit_application::geometry::Sensor;
use fabkit_application::memory::{self, MemoryHint};
use fabkit_application::reconstructing::{
    CapturedImage, DepthNetwork, DepthResult, ImageReader, ImageReading, ReconstructError,
    TrackedMarkers,
};
use fabkit_application::scene::SensorView;
use fabkit_application::staging::{OutputFile, write_all};
use serde_json::json;

use super::{Outcome, findings, view};
use crate::cli::Reconstruct;
use crate::failure::Failure;
use crate::interrupt;
use crate::table::format_size;

/// Size of the results, bytes for each pixel.
const RESULT_BYTES_PER_PIXEL: usize = 5;

pub(super) fn run(args: &Reconstruct) -> Result<Outcome, Failure> {
    let outputs = output_files(args)?;
    let paths: Vec<PathBuf> = outputs.iter().map(|(path, _)| path.clone()).collect();
    view::roles(&args.design, &args.camera)
        .reads("--constants", &args.light.constants)
        .reads("--reference", [&args.reference])
        .reads("--network", &args.network)
        .may_read("--network", args.network.as_deref().map(DepthNetwork::card_path))
        .reads("IMAGE", &args.images)
        .writes("-o", &paths)
        .check()?;
    let (project, viewpoint) = view::load_viewpoint(&args.design, &args.camera, None)?;
    let sensor = &project.design.sensor;
    let (lighting, constants) = view::find_lighting(&project, &args.light)?;
    let viewpoint = view::lighting_viewpoint(lighting, &args.camera, viewpoint)?;
    let reference = CapturedImage::read(&args.reference)?;
    let network = args.network.as_deref().map(DepthNetwork::read).transpose()?;
    let (reader, mut judgement) = ImageReader::new(
        (sensor, &viewpoint),
        || SensorView::new(Arc::clone(&project), viewpoint.clone()),
        (lighting, &constants),
        network.as_ref(),
        (&args.reference, &reference),
    )?
    .accept_anyway();
    let [width, height] = reader.size_px();
    let bytes = (RESULT_BYTES_PER_PIXEL * width * height * outputs.len()) as u64;
    memory::check_memory("reconstruction of these images", bytes, MemoryHint::Files)?;
    let mut results = String::new();
    let mut text = heading(sensor, &reader, network.as_ref());
    let (mut files, mut listed, mut rates) = (Vec::new(), Vec::new(), None);
    for (path, image) in &outputs {
        let taken = CapturedImage::read(image)?;
        if rates.is_none() {
            rates = Some(reader.measure_rates(image, &taken)?);
        }
        let (read, found) = reader.read(image, taken)?.accept_anyway();
        judgement.merge(&found);
        let bytes = reader.npz(&read)?;
        let farthest_px = reader.max_displacement_px(&read);
        let written = format_size(bytes.len() as u64);
        results +=
            &format!("{}: {}; {written}\n", path.display(), format_result(&read, farthest_px));
        listed.push(json!({
            "file": path.display().to_string(),
            "picture": image.display().to_string(),
            "deepest_mm": read.depth.as_ref().and_then(DepthResult::deepest_mm),
            "contact_px": read.contact_px(),
            "brighter": read.depth.as_ref().map(|shown| shown.relative_brightness),
            "marks_seen": read.markers.as_ref().map(TrackedMarkers::found),
            "marks_left_out": read.markers.as_ref().map(|followed| followed.left_out.count),
            "marks_significance": read
                .markers
                .as_ref()
                .and_then(|followed| Some(followed.least_significance()?.sigmas())),
            "marks_moved_px": farthest_px,
            "bytes": bytes.len(),
        }));
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        files.push(OutputFile { name, bytes });
    }
    let is_written = judgement.is_plausible() || args.force;
    if is_written {
        interrupt::begin_writing()?;
        write_all(&args.output, &files, &interrupt::is_requested)?;
    }
    // What is not written is no result.
    text += if is_written { &results } else { "" };
    text += &findings::format_findings(&judgement, args.force);
    let rate = rates.map_or(f64::NAN, |rates| rates.images_per_s);
    text +=
        &format!("{rate:.0} images per second on one core, without reading and writing files\n");
    // A network does not use light constants, and marker tracking alone needs none.
    let constants = if reader.scene.is_some() && network.is_none() {
        json!(constants.document(&lighting.effect))
    } else {
        json!([])
    };
    let json = json!({
        "format": "fabkit-reconstruction",
        "version": 1,
        "sensor": sensor.name,
        "light": lighting.name,
        "constants": constants,
        "network": network.zip(reader.scene.as_ref()).map(|(network, scene)| network.document(scene)),
        "marks": reader.marks.as_ref().map(|marks| json!({
            "drawn": marks.names().len(),
            "in_view": count_known(marks.drawn_px()),
            "at_rest": count_known(marks.rest_px()),
            "left_out": marks.rest().left_out.count,
            "left_out_contrast": marks.rest().left_out.max_contrast,
            "pictures_per_s": rates.and_then(|rates| rates.marks_per_s),
        })),
        "left_out": reader.omissions,
        "plausibility": judgement.document(),
        "written": is_written,
        "width_px": width,
        "height_px": height,
        "pictures_per_s": rate,
        "files": listed,
    });
    Ok(Outcome { text, json, failed: !is_written })
}

/// Formats what is reconstructed, and with which model.
fn heading(sensor: &Sensor, reader: &ImageReader, network: Option<&DepthNetwork>) -> String {
    let mut text = String::new();
    if let Some((network, scene)) = network.zip(reader.scene.as_ref()) {
        if let Some(warning) = network.warning(scene) {
            text += &format!("warning: {warning}\n");
        }
        text += &format!("{}\n", network.words());
    }
    // Users of a sensor without markers know that it has none.
    let told = reader.omissions.iter().filter(|_| !sensor.marks.is_empty());
    text.extend(told.map(|left_out| format!("{left_out}\n")));
    if let Some(marks) = &reader.marks {
        let [at_rest, drawn] = [marks.rest_px(), marks.drawn_px()].map(count_known);
        let all = marks.names().len();
        text += &format!(
            "{at_rest} markers found at rest; the design has {all}, {drawn} of them in view\n"
        );
        if marks.rest().left_out.count > 0 {
            text += &format!("at rest, {}\n", marks.rest().left_out);
        }
    }
    text
}

/// Formats the result of one image.
fn format_result(read: &ImageReading, farthest_px: Option<f64>) -> String {
    let mut words = Vec::new();
    if let Some((shown, contact_px)) = read.depth.as_ref().zip(read.contact_px()) {
        let deepest =
            shown.deepest_mm().map_or("no contact".to_owned(), |mm| format!("{mm:.2} mm deep"));
        words.push(format!("{deepest}, {contact_px} px in contact"));
    }
    if let Some(followed) = &read.markers {
        let seen = followed.found();
        words.push(match followed.least_significance().zip(farthest_px) {
            Some((least, px)) => format!(
                "{seen} markers, each at least {:.0} times the noise, moved by up to {px:.1} px",
                least.sigmas()
            ),
            None => "no markers".to_owned(),
        });
        if followed.left_out.count > 0 {
            words.push(followed.left_out.to_string());
        }
    }
    words.join("; ")
}

fn count_known(px: &[Option<[f64; 2]>]) -> usize {
    px.iter().flatten().count()
}

/// Lists the output file of each image.
fn output_files(args: &Reconstruct) -> Result<Vec<(PathBuf, &Path)>, Failure> {
    let mut seen: BTreeMap<String, &Path> = BTreeMap::new();
    let mut outputs = Vec::new();
    for image in &args.images {
        let stem = image.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{stem}.npz");
        // Images from different folders may share a name; one would overwrite the other.
        if let Some(first) = seen.insert(name.clone(), image) {
            let (first, second) = (first.to_owned(), image.clone());
            return Err(Error::from(ReconstructError::SameName { first, second, name }).into());
        }
        outputs.push((args.output.join(name), image.as_path()));
    }
    Ok(outputs)
}
