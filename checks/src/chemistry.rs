//! What is poured cures against everything that it touches, and what is to come apart does not grow together.

use fabkit_geometry::{Action, Assembly, Body, Curing, Sensor, Sort};

use crate::finding::{Finding, Rule};

/// All findings, and how many faces of liquids were looked at.
pub(crate) fn examine(sensor: &Sensor) -> (Vec<Finding>, usize) {
    let (mut findings, mut count) = (Vec::new(), 0);
    for (index, step) in sensor.chain.iter().enumerate() {
        let (layer, beside) = match &step.action {
            Action::Pour(pour) => (&pour.layer, &pour.walls),
            Action::Spray(spray) => (&spray.layer, &spray.onto),
            _ => continue,
        };
        let Some(layer) = sensor.body(layer) else { continue };
        for wall in beside.iter().filter_map(|name| sensor.body(name)) {
            count += 1;
            let contact = Contact { sensor, index, layer, wall };
            let found = contact.inhibited().or_else(|| contact.grown_together());
            findings.extend(found.map(|finding| finding.in_step(&step.name)));
        }
    }
    (findings, count)
}

/// A liquid, what it touches, and in which step.
struct Contact<'a> {
    sensor: &'a Sensor,
    index: usize,
    layer: &'a Body,
    wall: &'a Body,
}

impl Contact<'_> {
    /// The wall keeps the liquid from curing.
    fn inhibited(&self) -> Option<Finding> {
        let (layer, wall) = (self.layer, self.wall);
        let curing = layer.substance.cures?;
        if !wall.substance.inhibits.contains(&curing) || self.is_sealed() {
            return None;
        }
        let message = format!(
            "{} of {} stays sticky against {} of {}, which keeps {} from curing",
            layer.name,
            layer.material,
            wall.name,
            stuff(wall),
            curing.word()
        );
        let fix = match wall.sealed_by {
            Some(by) => {
                format!("say in a step before the pour that {} is sealed ({by})", wall.name)
            }
            None => format!(
                "seal {} and say so in its material (`sealed {}`), or make it of something that does \
                 not inhibit {}",
                wall.name,
                stuff(wall),
                curing.word()
            ),
        };
        Some(Finding::error(Rule::Chemistry, message, fix).of([wall.name.as_str(), &layer.name]))
    }

    /// What seals the wall is said by its maker and by a step until now.
    fn is_sealed(&self) -> bool {
        let Some(by) = self.wall.sealed_by else { return false };
        let mut until_now = self.sensor.chain[..=self.index].iter();
        until_now.any(|step| step.instruction.to_lowercase().contains(by))
    }

    /// Silicone on cured silicone is one piece, unless release agent lies between them.
    fn grown_together(&self) -> Option<Finding> {
        let (layer, wall) = (self.layer, self.wall);
        let is_silicone = |body: &Body| {
            body.substance.sort == Some(Sort::Silicone)
                && body.substance.cures != Some(Curing::Moisture)
        };
        let both_stay = [layer, wall].into_iter().all(in_use);
        if both_stay || !is_silicone(layer) || !is_silicone(wall) || self.is_released() {
            return None;
        }
        let message = format!(
            "{} of {} grows together with {} of {}: silicone sticks to silicone",
            layer.name, layer.material, wall.name, wall.material
        );
        let fix = format!("spray {} with release agent, and say so in a step before", wall.name);
        Some(Finding::error(Rule::Chemistry, message, fix).of([wall.name.as_str(), &layer.name]))
    }

    fn is_released(&self) -> bool {
        let chain = self.sensor.chain[..=self.index].iter().enumerate();
        chain.into_iter().any(|(at, step)| {
            let is_meant = at == self.index || step.bodies.contains(&self.wall.name);
            is_meant && step.instruction.to_lowercase().contains("release")
        })
    }
}

fn stuff(body: &Body) -> &str {
    if body.material.is_empty() { &body.summary } else { &body.material }
}

/// Whether a body is a part of the sensor in use.
pub(crate) fn in_use(body: &Body) -> bool {
    body.placements.iter().any(|placement| placement.assembly == Assembly::sensor())
}
