//! Instructions for each step: tools, directions in which bodies move, and checks afterwards.

mod acceptance_checks;

use std::collections::BTreeMap;

use fabkit_checks::{Movement, Stage};
use fabkit_geometry::{Action, Occasion, Placement, Sensor, Step};

use crate::{BodyMotion, GuideStep, NeededBody, StepMix};
use acceptance_checks::StageMeasurements;

/// Largest cure temperature without an oven, degrees Celsius; chosen: no room is warmer.
const ROOM_CELSIUS: f64 = 30.0;

/// Returns all steps of a sensor's chain.
pub(crate) fn steps(sensor: &Sensor, stages: &[Stage], mixes: &[StepMix]) -> Vec<GuideStep> {
    let measured = StageMeasurements::new(stages);
    let stages: BTreeMap<usize, &Stage> = stages.iter().map(|stage| (stage.step, stage)).collect();
    let told = |(index, step): (usize, &Step)| {
        let stage = stages.get(&index).copied();
        let mix = mixes.iter().find(|mix| mix.step == index + 1);
        GuideStep {
            tools: tools(step, stage),
            checks: measured.checks(sensor, step, stage, mix),
            ways: stage.map_or(Vec::new(), find_motions),
            ..step_without_checks(sensor, index, step)
        }
    };
    sensor.chain.iter().enumerate().map(told).collect()
}

/// Returns a step with everything that needs no solids.
fn step_without_checks(sensor: &Sensor, index: usize, step: &Step) -> GuideStep {
    let number_of =
        |name: &String| sensor.chain.iter().position(|s| s.name == *name).map(|i| i + 1);
    GuideStep {
        number: index + 1,
        name: step.name.clone(),
        action: step.action.word(),
        instruction: step.instruction.clone(),
        assembly: step.assembly.as_ref().map(|assembly| assembly.0.clone()),
        needs: step.bodies.iter().map(|name| need(sensor, step, name)).collect(),
        removed: match &step.action {
            Action::Demold(pulls) => pulls.iter().map(|pull| pull.body.clone()).collect(),
            _ => Vec::new(),
        },
        adjusted: step.adjustments.iter().map(|one| one.body.clone()).collect(),
        during: step.during_cure_of.as_ref().and_then(number_of),
        source: step.source.clone(),
        tools: Vec::new(),
        checks: Vec::new(),
        ways: Vec::new(),
    }
}

/// Counts the pieces of a body that the step places in its assembly; if it places none, those of the
/// whole design.
fn need(sensor: &Sensor, step: &Step, name: &str) -> NeededBody {
    let count = sensor.body(name).map_or(1, |body| {
        let is_there = |placed: &&Placement| Some(&placed.assembly) == step.assembly.as_ref();
        match body.placements.iter().filter(is_there).count() {
            // The step may need bodies that it does not place in its own assembly.
            0 => body.quantity as usize,
            count => count,
        }
    });
    NeededBody { name: name.to_owned(), count }
}

/// Returns the tools of a step: those that its bodies need, and those for mixing.
fn tools(step: &Step, stage: Option<&Stage>) -> Vec<String> {
    let mut tools: Vec<String> = Vec::new();
    let mut add = |tool: String| {
        if !tools.contains(&tool) {
            tools.push(tool);
        }
    };
    let liquid = match &step.action {
        Action::Pour(pour) => Some((&pour.mix, pour.cure)),
        Action::Spray(spray) => Some((&spray.mix, spray.cure)),
        _ => None,
    };
    if let Some((mix, cure)) = liquid {
        add("a scale to 0.01 g, cups and a stick".to_owned());
        if mix.degas {
            add("a vacuum chamber".to_owned());
        }
        if cure.celsius > ROOM_CELSIUS {
            add(format!("an oven at {} °C", cure.celsius));
        }
    }
    let Some(stage) = stage else { return tools };
    let coming = stage.coming.iter().flat_map(|came| &came.bodies);
    let adjusted = stage.after.iter().filter(|stand| {
        step.adjustments.iter().any(|adjustment| adjustment.body == stand.body.name)
    });
    let occasion = match &step.action {
        Action::Pour(_) => Some(Occasion::Pour),
        Action::Demold(_) => Some(Occasion::Removal),
        _ => None,
    };
    // Pouring and demolding concern bodies that are already in place.
    let there = occasion.map_or(&[][..], |_| &stage.before[..]);
    let asked = coming.map(|stand| (stand, Some(Occasion::Arrival)));
    let asked = asked.chain(adjusted.map(|stand| (stand, Some(Occasion::Adjustment))));
    let asked = asked.chain(there.iter().map(|stand| (stand, occasion)));
    for (stand, occasion) in asked {
        for reach in stand.body.reach.iter().filter(|reach| Some(reach.occasion) == occasion) {
            add(reach.tool.clone());
        }
    }
    tools
}

/// Returns the directions in which bodies come and go; bodies that are assembled separately first, then their arrival
/// as a whole.
fn find_motions(stage: &Stage) -> Vec<BodyMotion> {
    let mut all: Vec<BodyMotion> = Vec::new();
    stage.coming.iter().for_each(|came| add_motions(&mut all, came, true));
    stage.going.iter().for_each(|came| add_motions(&mut all, came, false));
    all
}

/// Adds the motions of bodies that come or go together, and of their subassemblies.
fn add_motions(all: &mut Vec<BodyMotion>, came: &Movement, is_coming: bool) {
    // Subassemblies are put together before they move as a whole.
    came.parts.iter().for_each(|came| add_motions(all, came, is_coming));
    let Some(out) = came.removal_direction else { return };
    let mut bodies: Vec<String> = Vec::new();
    for stand in &came.bodies {
        if !bodies.contains(&stand.body.name) {
            bodies.push(stand.body.name.clone());
        }
    }
    // Adding zero avoids -0 in files.
    let along = if is_coming { -out } else { out }.map(|v| v + 0.0);
    let way = BodyMotion { bodies, is_coming, along: along.into() };
    if !all.contains(&way) {
        all.push(way);
    }
}
