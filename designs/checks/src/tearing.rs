//! Whether a press shears layers off what they are bonded to.

use fabkit_elastic::{BondLine, SoftStack};
use fabkit_geometry::{Adhesion, Sensor};

use crate::finding::{Finding, Severity};
use crate::rule::Rule;

/// A fingertip's size.
const BALL_RADIUS_MM: f64 = 4.0;
/// What sensors are pressed by in use, or all of what gives way, mm.
const DEPTH_MM: f64 = 1.0;

/// Bonds along which a ball on the tip, or on the middle of a pad, drives the layer harder than they bear. Small strain
/// and no friction: what is dragged along the surface drives bonds harder. What no solver can press says nothing here;
/// bonds of unknown strength neither.
pub(crate) fn examine(sensor: &Sensor) -> Vec<Finding> {
    let Some(touch) = &sensor.touch else { return Vec::new() };
    let depth_mm = DEPTH_MM.min(touch.soft_mm());
    let press = SoftStack::at_tip(sensor).and_then(|soft| soft.press_tip(BALL_RADIUS_MM, depth_mm));
    let Ok(press) = press else { return Vec::new() };
    press.bonds.iter().filter_map(|line| torn(sensor, line, depth_mm)).collect()
}

fn torn(sensor: &Sensor, line: &BondLine, depth_mm: f64) -> Option<Finding> {
    let below = line.below.as_deref()?;
    let adhesion = between(sensor, [&line.layer, below])?;
    if line.shear_mpa <= adhesion.shear_mpa {
        return None;
    }
    let layer = &line.layer;
    let message = format!(
        "a ball of {} mm that presses {depth_mm} mm deep drives {layer} along {below} with {:.1} kPa, {:.1} mm from the \
         axis; {} bears {:.1} kPa",
        2.0 * BALL_RADIUS_MM,
        1e3 * line.shear_mpa,
        line.radius_mm,
        adhesion.by,
        1e3 * adhesion.shear_mpa
    );
    let softer = format!("make {layer} thicker or softer");
    let fix = match adhesion.by.contains("primer") {
        true => softer,
        false => format!("prime {below}, or {softer}"),
    };
    let finding = Finding::error(Rule::Bonding, message, fix).with_severity(Severity::Warning);
    Some(finding.of([layer.as_str(), below]))
}

/// The strongest of what holds two bodies to each other.
fn between<'a>(sensor: &'a Sensor, pair: [&str; 2]) -> Option<&'a Adhesion> {
    let is_pair = |adhesion: &&Adhesion| {
        let [a, b] = adhesion.bodies.each_ref().map(String::as_str);
        [a, b] == pair || [b, a] == pair
    };
    let found = sensor.adhesions.iter().filter(is_pair);
    found.max_by(|a, b| a.shear_mpa.total_cmp(&b.shear_mpa))
}
