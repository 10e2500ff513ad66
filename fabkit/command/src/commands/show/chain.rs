//! `fabkit show SENSOR --chain`

use fabkit_application::checks::batches;
use fabkit_application::designs::Design;
use fabkit_application::documents::{batch_of, removed};
use fabkit_application::geometry::Cure;

use crate::commands::check::components;
use crate::table::wrap_text;

/// Lists all steps in order, for the person at the bench.
pub(super) fn text(design: &Design) -> String {
    let sensor = &design.sensor;
    let batches = batches(sensor);
    let mut text = format!("{}: {}\n", sensor.name, sensor.title);
    for (number, step) in sensor.chain.iter().enumerate() {
        let step_text = format!("{}. {}: {}", number + 1, step.name, step.instruction);
        text += &format!("\n{}\n", wrap_text(&step_text, 3));
        let mut line = |label: &str, value: String| {
            if !value.is_empty() {
                // A placeholder as wide as the label, because wrapping would remove the label's trailing blanks.
                let line = wrap_text(&format!("{} {value}", "_".repeat(12)), 13);
                text += &format!("   {label:<9}{}\n", &line[12..]);
            }
        };
        line("assembly", step.assembly.as_ref().map(|a| a.0.clone()).unwrap_or_default());
        line("bodies", step.bodies.join(", "));
        if let Some(batch) = batch_of(&batches, step) {
            let degas = if batch.degas { ", degas" } else { "" };
            line("mix", format!("{}{degas}", components(batch)));
            line("becomes", format!("{}, {:.2} mm3", batch.layer, batch.volume.value_mm3));
        }
        line("during", step.during_cure_of.clone().unwrap_or_default());
        let adjusted = step.adjustments.iter().map(|one| one.body.as_str()).collect::<Vec<_>>();
        line("adjust", adjusted.join(", "));
        line("cure", step.cure().map(cure_text).unwrap_or_default());
        line("remove", removed(&step.action).join(", "));
        line("source", step.source.clone());
    }
    text
}

fn cure_text(cure: Cure) -> String {
    format!("{} h at {} degrees Celsius", cure.hours, cure.celsius)
}
