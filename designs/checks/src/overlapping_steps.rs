//! Steps that overlap in time: work during the cure of an earlier step.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Action, MechanicalRole, Sensor, Step};

use crate::finding::Finding;
use crate::rule::Rule;

/// Largest difference of equal durations, h.
const SAME_H: f64 = 1e-9;

/// Finds errors in steps that are done during others.
pub(crate) fn examine(sensor: &Sensor) -> Vec<Finding> {
    let steps = sensor.chain.iter().enumerate();
    // Time used so far, by the step that is waited for.
    let mut hours = BTreeMap::new();
    steps
        .filter_map(|(at, step)| {
            let waiting = step.during_cure_of.as_deref()?;
            let found = overlap(sensor, at, step, waiting, hours.entry(waiting).or_insert(0.0));
            Some(found?.in_step(&step.name))
        })
        .collect()
}

/// Checks a step that is done during another one. `hours` sums up the time of that one that other steps have used.
fn overlap(
    sensor: &Sensor,
    at: usize,
    step: &Step,
    waiting: &str,
    hours: &mut f64,
) -> Option<Finding> {
    let wrong = |message: String, fix: &str| Some(Finding::error(Rule::Chain, message, fix));
    let Some(before) = sensor.chain[..at].iter().position(|other| other.name == waiting) else {
        let message =
            format!("the step is done during `{waiting}`, but no earlier step has this name");
        return wrong(message, "name an earlier step that cures");
    };
    let Some(cure) = sensor.chain[before].cure().filter(|cure| cure.hours > 0.0) else {
        let message = format!("the step is done during `{waiting}`, but nothing cures in it");
        return wrong(message, "name a step whose cure takes time");
    };
    let between = &sensor.chain[before + 1..at];
    // All steps in between must be done during the same cure.
    if let Some(after) =
        between.iter().find(|other| other.during_cure_of.as_deref() != Some(waiting))
    {
        let message = format!(
            "the step is done during `{waiting}`, but `{}` comes in between, after the cure",
            after.name
        );
        return wrong(message, "put the step right behind the one that cures");
    }
    if let Some(body) =
        handled_bodies(step).find(|body| resting_bodies(sensor, before).contains(body))
    {
        let message = format!("{body} is handled while it cures in `{waiting}`");
        let finding = wrong(message, "leave it alone until it has cured")?;
        return Some(finding.about_bodies([body]));
    }
    *hours += step.cure().map_or(0.0, |cure| cure.hours);
    (*hours > cure.hours + SAME_H).then(|| {
        let message = format!(
            "the steps during `{waiting}` take {hours} h up to this one, but its cure takes {} h",
            cure.hours
        );
        Finding::error(Rule::Chain, message, "do it before or after")
            .with_measurement(*hours, cure.hours, "h")
    })
}

/// Iterates over the bodies that the hands move or work on in a step.
fn handled_bodies(step: &Step) -> impl Iterator<Item = &str> {
    let more: Vec<&str> = match &step.action {
        Action::Pour(pour) => named(&pour.walls, &pour.layer),
        Action::Spray(spray) => named(&spray.onto, &spray.layer),
        Action::Demold(pulls) => pulls.iter().map(|pull| pull.body.as_str()).collect(),
        Action::Make | Action::Prepare | Action::Assemble | Action::Bond(_) => Vec::new(),
    };
    step.bodies.iter().map(String::as_str).chain(more)
}

/// Returns a layer with other bodies, by name.
fn named<'a>(bodies: &'a [String], layer: &'a str) -> Vec<&'a str> {
    bodies.iter().map(String::as_str).chain([layer]).collect()
}

/// Returns the bodies that must rest while a step cures: those on which it works, and all that earlier steps have
/// joined with them in the same assembly and not taken away again. Screws, nuts and pins are left out: names of
/// fasteners stand for many pieces, most of them loose.
fn resting_bodies(sensor: &Sensor, step: usize) -> BTreeSet<&str> {
    let here = &sensor.chain[step].assembly;
    let is_loose = |name: &&str| {
        let duty = sensor.body(name).map(|body| body.duty);
        matches!(duty, Some(MechanicalRole::Fastener | MechanicalRole::Threaded))
    };
    let mut last = BTreeSet::new();
    let mut groups: Vec<BTreeSet<&str>> = Vec::new();
    for (at, other) in sensor.chain[..=step].iter().enumerate() {
        // Without an assembly, only the step itself counts.
        if at != step && (here.is_none() || other.assembly != *here) {
            continue;
        }
        let named: BTreeSet<&str> = handled_bodies(other).filter(|name| !is_loose(name)).collect();
        if matches!(other.action, Action::Demold(_)) {
            groups.iter_mut().for_each(|group| group.retain(|name| !named.contains(name)));
            continue;
        }
        // Groups that share a body with this step become one.
        let (joined, apart) =
            groups.into_iter().partition::<Vec<_>, _>(|group| !group.is_disjoint(&named));
        last = joined.into_iter().flatten().chain(named).collect();
        groups = apart;
        groups.push(last.clone());
    }
    last
}
