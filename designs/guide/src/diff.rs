//! What changes from one design to another: what can be used again, what to make, cast and buy.

use std::collections::{BTreeMap, BTreeSet};

use fabkit_geometry::{Body, Kind, Process, Sensor};
use serde::Serialize;

use crate::Tool;
use crate::membership::stays;

/// From one design to another.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// `fabkit-diff`.
    pub format: &'static str,
    /// 1.
    pub version: u32,
    /// What there is.
    pub from: DesignName,
    /// What is wanted.
    pub to: DesignName,
    /// Parameters whose values differ, by path.
    pub parameters: Vec<ParameterChange>,
    /// Every body of either.
    pub bodies: Vec<BodyChange>,
    /// Steps by name: those that are done in one of them alone, or otherwise.
    pub steps: Vec<StepChange>,
}

/// Which design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignName {
    /// Its name.
    pub name: String,
    /// Its title.
    pub title: String,
    /// Tells it from others of its name.
    pub design_hash: String,
}

/// A parameter that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterChange {
    /// Dotted.
    pub path: String,
    /// As it is; `null` where there is none.
    pub from: Option<String>,
    /// As it is to be.
    pub to: Option<String>,
}

/// What becomes of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// It is what is wanted: the same shape from the same material.
    Same,
    /// It is wanted otherwise.
    Changed,
    /// Nothing like it is there.
    Added,
    /// It is not wanted any more.
    Removed,
}

impl Change {
    /// As in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Changed => "changed",
            Self::Added => "added",
            Self::Removed => "removed",
        }
    }
}

/// A body of either design.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyChange {
    /// Its name.
    pub name: String,
    /// `part`, `board`, `layer` or `component`.
    pub kind: &'static str,
    /// What it is of.
    pub of: Tool,
    /// What becomes of it.
    pub change: Change,
    /// In what it differs: `shape`, `material`, `process`, `order`.
    pub differs: Vec<&'static str>,
    /// What it was called, where the same thing had another name.
    pub was: Option<String>,
    /// How many there are, and how many are wanted, for one unit.
    pub quantity: [u32; 2],
    /// How many are to be made, cast or bought besides what is there.
    pub besides: u32,
}

/// A step that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepChange {
    /// Its name.
    pub name: String,
    /// What becomes of it.
    pub change: Change,
}

/// A design to compare.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    /// Its bodies and steps.
    pub sensor: &'a Sensor,
    /// Its hash.
    pub design_hash: &'a str,
    /// Its parameters: path and value.
    pub parameters: &'a [(String, String)],
}

impl Difference {
    /// From one design to another.
    pub fn between(from: Side, to: Side) -> Self {
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

    /// As JSON (`fabkit-diff` version 1).
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("names and numbers alone")
    }

    /// Bodies of a kind that something becomes of.
    pub fn of(&self, change: Change) -> impl Iterator<Item = &BodyChange> {
        self.bodies.iter().filter(move |body| body.change == change)
    }
}

fn named(side: Side) -> DesignName {
    DesignName {
        name: side.sensor.name.clone(),
        title: side.sensor.title.clone(),
        design_hash: side.design_hash.to_owned(),
    }
}

fn parameters(from: Side, to: Side) -> Vec<ParameterChange> {
    let map =
        |side: Side| -> BTreeMap<String, String> { side.parameters.iter().cloned().collect() };
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

/// In what two bodies differ.
fn differs(a: &Body, b: &Body) -> Vec<&'static str> {
    let is_bought = b.kind == Kind::Bought;
    [
        // Of what is bought, what to order says more than how it is drawn.
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
        Kind::Made(Process::Pcb) => "board",
        kind => kind.word(),
    }
}

fn bodies(from: &Sensor, to: &Sensor) -> Vec<BodyChange> {
    let mut taken: BTreeSet<&str> = to
        .bodies
        .iter()
        .filter(|b| from.body(&b.name).is_some())
        .map(|b| b.name.as_str())
        .collect();
    let mut all = Vec::new();
    for body in &to.bodies {
        let namesake = from.body(&body.name);
        // What is the same under another name is there, too.
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
            (None, _) => Change::Added,
            (Some(_), true) => Change::Same,
            (Some(_), false) => Change::Changed,
        };
        let usable = if change == Change::Same && body.kind != Kind::Cast { there } else { 0 };
        taken.extend(old.map(|old| old.name.as_str()));
        all.push(BodyChange {
            name: body.name.clone(),
            kind: kind(body),
            of: tool(body),
            change,
            differs,
            was: old.filter(|old| old.name != body.name).map(|old| old.name.clone()),
            quantity: [there, body.quantity],
            // A layer that is the same is there if nothing of it is taken apart: that is left to the reader.
            besides: match (change, body.kind) {
                (Change::Same, Kind::Cast) => 0,
                _ => body.quantity.saturating_sub(usable),
            },
        });
    }
    let gone = from.bodies.iter().filter(|old| !taken.contains(old.name.as_str()));
    all.extend(gone.map(|old| BodyChange {
        name: old.name.clone(),
        kind: kind(old),
        of: tool(old),
        change: Change::Removed,
        differs: Vec::new(),
        was: None,
        quantity: [old.quantity, 0],
        besides: 0,
    }));
    all
}

fn tool(body: &Body) -> Tool {
    if stays(body) { Tool::Sensor } else { Tool::Tool }
}

fn steps(from: &Sensor, to: &Sensor) -> Vec<StepChange> {
    let find = |sensor: &Sensor, name: &str| {
        let step = sensor.chain.iter().find(|step| step.name == name)?;
        Some((step.instruction.clone(), step.bodies.clone(), step.cure()))
    };
    let told = |name: &str, change| StepChange { name: name.to_owned(), change };
    let kept = to.chain.iter().filter_map(|step| match find(from, &step.name) {
        None => Some(told(&step.name, Change::Added)),
        Some(old) if Some(&old) != find(to, &step.name).as_ref() => {
            Some(told(&step.name, Change::Changed))
        }
        Some(_) => None,
    });
    let gone = from.chain.iter().filter(|step| find(to, &step.name).is_none());
    kept.chain(gone.map(|step| told(&step.name, Change::Removed))).collect()
}
