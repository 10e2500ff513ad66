//! Fitted constants as JSON, and as what pictures rest on.

use std::path::Path;

use fabkit_files::Error;
use fabkit_files::reading::{self, Expected};
use fabkit_geometry::Sensor;
use serde_json::{Value, json};

use super::{FitLightError, FittedLight, Ring};
use crate::{Constant, Known, LightConstants};

pub(super) const FORMAT: &str = "fabkit-fit-light";

/// Names of the fitted numbers, in their order.
pub(super) const NAMES: [&str; 4] = ["layer_grey", "ground_grey", "scatter_per_mm", "spread_mm"];

/// As `fabkit fit-light --json` says it (`fabkit-fit-light` version 1), without files.
pub fn document(sensor: &Sensor, fitted: &FittedLight) -> Value {
    let constant = |(i, name): (usize, &&str)| json!({ "name": name, "value": fitted.values[i], "sigma": fitted.sigmas[i] });
    let ring = |ring: &Ring| {
        json!({
            "polar_deg": ring.polar_deg,
            "stated_pin_depth_mm": ring.stated_depth_mm,
            "pins": ring.pins,
            "real_grey": ring.real_grey,
            "predicted_grey": ring.predicted_grey,
            "error_grey": ring.predicted_grey - ring.real_grey,
            "profile_rms_grey": ring.profile_rms_grey,
            "profile_grey": ring.profile_grey,
        })
    };
    let rest = |[polar, real, now]: &[f64; 3]| json!({ "polar_deg": polar.to_degrees(), "real_grey": real, "simulated_grey": now });
    json!({
        "format": FORMAT,
        "version": 1,
        "sensor": sensor.name,
        "captures": fitted.captures,
        "constants": NAMES.iter().enumerate().map(constant).collect::<Vec<_>>(),
        "pin_depth_mm": fitted.pin_depth_mm,
        "stated_pin_depth_mm": fitted.stated_depth_mm,
        "held_out_profile_rms_grey": fitted.held_out_profile_rms_grey,
        "held_out_peak_error_grey": fitted.rings.iter().map(ring).collect::<Vec<_>>(),
        "reference_rms_grey": fitted.reference_rms_grey,
        "reference": fitted.reference.iter().map(rest).collect::<Vec<_>>(),
        "unexplained": unexplained(fitted),
    })
}

/// What the constants do not explain, in words.
fn unexplained(fitted: &FittedLight) -> Vec<String> {
    let mut found = Vec::new();
    let errors =
        fitted.rings.iter().map(|ring| (ring.polar_deg, ring.predicted_grey - ring.real_grey));
    for (polar_deg, error) in errors.filter(|(_, error)| error.abs() > 5.0) {
        found.push(format!(
            "pins {polar_deg:.0} deg from the tip are {:.0} grey {} than predicted in their middle",
            error.abs(),
            if error > 0.0 { "less dark" } else { "darker" }
        ));
    }
    let off_mm = fitted.pin_depth_mm - fitted.stated_depth_mm;
    if off_mm.abs() > 0.25 {
        found.push(format!(
            "landmarks say that pins go {:.2} mm in; {:.2} mm explain the captures better",
            fitted.stated_depth_mm, fitted.pin_depth_mm
        ));
    }
    found
}

/// What pictures of a unit rest on, from the file that [`document`] is in.
///
/// # Errors
/// A file that cannot be read, or is none of those.
pub fn read_constants(sensor: &Sensor, path: &Path) -> Result<LightConstants, Error> {
    let hint = "`fabkit fit-light` writes such files with -o";
    let expected = Expected { what: "constants of light", max_bytes: 1 << 20, hint };
    let text = reading::read_text(path, expected)?;
    let wrong = |what: &str| FitLightError::File { file: path.into(), what: what.to_owned() };
    let document: Value =
        serde_json::from_str(&text).map_err(|error| wrong(&format!("is no JSON: {error}")))?;
    if document["format"] != FORMAT || document["version"] != 1 {
        return Err(wrong("is not of the format fabkit-fit-light 1").into());
    }
    let value = |name: &str| {
        let constants = document["constants"].as_array().into_iter().flatten();
        let mut named = constants.filter(|constant| constant["name"] == name);
        let value = named.next().and_then(|constant| constant["value"].as_f64());
        let value = value.filter(|value| *value > 0.0 && value.is_finite());
        value.ok_or_else(|| wrong(&format!("has no {name} above zero")))
    };
    let rms = document["held_out_profile_rms_grey"].as_f64();
    let rms = rms.map_or_else(
        || "none was held out".to_owned(),
        |rms| format!("{rms:.1} grey rms are left on those that were held out"),
    );
    // On pads how far light spreads is held.
    let is_pad = document["balls"].is_array();
    let (fitted, what) = if is_pad { (&NAMES[..3], "balls") } else { (&NAMES[..], "pins") };
    let source =
        format!("{}: fitted to {} captures of {what}; {rms}", path.display(), document["captures"]);
    let mut constants = LightConstants { middle_grey: None, ..LightConstants::of(sensor) };
    let parts: [&mut Constant; 4] = [
        &mut constants.layer_grey,
        &mut constants.ground_grey,
        &mut constants.scatter_per_mm,
        &mut constants.spread_mm,
    ];
    for (constant, name) in parts.into_iter().zip(fitted) {
        (constant.value, constant.known) = (value(name)?, Known::Fitted);
        constant.source.clone_from(&source);
    }
    Ok(constants)
}
