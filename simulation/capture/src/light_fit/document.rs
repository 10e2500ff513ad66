//! JSON document of fitted constants.

use fabkit_geometry::Sensor;
use serde_json::{Value, json};

use super::{LightFit, Ring};
use crate::constants_file::{FITTED, FORMAT};

/// Returns fitted constants as `fabkit fit-light --json` prints them (`fabkit-fit-light` version 1), without files.
pub fn fit_document(sensor: &Sensor, fitted: &LightFit) -> Value {
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
        "constants": FITTED.iter().enumerate().map(constant).collect::<Vec<_>>(),
        "pin_depth_mm": fitted.pin_depth_mm,
        "stated_pin_depth_mm": fitted.stated_depth_mm,
        "held_out_profile_rms_grey": fitted.held_out_profile_rms_grey,
        "held_out_peak_error_grey": fitted.rings.iter().map(ring).collect::<Vec<_>>(),
        "reference_rms_grey": fitted.reference_rms_grey,
        "reference": fitted.reference.iter().map(rest).collect::<Vec<_>>(),
        "unexplained": unexplained(fitted),
    })
}

/// Describes what the constants do not explain, for people.
fn unexplained(fitted: &LightFit) -> Vec<String> {
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
