//! `fabkit fit-light SENSOR --camera camera.yaml --captures DIR`: of pins on a dome, of a ball on a pad.

mod pads;

use fabkit_application::calibrating::captures;
use fabkit_application::calibrating::extrinsics::{landmarks_of, read_camera, read_landmarks};
use fabkit_application::fitting_light::{FittedLight, FittingLight, document, is_pad};
use fabkit_application::picture::is_named_as_one as is_picture;
use fabkit_application::source::Target;
use fabkit_application::staging::write_each;
use serde_json::{Value, json};

use super::Outcome;
use crate::cli::FitLight;
use crate::failure::{ErrorKind, Failure};
use crate::interrupt;
use crate::roles::Roles;

pub(super) fn run(args: &FitLight) -> Result<Outcome, Failure> {
    let is_read = |name: &str| is_picture(name) || name.ends_with(".csv");
    Roles::default()
        .reads("SENSOR", Target::new(&args.design.sensor).files())
        .reads("--camera", &args.camera)
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
        return pads::run(args, &reference);
    }
    let of_pads = [
        ("--pose", args.pose.is_some(), "a dome's pins say where the camera is"),
        ("--scale", args.scale.is_some(), "write --camera FILE.yaml"),
        ("--ball-diameter", args.ball_diameter.is_some(), "captures of a dome show pins"),
    ];
    refuse(&of_pads, &format!("belongs to pads; {} is none", design.sensor.name))?;
    let Some(camera) = &args.camera else {
        let message = format!("nobody says which camera looks at {}", design.sensor.name);
        return Err(Failure::new(ErrorKind::BadInput, message, "write --camera FILE.yaml"));
    };
    let camera = read_camera(camera)?;
    let own = || -> Result<_, Failure> {
        let target =
            Target { sensor: &args.design.sensor, fixture: None, part: None, preset: None };
        Ok(landmarks_of(&target.pins(&args.design.set)?)?.clone())
    };
    let landmarks = match &args.landmarks {
        Some(path) => read_landmarks(path)?,
        None => own()?,
    };
    let told = args.pin_radius.or(Some(landmarks.tip_radius_mm).filter(|radius| *radius > 0.0));
    let pin_radius_mm = match told {
        Some(radius_mm) => radius_mm,
        None => own()?.tip_radius_mm,
    };
    if pin_radius_mm <= 0.0 {
        let message = "nobody says how round the pins' tips are";
        return Err(Failure::new(ErrorKind::BadInput, message, "write --pin-radius"));
    }
    let kind = args.pin.as_deref();
    let captures = captures::read(&args.captures, Some(&reference), &landmarks, kind)?;
    let fitting = FittingLight {
        sensor: &design.sensor,
        camera: &camera,
        landmarks: &landmarks,
        captures: &captures,
        folder: &args.captures,
        reference: &reference,
        pin_radius_mm,
    };
    let fitted = fitting.run()?;
    let mut json = document(&design.sensor, &fitted);
    json["pin_radius_mm"] = json!(pin_radius_mm);
    let text = summary(&fitted);
    ended(args, text, json)
}

/// Options of this kind of sensor's sibling, whether each was given, and what to do instead.
fn refuse(options: &[(&str, bool, &str)], why: &str) -> Result<(), Failure> {
    match options.iter().find(|(_, is_given, _)| *is_given) {
        Some((option, _, hint)) => {
            Err(Failure::new(ErrorKind::BadInput, format!("{option} {why}"), *hint))
        }
        None => Ok(()),
    }
}

/// Says what is not explained, and writes the file.
fn ended(args: &FitLight, mut text: String, json: Value) -> Result<Outcome, Failure> {
    for sentence in json["unexplained"].as_array().into_iter().flatten() {
        text += &format!("not explained: {}\n", sentence.as_str().unwrap_or_default());
    }
    if let Some(path) = &args.output {
        let bytes = format!("{json:#}\n").into_bytes();
        interrupt::begin_writing()?;
        write_each([(path.clone(), &bytes[..])], &interrupt::requested)?;
        text += &format!("{}\n", path.display());
    }
    Ok(Outcome { text, json, failed: false })
}

fn summary(fitted: &FittedLight) -> String {
    let [layer, ground, scatter, spread] = fitted.values;
    let [of_layer, of_ground, of_scatter, of_spread] = fitted.sigmas;
    let mut text = format!(
        "an endless layer sends back {layer:.0} +- {of_layer:.0} grey, {ground:.0} +- {of_ground:.0} come from elsewhere; it \
         scatters {scatter:.2} +- {of_scatter:.2} /mm, light spreads {spread:.2} +- {of_spread:.2} mm\n\
         pins go {:.2} mm in (landmarks: {:.2} mm)\n\
         held out: profiles {:.2} grey rms; at rest {:.2} grey rms\n\
         ring deg  pins  real grey  predicted  profile rms\n",
        fitted.pin_depth_mm,
        fitted.stated_depth_mm,
        fitted.held_out_profile_rms_grey,
        fitted.reference_rms_grey
    );
    for ring in &fitted.rings {
        text += &format!(
            "{:8.0}  {:4}  {:9.1}  {:9.1}  {:11.2}\n",
            ring.polar_deg, ring.pins, ring.real_grey, ring.predicted_grey, ring.profile_rms_grey
        );
    }
    text
}
