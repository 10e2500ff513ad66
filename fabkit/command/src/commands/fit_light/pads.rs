//! Light of a flat gel, fitted to images of a ball.

use std::path::{Path, PathBuf};

use fabkit_application::calibration_runs::captures::image_paths;
use fabkit_application::light_fit::{PadFit, PadFitInput, PadMapping, pads_document};
use serde_json::json;

use super::super::{Outcome, view};
use super::{finish_outcome, refuse_options};
use crate::cli::{CameraArgs, FitLight};
use crate::failure::{ErrorKind, Failure};

pub(super) fn run(args: &FitLight, reference: &Path) -> Result<Outcome, Failure> {
    let of_domes = [
        (
            "--landmarks",
            args.landmarks.is_some(),
            "leave it out: the image shows where the ball is",
        ),
        ("--pin", args.pin.is_some(), "press one ball in each capture"),
        ("--pin-radius", args.pin_radius.is_some(), "write --ball-diameter LENGTH"),
    ];
    refuse_options(&of_domes, "is for domes; captures of a pad show a ball")?;
    let Some(diameter_mm) = args.ball_diameter else {
        let message = "the diameter of the ball is not given";
        return Err(Failure::new(ErrorKind::BadInput, message, "write --ball-diameter LENGTH"));
    };
    let camera = CameraArgs { camera: args.camera.clone(), pose: args.pose.clone() };
    let (project, viewpoint) = view::load_viewpoint(&args.design, &camera, None)?;
    let captures: Vec<PathBuf> = image_paths(&args.captures, reference)?;
    let fitting = PadFitInput {
        project: &project,
        outline: args.scale.map_or(PadMapping::Camera(&viewpoint), PadMapping::Rectified),
        reference,
        captures: &captures,
        ball_radius_mm: diameter_mm / 2.0,
    };
    let (fitted, judgement) = fitting.run()?.accept_anyway();
    let mut json = pads_document(&project.design.sensor, &fitted);
    json["ball_diameter_mm"] = json!(diameter_mm);
    finish_outcome(args, &project.design.sensor, summary(&fitted), json, &judgement)
}

fn summary(fitted: &PadFit) -> String {
    let [layer, ground, scatter] = fitted.values;
    let [of_layer, of_ground, of_scatter] = fitted.sigmas;
    let [first, of_first] = fitted.layer_grey_per_mm;
    let held_out = fitted.held_out_profile_rms_grey;
    let held_out = held_out.map_or_else(
        || "none held out (one capture)".to_owned(),
        |rms| format!("held out {rms:.2}"),
    );
    let mut text = format!(
        "intensity: {first:.1} +- {of_first:.1} per mm of a thin layer, {ground:.0} +- {of_ground:.0} from elsewhere\n\
         intensity of an endless layer {layer:.0} +- {of_layer:.0}, scattering {scatter:.2} +- {of_scatter:.2} /mm; a spread of light of {:.2} mm is assumed\n\
         intensity rms: profiles {:.2}, {held_out}; at rest {:.2}\n\
         each real, predicted:  depth mm  middle          edge mm      ring         ring mm      dark rms\n",
        fitted.spread_mm, fitted.profile_rms_grey, fitted.reference_rms_grey
    );
    for ball in &fitted.balls {
        let (real, now) = (ball.real, ball.predicted);
        let [real_edge, edge] =
            [real, now].map(|shape| shape.edge_mm.map_or("-".to_owned(), |mm| format!("{mm:.2}")));
        let name = ball.file.file_name().unwrap_or_default().to_string_lossy();
        text += &format!(
            "{name:22} {:9.2}  {:5.1} {:5.1}  {real_edge:>5} {edge:>5}  {:6.1} {:5.1}  {:5.2} {:5.2}  {:8.2}\n",
            ball.depth_mm,
            real.middle_grey,
            now.middle_grey,
            real.ring_grey,
            now.ring_grey,
            real.ring_mm,
            now.ring_mm,
            ball.dark_rms_grey
        );
    }
    text
}
