//! Labels: printed parts can be told apart, and letters are where they do no harm.

use fabkit_geometry::{
    Body, CompiledSolid, LETTERING_FEATURES, PlacedPrimitive, Point3, Process, Ray, Sensor, Solid,
    Vector3, has_lettering,
};

use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::sampling_lines::Caster;
use crate::scene::{Assemblies, Placed};

rule! {
    /// Printed parts can be told apart, and letters are where they do no harm.
    Labels = "labels",
    examines: "printed parts",
    finds: "parts that look alike and have no labels, letters on faces that touch other bodies",
    limit: "0.5 mm of difference in size",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    Ok(examine(case.sensor, case.scene))
}

/// Largest difference in size of parts that look alike, mm: nobody sees it without a gauge.
const ALIKE_MM: f64 = 0.5;

/// Largest distance at which a body touches a face, mm.
const TOUCH_MM: f64 = 0.05;

/// Spacing of the lines through a letter, mm: about the width of a stroke.
const STEP_MM: f64 = 0.5;

/// Prefix of the note with which a part says why it carries no label.
const BARE: &str = "carries no label: ";

/// Finds missing labels and covered letters. Also returns the number of printed parts.
pub(crate) fn examine(sensor: &Sensor, scene: &Assemblies) -> (Vec<Finding>, usize) {
    let printed: Vec<&Body> = sensor.parts().filter(|part| is_printed(part)).collect();
    let (lettered, bare): (Vec<&Body>, Vec<&Body>) =
        printed.iter().copied().partition(|part| has_lettering(&part.solid));
    let mut findings: Vec<Finding> =
        lettered.iter().filter_map(|part| covered(part, scene)).collect();
    findings.extend(twins(&bare));
    findings.extend(report_bare_parts(&bare));
    (findings, printed.len())
}

/// Returns whether a part is printed.
fn is_printed(part: &Body) -> bool {
    matches!(part.process(), Some(Process::Fdm | Process::Sla | Process::PolyJet))
}

/// Finds letters on a face that another body touches in any assembly.
fn covered(part: &Body, scene: &Assemblies) -> Option<Finding> {
    for (assembly, bodies) in &scene.assemblies {
        // All copies of the part in this assembly.
        let own = bodies.iter().filter(|placed| placed.name == part.name);
        for letter in own.flat_map(|placed| placed.body.leaves().iter().filter(|l| is_letter(l))) {
            let mut others = bodies.iter().filter(|placed| placed.name != part.name);
            let Some((other, place)) =
                others.find_map(|other| Some((other, touched(letter, other)?)))
            else {
                continue;
            };
            let message = format!(
                "the label of {} lies where {} touches it: letters leak, and keep faces apart",
                part.name, other.name
            );
            let fix = "put it on a face that nothing touches, or set `labels.parts` without it";
            return Some(
                Finding::error(Rule::Labels, message, fix)
                    .in_assembly(assembly)
                    .about_bodies([part.name.as_str(), other.name])
                    .at_position(Some(place)),
            );
        }
    }
    None
}

/// Returns whether a primitive belongs to a label.
fn is_letter(leaf: &PlacedPrimitive) -> bool {
    LETTERING_FEATURES.contains(&leaf.feature.as_str())
}

/// Returns a point at which a body touches or overlaps a letter.
fn touched(letter: &PlacedPrimitive, other: &Placed) -> Option<Point3<f64>> {
    let alone = CompiledSolid::new(&letter.primitive.clone().placed(letter.body_from_leaf)).ok()?;
    // Most bodies are excluded by their boxes.
    if alone.bounds().grown(TOUCH_MM).common(&other.body.bounds()).is_empty() {
        return None;
    }
    let Solid::Extrusion(_) = &letter.primitive else { return None };
    // Letters are extruded along their z axis, which points out of the face.
    let in_leaf = CompiledSolid::new(&letter.primitive).ok()?.bounds();
    let mut caster = Caster::default();
    let count = |axis: usize| (in_leaf.size_mm()[axis] / STEP_MM).ceil().max(1.0) as usize;
    for j in 0..=count(1) {
        for i in 0..=count(0) {
            let part = |axis: usize, i: usize| {
                let along = (i as f64 + 0.5).min(count(axis) as f64) / count(axis) as f64;
                in_leaf.min[axis] + along * in_leaf.size_mm()[axis]
            };
            let foot = Point3::new(part(0, i), part(1, j), in_leaf.min.z);
            let ray = Ray {
                origin: letter.body_from_leaf.point(foot),
                direction: letter.body_from_leaf.vector(Vector3::z()),
            };
            let top_mm = in_leaf.size_mm()[2] + TOUCH_MM;
            let hit = caster
                .stretches(&other.body, &ray)
                // Stretches that end at the letter's foot lie below the letter.
                .find(|stretch| stretch.exit.t > TOUCH_MM && stretch.enter.t < top_mm);
            if let Some(hit) = hit {
                return Some(ray.at(hit.enter.t.max(0.0)));
            }
        }
    }
    None
}

/// Finds parts of different names and the same size that carry no letters.
fn twins(bare: &[&Body]) -> Vec<Finding> {
    let size = |part: &Body| {
        // Sizes as the parts lie on the bed.
        let body = CompiledSolid::new(&part.solid.clone().placed(part.bed_from_body)).ok()?;
        let mut size = body.bounds().size_mm();
        // Sorted, since nobody sees the orientation in a bag of parts.
        size.sort_by(f64::total_cmp);
        Some(size)
    };
    let sizes: Vec<_> = bare.iter().filter_map(|part| Some((*part, size(part)?))).collect();
    let is_alike =
        |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < ALIKE_MM);
    let mut findings = Vec::new();
    let mut told = Vec::new();
    for (i, (part, own)) in sizes.iter().enumerate() {
        if told.contains(&part.name.as_str()) {
            continue;
        }
        let alike = sizes[i + 1..].iter().filter(|(_, size)| is_alike(own, size));
        let alike: Vec<&Body> = alike.map(|(other, _)| *other).collect();
        if alike.is_empty() {
            continue;
        }
        // If letters were asked for and had no room, only marking by hand helps.
        let has_no_room = std::iter::once(part).chain(&alike).all(|part| why(part).is_some());
        let severity = if has_no_room { Severity::Note } else { Severity::Error };
        let alike: Vec<&str> = alike.into_iter().map(|other| other.name.as_str()).collect();
        told.extend(&alike);
        let [x, y, z] = own;
        let message = format!(
            "{} and {} are printed in the same size ({x:.1} x {y:.1} x {z:.1} mm) and carry no label",
            part.name,
            alike.join(", ")
        );
        let fix = match severity {
            Severity::Error => "write `labels.style: sunken`, or a shorter `labels.text`",
            _ => "mark them by hand",
        };
        findings.push(
            Finding::error(Rule::Labels, message, fix)
                .with_severity(severity)
                .about_bodies(std::iter::once(part.name.as_str()).chain(alike)),
        );
    }
    findings
}

/// Returns the reason why a part carries no label, if its notes give one.
fn why(part: &Body) -> Option<&str> {
    part.notes.iter().find_map(|note| note.strip_prefix(BARE))
}

/// Lists the parts without a label for which a reason is given, as a note.
fn report_bare_parts(bare: &[&Body]) -> Option<Finding> {
    let first = bare.iter().find(|part| why(part).is_some())?;
    let named: Vec<String> =
        bare.iter().filter_map(|part| Some(format!("{} ({})", part.name, why(part)?))).collect();
    let message = format!("these parts carry no label: {}", named.join(", "));
    let fix = "mark them by hand where they could be mixed up";
    Some(
        Finding::error(Rule::Labels, message, fix)
            .with_severity(Severity::Note)
            .about_bodies([first.name.as_str()]),
    )
}
