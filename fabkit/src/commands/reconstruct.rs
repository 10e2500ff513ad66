//! `fabkit reconstruct SENSOR --reference ref.png pictures... -o DIR`

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fabkit_application::Error;
use fabkit_application::memory::{self, Less};
use fabkit_application::reconstructing::{
    DepthNetwork, ReconstructError, Reconstructor, Taken, npz_of,
};
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
    let scene = view::scene(&args.design, &args.camera)?;
    let sensor = &scene.project.design.sensor;
    let (lighting, constants) = view::lit(sensor, &args.light)?;
    let reference = Taken::read(&args.reference)?;
    let rest = (args.reference.as_path(), &reference);
    let network = args.network.as_deref().map(DepthNetwork::read).transpose()?;
    let known = match &network {
        Some(network) => Reconstructor::with_network(&scene, network, rest)?,
        None => Reconstructor::new(&scene, lighting, &constants, rest)?,
    };
    let [width, height] = known.size_px();
    let bytes = (BYTES_A_PIXEL * width * height * outputs.len()) as u64;
    memory::admit("what these pictures show", bytes, Less::Files)?;
    let (mut files, mut listed, mut text) = (Vec::new(), Vec::new(), String::new());
    if let Some(network) = &network {
        if let Some(warning) = network.warning(&scene) {
            text += &format!("warning: {warning}\n");
        }
        text += &format!("{}\n", network.words());
    }
    let mut rate = None;
    for (path, picture) in &outputs {
        let taken = Taken::read(picture)?;
        if rate.is_none() {
            rate = Some(known.pictures_per_s(picture, &taken)?);
        }
        let shown = known.reconstruct(picture, taken)?;
        let bytes = npz_of(known.size_px(), &shown)?;
        let contact_px = shown.contact.iter().filter(|contact| **contact).count();
        let deepest_mm = shown.deepest_mm();
        let deepest = deepest_mm.map_or("no contact".to_owned(), |mm| format!("{mm:.2} mm deep"));
        text += &format!(
            "{}: {}, {contact_px} px touched; {}\n",
            path.display(),
            deepest,
            size(bytes.len() as u64)
        );
        listed.push(json!({
            "file": path.display().to_string(),
            "picture": picture.display().to_string(),
            "deepest_mm": deepest_mm,
            "contact_px": contact_px,
            "brighter": shown.brighter,
            "bytes": bytes.len(),
        }));
        files.push((path.clone(), bytes));
    }
    interrupt::begin_writing()?;
    let written = files.iter().map(|(path, bytes)| (path.clone(), &bytes[..]));
    write_each(written, &interrupt::requested)?;
    let rate = rate.unwrap_or(f64::NAN);
    text += &format!("{rate:.0} pictures a second on one core, read and written apart\n");
    // A network knows nothing of how light behaves.
    let constants = match &network {
        Some(_) => json!([]),
        None => json!(constants.document(&lighting.shows)),
    };
    let json = json!({
        "format": "fabkit-reconstruction",
        "version": 1,
        "sensor": sensor.name,
        "light": lighting.name,
        "constants": constants,
        "network": network.map(|network| network.document(&scene)),
        "width_px": known.size_px()[0],
        "height_px": known.size_px()[1],
        "pictures_per_s": rate,
        "files": listed,
    });
    Ok(Outcome { text, json, failed: false })
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
