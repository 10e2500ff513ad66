//! Layers that do not stick to the body they are cast onto, or that tear off it.

use fabkit_geometry::{Sensor, UnbondedLayer};

use crate::declaration::rule;
use crate::finding::{Finding, Severity};
use crate::rule::Rule;
use crate::rule_input::{RuleInput, RuleResult};
use crate::tearing;

rule! {
    /// Layers stick to the bodies they are cast onto.
    Bonding = "bonding",
    examines: "layers",
    finds: "layers that are cast onto a body to which they do not bond",
    limit: "`bonds` of the materials",
    for_variants: true,
    look: apply,
}

fn apply(case: &RuleInput<'_>) -> RuleResult {
    let loose = case.sensor.loose.iter().map(|loose| unbonded(case.sensor, loose));
    let loose = loose.chain(tearing::examine(case.sensor)).collect();
    Ok((loose, case.sensor.layers().count()))
}

/// Reports a layer that does not stick to the body it is cast onto. A warning, since its shape may hold it.
fn unbonded(sensor: &Sensor, loose: &UnbondedLayer) -> Finding {
    // Bought bodies have no material; their description stands in for it.
    let from = |name: &str| {
        let body = sensor.body(name);
        let from =
            body.map(|body| if body.material.is_empty() { &body.summary } else { &body.material });
        from.map_or("", String::as_str)
    };
    let (layer, on) = (from(&loose.layer), from(&loose.substrate));
    let message = format!(
        "{} of {layer} is cast onto {} of {on}, to which it does not stick",
        loose.layer, loose.substrate
    );
    let fix = format!(
        "hold it by its shape or by a glue, take another material, or name a primer in `bonds` of {layer}"
    );
    Finding::error(Rule::Bonding, message, fix)
        .with_severity(Severity::Warning)
        .in_step(&loose.step)
        .about_bodies([loose.layer.as_str(), loose.substrate.as_str()])
}
