//! Lenses that are focused: a step of the chain must focus each one, with fingers or a tool that can turn it.

use fabkit_geometry::{Body, Occasion, Sensor, Step};

use crate::declaration::rule;
use crate::finding::Finding;
use crate::motion;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use std::mem;

rule! {
    /// Hands and tools have room where they work.
    Access = "access",
    examines: "places for hands and tools",
    finds: "a screw without room for its driver, a nut without room for its spanner, an insert \
             without room for its soldering iron; a pry slot that no screwdriver can enter when \
             the mold is opened, a mold with neither a slot nor 3 mm of edge for two fingers, a \
             seat without room for syringe and hand while it is filled; a lens that no step \
             focuses, or without room for fingers or tweezers in the step that does; a pin that \
             fingers cannot pull out, a dowel that nothing presses in, a robot's bolt without \
             room for its key",
    limit: "the tool's own size, at the step that uses it; the prying blade is 0.8 x 4 mm (ISO \
             2380-1); 3 mm of a barrel and 8 mm beside it for fingers, 0.5 mm of a rim for \
             tweezers, 3 mm of a pin's head and 6 mm beside it (chosen)",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    // Tools are examined together with the motions of the parts that they fix.
    let mut ways = motion::ways(case);
    Ok(([mem::take(&mut ways.findings), examine(case.sensor)].concat(), ways.tools))
}

/// Returns whether a tool or hand can adjust the body.
fn is_adjustable(body: &Body) -> bool {
    body.reach.iter().any(|reach| reach.occasion == Occasion::Adjustment)
}

/// Finds steps that adjust what they cannot adjust, and adjustable bodies that no step adjusts.
pub(crate) fn examine(sensor: &Sensor) -> Vec<Finding> {
    let forgotten = sensor.bodies.iter().filter(|body| is_forgotten(sensor, body)).map(|body| {
        let message = format!(
            "no step adjusts {}: once the sensor is closed, it cannot be reached",
            body.name
        );
        Finding::error(
            Rule::Access,
            message,
            "adjust it in a step in which it can still be reached",
        )
        .about_bodies([body.name.as_str()])
    });
    let wrong = sensor.chain.iter().flat_map(|step| {
        step.adjustments.iter().filter_map(|adjustment| wrong(sensor, step, &adjustment.body))
    });
    forgotten.chain(wrong).collect()
}

/// Returns whether a body is adjustable and no step adjusts it. False for kits of loose parts, which have no steps.
fn is_forgotten(sensor: &Sensor, body: &Body) -> bool {
    let is_done = |step: &Step| step.adjustments.iter().any(|one| one.body == body.name);
    is_adjustable(body)
        && !body.placements.is_empty()
        && !sensor.chain.is_empty()
        && !sensor.chain.iter().any(is_done)
}

/// Returns the error of an adjustment: a body that cannot be adjusted, or that does not take part in the step.
fn wrong(sensor: &Sensor, step: &Step, body: &str) -> Option<Finding> {
    let (message, fix) = match sensor.body(body) {
        Some(of) if !is_adjustable(of) => {
            (format!("fabkit knows no way to adjust {body}"), "state what turns it, and where")
        }
        Some(_) if step.bodies.iter().any(|name| name == body) => return None,
        _ => (
            format!("the step adjusts {body}, which is not one of its bodies"),
            "name it in the step",
        ),
    };
    Some(Finding::error(Rule::Chain, message, fix).in_step(&step.name).about_bodies([body]))
}
