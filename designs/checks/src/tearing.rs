//! Tearing: whether a press shears layers off the bodies they are bonded to.

use fabkit_elastic::{BondLine, SoftStack};
use fabkit_geometry::{Adhesion, Sensor};

use crate::finding::{Finding, Severity};
use crate::rule::Rule;

/// Radius of the pressing ball, mm: a fingertip's size.
const BALL_RADIUS_MM: f64 = 4.0;
/// Depth of the press, mm, as in use; less if the soft layers are thinner.
const DEPTH_MM: f64 = 1.0;

/// Finds bonds that a ball pressed onto the tip, or onto the middle of a pad, shears harder than they bear. The solver
/// assumes small strain and no friction; dragging along the surface would load bonds more. Sensors that no solver can
/// press and bonds of unknown strength are skipped.
pub(crate) fn examine(sensor: &Sensor) -> Vec<Finding> {
    let Some(touch) = &sensor.touch else { return Vec::new() };
    // A thin layer cannot be pressed deeper than its thickness.
    let depth_mm = DEPTH_MM.min(touch.max_indentation_mm());
    let press = SoftStack::at_tip(sensor).and_then(|soft| soft.press_tip(BALL_RADIUS_MM, depth_mm));
    let Ok(press) = press else { return Vec::new() };
    press.bonds.iter().filter_map(|line| torn(sensor, line, depth_mm)).collect()
}

/// Reports a bond line whose shear stress exceeds the strength of its bond.
fn torn(sensor: &Sensor, line: &BondLine, depth_mm: f64) -> Option<Finding> {
    let below = line.below.as_deref()?;
    let adhesion = between(sensor, [&line.layer, below])?;
    if line.shear_mpa <= adhesion.shear_mpa {
        return None;
    }
    let layer = &line.layer;
    let message = format!(
        "a ball of {} mm, pressed {depth_mm} mm deep, shears {layer} on {below} with {:.1} kPa, {:.1} mm from the axis; {} withstands {:.1} kPa",
        2.0 * BALL_RADIUS_MM,
        1e3 * line.shear_mpa,
        line.radius_mm,
        adhesion.by,
        1e3 * adhesion.shear_mpa
    );
    let softer = format!("make {layer} thicker or softer");
    let fix =
        if adhesion.by.contains("primer") { softer } else { format!("prime {below}, or {softer}") };
    let finding = Finding::error(Rule::Bonding, message, fix).with_severity(Severity::Warning);
    Some(finding.about_bodies([layer.as_str(), below]))
}

/// Returns the strongest bond between two bodies.
fn between<'a>(sensor: &'a Sensor, pair: [&str; 2]) -> Option<&'a Adhesion> {
    let is_pair = |adhesion: &&Adhesion| {
        let [a, b] = adhesion.bodies.each_ref().map(String::as_str);
        [a, b] == pair || [b, a] == pair
    };
    let found = sensor.adhesions.iter().filter(is_pair);
    found.max_by(|a, b| a.shear_mpa.total_cmp(&b.shear_mpa))
}
