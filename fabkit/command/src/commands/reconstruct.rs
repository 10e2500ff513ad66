//! `fabkit reconstruct SENSOR --reference ref.png pictures... -o DIR`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use fabkit_application::Error;
use fabkit_application::ground_truth::Viewpoint;
use fabkit_application::memory::{self, Less};
use fabkit_application::reconstructing::{
    DepthNetwork, Followed, MarkFollower, ReconstructError, Reconstructed, Reconstructor, Taken,
    hides_marks, npz_of, shows_depth,
};
use fabkit_application::scene::SensorView;
use fabkit_application::staging::write_each;
use serde_json::json;

use super::{Outcome, view};
use crate::cli::Reconstruct;
use crate::failure::Failure;
use crate::interrupt;
use crate::table::size;

/// Of what is written.
const BYTES_A_PIXEL: usize = 5;

pub(super) fn run(args: &Reconstruct) -> Result<Outcome, Failure> {
    let outputs = outputs(args)?;
    let paths: Vec<PathBuf> = outputs.iter().map(|(path, _)| path.clone()).collect();
    view::roles(&args.design, &args.camera)
        .reads("--constants", &args.light.constants)
        .reads("--reference", [&args.reference])
        .reads(
            "--network",
            args.network.iter().flat_map(|file| [file.clone(), DepthNetwork::card_of(file)]),
        )
        .reads("IMAGE", &args.pictures)
        .writes("-o", &paths)
        .check()?;
    let (project, viewpoint) = view::seen_from(&args.design, &args.camera, None)?;
    let sensor = &project.design.sensor;
    let (lighting, constants) = view::lit(&project, &args.light)?;
    let viewpoint = match &lighting.camera {
        Some(camera) if args.camera.camera.is_none() && args.camera.pose.is_none() => {
            Viewpoint::new(camera, None, None).map_err(Failure::bug)?
        }
        _ => viewpoint,
    };
    let reference = Taken::read(&args.reference)?;
    let rest = (args.reference.as_path(), &reference);
    let network = args.network.as_deref().map(DepthNetwork::read).transpose()?;
    let mut left_out = Vec::new();
    let (mut depth, mut scene) = (None, None);
    if network.is_some() || shows_depth(lighting) || hides_marks(sensor, lighting).is_some() {
        let view = SensorView::new(Arc::clone(&project), viewpoint.clone())?;
        depth = Some(match &network {
            Some(network) => Reconstructor::with_network(&view, network, rest)?,
            None => Reconstructor::new(&view, lighting, &constants, rest)?,
        });
        scene = Some(view);
    } else {
        let (sensor, light) = (sensor.name.clone(), lighting.name);
        left_out.push(ReconstructError::OtherLight { sensor, light }.to_string());
    }
    let marks = match MarkFollower::new(sensor, &viewpoint, lighting, rest) {
        Ok(marks) => Some(marks),
        // Depth needs none, and a picture without marks still shows it.
        Err(error) if depth.is_some() => match error.downcast_ref() {
            Some(few @ ReconstructError::FewMarks { .. }) => {
                left_out.push(format!("{few}: they are not followed"));
                None
            }
            Some(none @ ReconstructError::NoMarks { .. }) => {
                left_out.push(none.to_string());
                None
            }
            _ => return Err(error.into()),
        },
        Err(error) => return Err(error.into()),
    };
    let camera = viewpoint.camera();
    let [width, height] = [camera.width_px(), camera.height_px()].map(|px| px as usize);
    let bytes = (BYTES_A_PIXEL * width * height * outputs.len()) as u64;
    memory::admit("what these pictures show", bytes, Less::Files)?;
    let (mut files, mut listed, mut text) = (Vec::new(), Vec::new(), String::new());
    if let Some((network, scene)) = network.as_ref().zip(scene.as_ref()) {
        if let Some(warning) = network.warning(scene) {
            text += &format!("warning: {warning}\n");
        }
        text += &format!("{}\n", network.words());
    }
    // Who has a sensor without marks knows it.
    let told = left_out.iter().filter(|_| !sensor.marks.is_empty());
    text.extend(told.map(|left_out| format!("{left_out}\n")));
    if let Some(marks) = &marks {
        let [at_rest, drawn] = [marks.rest_px(), marks.drawn_px()].map(known);
        let all = marks.names().len();
        text += &format!("{at_rest} marks at rest, of {drawn} drawn in view and {all} in all\n");
    }
    let (mut rate, mut marks_rate) = (None, None);
    for (path, picture) in &outputs {
        let taken = Taken::read(picture)?;
        if rate.is_none() {
            let of_depth = depth.as_ref().map(|depth| depth.pictures_per_s(picture, &taken));
            let of_marks = marks.as_ref().map(|marks| marks.pictures_per_s(picture, &taken));
            marks_rate = of_marks.transpose()?;
            let rates = [of_depth.transpose()?, marks_rate];
            rate = Some(rates.into_iter().flatten().map(f64::recip).sum::<f64>().recip());
        }
        let followed = marks.as_ref().map(|marks| marks.follow(picture, &taken)).transpose()?;
        let shown = depth.as_ref().map(|depth| depth.reconstruct(picture, taken)).transpose()?;
        let of_marks = marks.as_ref().zip(followed.as_ref());
        let arrays = of_marks.map_or_else(Vec::new, |(marks, followed)| marks.arrays(followed));
        let bytes = npz_of([width, height], shown.as_ref(), arrays)?;
        let mut words = Vec::new();
        let deepest_mm = shown.as_ref().and_then(Reconstructed::deepest_mm);
        let contact_px =
            shown.as_ref().map(|shown| shown.contact.iter().filter(|contact| **contact).count());
        if let Some(contact_px) = contact_px {
            let deepest =
                deepest_mm.map_or("no contact".to_owned(), |mm| format!("{mm:.2} mm deep"));
            words.push(format!("{deepest}, {contact_px} px touched"));
        }
        let farthest_px = of_marks.map(|(marks, followed)| {
            let moved = marks.moved_px(followed).into_iter().flatten();
            moved.map(|[x, y]| x.hypot(y)).fold(0.0, f64::max)
        });
        if let Some((followed, farthest_px)) = followed.as_ref().zip(farthest_px) {
            let seen = followed.seen();
            words.push(format!("{seen} marks, which move up to {farthest_px:.1} px"));
        }
        let written = size(bytes.len() as u64);
        text += &format!("{}: {}; {written}\n", path.display(), words.join("; "));
        listed.push(json!({
            "file": path.display().to_string(),
            "picture": picture.display().to_string(),
            "deepest_mm": deepest_mm,
            "contact_px": contact_px,
            "brighter": shown.as_ref().map(|shown| shown.brighter),
            "marks_seen": followed.as_ref().map(Followed::seen),
            "marks_moved_px": farthest_px,
            "bytes": bytes.len(),
        }));
        files.push((path.clone(), bytes));
    }
    interrupt::begin_writing()?;
    let written = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
    write_each(written, &interrupt::requested)?;
    let rate = rate.unwrap_or(f64::NAN);
    text += &format!("{rate:.0} pictures a second on one core, read and written apart\n");
    // A network knows nothing of how light behaves, and marks need not.
    let constants = if depth.is_some() && network.is_none() {
        json!(constants.document(&lighting.shows))
    } else {
        json!([])
    };
    let json = json!({
        "format": "fabkit-reconstruction",
        "version": 1,
        "sensor": sensor.name,
        "light": lighting.name,
        "constants": constants,
        "network": network.zip(scene).map(|(network, scene)| network.document(&scene)),
        "marks": marks.as_ref().map(|marks| json!({
            "drawn": marks.names().len(),
            "in_view": known(marks.drawn_px()),
            "at_rest": known(marks.rest_px()),
            "pictures_per_s": marks_rate,
        })),
        "left_out": left_out,
        "width_px": width,
        "height_px": height,
        "pictures_per_s": rate,
        "files": listed,
    });
    Ok(Outcome { text, json, failed: false })
}

fn known(px: &[Option<[f64; 2]>]) -> usize {
    px.iter().flatten().count()
}

/// The file of each picture.
fn outputs(args: &Reconstruct) -> Result<Vec<(PathBuf, &Path)>, Failure> {
    let mut seen: BTreeMap<String, &Path> = BTreeMap::new();
    let mut outputs = Vec::new();
    for picture in &args.pictures {
        let stem = picture.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{stem}.npz");
        if let Some(first) = seen.insert(name.clone(), picture) {
            let (first, second) = (first.to_owned(), picture.clone());
            return Err(Error::from(ReconstructError::SameName { first, second, name }).into());
        }
        outputs.push((args.output.join(name), picture.as_path()));
    }
    Ok(outputs)
}
