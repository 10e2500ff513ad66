//! Difference between two designs: what can be reused, and what to make, cast and buy.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Body, BodyKind, Process, Sensor};
use serde::Serialize;

use crate::BodyUse;
use crate::membership::is_in_sensor;

/// Difference from one design to another.
#[derive(Clone, Debug, Serialize)]
pub struct DesignDifference {
    /// Format name, `fabkit-diff`.
    pub format: &'static str,
    /// Format version, 1.
    pub version: u32,
    /// Existing design.
    pub from: DesignName,
    /// Wanted design.
    pub to: DesignName,
    /// Parameters whose values differ, by path.
    pub parameters: Vec<ParameterChange>,
    /// All bodies of either design.
    pub bodies: Vec<BodyChange>,
    /// Steps that occur in one of the designs only, or differ, by name.
    pub steps: Vec<StepChange>,
}

/// Identity of a design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignName {
    /// Name of the design.
    pub name: String,
    /// Title of the design.
    pub title: String,
    /// Hash that distinguishes it from other designs of the same name.
    pub design_hash: String,
}

/// Parameter that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterChange {
    /// Dotted path.
    pub path: String,
    /// Existing value; `null` if there is none.
    pub from: Option<String>,
    /// Wanted value; `null` if there is none.
    pub to: Option<String>,
}

/// Kind of change of a body or step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChangeKind {
    /// Unchanged: the same shape from the same material.
    Same,
    /// Wanted in another form.
    Changed,
    /// Only in the wanted design.
    Added,
    /// Only in the existing design.
    Removed,
}

impl ChangeKind {
    /// Returns the word used in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Changed => "changed",
            Self::Added => "added",
            Self::Removed => "removed",
        }
    }
}

/// Comparison of a body of either design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyChange {
    /// Name of the body.
    pub name: String,
    /// Kind: `part`, `board`, `layer` or `component`.
    pub kind: &'static str,
    /// Use: part of the sensor, or tool.
    pub of: BodyUse,
    /// Kind of change.
    pub change: ChangeKind,
    /// Properties that differ: `shape`, `material`, `process`, `order`.
    pub differs: Vec<&'static str>,
    /// Old name, if the same part had another one.
    pub was: Option<String>,
    /// Existing and wanted quantity for one unit.
    pub quantity: [u32; 2],
    /// Number of pieces to make, cast or buy in addition.
    pub besides: u32,
}

/// Step that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepChange {
    /// Name of the step.
    pub name: String,
    /// Kind of change.
    pub change: ChangeKind,
}

/// Design to compare.
#[derive(Clone, Copy)]
pub struct ComparedDesign<'a> {
    /// Bodies and steps.
    pub sensor: &'a Sensor,
    /// Hash of the design.
    pub design_hash: &'a str,
    /// Parameters: path and value.
    pub parameters: &'a [(String, String)],
}

impl DesignDifference {
    /// Computes the difference from one design to another.
    ///
    /// ```
    /// use fabkit_checks::example;
    /// use fabkit_geometry::Solid;
    /// use fabkit_guide::{ChangeKind, ComparedDesign, DesignDifference};
    /// let old = example::puck();
    /// let mut new = example::puck();
    /// new.bodies[1].solid = Solid::cylinder(12.0, 6.0).at_z(2.0);
    /// let design = |sensor| ComparedDesign { sensor, design_hash: "00", parameters: &[] };
    /// let difference = DesignDifference::between(design(&old), design(&new));
    /// // Only the lid has to be made again.
    /// let changed: Vec<_> = difference.with_change(ChangeKind::Changed).collect();
    /// assert_eq!((changed.len(), &*changed[0].name, changed[0].besides), (1, "lid", 1));
    /// assert_eq!(changed[0].differs, ["shape"]);
    /// ```
    pub fn between(from: ComparedDesign, to: ComparedDesign) -> Self {
        Self {
            format: "fabkit-diff",
            version: 1,
            from: named(from),
            to: named(to),
            parameters: parameters(from, to),
            bodies: bodies(from.sensor, to.sensor),
            steps: steps(from.sensor, to.sensor),
        }
    }

    /// Returns the difference as JSON (`fabkit-diff` version 1).
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("names and numbers alone")
    }

    /// Iterates over the bodies with a kind of change.
    pub fn with_change(&self, change: ChangeKind) -> impl Iterator<Item = &BodyChange> {
        self.bodies.iter().filter(move |body| body.change == change)
    }
}

/// Returns the identity of a design.
fn named(side: ComparedDesign) -> DesignName {
    DesignName {
        name: side.sensor.name.clone(),
        title: side.sensor.title.clone(),
        design_hash: side.design_hash.to_owned(),
    }
}

/// Compares the parameters by path.
fn parameters(from: ComparedDesign, to: ComparedDesign) -> Vec<ParameterChange> {
    let map = |side: ComparedDesign| -> BTreeMap<String, String> {
        side.parameters.iter().cloned().collect()
    };
    let (from, to) = (map(from), map(to));
    let paths: BTreeSet<&String> = from.keys().chain(to.keys()).collect();
    let differing = paths.into_iter().filter(|path| from.get(*path) != to.get(*path));
    let change = |path: &String| ParameterChange {
        path: path.clone(),
        from: from.get(path).cloned(),
        to: to.get(path).cloned(),
    };
    differing.map(change).collect()
}

/// Returns the properties in which two bodies differ.
fn differs(a: &Body, b: &Body) -> Vec<&'static str> {
    let is_bought = b.kind == BodyKind::Bought;
    [
        // For bought bodies, the specification says more than the drawn shape.
        ("shape", !is_bought && a.solid.shape_key() != b.solid.shape_key()),
        ("material", a.material != b.material),
        ("process", a.kind != b.kind),
        ("order", is_bought && a.summary != b.summary),
    ]
    .into_iter()
    .filter_map(|(word, is_other)| is_other.then_some(word))
    .collect()
}

fn kind(body: &Body) -> &'static str {
    match body.kind {
        BodyKind::Made(Process::Pcb) => "board",
        kind => kind.word(),
    }
}

/// Compares the bodies by name; an unchanged part may have another name.
fn bodies(from: &Sensor, to: &Sensor) -> Vec<BodyChange> {
    // An old body that has a namesake cannot be matched to another name.
    let mut taken: BTreeSet<&str> = to
        .bodies
        .iter()
        .filter(|b| from.body(&b.name).is_some())
        .map(|b| b.name.as_str())
        .collect();
    let mut all = Vec::new();
    for body in &to.bodies {
        let namesake = from.body(&body.name);
        // The same part under another name exists already.
        let renamed = || {
            let is_it = |old: &&Body| {
                !taken.contains(old.name.as_str()) && old.is_made() && differs(old, body).is_empty()
            };
            body.is_made().then(|| from.bodies.iter().find(is_it)).flatten()
        };
        let old = namesake.or_else(renamed);
        let differs = old.map_or(Vec::new(), |old| differs(old, body));
        let there = old.map_or(0, |old| old.quantity);
        let change = match (old, differs.is_empty()) {
            (None, _) => ChangeKind::Added,
            (Some(_), true) => ChangeKind::Same,
            (Some(_), false) => ChangeKind::Changed,
        };
        let usable =
            if change == ChangeKind::Same && body.kind != BodyKind::Cast { there } else { 0 };
        taken.extend(old.map(|old| old.name.as_str()));
        all.push(BodyChange {
            name: body.name.clone(),
            kind: kind(body),
            of: tool(body),
            change,
            differs,
            was: old.filter(|old| old.name != body.name).map(|old| old.name.clone()),
            quantity: [there, body.quantity],
            // An unchanged layer exists if the old sensor is not taken apart: that is up to the reader.
            besides: match (change, body.kind) {
                (ChangeKind::Same, BodyKind::Cast) => 0,
                _ => body.quantity.saturating_sub(usable),
            },
        });
    }
    let gone = from.bodies.iter().filter(|old| !taken.contains(old.name.as_str()));
    all.extend(gone.map(|old| BodyChange {
        name: old.name.clone(),
        kind: kind(old),
        of: tool(old),
        change: ChangeKind::Removed,
        differs: Vec::new(),
        was: None,
        quantity: [old.quantity, 0],
        besides: 0,
    }));
    all
}

fn tool(body: &Body) -> BodyUse {
    if is_in_sensor(body) { BodyUse::Sensor } else { BodyUse::Tool }
}

/// Compares the steps by name.
fn steps(from: &Sensor, to: &Sensor) -> Vec<StepChange> {
    let find = |sensor: &Sensor, name: &str| {
        let step = sensor.chain.iter().find(|step| step.name == name)?;
        Some((step.instruction.clone(), step.bodies.clone(), step.cure()))
    };
    let told = |name: &str, change| StepChange { name: name.to_owned(), change };
    let kept = to.chain.iter().filter_map(|step| match find(from, &step.name) {
        None => Some(told(&step.name, ChangeKind::Added)),
        Some(old) if Some(&old) != find(to, &step.name).as_ref() => {
            Some(told(&step.name, ChangeKind::Changed))
        }
        Some(_) => None,
    });
    let gone = from.chain.iter().filter(|step| find(to, &step.name).is_none());
    kept.chain(gone.map(|step| told(&step.name, ChangeKind::Removed))).collect()
}
