//! Results as JSON documents, identical for the command, Python and other callers.

use std::path::Path;

use fabkit_checks::{self as checks, Batch, CheckReport, Finding, Rule, UnknownProperty};
use fabkit_designs::fixing::{FeasibleRange, ValueChange, ValueRange};
use fabkit_designs::{Design, design_hash};
use fabkit_files::{limit_json, split_amount};
use fabkit_geometry::{Action, Body, Step};
use fabkit_sweep::Status;
use fabkit_text::{Setting, ValueKind};
use serde_json::{Map, Value, json};

use crate::sweep_runs::SweepResult;

/// Returns a design's parameters, derived values, bodies and materials (`fabkit-show` version 2).
///
/// ```
/// use fabkit_application::{documents::show, source::Target};
///
/// let document = show(&Target::new("rtac0").design(&[])?);
/// assert_eq!((&document["name"], &document["version"]), (&"rtac0".into(), &2.into()));
/// let parameters = document["parameters"].as_array().ok_or("no list")?;
/// let radius = parameters.iter().find(|one| one["path"] == "surface.radius").ok_or("no radius")?;
/// // Numbers are numbers, and their unit is beside them.
/// assert_eq!((&radius["value"], &radius["unit"]), (&15.0.into(), &"mm".into()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn show(design: &Design) -> Value {
    let sensor = &design.sensor;
    let parameters: Vec<Value> = own_first(&design.parameters).map(parameter_json).collect();
    let derived: Vec<Value> = design
        .derived
        .iter()
        .map(|(name, written)| {
            let (value, unit) = split_amount(written);
            json!({ "name": name, "value": value, "unit": unit, "written": written })
        })
        .collect();
    let bodies: Vec<Value> = sensor.bodies.iter().map(body_json).collect();
    json!({
        "format": "fabkit-show",
        "version": 2,
        "name": sensor.name,
        "title": sensor.title,
        "reference": sensor.reference,
        "design_hash": design_hash(design),
        "parameters": parameters,
        "derived": derived,
        "bodies": bodies,
        "materials": crate::materials::materials_json(&design.materials),
    })
}

/// Lists a fixture's own parameters before those of the sensor it is made for.
pub fn own_first(settings: &[Setting]) -> impl Iterator<Item = &Setting> {
    let is_own = |setting: &&Setting| setting.path.starts_with("fixtures.");
    settings.iter().filter(is_own).chain(settings.iter().filter(move |s| !is_own(s)))
}

fn parameter_json(setting: &Setting) -> Value {
    let (value, unit) = value_of(setting);
    let ends = setting.bounds.as_ref().map(|ends| ends.each_ref().map(String::as_str));
    let [min, max] = ends.map_or([None, None], |ends| ends.map(Some));
    json!({
        "path": setting.path,
        "value": value,
        "unit": unit,
        "written": setting.value,
        "limit": limit_json([min, max], &setting.choices),
        "limits": setting.limits,
        "summary": setting.summary,
        "source": setting.source.kind.to_string(),
        "note": setting.source.note,
        "tolerance": setting.source.tolerance,
        "expression": setting.expression,
    })
}

/// Splits a setting into its JSON value and its unit.
fn value_of(setting: &Setting) -> (Value, Option<String>) {
    let text = setting.value.as_str();
    match setting.kind {
        ValueKind::Length | ValueKind::Angle | ValueKind::Number => split_amount(text),
        ValueKind::Count => (text.parse::<u64>().map_or_else(|_| json!(text), Value::from), None),
        ValueKind::Switch => (json!(text == "true"), None),
        ValueKind::Text => (json!(text), None),
        ValueKind::List => {
            let inner = text.trim_start_matches('[').trim_end_matches(']');
            let items = inner.split(", ").filter(|item| !item.is_empty()).map(split_amount);
            let (values, units): (Vec<Value>, Vec<Option<String>>) = items.unzip();
            // All items of a list have the same unit.
            (json!(values), units.into_iter().next().flatten())
        }
    }
}

/// Lists the automatic changes that made a design buildable, as they stand under `changes` in other documents.
pub fn changes(changes: &[ValueChange]) -> Value {
    let change = |ValueChange { path, from, to, because }: &ValueChange| json!({ "path": path, "from": from, "to": to, "because": because });
    changes.iter().map(change).collect()
}

/// Returns the feasible ranges of parameters (`fabkit-limits` version 1).
pub fn limits(name: &str, limits: &[FeasibleRange]) -> Value {
    let range = |range: &ValueRange| {
        json!({
            "low": range.low,
            "high": range.high,
            "low_is_smallest_allowed": range.is_end[0],
            "high_is_largest_allowed": range.is_end[1],
        })
    };
    let one = |feasible: &FeasibleRange| {
        json!({
            "path": feasible.path,
            "value": feasible.value,
            "unit": feasible.unit,
            "held": range(&feasible.alone),
            "followed": feasible.following.as_ref().map(range),
        })
    };
    json!({
        "format": "fabkit-limits",
        "version": 1,
        "name": name,
        "limits": limits.iter().map(one).collect::<Vec<_>>(),
    })
}

fn body_json(body: &Body) -> Value {
    json!({
        "name": &body.name,
        "kind": body.kind.word(),
        "summary": &body.summary,
        "process": body.process_word(),
        "material": &body.material,
        "quantity": body.quantity,
        "notes": body.notes,
        "assemblies": body.placements.iter().map(|p| &p.assembly.0).collect::<Vec<_>>(),
    })
}

/// Returns the rules examined, the findings and the batches (`fabkit-check` version 1).
pub fn check(design: &Design, report: &CheckReport) -> Value {
    json!({
        "format": "fabkit-check",
        "version": 1,
        "name": design.sensor.name,
        "design_hash": design_hash(design),
        "passed": report.errors() == 0,
        "resolution": checks::RESOLUTION,
        "rules": rules_json(report),
        "findings": report.findings.iter().map(finding_json).collect::<Vec<_>>(),
        "batches": report.batches.iter().map(batch).collect::<Vec<_>>(),
        "not_known": report.not_known.iter().map(unknown_property).collect::<Vec<_>>(),
    })
}

/// Returns a property that no source states, with what would settle it.
pub fn unknown_property(unknown: &UnknownProperty) -> Value {
    json!({
        "property": unknown.property.word(),
        "material": unknown.material,
        "bodies": unknown.bodies,
        "rules": unknown.rules.iter().map(|rule| rule.word()).collect::<Vec<_>>(),
        "remedy": unknown.remedy,
    })
}

fn rules_json(report: &CheckReport) -> Vec<Value> {
    let rule = |rule: Rule| report.for_rule(rule).count();
    let entries = report.examined.iter().map(|examined| {
        json!({
            "rule": examined.rule.word(),
            "examined": examined.count,
            "of": examined.what,
            "findings": rule(examined.rule),
        })
    });
    entries.collect()
}

fn finding_json(finding: &Finding) -> Value {
    json!({
        "rule": finding.rule.word(),
        "severity": finding.severity.to_string(),
        "step": finding.step,
        "assembly": finding.assembly,
        "bodies": finding.bodies,
        "place_mm": finding.place.map(|p| [p.x, p.y, p.z]),
        "value": finding.measured.map(|m| m.value),
        "limit": finding.measured.map(|m| m.limit),
        "unit": finding.measured.map(|m| m.unit),
        "message": finding.message,
        "fix": finding.fix,
    })
}

/// Returns what a script needs to mix one batch: volume, waste, masses, curing.
pub fn batch(batch: &Batch) -> Value {
    let components = batch.components_g.iter();
    json!({
        "step": batch.step,
        "layer": batch.layer,
        "volume_mm3": batch.volume.value_mm3,
        "volume_error_mm3": batch.volume.error_mm3,
        "waste": batch.waste,
        "components": components
            .map(|(name, grams)| json!({ "name": name, "mass_g": grams }))
            .collect::<Vec<_>>(),
        "degas": batch.degas,
        "cure": { "hours": batch.cure.hours, "celsius": batch.cure.celsius },
    })
}

/// Returns the build steps of a design (`fabkit-chain` version 1).
///
/// ```
/// use fabkit_application::{documents::chain, source::Target};
///
/// let document = chain(&Target::new("rtac0").design(&[])?);
/// let steps = document["steps"].as_array().ok_or("no list")?;
/// // A layer that is poured has a batch to mix.
/// let poured = steps.iter().find(|step| step["action"] == "pour").ok_or("nothing is poured")?;
/// assert!(poured["batch"]["volume_mm3"].as_f64().is_some_and(|mm3| mm3 > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn chain(design: &Design) -> Value {
    let sensor = &design.sensor;
    let batches = checks::batches(sensor);
    let steps = sensor.chain.iter().map(|step| {
        json!({
            "name": step.name,
            "instruction": step.instruction,
            "action": step.action.word(),
            "assembly": step.assembly.as_ref().map(|a| &a.0),
            "bodies": step.bodies,
            "batch": batch_of(&batches, step).map(batch),
            "during": step.during_cure_of,
            "adjust": step.adjustments.iter().map(|one| &one.body).collect::<Vec<_>>(),
            "cure": step.cure().map(|c| json!({ "hours": c.hours, "celsius": c.celsius })),
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

/// Finds the batch that is mixed for a step.
pub fn batch_of<'a>(batches: &'a [Batch], step: &Step) -> Option<&'a Batch> {
    batches.iter().find(|batch| batch.step == step.name)
}

/// Returns the tools that are removed in a step.
pub fn removed(action: &Action) -> Vec<&str> {
    match action {
        Action::Demold(pulls) => pulls.iter().map(|pull| pull.body.as_str()).collect(),
        _ => Vec::new(),
    }
}

/// Returns the result of a sweep (`fabkit-sweep-report` version 1).
pub fn sweep(folder: &Path, finished: &SweepResult) -> Value {
    let SweepResult { variants, found, counts, panicked, on_front, none_left, empty_metrics } =
        finished;
    let status: Map<String, Value> =
        Status::ALL.iter().zip(counts).map(|(s, n)| (s.word().to_owned(), json!(n))).collect();
    json!({
        "format": "fabkit-sweep-report",
        "version": 1,
        "folder": folder.display().to_string(),
        "variants": variants,
        "rows_found": found,
        "status": status,
        "panicked": panicked,
        "pareto": on_front,
        "empty_metrics": empty_metrics,
        "none_left": none_left,
    })
}
