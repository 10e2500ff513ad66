//! Lenses that are focused: each in a step that brings it, with something that turns it.

use fabkit_geometry::{Body, Occasion, Sensor, Step};

use crate::finding::{Finding, Rule};

fn is_adjustable(body: &Body) -> bool {
    body.reach.iter().any(|reach| reach.occasion == Occasion::Adjustment)
}

/// All findings about what the chain sets right, and what it forgets.
pub(crate) fn examine(sensor: &Sensor) -> Vec<Finding> {
    let forgotten = sensor.bodies.iter().filter(|body| is_forgotten(sensor, body)).map(|body| {
        let message =
            format!("no step sets {} right: once all is closed, it stays as it is", body.name);
        Finding::error(Rule::Access, message, "focus it in a step in which it is still reached")
            .of([body.name.as_str()])
    });
    let wrong = sensor.chain.iter().flat_map(|step| {
        step.adjustments.iter().filter_map(|adjustment| wrong(sensor, step, &adjustment.body))
    });
    forgotten.chain(wrong).collect()
}

/// A kit of loose parts has no steps that could do it.
fn is_forgotten(sensor: &Sensor, body: &Body) -> bool {
    let is_done = |step: &Step| step.adjustments.iter().any(|one| one.body == body.name);
    is_adjustable(body)
        && !body.placements.is_empty()
        && !sensor.chain.is_empty()
        && !sensor.chain.iter().any(is_done)
}

fn wrong(sensor: &Sensor, step: &Step, body: &str) -> Option<Finding> {
    let (message, fix) = match sensor.body(body) {
        Some(of) if !is_adjustable(of) => {
            (format!("nothing is known that sets {body} right"), "say what turns it, and where")
        }
        Some(_) if step.bodies.iter().any(|name| name == body) => return None,
        _ => (format!("{body} is set right, and is not of this step"), "name it in the step"),
    };
    Some(Finding::error(Rule::Chain, message, fix).in_step(&step.name).of([body]))
}
