//! JSON Schema (draft-07) of sensor files, derived from the declarations.

use std::collections::BTreeSet;

use serde_json::{Map, Value as Json, json};

use crate::{FieldDeclaration, FieldShape, SourceKind, ValueKind, join};

/// Input of the schema for one family.
///
/// ```
/// use std::collections::BTreeSet;
///
/// use fabkit_text::{FamilySchema, FieldDeclaration, Parameter, root_schema};
///
/// let count = |name| FieldDeclaration { name, summary: String::new(), shape: u32::shape(&(1..=9)) };
/// let family = FamilySchema {
///     name: "pins",
///     summary: "A field of pins.",
///     fields: vec![count("rows"), count("columns")],
///     sensors: vec!["pins4"],
///     optional: BTreeSet::from(["columns".to_owned()]),
/// };
/// let schema = root_schema(1, &[family], &[]);
/// assert_eq!(schema["definitions"]["pins"]["required"].as_array().map(Vec::len), Some(1));
/// // A file that extends a sensor may leave out everything.
/// assert!(schema["definitions"]["pins-variant"].get("required").is_none());
/// ```
pub struct FamilySchema<'a> {
    /// Word behind `family:`.
    pub name: &'a str,
    /// Description in one line.
    pub summary: &'a str,
    /// Keys of the file, without `format`, `family` and `extends`.
    pub fields: Vec<FieldDeclaration>,
    /// Names of the family's built-in sensors.
    pub sensors: Vec<&'a str>,
    /// Paths of values that a file may omit.
    pub optional: BTreeSet<String>,
}

/// Builds the schema of a sensor file: complete if it names a family, partial if it extends a sensor.
pub fn root_schema(
    format: u32,
    families: &[FamilySchema<'_>],
    extensions: &[(&str, &str, Vec<FieldDeclaration>)],
) -> Json {
    let names: Vec<&str> = families.iter().map(|f| f.name).collect();
    let sensors: Vec<&str> = families.iter().flat_map(|f| f.sensors.iter().copied()).collect();
    let head = json!({
        "format": { "const": format, "description": "Version of the file format." },
        "family": { "enum": names, "description": "Family of parts." },
        "extends": {
            "anyOf": [{ "enum": sensors }, { "type": "string", "pattern": "\\.ya?ml$" }],
            "description": "Name of a built-in sensor, or path of another file relative to this file's \
                            folder. This file then lists only the changes.",
        },
    });
    let mut definitions = Map::new();
    let mut cases = Vec::new();
    for family in families {
        let complete = family.name.to_owned();
        let partial = format!("{}-variant", family.name);
        cases.push(json!({
            "if": {
                "properties": { "family": { "const": family.name } },
                "required": ["family"],
                // A file that extends another may name the family too, but need not be complete.
                "not": { "required": ["extends"] },
            },
            "then": { "$ref": format!("#/definitions/{complete}") },
        }));
        cases.push(json!({
            "if": {
                "properties": { "extends": { "enum": family.sensors } },
                "required": ["extends"],
            },
            "then": { "$ref": format!("#/definitions/{partial}") },
        }));
        // The same keys twice: all required, or none.
        for (name, is_complete) in [(complete, true), (partial, false)] {
            let mut schema = build_section(
                &family.fields,
                family.summary,
                is_complete.then_some(("", &family.optional)),
            );
            // Draft-07 has no way to extend a closed object, so common keys are copied into each definition.
            if let (Some(properties), Some(head)) =
                (schema["properties"].as_object_mut(), head.as_object())
            {
                properties.extend(head.clone());
                for (key, summary, fields) in extensions {
                    properties.insert((*key).to_owned(), build_section(fields, summary, None));
                }
            }
            definitions.insert(name, schema);
        }
    }
    json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "fabkit sensor",
        "description": "One vision-based tactile sensor, from which parts, molds and ground \
                        truth are made.",
        "type": "object",
        "properties": head,
        "required": ["format"],
        // Every file names a family or extends a sensor.
        "anyOf": [{ "required": ["family"] }, { "required": ["extends"] }],
        "allOf": cases,
        "definitions": definitions,
    })
}

/// Builds the schema of a section in which every key may be omitted.
///
/// ```
/// use fabkit_text::{FieldDeclaration, Parameter, section_schema};
///
/// let shape = u32::shape(&(1..=9));
/// let rows = FieldDeclaration { name: "rows", summary: "Rows of pins.".into(), shape };
/// let schema = section_schema(&[rows], "A field of pins.");
/// assert_eq!(schema["properties"]["rows"]["description"], "Rows of pins. Allowed: 1 to 9.");
/// assert_eq!(schema["properties"]["rows"]["anyOf"][0]["maximum"], 9);
/// assert_eq!(schema["additionalProperties"], false);
/// ```
pub fn section_schema(fields: &[FieldDeclaration], summary: &str) -> Json {
    build_section(fields, summary, None)
}

/// Path of a section that must be complete, and the paths that may be omitted; `None` if all may be.
type Completeness<'a> = Option<(&'a str, &'a BTreeSet<String>)>;

/// Builds the schema of a section.
fn build_section(fields: &[FieldDeclaration], summary: &str, complete: Completeness) -> Json {
    let property = |field: &FieldDeclaration| {
        let schema = match &field.shape {
            FieldShape::Section(inner) => {
                let path = complete.map(|(path, _)| join(path, field.name)).unwrap_or_default();
                build_section(
                    inner,
                    &field.summary,
                    complete.map(|(_, optional)| (&*path, optional)),
                )
            }
            FieldShape::Value { allowed, schema, kind, is_list } => {
                let expressions = matches!(
                    kind,
                    ValueKind::Length | ValueKind::Angle | ValueKind::Count | ValueKind::Number
                );
                build_value(&field.summary, allowed, schema, expressions, *is_list)
            }
        };
        (field.name.to_owned(), schema)
    };
    let properties: Map<String, Json> = fields.iter().map(property).collect();
    let mut schema = json!({
        "type": "object",
        "description": summary,
        "properties": properties,
        "additionalProperties": false,
    });
    if let Some((path, optional)) = complete {
        let required = fields.iter().filter(|field| !is_optional(field, path, optional));
        schema["required"] = required.map(|field| field.name).collect();
    }
    schema
}

/// Returns whether a value may be omitted; for a section, whether all its values may be.
fn is_optional(field: &FieldDeclaration, path: &str, optional: &BTreeSet<String>) -> bool {
    let path = join(path, field.name);
    match &field.shape {
        FieldShape::Section(inner) => inner.iter().all(|field| is_optional(field, &path, optional)),
        FieldShape::Value { .. } => optional.contains(&path),
    }
}

/// Builds the schema of a value: alone, or in a mapping with its source. Numbers may also be expressions.
fn build_value(
    summary: &str,
    allowed: &str,
    plain: &Json,
    has_expressions: bool,
    is_list: bool,
) -> Json {
    // Any text that begins with `=`; its grammar is checked when the file is read.
    let expression = json!({ "type": "string", "pattern": "^ *=" });
    let mut plain = plain.clone();
    // In lists, single items may be expressions.
    if has_expressions && is_list {
        plain["items"] = json!({ "anyOf": [plain["items"], expression] });
    }
    let (value, alone) = if has_expressions && !is_list {
        (json!({ "anyOf": [plain, expression] }), vec![expression])
    } else {
        (plain.clone(), Vec::new())
    };
    let with_source = json!({
        "type": "object",
        "properties": {
            "value": value,
            "source": { "enum": SourceKind::ALL.map(SourceKind::word) },
            "note": { "type": "string" },
            "tolerance": { "type": "string" },
        },
        "required": ["value"],
        "additionalProperties": false,
    });
    let forms: Vec<Json> = [plain, with_source].into_iter().chain(alone).collect();
    json!({ "description": format!("{summary} Allowed: {allowed}."), "anyOf": forms })
}
