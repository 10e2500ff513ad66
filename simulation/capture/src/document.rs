//! JSON documents and comments of captures.

use fabkit_checks::UnknownProperty;
use fabkit_designs::{Design, design_hash};
use fabkit_fixtures::Project;
use fabkit_geometry::VisibleEffect;
use fabkit_scene::ground_truth::Viewpoint;
use fabkit_scene::press_simulation::marks_document;
use serde_json::{Value, json};

use super::{CameraGain, CaptureRequest, SimulatedCapture, lens, unit_document};

/// Returns what the simulation leaves out, as phrases for people.
pub(super) fn omitted_effects(
    shows: &VisibleEffect,
    of_lens: Vec<&'static str>,
) -> Vec<&'static str> {
    let own: &[&str] = match shows {
        VisibleEffect::Thickness { .. } => {
            &["the bending of light between lamps and curved layers"]
        }
        VisibleEffect::Slopes { .. } => {
            &["light that the coat sends onto itself", "what lamps' own lenses do to their light"]
        }
        VisibleEffect::Fluorescence { .. } => {
            &["light that one ink takes up of the other", "light that is scattered"]
        }
        VisibleEffect::Markers { .. } => &["shadows of marks on marks", "how the ground moves"],
        VisibleEffect::LiquidColumns { .. } => {
            &["the bending of light in the display", "menisci", "shadows"]
        }
    };
    let all = ["what the camera sees beside the surface, but for a constant"];
    let bounces = ["what bounces on, but for a constant"];
    own.iter().copied().chain(bounces).chain(of_lens).chain(all).collect()
}

/// Returns the constants behind a capture as JSON, those of the lens included.
pub(super) fn constants(design: &Design, capturing: &CaptureRequest<'_>) -> Value {
    let Value::Array(mut all) = capturing.constants.document(&capturing.lighting.effect) else {
        return Value::Null;
    };
    all.extend(lens::constants(design, capturing.lighting));
    all.into()
}

/// Returns the camera's gain over usual materials as JSON: needed, applied, and the most that is applied.
pub(super) fn camera_gain_document(gain: CameraGain) -> Value {
    json!({ "needed": gain.needed, "applied": gain.applied(), "most": CameraGain::most() })
}

/// Returns properties that no source states as JSON, with the keys of `fabkit check`.
pub fn unknown_document(not_known: &[UnknownProperty]) -> Value {
    let one = |unknown: &UnknownProperty| {
        json!({
            "property": unknown.property.word(),
            "material": unknown.material,
            "bodies": unknown.bodies,
            "remedy": unknown.remedy,
        })
    };
    not_known.iter().map(one).collect()
}

/// Returns a capture as `fabkit capture --json` prints it (`fabkit-capture` version 1), without files.
pub fn capture_document(
    project: &Project,
    viewpoint: &Viewpoint,
    capturing: &CaptureRequest<'_>,
    captured: &SimulatedCapture,
) -> Value {
    // Rays that meet no layer have NaN.
    let known = captured.thickness_mm.iter().filter(|mm| mm.is_finite());
    let ends = |[low, high]: [f64; 2], mm: &f64| [low.min(*mm), high.max(*mm)];
    let thickness = known.fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    let design = &project.design;
    json!({
        "format": "fabkit-capture",
        "version": 1,
        "is_simulated": true,
        "sensor": project.design.sensor.name,
        "design_hash": design_hash(&project.design),
        "viewpoint": viewpoint.to_json(),
        "presses": capturing.cast.presses.iter().map(|press| &press.id).collect::<Vec<_>>(),
        "contact_level": captured.contact_level,
        "elastic": captured.elastic,
        "light": capturing.lighting.name,
        "width_px": captured.size_px[0],
        "height_px": captured.size_px[1],
        "channels": captured.channels,
        "samples": capturing.cast.samples,
        "seed": capturing.seed,
        "unit": unit_document(project),
        "exposure": captured.exposure,
        "camera_gain": camera_gain_document(captured.camera_gain),
        "not_known": unknown_document(&captured.not_known),
        "drift_grey": captured.drift_grey,
        "jpeg_quality": capturing.jpeg_quality(&project.design.sensor),
        "range_grey": captured.range_grey(),
        "shown": captured.shown,
        // Without any finite thickness the range is still inverted, and null is written.
        "thickness_mm": (thickness[0] <= thickness[1]).then_some(thickness),
        "lamps": captured.light_sources,
        "marks": marks(captured),
        "constants": constants(design, capturing),
        "left_out": omitted_effects(&capturing.lighting.effect, lens::omitted_effects(&design.sensor, capturing.lighting)),
    })
}

/// Returns the markers as `fabkit press` prints them, with their pixels.
fn marks(captured: &SimulatedCapture) -> Value {
    let mut document = marks_document(&captured.marks);
    for (mark, pixel) in document.as_array_mut().into_iter().flatten().zip(&captured.mark_pixels) {
        mark["pixel"] = json!(pixel);
    }
    document
}

/// Returns one line about the origin of a capture, to be embedded in its files.
pub fn capture_comment(
    project: &Project,
    capturing: &CaptureRequest<'_>,
    captured: &SimulatedCapture,
) -> String {
    let presses: Vec<&str> = capturing.cast.presses.iter().map(|p| p.id.as_str()).collect();
    let pressed = if presses.is_empty() { "no contact".to_owned() } else { presses.join(" ") };
    let noise = capturing.seed.map_or("no noise".to_owned(), |seed| format!("seed {seed}"));
    let unit =
        project.unit.as_ref().map_or(String::new(), |unit| format!(" unit {},", unit.number));
    format!(
        "simulated by fabkit: {}, design {},{unit} {} light, {pressed}, {} contact, {noise}",
        project.design.sensor.name,
        design_hash(&project.design),
        capturing.lighting.name,
        captured.contact_level,
    )
}
