//! Small bodies that hold nothing and are not blocked by others: a step solders, glues or sticks each one, and each
//! touches the body on which that step fixes it.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Assembly, MechanicalRole, Sensor};
use rayon::prelude::*;

use crate::contacts::faces;
use crate::finding::Finding;
use crate::rule::Rule;
use crate::scene::{Assemblies, Placed};

/// Largest gap that a solder fillet, a drop of glue or a foam tape fills, mm (chosen).
const FILLED_MM: f64 = 0.35;

/// Smallest area that must be within that gap, mm2 (chosen): the two pads of an LED of size 0603.
const PADS_MM2: f64 = 0.5;

/// Finds small bodies that no step fixes, and those that do not touch the body on which a step fixes them.
pub(super) fn examine(sensor: &Sensor, scene: &Assemblies) -> Vec<Finding> {
    let placed = scene.bodies(&Assembly::sensor().0);
    let small: Vec<&Placed> =
        placed.iter().filter(|one| one.of.duty == MechanicalRole::Attached).collect();
    let carriers: BTreeMap<&str, Vec<&str>> =
        small.iter().map(|one| (one.name, carriers(sensor, one.name))).collect();
    // One contact with any of its carriers is enough.
    let in_the_air = small.into_par_iter().filter(|one| {
        let carriers = &carriers[one.name];
        let mut others = placed.iter().filter(|other| carriers.contains(&other.name));
        !carriers.is_empty() && !others.any(|other| touches(one, other))
    });
    let in_the_air: BTreeSet<&str> = in_the_air.map(|one| one.name).collect();
    let unfixed =
        carriers.iter().filter(|(_, onto)| onto.is_empty()).map(|(name, _)| unfixed(name));
    unfixed.chain(in_the_air.into_iter().map(|name| apart(name, &carriers[name]))).collect()
}

/// Returns the bodies on which the chain's steps fix a body.
fn carriers<'a>(sensor: &'a Sensor, name: &str) -> Vec<&'a str> {
    let fixings = sensor.chain.iter().flat_map(|step| &step.fixings);
    let of_it = fixings.filter(|fixing| fixing.bodies.iter().any(|body| body == name));
    let onto: BTreeSet<&str> =
        of_it.flat_map(|fixing| fixing.onto.iter().map(String::as_str)).collect();
    onto.into_iter().collect()
}

/// Returns whether enough area of the two bodies is within reach of solder or glue.
fn touches(one: &Placed, other: &Placed) -> bool {
    faces([one, other], Some(FILLED_MM)).is_some_and(|faces| faces.bonded_mm2 > PADS_MM2)
}

/// Reports a small body that no step fixes.
fn unfixed(name: &str) -> Finding {
    let message = format!("{name} is only laid in place: no step solders, glues or sticks it");
    let fix = "state what fixes it in the step that places it";
    Finding::error(Rule::Retention, message, fix).about_bodies([name])
}

/// Reports a small body that does not touch its carrier.
fn apart(name: &str, onto: &[&str]) -> Finding {
    let message = format!(
        "{name} does not touch {}, to which a step fixes it: less than {PADS_MM2} mm2 lies within \
         {FILLED_MM} mm",
        onto.join(" or ")
    );
    let fix = "move it onto the body that it is soldered, glued or stuck to";
    let bodies = std::iter::once(name).chain(onto.iter().copied());
    Finding::error(Rule::Retention, message, fix).about_bodies(bodies)
}
