//! `fabkit fit-light SENSOR --camera camera.yaml --captures DIR`: from presses of pins on a dome, or of a ball on a
//! pad.

mod domes;
mod pads;

use fabkit_application::capturing::plausibility::Judgement;
use fabkit_application::capturing::{LightConstants, find_lighting};
use fabkit_application::documents;
use fabkit_application::geometry::{MaterialProperty, Sensor};
use fabkit_application::image::has_image_extension as is_image;
use fabkit_application::light_fit::is_pad;
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;
use serde_json::Value;

use super::{Outcome, findings};
use crate::cli::FitLight;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::FileRoles;

pub(super) fn run(args: &FitLight) -> Result<Outcome, Failure> {
    let is_read = |name: &str| is_image(name) || name.ends_with(".csv");
    FileRoles::default()
        .reads("SENSOR", Target::new(&args.design.sensor).files())
        .reads_camera(&args.camera)
        .reads("--pose", &args.pose)
        .reads("--landmarks", &args.landmarks)
        .reads("--reference", &args.reference)
        .reads_all("--captures", Some(args.captures.as_path()), is_read)
        .writes("-o", &args.output)
        .check()?;
    let target = Target::new(&args.design.sensor);
    let design = target.design(&args.design.set)?;
    let reference = args.reference.clone().unwrap_or_else(|| args.captures.join("ref.png"));
    if is_pad(&design.sensor) {
        pads::run(args, &reference)
    } else {
        domes::run(args, &design, &reference)
    }
}

/// Refuses options of the other kind of sensor. Each has its name, whether it was given, and a hint.
fn refuse_options(options: &[(&str, bool, &str)], why: &str) -> Result<(), Failure> {
    match options.iter().find(|(_, is_given, _)| *is_given) {
        Some((option, _, hint)) => {
            Err(Failure::new(ErrorKind::BadInput, format!("{option} {why}"), *hint))
        }
        None => Ok(()),
    }
}

/// Appends the unexplained effects and writes the file.
fn finish_outcome(
    args: &FitLight,
    sensor: &Sensor,
    mut text: String,
    mut json: Value,
    judgement: &Judgement,
) -> Result<Outcome, Failure> {
    json["plausibility"] = judgement.document();
    // The fit itself finds out how much the layer scatters.
    let mut unknown =
        LightConstants::for_sensor(sensor).not_known(&find_lighting(sensor, None)?.effect);
    unknown.retain(|one| one.property != MaterialProperty::Scattering);
    json["not_known"] = unknown.iter().map(documents::unknown_property).collect();
    for sentence in json["unexplained"].as_array().into_iter().flatten() {
        text += &format!("not explained: {}\n", sentence.as_str().unwrap_or_default());
    }
    text += &findings::format_findings(judgement, args.force);
    let is_written = judgement.is_plausible() || args.force;
    if let Some(path) = args.output.as_ref().filter(|_| is_written) {
        let bytes = format!("{json:#}\n").into_bytes();
        interrupt::begin_writing()?;
        write_each([(path.clone(), &bytes[..])], &interrupt::is_requested)?;
        text += &format!("{}\n", path.display());
    }
    Ok(Outcome { text, json, failed: !is_written })
}
