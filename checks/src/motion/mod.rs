//! Motions: every body gets to its place past what stands there already, and there is room for the
//! tool that puts it there.
//!
//! Each step of a chain that happens in an assembly brings the bodies that it names and that do not
//! stand there yet; what stood together elsewhere comes as one piece. See [`order`] for how ways are
//! looked for, [`path`] for how closely.

mod arrival;
mod grip;
mod order;
mod path;

use fabkit_geometry::{Occasion, Sensor};
use rayon::prelude::*;

use crate::chain::Place;
use crate::finding::{Finding, Rule};
use crate::memo::{Key, Memo};
use crate::scene::{Assemblies, Placed};

use arrival::{Arrival, Work, arrivals};
use order::{Order, Stuck};
use path::overlap;

/// What was found, and how much was looked at.
pub(crate) struct Ways {
    pub(crate) findings: Vec<Finding>,
    pub(crate) bodies: usize,
    pub(crate) tools: usize,
}

/// All findings about ways and tools.
pub(crate) fn examine(sensor: &Sensor, scene: &Assemblies, memo: &Memo) -> Ways {
    let (arrivals, works) = arrivals(sensor, scene);
    let found = |arrival: &Arrival| {
        let order = Order::find(sensor, arrival, memo);
        order.stuck.iter().map(|stuck| told(&arrival.place, stuck)).collect::<Vec<_>>()
    };
    let findings: Vec<Vec<Finding>> = arrivals.par_iter().map(found).collect();
    let worked: Vec<(Vec<Finding>, usize)> = works.par_iter().map(|w| working(w, memo)).collect();
    let tools: usize = worked.iter().map(|(_, count)| count).sum();
    let ungripped = works.iter().map(|work| grip::examine(sensor, work));
    let findings = findings.into_iter().chain(worked.into_iter().map(|(found, _)| found));
    let findings = findings.chain(ungripped);
    let coming = || arrivals.iter().flat_map(|arrival| arrival.coming.iter().flatten());
    Ways {
        findings: findings.flatten().collect(),
        bodies: coming().count(),
        tools: tools + coming().map(|placed| placed.tools.len()).sum::<usize>(),
    }
}

/// What stands where a tool works in a step that pours or takes off, and how many tools do.
///
/// Screws are drawn before anything is taken off.
fn working(work: &Work, memo: &Memo) -> (Vec<Finding>, usize) {
    let (mut findings, mut count) = (Vec::new(), 0);
    let is_there = |other: &&&Placed| work.occasion == Occasion::Pour || !other.is_drawn();
    for placed in &work.standing {
        for (reach, tool) in placed.of.reach.iter().zip(&placed.tools) {
            if reach.occasion != work.occasion {
                continue;
            }
            count += 1;
            let mut others = work.standing.iter().filter(is_there);
            findings.extend(others.find_map(|other| {
                let key = Key::new(6).key(tool.key).key(other.key);
                let mut contact = None;
                memo.is_clean(&key, || {
                    contact = overlap(&tool.room, &other.body, 0.0);
                    contact.is_none()
                });
                let rule = Rule::Access;
                let (body, by, tool) = (placed.name, other.name, Some(reach.tool.as_str()));
                contact.map(|contact| Stuck { rule, body, by, tool, along: None, contact })
            }));
        }
    }
    (findings.iter().map(|stuck| told(&work.place, stuck)).collect(), count)
}

fn told(place: &Place, stuck: &Stuck) -> Finding {
    let Stuck { rule, body, by, tool, along, contact } = stuck;
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
    let fix = match rule {
        Rule::Access => "put it in before what is in the way, or make room for the tool",
        _ => "bring it before what is in its way, make room, or state another motion in its step",
    };
    Finding::error(*rule, message, fix)
        .in_step(place.step)
        .in_assembly(place.assembly)
        .of([*body, *by])
        .at(Some(contact.place))
        .measured(depth_mm, 0.0, "mm")
}

/// A direction in a few words.
fn direction(along: &[f64; 3]) -> String {
    let axis = ["x", "y", "z"].into_iter().zip(along).find(|(_, v)| v.abs() > 0.999_999);
    match axis {
        Some((axis, v)) => format!("{}{axis}", if *v > 0.0 { '+' } else { '-' }),
        None => format!("({:.2}, {:.2}, {:.2})", along[0], along[1], along[2]),
    }
}
