//! Motions: every body can reach its place past the bodies that stand there already, and there is room for the tool
//! that installs it.
//!
//! Each step of a chain that happens in an assembly brings the bodies that it names and that do not stand there yet.
//! Bodies that stood together elsewhere come as one piece. See [`order`] for the search for paths and [`path`] for its
//! resolution.

mod arrival;
mod disassembly;
mod grip;
mod obstruction;
mod path;
mod stages;
mod tools;

use std::cell::RefMut;
use std::mem;

use fabkit_geometry::{Occasion, Sensor};
use rayon::prelude::*;

use crate::declaration::rule;
use crate::finding::Finding;
use crate::memo::Memo;
use crate::rule::Rule;
use crate::rule_input::Place;
use crate::rule_input::{MotionFindings, RuleInput, RuleResult};
use crate::scene::Assemblies;

pub use stages::{Movement, PlacedBody, Stage, stages};

use arrival::{Arrival, Work, arrivals};
use disassembly::Disassembly;
use obstruction::Obstruction;
use tools::{check_work, count};

rule! {
    /// Every body gets to its place past the bodies that stand there already.
    Motion = "motion",
    examines: "movements of bodies",
    finds: "bodies that cannot get to their place past the bodies already there: each step is \
             reversed, along the motion that it states, the path of a screw, an axis, or one of \
             24 directions",
    limit: "straight paths sampled with up to 160 lines across; rotations sampled every 0.25 mm",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let mut ways = ways(case);
    Ok((mem::take(&mut ways.findings), ways.bodies))
}

/// Returns the findings about motions and tools, computed once for the two rules that report them.
pub(crate) fn ways<'c>(case: &'c RuleInput<'_>) -> RefMut<'c, MotionFindings> {
    case.motion_findings(|| examine(case.sensor, case.scene, case.memo))
}

/// Finds bodies that cannot reach their places, and tools without room.
fn examine(sensor: &Sensor, scene: &Assemblies, memo: &Memo) -> MotionFindings {
    let (arrivals, works) = arrivals(sensor, scene);
    let found = |arrival: &Arrival| {
        let order = Disassembly::find(sensor, arrival, memo);
        order.stuck.iter().map(|stuck| to_finding(&arrival.place, stuck)).collect::<Vec<_>>()
    };
    let findings: Vec<Vec<Finding>> = arrivals.par_iter().map(found).collect();
    let worked = |work: &Work| {
        // Tools of pours, adjustments and demolding.
        let (stuck, count) = check_work(work, memo);
        (stuck.iter().map(|stuck| to_finding(&work.place, stuck)).collect::<Vec<_>>(), count)
    };
    let worked: Vec<(Vec<Finding>, usize)> = works.par_iter().map(worked).collect();
    let tools: usize = worked.iter().map(|(_, count)| count).sum();
    // Tools that nothing can take off the cast.
    let ungripped = works.iter().map(|work| grip::examine(sensor, work));
    let findings = findings.into_iter().chain(worked.into_iter().map(|(found, _)| found));
    let findings = findings.chain(ungripped);
    let coming = || arrivals.iter().flat_map(|arrival| arrival.coming.iter().flatten());
    MotionFindings {
        findings: findings.flatten().collect(),
        bodies: coming().count(),
        tools: tools + coming().map(|placed| count(placed, Occasion::Arrival)).sum::<usize>(),
    }
}

/// Converts an obstruction to a finding.
fn to_finding(place: &Place, stuck: &Obstruction) -> Finding {
    let Obstruction { rule, body, obstacle: by, tool, along, contact } = stuck;
    let depth_mm = contact.depth_mm;
    let message = match tool {
        Some(tool) => {
            format!("no room for {tool} at {body}: {by} stands {depth_mm:.2} mm in its way")
        }
        None => format!(
            "{body} does not get to its place{}: {by} stands {depth_mm:.2} mm in its way",
            along.map(|along| format!(" along {}", direction(&along.into()))).unwrap_or_default()
        ),
    };
    let fix = match *rule {
        Rule::Access => "put it in before what is in the way, or make room for the tool",
        _ => "bring it before what is in its way, make room, or state another motion in its step",
    };
    Finding::error(*rule, message, fix)
        .in_step(place.step)
        .in_assembly(place.assembly)
        .about_bodies([*body, *by])
        .at_position(Some(contact.place))
        .with_measurement(depth_mm, 0.0, "mm")
}

/// Formats a direction in a few words.
fn direction(along: &[f64; 3]) -> String {
    let axis = ["x", "y", "z"].into_iter().zip(along).find(|(_, v)| v.abs() > 0.999_999);
    match axis {
        Some((axis, v)) => format!("{}{axis}", if *v > 0.0 { '+' } else { '-' }),
        None => format!("({:.2}, {:.2}, {:.2})", along[0], along[1], along[2]),
    }
}
