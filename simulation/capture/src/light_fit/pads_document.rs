//! JSON document of constants fitted to balls on a pad.

use fabkit_geometry::Sensor;
use serde_json::{Value, json};

use super::pads::{BallResult, PadFit, ProfileShape};
use crate::constants_file::{FITTED, FORMAT};

/// Limits beyond which errors are reported in words: of the ring's height, as a share of the real one; of its radius,
/// mm; of profiles and of the image at rest, in intensities.
const RING_PART: f64 = 0.2;
const RING_MM: f64 = 0.3;
const PROFILE_GREY: f64 = 4.0;

/// Returns fitted constants of a pad as `fabkit fit-light --json` prints them (`fabkit-fit-light` version 1), without
/// files.
pub fn pads_document(sensor: &Sensor, fitted: &PadFit) -> Value {
    let constant = |(i, name): (usize, &&str)| json!({ "name": name, "value": fitted.values[i], "sigma": fitted.sigmas[i] });
    let mut constants: Vec<Value> = FITTED[..3].iter().enumerate().map(constant).collect();
    let [value, sigma] = fitted.layer_grey_per_mm;
    constants.push(json!({ "name": "layer_grey_per_mm", "value": value, "sigma": sigma }));
    let shape = |shape: &ProfileShape| {
        json!({
            "middle_grey": shape.middle_grey,
            "edge_mm": shape.edge_mm,
            "ring_grey": shape.ring_grey,
            "ring_mm": shape.ring_mm,
        })
    };
    let ball = |ball: &BallResult| {
        json!({
            "file": ball.file.display().to_string(),
            "at_mm": ball.at_mm,
            "depth_mm": ball.depth_mm,
            "brighter_grey": ball.brighter_grey,
            "real": shape(&ball.real),
            "predicted": shape(&ball.predicted),
            "dark_profile_rms_grey": ball.dark_rms_grey,
            "profile_grey": ball.profile_grey,
        })
    };
    json!({
        "format": FORMAT,
        "version": 1,
        "sensor": sensor.name,
        "captures": fitted.balls.len(),
        "constants": constants,
        "held_spread_mm": fitted.spread_mm,
        "balls": fitted.balls.iter().map(ball).collect::<Vec<_>>(),
        "bin_mm": fitted.bin_mm,
        "profile_rms_grey": fitted.profile_rms_grey,
        "held_out_profile_rms_grey": fitted.held_out_profile_rms_grey,
        "reference_rms_grey": fitted.reference_rms_grey,
        "unexplained": unexplained(fitted),
    })
}

/// Describes what the constants do not explain, for people.
fn unexplained(fitted: &PadFit) -> Vec<String> {
    let mut found = Vec::new();
    for ball in &fitted.balls {
        let (file, real, now) = (ball.file.display(), ball.real, ball.predicted);
        if ball.is_at_limit {
            let mm = ball.depth_mm;
            found.push(format!(
                "{file}: {mm:.2} mm explain it best, as far as depths are tried: is the ball as large as it is said to be?"
            ));
        }
        if ball.dark_rms_grey > PROFILE_GREY {
            let grey = ball.dark_rms_grey;
            found.push(format!("{file}: {grey:.1} grey rms are left where the ball makes it dark"));
        }
        // A maximum below the residual of profiles is no ring.
        let is_ring = real.ring_grey.max(now.ring_grey) > PROFILE_GREY;
        if is_ring && (now.ring_grey - real.ring_grey).abs() > RING_PART * real.ring_grey.abs() {
            found.push(format!(
                "{file}: the ring around the ball is {:.0} grey brighter than at rest; {:.0} grey are predicted",
                real.ring_grey, now.ring_grey
            ));
        }
        if is_ring && (now.ring_mm - real.ring_mm).abs() > RING_MM {
            found.push(format!(
                "{file}: the ring is brightest {:.2} mm out; {:.2} mm are predicted",
                real.ring_mm, now.ring_mm
            ));
        }
    }
    if fitted.reference_rms_grey > PROFILE_GREY {
        found.push(format!(
            "at rest light lies over the pad otherwise than drawn: {:.1} grey rms",
            fitted.reference_rms_grey
        ));
    }
    // An intensity from elsewhere at its lower limit means that the model explains all light by the layer.
    if fitted.values[1] < 1.0 {
        found.push("the image at rest is no brighter than the layer makes it: nothing comes from elsewhere".to_owned());
    }
    found
}
