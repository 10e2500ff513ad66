//! Reference of sweep plans, generated from `fabkit schema --sweep`.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::Value;

use super::{GENERATED, Output};

/// Makes one page with the keys of a plan and all metrics.
///
/// # Errors
/// A schema with an unexpected structure.
pub fn page(schema: &str) -> Result<Output, String> {
    let schema: Value =
        serde_json::from_str(schema).map_err(|e| format!("fabkit schema --sweep: {e}"))?;
    let properties = schema["properties"].as_object().ok_or("the schema of plans has no keys")?;
    let mut text = format!(
        "# Sweep plans\n\n{GENERATED}\n\n{} How to write one: [Sweep a design](../tutorials/sweep.md).\n\n\
         | key | what |\n|---|---|\n",
        words(&schema["description"])?
    );
    for (key, property) in properties {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| `{key}` | {} |", words(&property["description"])?);
    }
    text += "\n## Metrics\n\nUnits are in the names; a share has none. A metric that does not apply to a \
             sensor is an empty cell.\n\n| metric | group | what |\n|---|---|---|\n";
    let metrics = properties["metrics"]["items"]["anyOf"].as_array();
    for metric in metrics.ok_or("the schema of plans has no metrics")? {
        let (name, description) = (words(&metric["const"])?, words(&metric["description"])?);
        // Names of groups have descriptions without a group prefix.
        if let Some((group, what)) = description.split_once(": ") {
            let _ = writeln!(text, "| `{name}` | `{group}` | {what} |");
        }
    }
    Ok(Output { path: PathBuf::from("reference/sweep.md"), text })
}

fn words(value: &Value) -> Result<&str, String> {
    value.as_str().ok_or_else(|| "the schema of plans lacks a description".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_become_rows_and_groups_do_not() {
        let schema = r#"{"description": "Variants.", "properties": {
            "seed": {"description": "Which sample."},
            "metrics": {"description": "Which.", "items": {"anyOf": [
                {"const": "camera", "description": "All metrics of the group camera."},
                {"const": "coverage", "description": "camera: share seen."}]}}}}"#;
        let text = page(schema).unwrap().text;
        assert!(text.contains("| `seed` | Which sample. |"), "{text}");
        assert!(
            text.ends_with("|---|---|---|\n| `coverage` | `camera` | share seen. |\n"),
            "{text}"
        );
    }
}
