//! JSON Schema (draft-07) of plans.

use serde_json::{Value, json};

use super::{MAX_AXES, MAX_VARIANTS};
use crate::metrics::{GROUPS, METRICS, Metric};

/// Returns the schema of sweep files, for editors.
///
/// ```
/// let schema = fabkit_sweep::json_schema();
/// // What a plan cannot do without.
/// assert_eq!(schema["required"], serde_json::json!(["format", "sensor", "axes"]));
/// ```
pub fn json_schema() -> Value {
    let groups = GROUPS.iter().map(|group| {
        let summary = format!("All metrics of the group {}.", group.word());
        json!({ "const": group.word(), "description": summary })
    });
    let metrics = METRICS.iter().map(|metric| {
        let Metric { name, group, summary, .. } = metric;
        json!({ "const": name, "description": format!("{}: {summary}.", group.word()) })
    });
    let names: Vec<Value> = groups.chain(metrics).collect();
    let plain = json!({ "type": ["string", "number", "boolean"] });
    let value = json!({ "anyOf": [plain, { "type": "array", "items": plain }] });
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "fabkit sweep",
        "description": "Many variants of one sensor, and the metrics to compute for each.",
        "type": "object",
        "additionalProperties": false,
        "required": ["format", "sensor", "axes"],
        "properties": {
            "format": { "const": 1, "description": "Version of the file format." },
            "sensor": {
                "type": "string",
                "description": "Name of a built-in sensor, or path of a sensor's file relative to this file's folder.",
            },
            "seed": {
                "type": "integer",
                "minimum": 0,
                "description": "Seed of the random numbers for the sample and for the bench; 0 if not given.",
            },
            "sample": {
                "type": "integer",
                "minimum": 1,
                "maximum": MAX_VARIANTS,
                "description": "Number of variants to draw evenly, instead of all combinations.",
            },
            "set": {
                "type": "object",
                "additionalProperties": value,
                "description": "Parameters with the same value in all variants.",
            },
            "axes": {
                "type": "object",
                "minProperties": 1,
                "maxProperties": MAX_AXES,
                "description": "Parameters that are varied, by path.",
                "additionalProperties": {
                    "anyOf": [
                        { "type": "array", "minItems": 1, "items": value },
                        {
                            "type": "object",
                            "additionalProperties": false,
                            "required": ["from", "to"],
                            "properties": {
                                "from": plain,
                                "to": plain,
                                "steps": { "type": "integer", "minimum": 2, "maximum": MAX_VARIANTS },
                                "scale": { "enum": ["linear", "log"] },
                            },
                        },
                    ],
                },
            },
            "fix": {
                "type": "boolean",
                "description": "True to change values chosen by fabkit, as little as possible, to fit the axes, so that a variant is lost only where rules contradict each other; false if not given.",
            },
            "constraints": {
                "type": "array",
                "items": { "type": "string" },
                "description": "Comparisons of parameters, metrics and numbers, all of which must hold.",
            },
            "metrics": {
                "type": "array",
                "items": { "anyOf": names },
                "description": "Metrics or groups of metrics to compute; if not given, all metrics without a press, check, mesh or bench.",
            },
            "objectives": {
                "type": "object",
                "additionalProperties": { "enum": ["min", "max"] },
                "description": "Metrics to minimise (`min`) or maximise (`max`), which define the Pareto front.",
            },
        },
    })
}
