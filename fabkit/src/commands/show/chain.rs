//! `fabkit show SENSOR --chain`

use fabkit_application::checks::{Batch, batches};
use fabkit_application::designs::Design;
use fabkit_application::documents;
use fabkit_application::geometry::{Action, Cure, Step};
use fabkit_application::identity::design_hash;
use serde_json::{Value, json};

use crate::commands::check::components;

/// Every step in order, for the person at the bench.
pub(super) fn text(design: &Design) -> String {
    let sensor = &design.sensor;
    let batches = batches(sensor);
    let mut text = format!("{}: {}\n", sensor.name, sensor.title);
    for (number, step) in sensor.chain.iter().enumerate() {
        text += &format!("\n{}. {}: {}\n", number + 1, step.name, step.instruction);
        let mut line = |label: &str, value: String| {
            if !value.is_empty() {
                text += &format!("   {label:<9} {value}\n");
            }
        };
        line("assembly", step.assembly.as_ref().map(|a| a.0.clone()).unwrap_or_default());
        line("bodies", step.bodies.join(", "));
        if let Some(batch) = batch_of(&batches, step) {
            let degas = if batch.degas { ", degas" } else { "" };
            line("mix", format!("{}{degas}", components(batch)));
            line("becomes", format!("{}, {:.2} mm3", batch.layer, batch.volume.value_mm3));
        }
        line("cure", cure(&step.action).map(cure_text).unwrap_or_default());
        line("remove", removed(&step.action).join(", "));
        line("source", step.source.clone());
    }
    text
}

pub(super) fn json(design: &Design) -> Value {
    let sensor = &design.sensor;
    let batches = batches(sensor);
    let steps = sensor.chain.iter().map(|step| {
        json!({
            "name": step.name,
            "instruction": step.instruction,
            "action": word(&step.action),
            "assembly": step.assembly.as_ref().map(|a| &a.0),
            "bodies": step.bodies,
            "batch": batch_of(&batches, step).map(documents::batch),
            "cure": cure(&step.action).map(|c| json!({ "hours": c.hours, "celsius": c.celsius })),
            "remove": removed(&step.action),
            "source": step.source,
        })
    });
    json!({
        "format": "fabkit-chain",
        "version": 1,
        "name": sensor.name,
        "design_hash": design_hash(design),
        "steps": steps.collect::<Vec<_>>(),
    })
}

fn batch_of<'a>(batches: &'a [Batch], step: &Step) -> Option<&'a Batch> {
    batches.iter().find(|batch| batch.step == step.name)
}

fn cure(action: &Action) -> Option<Cure> {
    match action {
        Action::Bond(cure) => Some(*cure),
        Action::Spray(spray) => Some(spray.cure),
        Action::Pour(pour) => Some(pour.cure),
        Action::Make | Action::Prepare | Action::Assemble | Action::Demold(_) => None,
    }
}

fn cure_text(cure: Cure) -> String {
    format!("{} h at {} degrees Celsius", cure.hours, cure.celsius)
}

fn removed(action: &Action) -> Vec<&str> {
    match action {
        Action::Demold(pulls) => pulls.iter().map(|pull| pull.body.as_str()).collect(),
        _ => Vec::new(),
    }
}

fn word(action: &Action) -> &'static str {
    match action {
        Action::Make => "make",
        Action::Prepare => "prepare",
        Action::Assemble => "assemble",
        Action::Bond(_) => "bond",
        Action::Spray(_) => "spray",
        Action::Pour(_) => "pour",
        Action::Demold(_) => "demold",
    }
}
