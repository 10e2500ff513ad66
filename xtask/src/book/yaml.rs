//! Reference of sensor files, generated from `fabkit schema`.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::Value;

use super::{GENERATED, Output};

/// Keys of every family that `reference/yaml.md` and `reference/own.md` explain by hand.
const COMMON: [&str; 8] =
    ["format", "family", "extends", "fixtures", "materials", "processes", "parts", "buy"];

/// Makes one page for each family, and one for the fixtures, which are the same for all.
///
/// # Errors
/// A schema with an unexpected structure.
pub fn pages(schema: &str) -> Result<Vec<Output>, String> {
    let schema: Value = serde_json::from_str(schema).map_err(|e| format!("fabkit schema: {e}"))?;
    let definitions = schema["definitions"].as_object().ok_or("the schema has no definitions")?;
    let mut pages = Vec::new();
    let mut fixtures = None;
    for (family, definition) in definitions {
        if family.ends_with("-variant") {
            // A variant has the same keys, none of them required.
            continue;
        }
        let summary = text(definition, "description")?;
        let mut page = format!(
            "# Family `{family}`\n\n{GENERATED}\n\n{}. Built-in sensors: {}.\n",
            capitalised(summary),
            sensors(&schema, family)?
        );
        tables(&mut page, "", definition, &COMMON)?;
        pages.push(Output { path: path(family), text: page });
        fixtures = Some(&definition["properties"]["fixtures"]);
    }
    let fixtures = fixtures.ok_or("the schema has no families")?;
    let mut page = format!(
        "# Fixtures\n\n{GENERATED}\n\nThe section `fixtures` of every sensor's file. All of it may be \
         left out.\n"
    );
    tables(&mut page, "fixtures", fixtures, &[])?;
    pages.push(Output { path: path("fixtures"), text: page });
    Ok(pages)
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(format!("reference/yaml-{name}.md"))
}

/// Lists the built-in sensors that a file of this family may extend.
fn sensors(schema: &Value, family: &str) -> Result<String, String> {
    let variant = format!("#/definitions/{family}-variant");
    let cases = schema["allOf"].as_array().ok_or("the schema has no cases")?;
    let case = cases
        .iter()
        .find(|case| case["then"]["$ref"] == variant.as_str())
        .ok_or_else(|| format!("the schema says not what extends {family}"))?;
    let names = case["if"]["properties"]["extends"]["enum"].as_array();
    let names = names.into_iter().flatten().filter_map(Value::as_str);
    Ok(names.map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "))
}

/// Appends one table for each section, subsections below it.
fn tables(page: &mut String, path: &str, section: &Value, without: &[&str]) -> Result<(), String> {
    let properties = section["properties"]
        .as_object()
        .ok_or_else(|| format!("section `{path}` has no properties"))?;
    let is_section = |value: &Value| value["properties"].is_object();
    let wanted = || properties.iter().filter(|(name, _)| !without.contains(&name.as_str()));
    let mut rows = String::new();
    for (name, value) in wanted().filter(|(_, value)| !is_section(value)) {
        let (summary, allowed) = text(value, "description")?
            .split_once(" Allowed: ")
            .ok_or_else(|| format!("`{path}.{name}` says not what is allowed"))?;
        let allowed = allowed.trim_end_matches('.');
        // Writing to a string cannot fail.
        let _ = writeln!(rows, "| `{name}` | {} | {} |", cell(summary), cell(allowed));
    }
    if !path.is_empty() {
        let _ = write!(page, "\n## `{path}`\n\n{}\n", text(section, "description")?);
    }
    if !rows.is_empty() {
        let _ = write!(page, "\n| key | what | allowed |\n|---|---|---|\n{rows}");
    }
    for (name, value) in wanted().filter(|(_, value)| is_section(value)) {
        let deeper = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        tables(page, &deeper, value, &[])?;
    }
    Ok(())
}

fn text<'a>(value: &'a Value, key: &str) -> Result<&'a str, String> {
    value[key].as_str().ok_or_else(|| format!("the schema has a place without `{key}`"))
}

/// Escapes a text for a table cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;")
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_sections_become_tables() {
        let schema = r##"{
            "allOf": [{"if": {"properties": {"extends": {"enum": ["ball"]}}},
                       "then": {"$ref": "#/definitions/round-variant"}}],
            "definitions": {"round": {"description": "a ball", "properties": {
                "format": {"const": 1},
                "fixtures": {"description": "Hardware.", "properties": {}},
                "skin": {"description": "The skin.", "properties": {
                    "radius": {"description": "Radius. Allowed: 1 mm to 2 mm."}}}}}}}"##;
        let pages = pages(schema).unwrap();
        assert_eq!(pages.len(), 2);
        let page = &pages[0].text;
        assert!(page.contains("A ball. Built-in sensors: `ball`."), "{page}");
        assert!(page.contains("## `skin`\n\nThe skin.\n\n| key"), "{page}");
        assert!(page.contains("| `radius` | Radius. | 1 mm to 2 mm |"), "{page}");
    }
}
