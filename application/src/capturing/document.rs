//! Pictures as JSON and in words.

use serde_json::{Value, json};

use super::{Captured, Capturing};
use crate::identity::design_hash;
use crate::scene::SensorView;

/// What a simulated picture leaves out, for people.
const LEFT_OUT: [&str; 5] = [
    "the bending of light between lamps and layer",
    "what bounces on, but for a constant",
    "vignetting and defocus of the lens",
    "the JPEG in which some cameras send pictures",
    "what the camera sees beside the surface, but for a constant",
];

/// A picture as `fabkit capture --json` says it (`fabkit-capture` version 1), without files.
pub fn document(scene: &SensorView, capturing: &Capturing<'_>, captured: &Captured) -> Value {
    let known = captured.thickness_mm.iter().filter(|mm| mm.is_finite());
    let ends = |[low, high]: [f64; 2], mm: &f64| [low.min(*mm), high.max(*mm)];
    let thickness = known.fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    json!({
        "format": "fabkit-capture",
        "version": 1,
        "is_simulated": true,
        "sensor": scene.project.design.sensor.name,
        "design_hash": design_hash(&scene.project.design),
        "viewpoint": scene.viewpoint.to_json(),
        "presses": capturing.cast.presses.iter().map(|press| &press.id).collect::<Vec<_>>(),
        "contact_level": captured.contact_level,
        "elastic": captured.elastic,
        "width_px": captured.size_px[0],
        "height_px": captured.size_px[1],
        "samples": capturing.cast.samples,
        "seed": capturing.seed,
        "exposure": captured.exposure,
        "drift_grey": captured.drift_grey,
        "range_grey": captured.range_grey(),
        "layer": captured.layer,
        "thickness_mm": thickness,
        "lamps": captured.lamps,
        "constants": capturing.constants.document(),
        "left_out": LEFT_OUT,
    })
}

/// One line that goes with the picture wherever it goes.
pub fn comment(scene: &SensorView, capturing: &Capturing<'_>, captured: &Captured) -> String {
    let presses: Vec<&str> = capturing.cast.presses.iter().map(|p| p.id.as_str()).collect();
    let pressed = if presses.is_empty() { "no contact".to_owned() } else { presses.join(" ") };
    let noise = capturing.seed.map_or("no noise".to_owned(), |seed| format!("seed {seed}"));
    format!(
        "simulated by fabkit: {}, design {}, {pressed}, {} contact, {noise}",
        scene.project.design.sensor.name,
        design_hash(&scene.project.design),
        captured.contact_level,
    )
}
