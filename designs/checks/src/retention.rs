//! Retention: which bodies of the finished sensor hold each other, by blocking, screws, press fits or bonds.
//!
//! For each of six directions, a body that moves takes along the bodies that it pushes and those that are fixed to it.
//! If this does not lead to the sensor's housing, the body can leave along that direction. The same graph, with areas
//! times strengths as capacities, gives the force that the touched body bears: the minimum cut between it and the
//! housing.

mod graph;
mod load;
mod loose_small_bodies;

use fabkit_geometry::{Assembly, BodyKind, Sensor};

use crate::contacts::MOTION_DIRECTION_WORDS;
use crate::finding::{Finding, Severity};
use crate::material_questions::MaterialQuestions;
use crate::scene::Assemblies;

use crate::declaration::rule;
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use graph::Graph;

rule! {
    /// Every body of the finished sensor is held in every direction and bears its load.
    Retention = "held",
    examines: "pairs of touching bodies",
    finds: "bodies that can come off the finished sensor, screws without a thread, bodies that \
             nothing supports, LEDs that no step solders or glues, and a sensing module that does \
             not withstand its load",
    limit: "contacts, threads, press fits and bonds with their areas and lower strengths; 10 N \
             unless `loads.touch` is given",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    Ok(examine(case.sensor, case.scene, &case.questions))
}

/// Finds bodies that are not held. Also returns the number of pairs of bodies that meet.
pub(crate) fn examine(
    sensor: &Sensor,
    scene: &Assemblies,
    questions: &MaterialQuestions,
) -> (Vec<Finding>, usize) {
    // Kits of calibration hardware are held by hand, rubber bands and gravity.
    if sensor.required_load_n.is_none() {
        return (Vec::new(), 0);
    }
    // The strength of a bond follows from the classes of both bodies; of an unknown one it is a guess.
    for adhesion in &sensor.adhesions {
        for body in adhesion.bodies.iter().filter_map(|name| sensor.body(name)) {
            if body.kind != BodyKind::Bought || body.stock.is_some() {
                questions.class(Rule::Retention, body);
            }
        }
    }
    let graph = Graph::new(sensor, scene, questions);
    let mut findings = leaving(&graph);
    findings.extend(loose_small_bodies::examine(sensor, scene));
    findings.extend(load::examine(sensor, &graph));
    let assembly = Assembly::sensor().0;
    let findings = findings.into_iter().map(|finding| finding.in_assembly(&assembly)).collect();
    (findings, graph.links.len())
}

/// Finds groups of bodies that can leave, each reported once with all its directions.
fn leaving(graph: &Graph) -> Vec<Finding> {
    let mut groups: Vec<(Vec<&str>, Vec<&str>)> = Vec::new();
    for (way, word) in MOTION_DIRECTION_WORDS.iter().enumerate() {
        for names in graph.free_groups(way) {
            match groups.iter_mut().find(|(known, _)| *known == names) {
                Some((_, ways)) => ways.push(*word),
                None => groups.push((names, vec![*word])),
            }
        }
    }
    let finding = |(names, mut ways): (Vec<&str>, Vec<&str>)| {
        let together = match names.len() {
            1 => String::new(),
            n => format!(" with {} more", n - 1),
        };
        // Words are pushed in order, so equal ones are neighbours.
        ways.dedup();
        let idle: Vec<&str> = graph.idle_at(&names).into_iter().collect();
        let idle = if idle.is_empty() {
            String::new()
        } else {
            format!("; these have no thread and hold nothing: {}", idle.join(", "))
        };
        let message = format!(
            "{}{together} can leave the sensor along {}: nothing holds it{idle}",
            names[0],
            ways.join(", ")
        );
        let fix =
            "hold it by a screw, a shoulder or a step that glues it, or cast it onto a primed face";
        Finding::error(Rule::Retention, message, fix).about_bodies(names)
    };
    let mut findings: Vec<Finding> = groups.into_iter().map(finding).collect();
    findings.sort_by_key(|finding| finding.severity != Severity::Error);
    findings
}
