//! Validation of `--json` documents against the schemas that `fabkit schema --output` prints, with the few keywords of
//! JSON Schema that those use. `tests/oracles/check_contracts.py` uses an independent validator as well.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use serde_json::{Map, Value};

/// Returns the faults of a document. Keys without an entry in the schema are faults, unless the schema allows
/// additional ones.
pub fn find_faults(document: &Value) -> Vec<String> {
    let format = document["format"].as_str().unwrap_or_default();
    let mut faults = Vec::new();
    match schemas().get(format) {
        Some(schema) => compare(schema, document, format, &mut faults),
        None => faults.push(format!("no schema of `{format}`")),
    }
    faults
}

/// Returns the schemas by their value of `format`.
pub fn schemas() -> &'static BTreeMap<String, Value> {
    static SCHEMAS: OnceLock<BTreeMap<String, Value>> = OnceLock::new();
    SCHEMAS.get_or_init(|| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fabkit/command/schemas");
        let files = fs::read_dir(folder).expect("the schemas are there");
        let schema = |file: fs::DirEntry| -> Value {
            let bytes = fs::read(file.path()).expect("a schema can be read");
            serde_json::from_slice(&bytes).expect("a schema is JSON")
        };
        let schemas = files.map(|file| schema(file.expect("a schema can be listed")));
        let named = |schema: Value| {
            let format = schema["properties"]["format"]["const"].as_str();
            (format.expect("a schema names its format").to_owned(), schema)
        };
        schemas.map(named).collect()
    })
}

fn compare(schema: &Value, value: &Value, at: &str, faults: &mut Vec<String>) {
    let words = schema.as_object().expect("a schema is an object");
    for (word, wanted) in words {
        let holds = match word.as_str() {
            "$schema" | "title" | "description" => true,
            "type" => has_type(wanted, value),
            "const" => wanted == value,
            "enum" => items(wanted).iter().any(|one| one == value),
            "anyOf" => items(wanted).iter().any(|one| {
                let mut wrong = Vec::new();
                compare(one, value, at, &mut wrong);
                wrong.is_empty()
            }),
            // A keyword applies only to values of its type; others satisfy it, as JSON Schema defines.
            "minimum" => value.as_f64().is_none_or(|v| v >= wanted.as_f64().unwrap_or(f64::NAN)),
            "minItems" => value.as_array().is_none_or(|v| v.len() >= count(wanted)),
            "maxItems" => value.as_array().is_none_or(|v| v.len() <= count(wanted)),
            "pattern" => {
                // Only this pattern is implemented; another one must not pass unnoticed.
                assert_eq!(wanted, "^[a-z0-9_]+$", "the one pattern that is known here");
                let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
                value.as_str().is_none_or(|text| !text.is_empty() && text.chars().all(is_plain))
            }
            "required" => {
                let lacks = |key: &&Value| value.get(key.as_str().unwrap_or_default()).is_none();
                !value.is_object() || !items(wanted).iter().any(|key| lacks(&key))
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    compare(wanted, item, &format!("{at}[{i}]"), faults);
                }
                true
            }
            "properties" | "additionalProperties" => true,
            other => panic!("`{other}` is not known here"),
        };
        if !holds {
            faults.push(format!("{at}: {value} is not {word} {wanted}"));
        }
    }
    if let Some(object) = value.as_object() {
        keys(words, object, at, faults);
    }
}

fn keys(
    words: &Map<String, Value>,
    object: &Map<String, Value>,
    at: &str,
    faults: &mut Vec<String>,
) {
    let (known, others) = (words.get("properties"), words.get("additionalProperties"));
    for (key, value) in object {
        let at = format!("{at}.{key}");
        match (known.and_then(|known| known.get(key)), others) {
            (Some(schema), _) => compare(schema, value, &at, faults),
            (None, Some(Value::Bool(true))) => {}
            (None, Some(schema @ Value::Object(_))) => compare(schema, value, &at, faults),
            _ => faults.push(format!("{at} is not in the schema")),
        }
    }
}

fn has_type(types: &Value, value: &Value) -> bool {
    let is = |name: &Value| match name.as_str().unwrap_or_default() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("`{other}` is no type"),
    };
    if types.is_array() { items(types).iter().any(is) } else { is(types) }
}

fn items(value: &Value) -> &[Value] {
    value.as_array().map(Vec::as_slice).unwrap_or_default()
}

fn count(value: &Value) -> usize {
    value.as_u64().and_then(|count| usize::try_from(count).ok()).expect("a count")
}
