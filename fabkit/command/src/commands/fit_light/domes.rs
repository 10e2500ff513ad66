//! Light of a dome, fitted to images of pins.

use std::path::Path;

use fabkit_application::calibration_runs::captures;
use fabkit_application::calibration_runs::extrinsics::{
    check_camera_size, fixture_landmarks, read_landmarks,
};
use fabkit_application::designs::Design;
use fabkit_application::light_fit::{LightFit, LightFitInput, fit_document};
use fabkit_application::source::Target;
use serde_json::json;

use super::super::Outcome;
use super::super::camera_files::read_camera;
use super::{finish_outcome, refuse_options};
use crate::cli::FitLight;
use crate::failure::{ErrorKind, Failure};

pub(super) fn run(args: &FitLight, design: &Design, reference: &Path) -> Result<Outcome, Failure> {
    let of_pads = [
        (
            "--pose",
            args.pose.is_some(),
            "leave it out: the pins of a dome determine the camera's pose",
        ),
        ("--scale", args.scale.is_some(), "write --camera FILE.yaml"),
        (
            "--ball-diameter",
            args.ball_diameter.is_some(),
            "leave it out: captures of a dome show pins",
        ),
    ];
    refuse_options(&of_pads, &format!("is for pads; {} has none", design.sensor.name))?;
    let Some(camera) = &args.camera else {
        let message = format!("the camera of {} is not given", design.sensor.name);
        return Err(Failure::new(ErrorKind::BadInput, message, "write --camera FILE.yaml"));
    };
    let camera = read_camera(camera)?;
    let own = || -> Result<_, Failure> {
        let target =
            Target { sensor: &args.design.sensor, fixture: None, part: None, preset: None };
        Ok(fixture_landmarks(&target.pin_fixture(&args.design.set)?)?.clone())
    };
    let landmarks = match &args.landmarks {
        Some(path) => read_landmarks(path)?,
        None => own()?,
    };
    // In order of precedence: the option, the landmarks, the sensor's own fixture.
    let told = args.pin_radius.or(Some(landmarks.tip_radius_mm).filter(|radius| *radius > 0.0));
    let pin_radius_mm = match told {
        Some(radius_mm) => radius_mm,
        None => own()?.tip_radius_mm,
    };
    if pin_radius_mm <= 0.0 {
        let message = "the radius of the pins' tips is not given";
        return Err(Failure::new(ErrorKind::BadInput, message, "write --pin-radius"));
    }
    let kind = args.pin.as_deref();
    let captures = captures::read(&args.captures, Some(reference), &landmarks, kind)?;
    check_camera_size(&camera, &captures)?;
    let fitting = LightFitInput {
        sensor: &design.sensor,
        camera: &camera,
        landmarks: &landmarks,
        captures: &captures,
        folder: &args.captures,
        reference,
        pin_radius_mm,
    };
    let (fitted, judgement) = fitting.run()?.accept_anyway();
    let mut json = fit_document(&design.sensor, &fitted);
    json["pin_radius_mm"] = json!(pin_radius_mm);
    let text = summary(&fitted);
    finish_outcome(args, &design.sensor, text, json, &judgement)
}

fn summary(fitted: &LightFit) -> String {
    let [layer, ground, scatter, spread] = fitted.values;
    let [of_layer, of_ground, of_scatter, of_spread] = fitted.sigmas;
    let mut text = format!(
        "intensity: {layer:.0} +- {of_layer:.0} from an endless layer, {ground:.0} +- {of_ground:.0} from elsewhere\nscattering {scatter:.2} +- {of_scatter:.2} /mm, spread of light {spread:.2} +- {of_spread:.2} mm\n\
         pins press {:.2} mm deep (landmarks: {:.2} mm)\n\
         intensity rms: held-out profiles {:.2}, at rest {:.2}\n\
         ring deg  pins  intensity  predicted  profile rms\n",
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
